"""What pages take for granted when they show a command: images, recordings and ports of the reader's."""

from __future__ import annotations

import contextlib
import os
import pty
import re
import select
import shutil
import signal
import subprocess
import sys
from pathlib import Path

from hilbench.cli import main
from protocols import carla, pkt

ROOT = Path(__file__).parents[2]
IMAGES = ROOT / "targets/firmware/images"
PATIENCE_S = 600
PORT = re.compile(r"serial:(?:/dev|\.)/\w+|socket://[\d.:]+")
READY = "stop with Ctrl-C"
COPIES = {
    "sender.elf": "style-irq-dma.elf",
    "receiver.elf": "echo-irq.elf",
    "firmware.elf": "style-irq-dma.elf",
    "build/my-words.elf": "robot-words.elf",
    "build/my-dodger.elf": "robot-dodge.elf",
    "my-rover.elf": "rover.elf",
    "my-board.elf": "vehicle.elf",
}
RECORDED = ("session", "run", "yesterday", "today", "live", "replayed", "old", "new")
REQUEST = pkt.encode_frame(pkt.encode_command(pkt.RequestTelemetry()))
NOISY = """\
version = 1

[targets.robot]
model = "pioneer-2dx"

[[links]]
ends = ["peer", "robot.host"]

[[faults]]
kind = "drop"
byte = 2
from = "robot.host"

[[faults]]
kind = "delay"
byte = 4
duration_s = 0.001
from = "robot.host"
"""
SERVED = {
    "--calibrate": (f"bluepill:{IMAGES / 'echo-irq.elf'}", ["./board"]),
    "xrce-client": ("xrce-client", ["./at-client"]),
    "xrce": ("xrce-agent", ["line1=./at-first", "line2=./at-second"]),
    "p2os|replay|doctor": ("pioneer-plane", ["./at-robot"]),
    "vehicle": ("vehicle-model", ["usart2=./at-first", "usart3=./at-second"]),
    "": ("rover-model", ["./at-board"]),
}
"""What is at the ports of the reader's: by a pattern of the command what is served, and where."""
CLAUSES = {
    "p2os-server": "S01",
    "rover-motion": "R09",
    "my-dodger": "a_wall_is_turned_away_from",
    "my-board": "VB01 and [hardened]",
    "my-rover": "P01 and documented",
    "vehicle": "VB01",
    "rover": "P01",
    "xrce-client": "XC01",
}
"""The clause or case that is run where a page runs a suite for minutes: by a part of the command."""


def record(folder):
    """Write recordings of a robot that is spoken to, under all names that pages give to theirs."""
    with contextlib.chdir(folder):
        words = ["check", "pioneer-plane", "-k", "S01 or S18 or S36 or M05", "-q"]
        assert main([*words, "--journal", "session.jsonl", "--json", "session.json"]) == 0
        for name in RECORDED[1:]:
            for kind in ("json", "jsonl"):
                shutil.copy(f"session.{kind}", f"{name}.{kind}")
        assert main(["export", "session.jsonl", "--pcapng", "session.pcapng"]) == 0


def lay_out(folder, page, recordings):
    """Put into a folder what the commands of a page find in the reader's."""
    for name in ("targets", "examples"):
        (folder / name).symlink_to(ROOT / name)
    for file in recordings.iterdir():
        shutil.copy(file, folder)
    (folder / "build").mkdir()
    for name, image in COPIES.items():
        shutil.copy(IMAGES / image, folder / name)
    for name in ("noisy.toml", "my-bench.toml"):
        (folder / name).write_text(NOISY)
    status = next(vector.data for vector in carla.VECTORS.values())
    (folder / "capture.bin").write_bytes(status if "vehicle" in page else REQUEST)


def run_until_ready(words, folder):
    """Run a command that goes on until somebody ends it, and end it as it is ready; return its exit code."""
    with served([re.sub(r"\b(8101|4000)$", "0", word) for word in words], folder) as process:
        process.send_signal(signal.SIGINT)
        process.stderr.read()
        return process.wait()


@contextlib.contextmanager
def served(words, folder):
    """Run a command beside others, as soon as it is ready."""
    command = [sys.executable, "-m", "hilbench", *words]
    environment = {**os.environ, "PYTHONPATH": ""}
    with subprocess.Popen(
        command, cwd=folder, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            said = ""
            while READY not in said:
                line = process.stderr.readline()
                assert line, said
                said += line
            yield process
        finally:
            if process.poll() is None:
                process.send_signal(signal.SIGINT)


@contextlib.contextmanager
def at_stand_ins(line, words, folder):
    """Serve what a command finds at its ports; give its words with these ports."""
    what, places = next(one for pattern, one in SERVED.items() if re.search(pattern, line))
    ports = iter(place.rpartition("=")[2] for place in places)
    named = [PORT.sub(lambda _: f"serial:{next(ports)}", word) for word in words]
    with served(["serve", what, *(word for place in places for word in ("--pty", place))], folder):
        yield named


def with_one_clause(line, words):
    """Return the words of a check of whole suites as those of a check of one clause."""
    return [*words, "-k", next(clause for name, clause in CLAUSES.items() if name in line)]


def open_and_leave(words, folder):
    """Open a dashboard in a terminal, stop its bench as it is shown; return the exit code."""
    descriptor, inside = pty.openpty()
    environment = {**os.environ, "TERM": "xterm-256color", "COLUMNS": "80", "LINES": "24", "PYTHONPATH": ""}
    environment |= {"XDG_RUNTIME_DIR": str(folder), "XDG_STATE_HOME": str(folder / "state")}
    command = [sys.executable, "-m", "hilbench", *words]
    streams = {"stdin": inside, "stdout": inside, "stderr": inside}
    with subprocess.Popen(command, cwd=folder, env=environment, start_new_session=True, **streams) as process:
        os.close(inside)
        seen = ""
        while "Leave it how?" not in seen:  # a dashboard whose bench has not begun yet asks nothing
            try:
                if select.select((descriptor,), (), (), 1)[0]:
                    seen += os.read(descriptor, 65536).decode(errors="replace")
            except OSError:  # it has left its terminal: a recording asks nothing
                os.close(descriptor)
                return process.wait()
            if "Quit" in seen:
                os.write(descriptor, b"q")
                seen = seen.rpartition("Quit")[2]
        os.write(descriptor, b"s")
        with contextlib.suppress(OSError):  # a terminal that nobody has any more
            while os.read(descriptor, 65536):
                pass
        os.close(descriptor)
        return process.wait(PATIENCE_S)
