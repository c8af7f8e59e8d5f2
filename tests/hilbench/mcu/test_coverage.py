"""`hilbench run --coverage`: which lines of an unmodified image were executed."""

from __future__ import annotations

import json
import shutil
import subprocess

import pytest
from elftools.elf.elffile import ELFFile

from hilbench.cli import main
from tests.hilbench.mcu.test_init_and_fixtures import IMAGES

ECHO = f"bluepill:{IMAGES / 'echo-irq.elf'}"


def records(path):
    """Return the records of a trace file by source: lists of (key, value)."""
    found, file = {}, None
    for line in path.read_text().splitlines():
        key, _, value = line.partition(":")
        if key == "SF":
            file = found.setdefault(value, [])
        elif key not in {"TN", "end_of_record"}:
            file.append((key, value))
    return found


def functions(path):
    return {
        value.partition(",")[2]: value[0] == "1"
        for pairs in records(path).values()
        for key, value in pairs
        if key == "FNDA"
    }


def test_the_handler_of_a_line_with_bytes_was_executed(tmp_path, capsys):
    path = tmp_path / "echo.info"
    words = ["run", ECHO, "--for", "20ms", "--send", "5ms:usart1=hi", "--coverage", str(path), "--json"]
    assert main(words) == 0
    reached = functions(path)
    assert reached.items() >= {"main": True, "USART1_IRQHandler": True, "default_handler": False}.items()
    assert "USART2_IRQHandler" not in reached  # another name of the default handler, which is one function
    counted = json.loads(capsys.readouterr().out)["coverage"]
    pairs = [pair for file in records(path).values() for pair in file]
    hits = [value.partition(",")[2] == "1" for key, value in pairs if key == "DA"]
    assert counted == {"executed": sum(hits), "lines": len(hits)}
    for total, kind in (("LF", "DA"), ("FNF", "FN")):
        assert sum(int(value) for key, value in pairs if key == total) == sum(key == kind for key, _ in pairs)


def test_more_time_executes_no_less_and_the_lines_are_the_same(tmp_path, capsys):
    paths = [tmp_path / name for name in ("short.info", "long.info")]
    for path, for_ in zip(paths, ("1us", "20ms"), strict=True):
        assert main(["run", ECHO, "--for", for_, "--coverage", str(path)]) == 0
    short, long = ([pair for file in records(path).values() for pair in file if pair[0] == "DA"] for path in paths)
    assert [value.partition(",")[0] for _, value in short] == [value.partition(",")[0] for _, value in long]
    assert all(before <= after for before, after in zip(short, long, strict=True))
    assert short != long
    assert "lines of the firmware executed (" in capsys.readouterr().err


@pytest.mark.skipif(shutil.which("lcov") is None, reason="lcov is not installed")
def test_lcov_reads_it(tmp_path):
    path = tmp_path / "echo.info"
    assert main(["run", ECHO, "--for", "1ms", "--coverage", str(path)]) == 0
    said = subprocess.run(["lcov", "--summary", str(path)], check=True, capture_output=True, text=True, timeout=60)
    assert "functions" in said.stdout + said.stderr


def test_an_image_without_line_tables_is_refused(tmp_path, capsys):
    image = tmp_path / "echo.bin"
    image.write_bytes(bytes.fromhex("0050002009000008") + bytes.fromhex("FEE7") * 8)
    assert main(["run", f"bluepill:{image}", "--for", "1ms", "--coverage", str(tmp_path / "x.info")]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "--coverage: bluepill" in said
    assert "has no line tables; give the ELF file, compiled and linked with -g" in said
    assert not (tmp_path / "x.info").exists()


def test_a_file_that_cannot_be_written_is_said_before_the_run(tmp_path, capsys):
    assert main(["run", ECHO, "--for", "1ms", "--coverage", str(tmp_path / "none" / "x.info")]) == 2
    assert "there is no folder" in capsys.readouterr().err
    assert main(["run", ECHO, "--for", "1ms", "--coverage", str(IMAGES / "echo-irq.elf")]) == 2
    assert "echo-irq.elf" in capsys.readouterr().err


def test_damaged_line_tables_are_refused(tmp_path, capsys):
    whole = (IMAGES / "echo-irq.elf").read_bytes()
    with (IMAGES / "echo-irq.elf").open("rb") as file:
        header = ELFFile(file).get_section_by_name(".debug_abbrev").header
    image = tmp_path / "damaged.elf"
    at, size = header["sh_offset"], header["sh_size"]
    image.write_bytes(whole[: at + size // 2] + b"\xff" * (size // 2) + whole[at + size // 2 + size // 2 :])
    assert main(["run", f"bluepill:{image}", "--for", "1ms", "--coverage", str(tmp_path / "x.info")]) == 2
    assert "its line tables are damaged" in capsys.readouterr().err
