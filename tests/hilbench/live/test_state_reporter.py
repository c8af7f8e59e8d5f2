from __future__ import annotations

import enum
import json
from dataclasses import dataclass

import pytest

from hilbench.bench import Bench
from hilbench.bench.devices import DeviceActor
from hilbench.bench.state_reporter import Sense, StateReporter, describe_machine
from hilbench.clock import NS_PER_MS, Scheduler
from hilbench.driving.tap import Tap
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.links.faults import Direction, Fault, FaultKind
from hilbench.systems.rover.ground_station import GroundStation
from protocols.p2os import CLIENT_TABLE, Connection, Role
from protocols.pkt import PROFILES
from protocols.pkt import Counters as PktCounters
from targets.robots.rover import RoverRobot, RoverSettings


class Rig:
    """A station and a rover that a reporter looks at, in virtual time."""

    def __init__(self, tmp_path):
        self.path = tmp_path / "journal.jsonl"
        self.bench = Bench(Scheduler(), Journal(self.path))
        link = MemoryLink(self.bench.scheduler, Line(baud=115200), name="host")
        self.robot = RoverRobot(RoverSettings())
        DeviceActor(self.bench, self.robot, link.b, name="rover")
        self.tap = Tap(self.bench, link.a, "station", seed=1)
        self.station = GroundStation(self.bench, self.tap, PROFILES["documented"])
        machines = {"station": self.station.connection, "rover": self.robot.connection}
        self.reporter = StateReporter(self.bench, machines, {"host": self.tap})
        self.reporter.after.append(self.tap.flush)

    def run(self, seconds):
        self.bench.run_for(seconds)

    def told(self, kind, source):
        return [event for event in self.bench.journal.recent if (event["kind"], event["source"]) == (kind, source)]

    def last(self, kind, source, field):
        return next(event[field] for event in reversed(self.told(kind, source)) if field in event)


@pytest.fixture
def rig(tmp_path):
    return Rig(tmp_path)


def test_state_visits_and_counters_are_told_when_they_change(rig):
    rig.station.connect()
    rig.run(2.0)
    assert rig.last("machine", "station", "state") == "LINKED"
    assert rig.last("machine", "rover", "state") == "LINKED"
    visits = {}
    for event in rig.told("machine", "station"):
        visits |= {(state, trigger): count for state, trigger, count in event.get("visits", ())}
    assert visits == {
        (state.name, trigger.name): count for (state, trigger), count in rig.station.connection.visits.items()
    }
    quiet = [event for event in rig.told("machine", "station") if not event.keys() - {"ns", "kind", "source"}]
    assert not quiet


def test_the_margin_of_a_watchdog_is_what_was_left_when_it_was_fed(rig):
    rig.station.connect()
    rig.run(1.0)
    timers = rig.last("machine", "rover", "timers")
    server = rig.robot.connection
    assert {timer.name for timer in server.deadlines} == {"WATCHDOG"}
    watchdog = timers["WATCHDOG"]
    assert watchdog["deadline_ns"] == next(iter(server.deadlines.values()))
    assert 0 < watchdog["worst_ns"] <= watchdog["margin_ns"] < watchdog["span_ns"]


def test_a_watchdog_that_runs_out_has_no_margin_left(rig):
    rig.station.connect()
    rig.run(1.0)
    rig.station.disconnect()
    rig.run(10.0)
    watchdog = rig.last("machine", "rover", "timers")["WATCHDOG"]
    assert (watchdog["deadline_ns"], watchdog["worst_ns"]) == (None, 0)
    assert rig.last("machine", "rover", "state") == "LOST"


def test_everything_is_told_again_now_and_then(rig):
    rig.station.connect()
    rig.run(12.0)
    whole = [
        event["ns"]
        for event in rig.told("machine", "rover")
        if "bytes_in" in event.get("counters", {}) and "bad_lengths" in event["counters"]
    ]
    assert whole == [0, 5000 * NS_PER_MS, 10000 * NS_PER_MS]


def test_what_the_operator_hears_stands_in_the_journal(rig):
    rig.station.connect()
    rig.run(1.0)
    heard = b"".join(bytes.fromhex(event["data"]) for event in rig.told("rx", "station"))
    sent = b"".join(bytes.fromhex(event["data"]) for event in rig.told("tx", "rover"))
    assert heard
    assert sent.startswith(heard)
    assert rig.last("link", "host", "received") == rig.tap.counters.received


def test_the_file_is_never_more_than_a_turn_behind(rig):
    rig.station.connect()
    rig.run(0.95)
    events = [json.loads(line) for line in rig.path.read_text().splitlines()]
    assert events[-1]["ns"] >= 900 * NS_PER_MS


def test_injected_noise_is_counted_at_the_far_end_and_recorded(rig):
    rig.station.connect()
    rig.run(1.0)
    before = rig.robot.connection.counters.noise + rig.robot.connection.counters.bad_syncs
    rig.tap.inject(Fault(kind=FaultKind.NOISE, direction=Direction.A_TO_B, probability=0.2, count=3))
    rig.run(2.0)
    counters = rig.robot.connection.counters
    assert counters.noise + counters.bad_syncs > before
    faults = rig.told("fault", "line")
    assert faults
    assert {(event["fault"], event["towards"]) for event in faults} == {("noise", "target")}
    assert rig.tap.clear() == 1
    count = len(faults)
    rig.run(1.0)
    assert len(rig.told("fault", "line")) == count


