from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import subprocess
import sys

import pytest

from hilbench.driving.local_socket import connect_to
from hilbench.live.folders import Session

PATIENCE_S = 600
LOOK_EVERY_S = 0.02


class Live:
    """A live bench as a process, and a client at its socket."""

    def __init__(self, folder, bench, *words):
        self.session = Session(folder)
        command = [sys.executable, "-m", "hilbench", "live", bench, "--folder", str(folder), *words]
        with self.session.talk.open("w") as talk:
            self.process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=talk, start_new_session=True
            )
        assert self.process.stdout.readline(), self.session.talk.read_text()  # it says when it has begun
        self.process.stdout.close()
        self.process.pid_fd = os.pidfd_open(self.process.pid)
        self.seen, self.read_to, self.client = [], 0, None

    def join(self):
        self.client = connect_to(self.session.socket)
        self.client.settimeout(PATIENCE_S)
        self.answers = self.client.makefile("r")

    def ask(self, do, **more):
        self.client.sendall(json.dumps({"id": 1, "do": do, **more}).encode() + b"\n")
        return json.loads(self.answers.readline())

    def do(self, name, **more):
        answer = self.ask(name, **more)
        assert answer == {"id": 1, "ok": True}, answer

    def events(self):
        """Return what the journal holds by now."""
        with self.session.journal.open("rb") as journal:
            journal.seek(self.read_to)
            data = journal.read()
        whole = data[: data.rfind(b"\n") + 1]
        self.read_to += len(whole)
        self.seen += [json.loads(line) for line in whole.splitlines()]
        return self.seen

    def wait_for(self, condition):
        """Read the journal until an event is there; give it back."""
        looked_at = 0
        for _ in range(round(PATIENCE_S / LOOK_EVERY_S)):
            events = self.events()
            for event in events[looked_at:]:
                if condition(event):
                    return event
            looked_at = len(events)
            assert self.process.poll() is None, self.session.talk.read_text()
            select.select((self.process.pid_fd,), (), (), LOOK_EVERY_S)
        raise AssertionError(f"it is not told; the last: {self.seen[-1]}")

    def leave(self):
        self.answers.close()
        self.client.close()

    def end(self):
        if self.client is not None:
            self.leave()
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        os.close(self.process.pid_fd)
        try:
            return self.process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise


@pytest.fixture
def live(tmp_path):
    """Start live benches; they end with the test."""
    with benches(tmp_path) as start:
        yield start


@pytest.fixture(scope="module")
def rover(tmp_path_factory):
    """A rover that several tests ask for something, one after the other; its station is in touch with it."""
    with benches(tmp_path_factory.mktemp("rover")) as start:
        bench = start("rover-model")
        bench.wait_for(lambda event: event["kind"] == "machine" and event.get("state") == "LINKED")
        yield bench


@contextlib.contextmanager
def benches(folder):
    begun = []

    def start(bench="pioneer-plane", *words):
        session = folder / f"session-{len(begun)}"
        session.mkdir(mode=0o700)
        begun.append(Live(session, bench, *words))
        begun[-1].join()
        return begun[-1]

    yield start
    for one in begun:
        one.end()
