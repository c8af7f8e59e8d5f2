"""When the library is compiled, by whom, where it goes, and what is said where it cannot be."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from hilbench.errors import UnavailableError
from hilbench.mcu.images import translated
from targets.mcu.core import build, sources
from targets.mcu.errors import EngineError

LOAD = ("-c", "from targets.mcu.core.library import about; print(about().path, about().digest)")
MAKE = ("-m", "targets.mcu.core.build")


def test_a_library_of_the_sources_beside_it_is_taken_as_it_is(checkout):
    code, out, err = checkout.run(*LOAD)
    assert (code, err) == (0, "")
    assert out.split() == [str(checkout.library), sources.digest_of()]
    assert not checkout.compiled.exists()


@pytest.mark.exhaustive("compiles the library; the gate does where four processes begin together")
def test_after_a_change_of_the_sources_it_is_compiled_once_and_that_is_said(checkout):
    digest = checkout.change_a_source()
    code, out, err = checkout.run(*LOAD)
    assert (code, err) == (0, "hilbench: compiling the emulated CPU ...\n")
    assert out.split() == [str(checkout.library), digest]
    assert checkout.run(*LOAD) == (0, out, "")
    assert [*checkout.core.glob(".build-*")] == []


def test_processes_that_start_together_compile_once(checkout):
    checkout.library.unlink()
    started = [checkout.start(*MAKE) for _ in range(4)]
    said = [process.communicate(timeout=120) for process in started]
    assert [process.returncode for process in started] == [0] * 4, said
    assert checkout.compiled.read_text().split().count(checkout.library.name) == 1
    assert sources.is_of(checkout.library, sources.digest_of())


def test_where_its_folder_cannot_be_written_it_goes_to_the_users_cache(checkout, monkeypatch, tmp_path):
    digest = checkout.change_a_source()
    (tmp_path / "closed").touch()  # nothing can be made below a file, not even by root
    cached = sources.places(digest)[1]
    places = (tmp_path / "closed/core/lib.so", tmp_path / "cache/hilbench" / cached.name)
    monkeypatch.setattr(build, "digest_of", lambda *_: digest)
    monkeypatch.setattr(build, "places", lambda _: places)
    monkeypatch.setattr(build, "compile_library", lambda place, _: place.write_text(place.name))
    monkeypatch.setattr(build, "find_compiler", lambda: ["cc"])
    assert build.build() == places[1]
    assert places[1].read_text() == cached.name
    assert digest[:16] in cached.name


def test_the_cache_is_that_of_the_user(monkeypatch):
    digest = sources.digest_of()
    monkeypatch.setenv("XDG_CACHE_HOME", "/somewhere")
    beside, cached = sources.places(digest)
    assert beside == Path(sources.__file__).parent / sources.file_name()
    assert cached.parent == Path("/somewhere/hilbench")
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", "/home/somebody")
    assert sources.places(digest)[1].parent == Path("/home/somebody/.cache/hilbench")
    monkeypatch.setenv("XDG_CACHE_HOME", "not/absolute")
    assert sources.places(digest) == (beside,)


def fails(capsys):
    """Have it built; return the line that is said, with exit code 3."""
    assert build.main() == 3
    said = capsys.readouterr()
    assert said.out == ""
    (line,) = said.err.removeprefix("hilbench: compiling the emulated CPU ...\n").splitlines()
    return line


def test_without_a_compiler_one_line_says_how_to_get_one(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(build, "places", lambda _: (tmp_path / "lib.so",))
    monkeypatch.setattr(build.importlib.util, "find_spec", lambda _: None)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("CC", "no-such-compiler -O3")
    line = fails(capsys)
    assert line.startswith(
        "hilbench: the emulated CPU is not compiled, and there is no C compiler; sudo apt install gcc"
    )
    assert line.endswith("-m pip install ziglang")
    with pytest.raises(EngineError) as refused:
        build.build()
    error = translated(refused.value)
    assert isinstance(error, UnavailableError)
    assert error.exit_code == 3


def test_where_no_folder_can_be_written_one_line_says_who_can(monkeypatch, tmp_path, capsys, compiler):
    (tmp_path / "closed").touch()
    monkeypatch.setattr(build, "places", lambda _: (tmp_path / "closed/lib.so",))
    monkeypatch.setenv("CC", str(compiler))
    line = fails(capsys)
    assert line.startswith(f"hilbench: {tmp_path / 'closed'}: ")
    assert "no folder for it can be written; as its owner: " in line
    assert line.endswith("-m targets.mcu.core.build")


def test_a_source_that_is_refused_is_said_in_one_line(monkeypatch, tmp_path, capsys):
    refusing = tmp_path / "refusing"
    refusing.write_text("#!/bin/sh\necho 'In file included from x.h'\necho 'cpu.c:7:1: error: no such type'\nexit 1\n")
    refusing.chmod(0o755)
    monkeypatch.setattr(build, "places", lambda _: (tmp_path / "lib.so",))
    monkeypatch.setattr(build, "find_compiler", lambda: [str(refusing)])
    assert "refuses the emulated CPU: cpu.c:7:1: error: no such type; " in fails(capsys)
    assert [*tmp_path.glob(".build-*")] == []


def test_a_compiler_that_makes_no_library_is_passed_over(monkeypatch, tmp_path, compiler):
    folder = tmp_path / "bin"
    folder.mkdir()
    monkeypatch.setenv("PATH", str(folder))
    monkeypatch.setenv("CC", "/bin/false -m32")
    monkeypatch.setattr(build.importlib.util, "find_spec", lambda name: name == "ziglang")
    assert build.find_compiler() == build.zig_for(os.uname().machine)
    shutil.copy(compiler, folder / "cc")
    assert build.find_compiler() == ["cc"]
    monkeypatch.setenv("CC", f"{compiler} -m32")
    assert build.find_compiler() == [str(compiler), "-m32"]


def test_the_digest_is_that_of_all_sources_and_their_names(tmp_path):
    folder = tmp_path / "src"
    shutil.copytree(sources.SOURCES, folder)
    digest = sources.digest_of()
    (folder / "notes.txt").touch()
    assert sources.digest_of(folder) == digest
    (folder / "about.h").rename(folder / "abort.h")
    assert sources.digest_of(folder) != digest
