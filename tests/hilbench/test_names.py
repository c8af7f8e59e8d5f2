"""Names that UTF-8 cannot hold, and locales that cannot say them: everything still runs."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import pytest

from hilbench.errors import UsageError
from hilbench.files.names import as_utf8, escaped, escaped_all, file_name
from hilbench.journal import Journal
from tests.each import each
from tests.hilbench.forked import Forkable
from tests.share import few

IMAGE = Path(__file__).parents[2] / "targets/firmware/images/style-hal.elf"
ASCII = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "PYTHONPATH": ""}
BENCH = """\
version = 1
suites = ["test_лампа.py"]
[targets.brain]
board = "плата.toml"
firmware = "прошивка.elf"
[targets.brain.programs]
same = "прошивка.elf"
"""
SUITE = """\
from hilbench.check import case
@case("A1", text="It runs.", source="rev. C")
def test_it_runs(bench): pass
"""


@each(
    ("text", "said"),
    [
        ("plain", "plain"),
        ("лампа", "лампа"),
        (os.fsdecode(b"k\xff.elf"), r"k\xff.elf"),
        ("лампа".encode().decode("ascii", "surrogateescape"), "лампа"),
        ("\ud800", r"\ud800"),
    ],
)
def test_an_escaped_text_fits_into_utf8(text, said):
    assert escaped(text) == said
    assert escaped_all({text: [text, (1, text)]}) == {said: [said, [1, said]]}


def test_a_name_in_a_file_is_one_of_the_file_system_and_back():
    assert as_utf8(file_name("прошивка.elf")) == "прошивка.elf"
    with pytest.raises(UsageError, match="its name is not UTF-8"):
        as_utf8(os.fsdecode(b"\xff"))


@pytest.fixture(scope="module")
def forkable_in_ascii():
    made = Forkable(ASCII)
    yield made
    made.close()


@pytest.fixture(params=["forkable", "forkable_in_ascii"])
def run(tmp_path, request):
    in_locale = request.getfixturevalue(request.param)
    folder = os.fsencode(tmp_path)
    for name in (b"k\xff.elf", "прошивка.elf".encode()):
        shutil.copy(IMAGE, os.path.join(folder, name))
    for name, text in (
        (b"b\xff.toml", BENCH),
        ("плата.toml".encode(), 'name = "Плата"\nchip = "STM32F103C8"\n'),
        ("test_лампа.py".encode(), SUITE),
        (b"test_\xff.py", SUITE),
    ):
        with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
            file.write(text)

    def process(*words, code=0):
        done = in_locale.run(*(word if isinstance(word, bytes) else word.encode() for word in words), cwd=tmp_path)
        assert done.returncode == code, done.error
        return done

    return process


@pytest.mark.parametrize(
    "image", few([b"k\xff.elf", "прошивка.elf".encode()], 1, "the gate has the one that is no UTF-8")
)
def test_an_image_runs_whatever_it_is_called(run, tmp_path, image):
    assert "reset (POR)" in run("run", b"bluepill:" + image, "--for", "1ms", "--follow").output
    run("run", b"bluepill:" + image, "--for", "1ms", "--journal", b"j\xff", "--vcd", "волны.vcd")
    names = os.listdir(os.fsencode(tmp_path))
    assert b"j\xff" in names
    assert "волны.vcd".encode() in names


def test_a_bench_runs_whatever_it_and_its_files_are_called(run, tmp_path):
    assert json.loads(run("run", b"b\xff.toml", "--for", "1ms", "--json").output)["bench"] == r"b\xff.toml"
    run("run", b"b\xff.toml", "--for", "1ms", "--journal", "j", "--vcd", "w")
    assert Journal.read(tmp_path / "j").header["bench"] == r"b\xff.toml"
    assert run("validate", b"b\xff.toml").output == "b\\udcff.toml: ok\n"


def test_a_suite_is_checked_whatever_it_is_called(run, tmp_path):
    files = ("--journal", "j", "--junit", "x", "--json", "r")
    assert "A1" in run("check", b"b\xff.toml", "--suite", b"test_\xff.py", *files).output
    (case,) = json.loads((tmp_path / "r").read_text())["cases"]
    assert case["id"] == r"\xff/it_runs"
    # the same in every locale, and so its seed and its hash
    report = json.loads(run("check", b"b\xff.toml", "-k", "лампа", "--json", "-").output)
    assert [case["id"] for case in report["cases"]] == ["лампа/it_runs"]
    assert json.loads(run("check", b"b\xff.toml", "--list", "--json", "-").output)[0]["suite"] == "лампа"


def test_init_writes_names_that_a_bench_file_can_hold(run, tmp_path):
    run("init", "--board", "плата.toml", "--image", "прошивка.elf")
    assert 'board = "плата.toml"\nfirmware = "прошивка.elf"' in (tmp_path / "hilbench.toml").read_text("utf-8")
    run("run", "--for", "1ms")


def test_init_says_what_a_bench_file_cannot_hold(run, tmp_path):
    done = run("init", "--board", "bluepill", "--image", b"k\xff.elf", code=2)
    assert done.error == (
        "hilbench: k\\udcff.elf: its name is not UTF-8, so a bench file cannot contain it; rename it\n"
    )
    assert not (tmp_path / "hilbench.toml").exists()
