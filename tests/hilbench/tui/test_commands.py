"""The commands that open the dashboard, in a terminal of their own: they begin, show, and leave nothing behind."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import pty
import select
import signal
import struct
import subprocess
import termios
import threading
from itertools import pairwise

import pytest

from hilbench.cli import main
from hilbench.commands import dashboard
from hilbench.exit_codes import ExitCode
from hilbench.journal import Journal
from hilbench.live.folders import Session
from hilbench.tui.bench_process import BenchProcess

PATIENCE_S = 600
REAL_TIME = pytest.mark.real_time("a bench runs in a process of its own, and a dashboard in a terminal")


class Terminal:
    """A terminal with a command in it."""

    def __init__(self, command, folder):
        self.descriptor, inside = pty.openpty()
        fcntl.ioctl(inside, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
        environment = {**os.environ, "TERM": "xterm-256color"}
        environment |= {"XDG_RUNTIME_DIR": str(folder), "XDG_STATE_HOME": str(folder / "state")}
        self.process = subprocess.Popen(
            command, stdin=inside, stdout=inside, stderr=inside, cwd=folder, env=environment, start_new_session=True
        )
        os.close(inside)
        self.seen = ""

    def wait_for(self, text):
        """Read until a text has been on the screen, since it was waited for the last time."""
        while text not in self.seen:
            assert select.select((self.descriptor,), (), (), PATIENCE_S)[0], self.seen[-2000:]
            try:
                self.seen += os.read(self.descriptor, 65536).decode(errors="replace")
            except OSError:
                break
        assert text in self.seen, self.seen[-2000:]
        self.seen = self.seen.partition(text)[2]

    def press(self, keys):
        os.write(self.descriptor, keys.encode())

    def end(self):
        """Read to the end; give the exit code."""
        while select.select((self.descriptor,), (), (), PATIENCE_S)[0]:
            try:
                if not os.read(self.descriptor, 65536):
                    break
            except OSError:
                break
        os.close(self.descriptor)
        return self.process.wait(PATIENCE_S)


@pytest.fixture
def terminal(command, tmp_path):
    begun = []

    def start(*words):
        begun.append(Terminal([*command, *words], tmp_path))
        return begun[-1]

    yield start
    for one in begun:
        if one.process.poll() is None:
            one.process.kill()
            one.process.wait()


def has_ended(about):
    """Wait until the bench has ended that a file is about."""
    with contextlib.suppress(ProcessLookupError):
        process = os.pidfd_open(json.loads(about)["pid"])
        select.select((process,), (), ())
        os.close(process)


@pytest.mark.slow("a bench and two dashboards, one after the other, each a process")
@REAL_TIME
def test_a_bench_is_opened_left_found_again_and_stopped(terminal, tmp_path):
    opened = terminal("rover-model")
    opened.wait_for("station")
    opened.press("q")
    opened.wait_for("Leave it how?")
    opened.press("d")
    assert opened.end() == 0
    (folder,) = (tmp_path / "hilbench").iterdir()
    about = (folder / "about.json").read_text()
    again = terminal("attach")
    again.wait_for("rover-model")
    again.press("q")
    again.wait_for("Leave it how?")
    again.press("s")
    assert again.end() == 0
    has_ended(about)
    assert not (folder / "control").exists()


@pytest.mark.exhaustive("a terminal and a bench; the gate loses a terminal, and leaves and finds a bench")
@REAL_TIME
def test_a_dashboard_that_is_killed_leaves_the_bench_and_its_recording_whole(terminal, tmp_path):
    opened = terminal("rover-model", "--journal", "kept.jsonl")
    opened.wait_for("station")
    about = next(tmp_path.glob("hilbench/*/about.json")).read_text()
    assert (tmp_path / "nice").read_text() == "10"
    opened.process.kill()
    opened.process.wait()
    before = (tmp_path / "kept.jsonl").stat().st_size
    again = terminal("attach")
    again.wait_for("rover-model")
    again.press("q")
    again.wait_for("Leave it how?")
    again.press("s")
    assert again.end() == 0
    has_ended(about)
    recording = Journal.read(tmp_path / "kept.jsonl")
    assert (recording.problem, recording.ended) == (None, True)
    assert (tmp_path / "kept.jsonl").stat().st_size > before
    told = [event["ns"] for event in recording.events if event["kind"] == "host-pace"]
    assert told
    assert max(later - earlier for earlier, later in pairwise(told)) < 10**9, "bench time has a gap"


@REAL_TIME
@pytest.mark.exhaustive("the gate kills a bench that no terminal shows, and shows one that has ended (test_app)")
def test_a_bench_that_is_killed_leaves_the_dashboard_and_the_cause(terminal, tmp_path):
    shown = terminal("rover-model")
    shown.wait_for("station")
    (about,) = tmp_path.glob("hilbench/*/about.json")
    os.kill(json.loads(about.read_text())["pid"], signal.SIGKILL)
    shown.wait_for("the bench was killed by SIGKILL")
    shown.press("q")
    assert shown.end() == 0
    recording = Journal.read(about.with_name("journal.jsonl"))
    assert recording.events
    assert not recording.ended


def test_a_recording_is_opened_and_what_is_arranged_in_it_remembered(terminal, journals, tmp_path):
    shown = terminal("replay", str(journals["rover"]))
    shown.wait_for("recorded")
    shown.press(">")
    shown.press("q")
    assert shown.end() == 0
    assert '"span_s": 60' in (tmp_path / "state" / "hilbench" / "dashboard.json").read_text()


@pytest.mark.exhaustive("the gate has the exit code without a terminal, and why a bench ended on a screen (test_app)")
def test_a_port_that_is_not_there_is_said_on_the_screen(terminal, tmp_path):
    shown = terminal("--target", f"serial:{tmp_path / 'none'}")
    shown.wait_for("exit code 3")
    shown.press("q")
    assert shown.end() == 3


class Ended:
    """A bench's process that has ended by itself."""

    stdout = None

    def __init__(self, code):
        self.returncode = code

    def poll(self):
        return self.returncode

    def wait(self, timeout_s):
        return self.returncode


