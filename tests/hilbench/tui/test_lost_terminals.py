"""A terminal that is gone ends the dashboard, whatever it shows, and leaves the bench alone."""

from __future__ import annotations

import json
import os
import pty
import select
import signal
import subprocess
import sys

import pytest

PATIENCE_S = 600
REAL_TIME = pytest.mark.real_time("a bench runs in a process of its own, and a dashboard in a terminal that vanishes")
OTHERS = pytest.mark.exhaustive("the gate loses a terminal in both ways, with a bench and with a recording")
WITH_SIGNAL = ("sh", "-c", 'exec "$@" <"$0" >"$0" 2>&1')
"""The first terminal that the leader of a session opens is its controlling terminal: its loss is told by SIGHUP."""


class Terminal:
    """A terminal that vanishes; whoever is in it is told by a signal, or finds out when he reads or writes."""

    def __init__(self, words, folder, *, signalled):
        self.descriptor, inside = pty.openpty()
        given = (
            {"args": [*WITH_SIGNAL, os.ttyname(inside), *words], "stdin": subprocess.DEVNULL}
            if signalled
            else {"args": words, "stdin": inside, "stdout": inside, "stderr": inside}
        )
        environment = {**os.environ, "TERM": "xterm-256color", "XDG_RUNTIME_DIR": str(folder), "COLUMNS": "80"}
        environment |= {"LINES": "24", "XDG_STATE_HOME": str(folder / "state")}
        self.process = subprocess.Popen(**given, cwd=folder, env=environment, start_new_session=True)
        os.set_blocking(self.descriptor, False)
        self._inside = inside

    def wait_for(self, text):
        seen = ""
        while text not in seen:
            assert select.select((self.descriptor,), (), (), PATIENCE_S)[0], seen[-2000:]
            seen += os.read(self.descriptor, 65536).decode(errors="replace")
        if self._inside is not None:
            os.close(self._inside)
            self._inside = None

    def press(self, keys):
        os.write(self.descriptor, keys.encode())

    def vanish(self):
        """Go away; give the exit code of who was in it."""
        os.close(self.descriptor)
        return self.process.wait(PATIENCE_S)


@pytest.fixture
def terminal(command, tmp_path):
    begun = []

    def start(*words, signalled):
        begun.append(Terminal([*command, *words], tmp_path, signalled=signalled))
        return begun[-1]

    yield start
    for one in begun:
        if one.process.poll() is None:
            one.process.kill()
            one.process.wait()


STOP = """
import pathlib, sys
from hilbench.live.folders import Session
from hilbench.tui.bench_process import BenchProcess
process = BenchProcess(Session(pathlib.Path(sys.argv[1])))
process.poll()
process.stop()
"""


@pytest.fixture
def asking(terminal, tmp_path):
    """Open a bench and ask to leave it; the bench is still there afterwards."""

    def ask(*, signalled):
        shown = terminal("rover-model", signalled=signalled)
        shown.wait_for("station")
        shown.press("q")
        shown.wait_for("Leave it how?")
        return shown

    yield ask
    (about,) = tmp_path.glob("hilbench/*/about.json")
    os.kill(json.loads(about.read_text())["pid"], 0)
    stop = [sys.executable, "-c", STOP, str(about.parent)]
    subprocess.run(stop, env={**os.environ, "XDG_RUNTIME_DIR": str(tmp_path)}, check=True)


@REAL_TIME
@pytest.mark.parametrize("signalled", [True, pytest.param(False, marks=OTHERS)], ids=["SIGHUP", "EIO"])
def test_while_it_asks_how_to_leave(asking, signalled):
    assert asking(signalled=signalled).vanish() == 0


@REAL_TIME
def test_a_terminal_that_nobody_reads_any_more_holds_nobody_who_is_told_to_end(asking):
    shown = asking(signalled=False)
    shown.process.terminate()
    assert shown.process.wait(PATIENCE_S) in {0, -signal.SIGALRM}
    os.close(shown.descriptor)


@pytest.mark.exhaustive("the gate loses a terminal while it asks, and one that nobody reads")
@pytest.mark.parametrize(
    ("keys", "signalled"), [("", False), pytest.param("?", True, marks=OTHERS), pytest.param("5", False, marks=OTHERS)]
)
def test_whatever_a_recording_shows(terminal, journals, keys, signalled):
    shown = terminal("replay", str(journals["rover"]), signalled=signalled)
    shown.wait_for("recorded")
    shown.press(keys)
    assert shown.vanish() == 0
