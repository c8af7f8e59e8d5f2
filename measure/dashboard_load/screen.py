"""A dashboard in a terminal that somebody reads from, at a rate of one's choice."""

from __future__ import annotations

import contextlib
import fcntl
import os
import pty
import struct
import subprocess
import sys
import termios
from collections.abc import Iterator

import hilbench.tui.app
from hilbench.commands.dashboard import show
from hilbench.live.folders import sessions
from hilbench.tui.bench_process import BenchProcess

_COLUMNS, _ROWS = 200, 60


def attach(name: str, frames_per_s: int) -> int:
    """Be the process of a dashboard."""
    hilbench.tui.app.FRAMES_PER_S = frames_per_s
    found = next(session for session in sessions() if session.name == name)
    return show(BenchProcess(found))


@contextlib.contextmanager
def opened(name: str, frames_per_s: int) -> Iterator[tuple[int, int]]:
    """Open a dashboard on a bench; yield its process and the descriptor to read its screen from."""
    outside, inside = pty.openpty()
    fcntl.ioctl(inside, termios.TIOCSWINSZ, struct.pack("HHHH", _ROWS, _COLUMNS, 0, 0))
    words = [sys.executable, "-m", "measure.dashboard_load", "screen", name, "--fps", str(frames_per_s)]
    environment = {**os.environ, "TERM": "xterm-256color", "COLORTERM": "truecolor"}
    process = subprocess.Popen(words, stdin=inside, stdout=inside, stderr=inside, env=environment)
    os.close(inside)
    try:
        yield process.pid, outside
    finally:
        process.kill()  # in good order it would wait for somebody to read its screen
        process.wait()
        os.close(outside)
