"""The sources are clean by each compiler that is here, and each makes a library that works."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from targets.mcu.core import build, library, sources

COMPILERS = {"gcc": ["gcc"], "clang": ["clang"], "zig": build.zig_for(os.uname().machine)}


WIDE_DIVISION = re.compile(rb"__u?(?:div|mod)\w*ti\d")
"""Of 128-bit integers: in a library of the compiler's that `zig_for` leaves out."""


def compiled(tmp_path, name, *flags):
    """Return the library that a compiler makes."""
    if shutil.which(name) is None and not (name == "zig" and importlib.util.find_spec("ziglang")):
        pytest.skip(f"there is no {name} here")
    made = tmp_path / sources.file_name()
    build.compile_library(made, COMPILERS[name], ["-Werror", *flags])
    return library.open_library(made, sources.digest_of())


def test_gcc_has_nothing_to_say_of_a_source():
    if shutil.which("gcc") is None:
        pytest.skip("there is no gcc here")
    files = sorted(file.name for file in sources.SOURCES.glob("*.c"))
    words = [*COMPILERS["gcc"], *sources.COMPILE, "-Werror", "-fsyntax-only", '-DHIL_SOURCES_DIGEST=""', *files]
    done = subprocess.run(words, cwd=sources.SOURCES, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_the_library_in_use_needs_none_of_a_compiler_s():
    assert not WIDE_DIVISION.findall(Path(library.load()._name).read_bytes())


@pytest.mark.exhaustive("compiles everything; the gate lets gcc read it, and uses the library of the set-up")
@pytest.mark.parametrize("name", COMPILERS)
def test_a_compiler_has_nothing_to_say_and_its_library_works(tmp_path, name):
    made = compiled(tmp_path, name)
    assert made.hil_compiler().decode().startswith("gcc " if name == "gcc" else "clang ")
    assert made.hil_layout()[0].structure == b"hil_row"
    assert not WIDE_DIVISION.findall(Path(made._name).read_bytes())


@pytest.mark.exhaustive("the gate compiles as users do")
@pytest.mark.parametrize("name", [*COMPILERS])
def test_without_optimisation_it_is_clean_too(tmp_path, name):
    compiled(tmp_path, name, "-O0", "-Wconversion", "-Wno-sign-conversion", "-Wshadow")
