"""Bench files written on the spot; pins and chips that only remember."""

from __future__ import annotations

import heapq
from types import SimpleNamespace

import pytest

from hilbench.bench import Bench
from hilbench.benchfile.reader import open_bench
from hilbench.clock import Scheduler
from hilbench.journal import Journal


class FakePin:
    """A pin whose edges a test makes, as a chip does that runs ahead of the bench."""

    def __init__(self, level=None):
        self.level = level
        self.latch = False
        self.driven = []
        self.volts = []
        self._listeners = []

    def on_edge(self, callback):
        self._listeners.append(callback)

    def edge(self, ns, level):
        self.level = level
        for callback in self._listeners:
            callback(ns // 14, ns, level)

    def drive(self, level):
        self.driven.append(level)

    def drive_volts(self, volts):
        self.volts.append(volts)


class FakeMachine:
    """A chip that does what is put into it when it is told to run."""

    def __init__(self, **pins):
        self.chip = SimpleNamespace(pins={name: FakePin(level) for name, level in pins.items()}, i2cs={})
        self.done = []
        self._booked = []

    def at_ns(self, ns, action):
        heapq.heappush(self._booked, (ns, len(self._booked) + len(self.done), action))

    def run(self):
        while self._booked:
            ns, _, action = heapq.heappop(self._booked)
            self.done.append(ns)
            action()


@pytest.fixture
def bench():
    return Bench(Scheduler(), Journal())


@pytest.fixture(scope="session")
def pin():
    return FakePin


@pytest.fixture
def machine():
    return FakeMachine


@pytest.fixture
def read(tmp_path):
    (tmp_path / "a.elf").write_bytes(b"")

    def open_text(text):
        file = tmp_path / "my.toml"
        file.write_text(text)
        return open_bench(str(file))

    return open_text
