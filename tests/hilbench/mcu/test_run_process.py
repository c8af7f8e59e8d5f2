"""`hilbench run` as people and scripts start it: pipes that close, Ctrl-C, wrong words, what is written."""

from __future__ import annotations

import json
import os
import re
import select
import shutil
import signal
import subprocess
from pathlib import Path

import pytest

from hilbench.benchfile.reader import open_bench
from hilbench.cli import main
from hilbench.journal import Journal
from tests.each import each
from tests.hilbench.forked import CLOSED, HILBENCH, PATIENCE_S

IMAGES = Path(__file__).parents[3] / "targets/firmware/images"
HAL = f"bluepill:{IMAGES / 'style-hal.elf'}"

EVERYTHING = """\
version = 1
suites = ["test_suite.py"]

[world]
scene = "corridor.toml"

[targets.brain]
board = "board.toml"
firmware = "k.elf"

[targets.brain.programs]
other = "other.elf"

[targets.robot]
model = "pioneer-2dx"
"""


def test_a_blue_pill_with_128_kb_runs_what_is_too_large_for_64(tmp_path, capfd):
    image = tmp_path / "large.bin"
    image.write_bytes((IMAGES / "style-registers.bin").read_bytes().ljust(100 * 1024, b"\0"))
    assert main(["run", f"bluepill:{image}", "--for", "1ms"]) == 2
    assert "it would fit an STM32F103CB (128 KB of flash, 20 KB of RAM)" in capfd.readouterr().err
    assert main(["run", f"bluepill:{image}", "--for", "1ms", "--chip", "STM32F103CB"]) == 0
    assert (
        main(["init", "--board", "bluepill", "--image", str(image), "--chip", "stm32f103cb", "--dir", str(tmp_path)])
        == 0
    )
    assert open_bench(str(tmp_path / "hilbench.toml")).boards["board"].board.chip == "STM32F103CB"


def test_a_program_that_runs_on_is_seen_in_its_functions(capfd):
    assert main(["run", f"bluepill:{IMAGES / 'bench-busy.elf'}", "--for", "30ms"]) == 0
    assert "  bluepill: runs in main (3 of 3 looks at its program counter), at the end\n" in capfd.readouterr().err


def test_a_delay_loop_takes_longer_by_the_table(capfd):
    """Half a period of ``style-registers`` is 400 000 turns of a loop."""
    falls_s = []
    for options in ([], ["--timing", "table"]):
        assert main(["run", f"bluepill:{IMAGES / 'style-registers.elf'}", "--for", "600ms", "--follow", *options]) == 0
        led = re.findall(r"([0-9.]+) +bluepill.PC13", capfd.readouterr().out)
        falls_s.append(float(led[-1]))
    flat_s, table_s = falls_s
    assert 1.2 < table_s / flat_s < 1.6


