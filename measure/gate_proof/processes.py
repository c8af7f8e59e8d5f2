"""The processes that a run of tests has started: their time and memory, and how to be rid of them."""

from __future__ import annotations

import contextlib
import os
import signal
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

MARK = "GATE_PROOF_RUN"
"""Set to a run's name in the environment of all its processes."""
_TICKS = os.sysconf("SC_CLK_TCK")
_PAGE = os.sysconf("SC_PAGE_SIZE")


@dataclass(frozen=True, slots=True)
class Used:
    """What the processes of a run use.

    Attributes:
        cpu_s: processor time.
        memory: bytes in memory.
    """

    cpu_s: float
    memory: int


def of_run(name: str, leader: int) -> Iterator[int]:
    """Give the numbers of a run's processes: those that carry its mark, and those in the session of its first."""
    mark = f"{MARK}={name}".encode()
    for folder in Path("/proc").iterdir():
        if folder.name.isdigit():
            with contextlib.suppress(OSError):
                state, _, _, session, *_ = _fields(folder)
                marked = mark in (folder / "environ").read_bytes().split(b"\0")
                if state != "Z" and (int(session) == leader or marked):
                    yield int(folder.name)


def used(name: str, leader: int) -> Used:
    """Return what a run uses now."""
    cpu_s, memory = 0.0, 0
    for process in of_run(name, leader):
        with contextlib.suppress(OSError):
            fields = _fields(Path(f"/proc/{process}"))
            cpu_s += sum(map(int, fields[11:15])) / _TICKS
            memory += int(fields[21]) * _PAGE
    return Used(cpu_s, memory)


def end(name: str, leader: int) -> None:
    """End all that a run has left."""
    while left := list(of_run(name, leader)):
        for process in left:
            with contextlib.suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL)
        time.sleep(0.02)


def _fields(folder: Path) -> list[str]:
    """Return what the kernel says of a process, beginning with its state."""
    return (folder / "stat").read_text().rpartition(")")[2].split()
