"""A rover whose board is unplugged and comes back under another name, a hundred times, under load."""

from __future__ import annotations

import random

import pytest

from hilbench.bench import Bench
from hilbench.bench.devices import DeviceActor
from hilbench.clock import NS_PER_MS, Scheduler
from hilbench.driving.resuming import resume_sessions
from hilbench.driving.tap import Tap
from hilbench.journal import Journal
from hilbench.links import ReconnectingPort, SerialTarget
from hilbench.links.reconnecting import POLL_NS
from hilbench.systems.rover.ground_station import GroundStation
from hilbench.systems.rover.operator import RoverOperator
from hilbench.testing import FakeHostClock
from targets.robots.rover import RoverRobot, RoverSettings
from tests.hilbench.bay import Bay

TIMES = 100


class Powered:
    """A device whose time begins when it is plugged in, and which is dead once its plug is pulled."""

    def __init__(self, device, since_ns):
        self.device = device
        self.since_ns = since_ns

    def receive(self, data, now_ns):
        return self.device.receive(data, now_ns - self.since_ns) if self.device else b""

    def advance(self, now_ns):
        return self.device.advance(now_ns - self.since_ns) if self.device else b""

    def line_down(self, now_ns):
        self.device = None
        return b""

    def next_deadline_ns(self):
        deadline_ns = self.device.next_deadline_ns() if self.device else None
        return None if deadline_ns is None else deadline_ns + self.since_ns

    def take_events(self):
        return self.device.take_events() if self.device else []


@pytest.fixture
def bench(tmp_path):
    scheduler = Scheduler()
    scheduler.lock(FakeHostClock())
    made = Bench(scheduler, Journal(tmp_path / "journal.jsonl", keep=100_000))
    yield made
    scheduler.unlock()
    made.journal.close()


@pytest.fixture
def bay(bench):
    made = Bay(bench)
    made.attach = lambda far_end: DeviceActor(
        bench, Powered(RoverRobot(RoverSettings()), bench.now_ns), far_end, name="rover"
    )
    made.plug_in()
    return made


@pytest.fixture
def port(bench, bay):
    target = SerialTarget(url=bay.device, baud=0)  # without pace, a chunk is one entry
    made = ReconnectingPort(bench.scheduler, target, record=bench.record, ports=bay.ports, open_port=bay.open)
    yield made
    made.close()


def recorded(bench, kind):
    return [event for event in bench.journal.recent if event["kind"] == kind]


def test_a_hundred_times_under_load(bench, bay, port):
    tap = Tap(bench, port, "station", seed=1)
    station = GroundStation(bench, tap)
    operator = RoverOperator(bench, station)
    resume_sessions(tap, operator)
    operator.connect()

    def load():
        if operator.in_session:
            station.request()
            station.drive_motors(0.1, 0.1)
        bench.scheduler.after(20 * NS_PER_MS, load)

    load()
    chance = random.Random(8)
    reports = []
    for _ in range(TIMES):
        assert bench.run_until(lambda: operator.in_session, 5), "no session"
        before = station.counts.total()
        assert bench.run_until(lambda since=before: station.counts.total() > since, 5), "no reports"
        reports.append(station.counts.total())
        bench.run_for(chance.uniform(0, 0.1))
        bay.pull_out()
        assert bench.run_until(lambda: not port.line_is_up, 1)
        bench.run_for(chance.uniform(0, 0.9))
        bay.plug_in()
        lost_ns = recorded(bench, "port-lost")[-1]["ns"]
        assert bench.run_until(lambda: port.line_is_up, 1)
        polls = -(-(bay.plugged_ns - lost_ns) // POLL_NS) or 1
        assert recorded(bench, "port-returned")[-1]["ns"] == lost_ns + polls * POLL_NS, "not at the first poll"
    assert bench.run_until(lambda: operator.in_session, 5)
    tap.flush()
    bench.journal.close(bench.now_ns)

    events = Journal.read(bench.journal.path).events
    kinds = [event["kind"] for event in events if event["kind"].startswith("port-")]
    assert kinds == ["port-lost", "port-returned"] * TIMES
    returned = [event for event in events if event["kind"] == "port-returned"]
    assert all(event["device"] != event["was"] for event in returned)
    assert {event["serial_number"] for event in returned} == {"0668FF30"}
    heard = b"".join(bytes.fromhex(e["data"]) for e in events if e["kind"] == "rx" and e["source"] == "station")
    said = b"".join(bytes.fromhex(e["data"]) for e in events if e["kind"] == "tx" and e["source"] == "station")
    assert (len(heard), len(said)) == (port.counters.received, port.counters.sent)
    assert len(heard) > 10_000
    assert port.losses == TIMES