class Shown:
    """In the place of a dashboard: somebody looks until the bench has ended, and leaves."""

    return_code = 0

    def __init__(self, process, **_more):
        self.process = process

    def run(self):
        self.process.poll()


@pytest.mark.parametrize("code", [ExitCode.USAGE, ExitCode.UNAVAILABLE, ExitCode.OK])
def test_a_bench_that_never_began_ends_the_command_with_its_exit_code(code, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    monkeypatch.setattr(dashboard, "give_way", lambda: None)
    monkeypatch.setattr("hilbench.tui.app.Dashboard", Shown)
    assert dashboard.show(BenchProcess(Session(tmp_path), Ended(code))) == code


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["wrong.toml"], "wrong.toml"),
        (["--seed", "x"], "--seed: 'x' is not a whole number"),
        (["--scene=nosuch"], "--scene: no scene 'nosuch'"),
        (["--target=pioneer"], "--target pioneer: is no serial port"),
        (
            ["--target", "a=serial:x", "--target", "serial:y"],
            "--target a=serial:x --target serial:y: this bench has one line",
        ),
        (["vehicle", "--target", "stack=serial:x"], "--target: nothing at the line 'simulator'"),
        (["--web-host", "127.0.0.1"], "--web-host: goes with --web"),
        (["--journal", "none/session.jsonl"], "--journal none/session.jsonl: "),
    ],
)
def test_what_is_wrong_on_the_command_line_is_said_there(words, why, capfd, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "wrong.toml").write_text("version = 9\n")
    monkeypatch.setattr(dashboard, "require_terminal", lambda _hint: None)
    monkeypatch.setattr(BenchProcess, "start", lambda *_words, **_more: pytest.fail("a bench was begun"))
    assert main(words) == 2
    assert capfd.readouterr().err.startswith(f"hilbench: {why}")


def test_every_bench_goes_before_what_draws_it():
    found = []

    def dashboard_of_three():
        start = dashboard.ahead_of_us()
        dashboard.give_way()
        found.extend(start(lambda: os.getpriority(os.PRIO_PROCESS, 0)) for _ in range(3))
        found.append(os.getpriority(os.PRIO_PROCESS, 0))

    before = os.getpriority(os.PRIO_PROCESS, 0)
    thread = threading.Thread(target=dashboard_of_three)  # its niceness ends with it
    thread.start()
    thread.join()
    assert found == [before, before, before, min(19, before + 10)]
