"""A dashboard's bench as a process: it starts, obeys, and either side may die."""

from __future__ import annotations

import fcntl
import os
import select
import signal
import socket

import pytest

from hilbench.exit_codes import ExitCode
from hilbench.journal import Journal
from hilbench.live.folders import Session, sessions
from hilbench.tui import bench_process
from hilbench.tui.bench_process import BenchProcess, Phase

REAL_TIME = pytest.mark.real_time("a bench runs in a process of its own")


@pytest.fixture
def start(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.setattr(bench_process, "_PATIENCE_S", 600.0)
    begun = []

    def begin(what="rover-model"):
        begun.append(BenchProcess.start([what], name=what))
        return begun[-1]

    yield begin
    for process in begun:
        process.stop()


def poll_until(process, phase):
    """Look again and again until the bench is so far; the pause is for other processes' sake."""
    refused = []
    while process.phase is not phase:
        assert process.phase is not Phase.ENDED, process.cause
        select.select((), (), (), 0.02)
        refused += process.poll()
    return refused


@REAL_TIME
def test_a_bench_is_started_asked_and_stopped(start):
    process = start()
    poll_until(process, Phase.LIVE)
    assert "drive" in process.actions
    process.send("inject", kind="ghost")
    refused = []
    while not refused:
        select.select((), (), (), 0.02)
        refused = process.poll()
    assert refused[0].startswith("inject: no fault 'ghost'")
    folder = process.session.folder
    process.stop()
    assert not folder.exists()


@REAL_TIME
def test_a_bench_that_is_killed_is_seen_to_be(start):
    process = start()
    poll_until(process, Phase.LIVE)
    os.kill(int(process.about["pid"]), signal.SIGKILL)
    poll_until(process, Phase.ENDED)
    assert process.cause == "the bench was killed by SIGKILL"
    assert process.never_began == ExitCode.OK
    assert Journal.read(process.journal).events


def test_a_bench_that_cannot_begin_says_why(start):
    process = start("nonsense.toml")
    poll_until(process, Phase.ENDED)
    assert process.cause.startswith("the bench ended with exit code 2: nonsense.toml")
    assert process.never_began == ExitCode.USAGE


@pytest.mark.exhaustive("the gate leaves a bench and finds it again in test_commands")
@REAL_TIME
def test_a_bench_that_was_left_has_its_folder_and_is_found_there(start):
    process = start()
    poll_until(process, Phase.LIVE)
    process.leave()  # as one whose dashboard was killed
    folder = os.open(process.session.folder, os.O_RDONLY)
    with pytest.raises(BlockingIOError):
        fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
    (session,) = sessions()
    assert session.name == process.session.name
    again = BenchProcess(session)
    poll_until(again, Phase.LIVE)
    again.stop()
    assert not session.folder.exists()
    process._process.wait()
    fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
    os.close(folder)


def test_a_folder_that_others_can_look_into_is_refused(tmp_path, monkeypatch, start):
    (tmp_path / "hilbench").mkdir(mode=0o755)
    (tmp_path / "hilbench").chmod(0o755)
    with pytest.raises(Exception, match="not a private folder"):
        start()


class Ending:
    """A process that hangs up a moment before it has ended."""

    stdout = returncode = None

    def poll(self):
        return self.returncode

    def wait(self, _patience_s):
        return self.returncode


def test_how_a_bench_has_ended_is_asked_of_its_process_and_not_of_its_socket(tmp_path):
    session = Session(tmp_path)
    session.talk.write_text("hilbench: journal.jsonl: the journal cannot be written\n")
    process = BenchProcess(session, Ending())
    ours, its = socket.socketpair()
    ours.setblocking(False)
    process._socket, process.phase = ours, Phase.LIVE
    its.close()
    assert process.poll() == []
    process.send("drive")  # a moment too late
    assert process.poll() == []
    process._process.returncode = 3
    process.poll()
    assert process.phase is Phase.ENDED
    assert process.cause == "the bench ended with exit code 3: journal.jsonl: the journal cannot be written"
