from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from hilbench.live.folders import Session
from hilbench.live.session import LiveBench, LiveOptions
from hilbench.mcu.command_line import open_target
from hilbench.testing import FakeHostClock
from hilbench.tui.bench_process import Phase
from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.follower import Follower

EXPECTED = Path(__file__).parent / "expected"
WRITE = bool(os.environ.get("HILBENCH_WRITE_SCREENS"))
ACTIONS = (
    "connect", "demo", "disconnect", "drive", "clear-faults", "inject", "mark", "pause", "quit", "resume", "speed",
    "step", "stop",
)  # fmt: skip


def record(folder, bench, seconds):
    """Run a live bench on a clock that never waits, with a fault, a mark and somebody at the stick."""
    path = folder / f"{bench}.jsonl"
    live = LiveBench(open_target(bench), LiveOptions(session=Session(folder), journal=path))
    live.bench.scheduler.lock(FakeHostClock())
    live.bench.run_for(seconds / 2)
    live.actions.obey({"do": "inject", "kind": "noise", "probability": 0.05, "count": 3})
    live.bench.run_for(seconds / 4)
    live.actions.obey({"do": "clear-faults"})
    live.actions.obey({"do": "mark", "text": "three quarters"})
    live.actions.obey({"do": "drive", "forward": 0.5, "turn": -0.2})
    live.bench.run_for(seconds / 4)
    live.close()
    return path


@pytest.fixture(scope="session")
def journals(tmp_path_factory):
    folder = tmp_path_factory.mktemp("journals")
    return {
        "pioneer": record(folder, "pioneer-plane", 8.0),
        "rover": record(folder, "rover-model", 6.0),
        "vehicle": record(folder, "vehicle-model", 6.0),
    }


def read(path):
    follower = Follower(path)
    events = []
    while batch := follower.news():
        events += batch
    follower.close()
    return follower.header, events


@pytest.fixture(scope="session")
def recordings(journals):
    return {name: read(path) for name, path in journals.items()}


@pytest.fixture
def model_of(recordings):
    """Make the model of a recording, whole or up to a bench time."""

    def make(name, until_s=None):
        header, events = recordings[name]
        model = BenchModel(header)
        model.take(event for event in events if until_s is None or event["ns"] <= until_s * 1e9)
        return model

    return make


@pytest.fixture
def expect():
    """Compare a screen with the one that is stored; HILBENCH_WRITE_SCREENS=1 stores it anew."""

    def compare(name, lines):
        text = "\n".join(line.rstrip() for line in lines) + "\n"
        path = EXPECTED / f"{name}.txt"
        if WRITE:
            path.parent.mkdir(exist_ok=True)
            path.write_text(text)
        assert text == path.read_text()

    return compare


class FakeProcess:
    """A bench that is a recording; takes down what it is asked for."""

    def __init__(self, journal):
        self.journal = journal
        self.phase = Phase.LIVE
        self.cause = ""
        self.ended_well = False
        self.about = {}
        self.actions = ACTIONS
        self.sent = []
        self.refusals = []

    def poll(self):
        refusals, self.refusals = self.refusals, []
        return refusals

    def send(self, do, **more):
        self.sent.append((do, more))

    def stop(self):
        self.sent.append(("stopped", {}))

    def leave(self):
        self.sent.append(("left", {}))


@pytest.fixture
def process_of(journals):
    return lambda name: FakeProcess(journals[name])


@pytest.fixture
def journal_file(tmp_path):
    """Write a journal of events of one's own."""

    def write(events, **live):
        path = tmp_path / "own.jsonl"
        header = {"kind": "journal", "part": 0, "bench": "own", "live": live}
        path.write_text("".join(json.dumps(line) + "\n" for line in (header, *events)))
        return path

    return write