def test_a_wait_for_a_register_of_the_core_is_told_by_its_name(capfd):
    assert main(["run", f"bluepill:{IMAGES / 'style-swj.elf'}", "--for", "3ms"]) == 0
    assert "waits in main (swj.c:50), polling STK_CTRL, at the end" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["run", "bluepill:none.elf"], 3, "none.elf: no such firmware file; build it, or check the path"),
        (
            ["run", "stm32f103re:none.elf"],
            2,
            "stm32f103re:none.elf: 'stm32f103re' is a chip; a chip goes onto a board: bluepill:none.elf",
        ),
        (["run", "bluepil:none.elf"], 2, "bluepil:none.elf: no board 'bluepil'; did you mean 'bluepill'?"),
        (["run", "bluepill:"], 2, "bluepill:: names no image; write bluepill:IMAGE (ELF, Intel HEX or raw binary)"),
        (["run", "none.toml:x.elf"], 2, "none.toml: no such board file"),
        (
            ["run", HAL, "--chip", "STM32F103CG"],
            2,
            "--chip: no chip 'STM32F103CG' that could take the place of",
        ),
        (
            ["run", "pioneer", "--chip", "STM32F103CB"],
            2,
            "--chip: is for one board with an image; in a bench file:",
        ),
        (
            ["run", "pioneer", "--timing", "table"],
            2,
            "--timing: is for one board with an image; in a bench file:",
        ),
        (["serve", HAL, "--chip", "STM32F103T8"], 2, "--chip: does not fit the board: leds name 'PC13', which"),
        (["init", "--protocol", "p2os", "--chip", "STM32F103CB"], 2, "--chip: is for an emulated board"),
        (["run"], 2, "run: needs something to run, and there is no hilbench.toml here; write BOARD:IMAGE or"),
        (["run", HAL, "--for", "0.5"], 2, "--for: '0.5' is not a duration; write 10s, 500ms or 2min"),
        (["run", HAL, "--folow"], 2, "run: unknown option --folow; did you mean '--follow'?"),
        (["run", HAL, "--vcd", "none/w.vcd"], 3, "none/w.vcd: the waveforms cannot be written"),
        (["run", HAL, "--journal", "none/j"], 3, "none/j: the journal cannot be written"),
        (["serve", "bluepill:none.elf"], 3, "none.elf: no such firmware file"),
        (["run", HAL, "--vcd", "same", "--journal", "same"], 2, "--vcd same: would overwrite what --journal writes"),
        (["serve", HAL, "--pty", "same", "--journal", "same"], 2, "--journal same: would overwrite what --pty writes"),
        (["run", "bluepill:/dev/zero"], 2, "/dev/zero: a device or a pipe, not a file; name the ELF, HEX or BIN file"),
        (["run", HAL, "--for", "-1s"], 2, "--for: '-1s' is negative; a duration is positive: 10s, 500ms or 2min"),
        (["run", "none.hex"], 2, "none.hex: is firmware, and no bench; write bluepill:none.hex"),
        (
            ["run", IMAGES / "style-hal.elf"],
            2,
            f"{IMAGES / 'style-hal.elf'}: is firmware, and no bench; write bluepill",
        ),
        (["serve", "bluepill:"], 2, "bluepill:: names no image"),
    ],
)
def test_what_is_wrong_is_one_line(tmp_path, monkeypatch, capfd, words, code, said):
    monkeypatch.chdir(tmp_path)
    assert main([*map(str, words)]) == code
    out, err = capfd.readouterr()
    assert out == ""
    assert err.startswith(f"hilbench: {said}")
    assert err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_what_is_no_file_or_too_large_is_not_read(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    os.mkfifo(tmp_path / "pipe")
    with (tmp_path / "large.bin").open("wb") as file:
        file.truncate((64 << 20) + 1)
    assert main(["run", "bluepill:pipe"]) == 2
    assert capfd.readouterr().err.count("\n") == 1
    assert main(["run", "bluepill:large.bin"]) == 2
    said = "hilbench: large.bin: too large for firmware: 67108865 bytes; name the ELF, HEX or BIN file\n"
    assert capfd.readouterr().err == said


def test_firmware_is_known_by_its_content(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    shutil.copy(IMAGES / "style-hal.elf", "firmware")
    main(["run", "firmware"])
    assert capfd.readouterr().err == "hilbench: firmware: is firmware, and no bench; write bluepill:firmware\n"


@pytest.mark.parametrize("command", ["run --vcd", "run --journal", "serve --journal", "check --json", "check --junit"])
@pytest.mark.parametrize(
    ("file", "what"),
    [
        ("k.elf", "the firmware"),
        ("linked.elf", "the firmware"),
        ("other.elf", "the program 'other'"),
        ("b.toml", "the bench file"),
        ("board.toml", "the board file"),
        ("corridor.toml", "the scene"),
        ("test_suite.py", "the suite test_suite.py"),
    ],
)
def test_nothing_that_is_read_is_overwritten(tmp_path, monkeypatch, capfd, command, file, what):
    monkeypatch.chdir(tmp_path)
    for name in ("k.elf", "other.elf"):
        shutil.copy(IMAGES / "style-hal.elf", name)
    os.link("k.elf", "twin.elf")
    os.symlink("twin.elf", "linked.elf")
    (tmp_path / "board.toml").write_text('name = "Mine"\nchip = "STM32F103RB"\n')
    (tmp_path / "corridor.toml").write_text('name = "bare"\nfloor_friction = 1.0\n')
    (tmp_path / "test_suite.py").write_text("")
    (tmp_path / "b.toml").write_text(EVERYTHING)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    name, option = command.split()
    assert main([name, "b.toml", option, file]) == 2
    assert capfd.readouterr().err == f"hilbench: {option} {file}: would overwrite {what}; choose another file\n"
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


@pytest.mark.parametrize("option", ["--vcd", "--journal"])
def test_a_recording_that_a_disk_has_no_room_for_is_no_success(forkable, tmp_path, option):
    # A compiled module that is cut off would be found by whoever comes next.
    limit = "sys.dont_write_bytecode = True; resource.setrlimit(resource.RLIMIT_FSIZE, (1024, 1024))"
    program = f"import resource, sys; {limit}; {HILBENCH}"
    words = ["run", HAL, "--for", "100ms", "--json", option, "full"]
    done = forkable.run(*words, program=program, cwd=tmp_path)
    assert (done.returncode, done.output) == (3, "")
    assert re.fullmatch(r"hilbench: full: the \w+ cannot be written: File too large; .*", done.error.splitlines()[-1])
    assert "Traceback" not in done.error


def test_a_device_takes_several_outputs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["run", HAL, "--for", "1ms", "--vcd", "/dev/null", "--journal", "/dev/null"]) == 0


def test_a_reader_that_goes_away_is_no_error(forkable):
    with forkable.start("run", HAL, "--for", "50ms", "--follow", stdout=subprocess.PIPE) as process:
        line = b""
        while not line.endswith(b"\n"):
            line += process.stdout.read(1)
        process.hang_up()
        _, error = process.communicate()
    assert process.returncode == 0
    assert line.split() == [b"0.000000", b"bluepill", b"reset", b"(POR)"]
    assert error.startswith("ran 0.050000 s of bench time at ")
    assert "Traceback" not in error


@each("follow", [[], ["--follow"]])
def test_progress_is_shown_on_a_terminal_unless_lines_are(forkable, follow):
    ours, theirs = os.openpty()
    words = ["run", f"bluepill:{IMAGES / 'bench-busy.elf'}", *follow]
    program = f"import hilbench.serving.run; hilbench.serving.run._PATIENCE_S = 0.01; {HILBENCH}"
    with forkable.start(*words, program=program, stdin=theirs, stdout=theirs, stderr=theirs):
        os.close(theirs)
        said = b""
        while b"of bench time, " not in said and b"period" not in said:
            assert select.select((ours,), (), (), PATIENCE_S)[0], said
            said += os.read(ours, 4096)
    os.close(ours)
    assert (b"\x1b[K" in said) is not bool(follow)


@pytest.mark.parametrize(("stream", "code"), [("stdin", 0), ("stdout", 3), ("full disk", 3), ("stderr", 0)])
def test_closed_streams_get_no_file_and_lost_data_is_said(forkable, tmp_path, stream, code):
    with open("/dev/full", "w") as full:
        streams = {"stdout": full.fileno()} if stream == "full disk" else {stream: CLOSED}
        words = ["run", HAL, "--for", "10ms", "--follow", "--journal", "j", "--vcd", "w.vcd"]
        done = forkable.run(*words, cwd=tmp_path, **streams)
    assert done.returncode == code
    assert ("hilbench: the standard output: cannot be written: " in done.error) is (code == 3)
    assert done.error.count("\n") == 1 or code == 0
    assert "Traceback" not in done.error
    assert Journal.read(tmp_path / "j").ended
    assert (tmp_path / "w.vcd").read_text().startswith("$comment hilbench")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_leaves_whole_files(forkable, tmp_path, number):
    words = ["run", HAL, "--follow", "--journal", "j", "--vcd", "w.vcd"]
    with forkable.start(*words, cwd=tmp_path, stdout=subprocess.PIPE) as process:
        process.stdout.read(1)  # it runs
        process.send_signal(number)
        _, error = process.communicate()
    assert process.returncode == 130
    assert error.startswith("interrupted after ")
    assert "Traceback" not in error
    assert Journal.read(tmp_path / "j").ended
    assert (tmp_path / "w.vcd").read_text().splitlines()[-1]


def test_json_of_a_crash(capfd):
    assert main(["run", f"bluepill:{IMAGES / 'bad-lockup.elf'}", "--json"]) == 1
    out, err = capfd.readouterr()
    report = json.loads(out)
    assert (err, report["exit_code"]) == ("", 1)
    assert (report["end"]["kind"], report["end"]["place"]) == ("lockup", "HardFault_Handler (lockup.c:8)")