@pytest.mark.parametrize("more", [{"kind": FaultKind.DISCONNECT}, {"kind": FaultKind.BAUD, "baud": 300}], ids=str)
def test_faults_of_the_line_are_taken_back_and_do_not_end_a_later_one(rig, more):
    rig.station.connect()
    rig.run(1.0)
    rig.tap.inject(Fault(at_s=0.0, duration_s=4.0, **more))
    rig.run(0.2)
    assert rig.tap.clear() == 1
    assert rig.tap.clear() == 0
    assert rig.tap.line_is_up
    assert not rig.tap.port._wire_baud
    rig.run(3.0)
    rig.tap.inject(Fault(at_s=0.0, duration_s=4.0, **more))
    rig.run(1.5)  # the first would have ended by now
    assert not rig.tap.line_is_up or rig.tap.port._wire_baud
    rig.run(3.0)
    assert rig.tap.line_is_up
    assert not rig.tap.port._wire_baud
    assert rig.tap.clear() == 0


def test_a_fault_that_strikes_once_strikes_once(rig):
    rig.station.connect()
    rig.run(1.0)
    rig.tap.inject(Fault(kind=FaultKind.DROP, direction=Direction.B_TO_A, at_s=0.0))
    rig.run(2.0)
    assert len(rig.told("fault", "line")) == 1


def test_an_interrupted_line_comes_back(rig):
    rig.station.connect()
    rig.run(1.0)
    rig.tap.inject(Fault(kind=FaultKind.DISCONNECT, at_s=0.0, duration_s=0.5))
    rig.run(0.3)
    assert rig.last("link", "host", "up") is False
    rig.run(1.0)
    assert rig.last("link", "host", "up") is True
    assert rig.last("machine", "station", "state") == "LINKED"


def test_a_table_is_described_whole():
    about = describe_machine(Connection(Role.CLIENT))
    assert about["begins"] == "IDLE"
    assert len(about["edges"]) == len(CLIENT_TABLE)
    assert set(about["states"]) == {name for edge in about["edges"] for name in (edge[0], edge[2])}
    assert about["states"]["OPEN"] == "in session"


class Ended(enum.Enum):
    """The timers of something that is looked at."""

    WAIT = "for something"
    REST = "for a while"


@dataclass
class Looked:
    """Something that is looked at, as a test wants it to be."""

    deadlines: dict
    misses: dict
    visits: dict

    state = Ended.WAIT
    counters = PktCounters()


def test_a_wait_that_ends_early_was_met_and_a_rest_has_no_margin(tmp_path):
    bench = Bench(Scheduler(), Journal(tmp_path / "journal.jsonl"))
    looked = Looked(deadlines={}, misses={Ended.WAIT: (0, 10)}, visits={})
    StateReporter(bench, {"it": looked}, {}, senses={"it": {"WAIT": Sense.WAIT, "REST": Sense.REST}})

    def last(field):
        return next(event[field] for event in reversed(bench.journal.recent) if field in event)

    def at(deadlines, misses=0):
        looked.deadlines = deadlines
        looked.misses = {Ended.WAIT: (misses, 10)}
        bench.record("look", "test")
        bench.run_for(0.1)

    at({Ended.WAIT: bench.now_ns + 300 * NS_PER_MS})
    at({Ended.REST: bench.now_ns + 60 * NS_PER_MS}, misses=7)
    at({}, misses=2)
    timers = last("timers")
    assert timers["WAIT"] == {
        "rest": False,
        "deadline_ns": None, "span_ns": 300 * NS_PER_MS, "margin_ns": 200 * NS_PER_MS, "worst_ns": 200 * NS_PER_MS,
    }  # fmt: skip
    assert (timers["REST"]["margin_ns"], timers["REST"]["worst_ns"]) == (None, None)
    assert last("misses") == {"WAIT": [2, 10, 7]}


def test_edges_of_a_machine_that_was_reset_are_none_again(tmp_path):
    bench = Bench(Scheduler(), Journal(tmp_path / "journal.jsonl"))
    looked = Looked(deadlines={}, misses={}, visits={(Ended.WAIT, Ended.REST): 3})
    StateReporter(bench, {"it": looked}, {})
    looked.visits = {}
    bench.run_for(0.15)
    told = [event["visits"] for event in bench.journal.recent if "visits" in event]
    assert told == [[["WAIT", "REST", 3]], [["WAIT", "REST", 0]]]


def test_what_else_is_looked_at_is_told_when_it_changes(tmp_path):
    bench = Bench(Scheduler(), Journal(tmp_path / "journal.jsonl"))
    seen = {"light": "red"}
    StateReporter(bench, {}, {}, views={"vehicle": lambda: dict(seen)})
    bench.run_for(0.35)
    seen["light"] = "green"
    bench.run_for(0.2)
    told = [(event["ns"] // NS_PER_MS, event["light"]) for event in bench.journal.recent if event["kind"] == "vehicle"]
    assert told == [(0, "red"), (400, "green")]
