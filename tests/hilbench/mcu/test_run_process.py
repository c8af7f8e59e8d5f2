"""`hilbench run` as people and scripts start it: pipes that close, Ctrl-C, wrong words, what is imported."""

from __future__ import annotations

import json
import os
import re
import select
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from hilbench.cli import main
from hilbench.journal import Journal

IMAGES = Path(__file__).parents[3] / "targets/firmware/images"
HAL = f"bluepill:{IMAGES / 'style-hal.elf'}"
MAIN = "import sys; from hilbench.cli import main; sys.exit(main())"
HEAVY = {"elftools", "intelhex", "msgspec", "numpy", "pybullet", "pytest", "rich", "serial", "unicorn", "vcd"}
PATIENCE_S = 60

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


def hilbench(*words, folder=None, program=MAIN, **options):
    command = [sys.executable, "-c", program, *map(str, words)]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=PATIENCE_S, **options)


@pytest.mark.parametrize("command", ["run", "init", "doctor", "serve"])
def test_help_loads_nothing_heavy(command):
    program = f"{MAIN.replace('sys.exit(main())', 'main()')}; print('loaded:', *sys.modules)"
    done = hilbench(command, "--help", program=program)
    loaded = {name.partition(".")[0] for name in done.stdout.partition("loaded:")[2].split()}
    assert "hilbench" in loaded
    assert loaded & HEAVY == set()


def test_a_bench_file_is_read_without_an_engine(tmp_path):
    (tmp_path / "b.toml").write_text(
        f'version = 1\n[targets.a]\nboard = "bluepill"\nfirmware = "{IMAGES / "echo-irq.elf"}"\n'
    )
    program = f"{MAIN.replace('sys.exit(main())', 'main()')}; print('loaded:', *sys.modules)"
    done = hilbench("validate", "b.toml", folder=tmp_path, program=program)
    loaded = {name.partition(".")[0] for name in done.stdout.partition("loaded:")[2].split()}
    assert loaded & {"elftools", "intelhex", "pybullet", "unicorn", "vcd"} == set()


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["run", "bluepill:none.elf"], 3, "none.elf: no such firmware file; build it, or check the path"),
        (["run", "bluepil:none.elf"], 2, "bluepil:none.elf: no board 'bluepil'; did you mean 'bluepill'?"),
        (["run", "bluepill:"], 2, "bluepill:: names no image; write bluepill:IMAGE (ELF, Intel HEX or raw binary)"),
        (["run", "none.toml:x.elf"], 2, "none.toml: no such board file"),
        (["run"], 2, "run: names nothing to run, and there is no hilbench.toml here; write bluepill:IMAGE or"),
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
def test_what_is_wrong_is_one_line(tmp_path, words, code, said):
    done = hilbench(*words, folder=tmp_path)
    assert (done.returncode, done.stdout) == (code, "")
    assert done.stderr.startswith(f"hilbench: {said}"), done.stderr
    assert done.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_what_is_no_file_or_too_large_is_not_read(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with (tmp_path / "large.bin").open("wb") as file:
        file.truncate((64 << 20) + 1)
    done = hilbench("run", "bluepill:pipe", folder=tmp_path)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    done = hilbench("run", "bluepill:large.bin", folder=tmp_path)
    assert (done.returncode, done.stderr) == (
        2,
        "hilbench: large.bin: too large for firmware: 67108865 bytes; name the ELF, HEX or BIN file\n",
    )


def test_firmware_is_known_by_its_content(tmp_path):
    shutil.copy(IMAGES / "style-hal.elf", tmp_path / "firmware")
    done = hilbench("run", "firmware", folder=tmp_path)
    assert done.stderr == "hilbench: firmware: is firmware, and no bench; write bluepill:firmware\n"


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
def test_a_recording_that_a_disk_has_no_room_for_is_no_success(tmp_path, option):
    script = f'ulimit -f 1; "$@" run {HAL} --for 100ms --json {option} full'
    done = subprocess.run(
        ["bash", "-c", script, "sh", sys.executable, "-c", MAIN],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
    )
    assert (done.returncode, done.stdout) == (3, "")
    assert re.fullmatch(r"hilbench: full: the \w+ cannot be written: File too large; .*", done.stderr.splitlines()[-1])
    assert "Traceback" not in done.stderr


def test_a_device_takes_several_outputs(tmp_path):
    done = hilbench("run", HAL, "--for", "1ms", "--vcd", "/dev/null", "--journal", "/dev/null", folder=tmp_path)
    assert done.returncode == 0, done.stderr


def test_a_reader_that_goes_away_is_no_error(tmp_path):
    script = f'"$@" run {HAL} --for 50ms --follow | head -1'
    done = subprocess.run(
        ["bash", "-o", "pipefail", "-c", script, "sh", sys.executable, "-c", MAIN],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
    )
    assert done.returncode == 0
    assert done.stdout.split() == ["0.000000", "bluepill", "reset", "(POR)"]
    assert done.stderr.startswith("ran 0.050000 s of bench time at ")
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("follow", [[], ["--follow"]])
def test_progress_is_shown_on_a_terminal_unless_lines_are(follow):
    ours, theirs = os.openpty()
    command = [sys.executable, "-c", MAIN, "run", f"bluepill:{IMAGES / 'bench-busy.elf'}", *follow]
    process = subprocess.Popen(command, stdin=theirs, stdout=theirs, stderr=theirs)
    os.close(theirs)
    said = b""
    while b"of bench time, " not in said and b"period" not in said:
        assert select.select((ours,), (), (), PATIENCE_S)[0], said
        said += os.read(ours, 4096)
    process.kill()
    process.wait()
    os.close(ours)
    assert (b"\x1b[K" in said) is not bool(follow)


@pytest.mark.parametrize(("closed", "code"), [("<&-", 0), (">&-", 3), (">/dev/full", 3), ("2>&-", 0)])
def test_closed_streams_get_no_file_and_lost_data_is_said(tmp_path, closed, code):
    script = f'"$@" run {HAL} --for 10ms --follow --journal j --vcd w.vcd {closed}'
    done = subprocess.run(
        ["sh", "-c", script, "sh", sys.executable, "-c", MAIN],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
    )
    assert done.returncode == code
    assert ("hilbench: the standard output: cannot be written: " in done.stderr) is (code == 3)
    assert done.stderr.count("\n") == 1 or code == 0
    assert "Traceback" not in done.stderr
    assert Journal.read(tmp_path / "j").ended
    assert (tmp_path / "w.vcd").read_text().startswith("$comment hilbench")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_leaves_whole_files(tmp_path, number):
    command = [sys.executable, "-c", MAIN, "run", HAL, "--follow", "--journal", "j", "--vcd", "w.vcd"]
    process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert select.select((process.stdout,), (), (), PATIENCE_S)[0]
    os.read(process.stdout.fileno(), 1)  # it runs
    process.send_signal(number)
    _, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130
    assert err.startswith(b"interrupted after ")
    assert b"Traceback" not in err
    assert Journal.read(tmp_path / "j").ended
    assert (tmp_path / "w.vcd").read_text().splitlines()[-1]


def test_json_of_a_crash():
    done = hilbench("run", f"bluepill:{IMAGES / 'bad-lockup.elf'}", "--json")
    report = json.loads(done.stdout)
    assert (done.returncode, done.stderr, report["exit_code"]) == (1, "", 1)
    assert (report["end"]["kind"], report["end"]["place"]) == ("lockup", "HardFault_Handler (lockup.c:8)")
