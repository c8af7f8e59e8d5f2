"""A bench in real time that slips says so when it does, and not all the time."""

from __future__ import annotations

from itertools import pairwise

import pytest

from hilbench.clock import HEARTBEAT_NS, NS_PER_MS, NS_PER_S, Scheduler
from hilbench.pace.slips import SAID_EVERY_NS, SlipsSaid
from hilbench.serving import run_until_stopped
from hilbench.testing import FakeHostClock


class Told:
    """Another listener."""

    def __init__(self):
        self.calls = []

    def due(self, host_ns):
        self.calls.append("due")

    def ran(self, due_ns, began_ns, done_ns, *, spoke):
        self.calls.append("ran")

    def slipped(self, slip_ns, host_ns):
        self.calls.append(slip_ns)


class Rig:
    """A bench on a host that stalls when it is told to, and what was said at which millisecond of the host."""

    def __init__(self):
        self.host = FakeHostClock()
        self.begin_ns = self.host.host_ns
        self.scheduler = Scheduler()
        self.told = Told()
        self.said = []
        self.scheduler.lock(self.host, listener=SlipsSaid(self.say, self.begin_ns, self.told))

    def say(self, text):
        self.said.append(((self.host.host_ns - self.begin_ns) // NS_PER_MS, text))

    def stall(self, at_s, for_ms):
        self.host.stall(self.begin_ns + at_s * NS_PER_S, for_ms * NS_PER_MS)

    def run(self, seconds):
        self.scheduler.run_for(seconds * NS_PER_S)


@pytest.fixture
def rig():
    return Rig()


def test_a_slip_is_said_when_it_happens_with_how_much_and_the_factor(rig):
    rig.stall(20, 500)
    rig.run(60)
    assert rig.said == [
        (20_500, "this host is late: bench time stood still for 500 ms, 0.952 x real time in the last 10.5 s")
    ]


def test_one_soon_after_the_begin_is_measured_from_there(rig):
    rig.stall(1, 1000)
    rig.run(20)
    assert rig.said == [
        (2000, "this host is late: bench time stood still for 1000 ms, 0.500 x real time in the last 2.0 s")
    ]


def test_then_not_again_for_a_while_but_nothing_goes_unsaid(rig):
    for at_s in range(3, 13):
        rig.stall(at_s, 100)
    rig.run(60)
    first, others = rig.said
    assert first == (3100, "this host is late: bench time stood still for 100 ms, 0.968 x real time in the last 3.1 s")
    at_ms, text = others
    assert 0 <= (at_ms - 3100) * NS_PER_MS - SAID_EVERY_NS <= HEARTBEAT_NS
    assert text == (
        "this host is late: bench time stood still for 900 ms in 9 slips, 0.910 x real time in the last 10.0 s"
    )


def test_a_host_that_is_always_late_is_said_at_most_every_ten_seconds(rig):
    for at_s in range(1, 100):
        rig.stall(at_s, 100)
    rig.run(100)
    times_ms = [at_ms for at_ms, _ in rig.said]
    assert all(later - sooner >= SAID_EVERY_NS // NS_PER_MS for sooner, later in pairwise(times_ms))
    assert 10 <= len(times_ms) <= 11
    assert rig.scheduler.slips == 99


def test_a_host_that_was_asleep(rig):
    rig.stall(30, 3_600_000)
    rig.run(60)
    assert [text for _, text in rig.said] == [
        "this host is late: bench time stood still for 3600000 ms, 0.003 x real time in the last 3610.0 s"
    ]


def test_a_little_late_is_no_slip(rig):
    for at_s in range(1, 10):
        rig.stall(at_s, 50)
    rig.run(10)
    assert rig.said == []


def test_another_listener_hears_all_of_it(rig):
    rig.stall(1, 100)
    rig.run(2)
    assert rig.told.calls.count(100 * NS_PER_MS) == 1
    assert rig.told.calls.count("due") >= rig.told.calls.count("ran") >= 200


def test_a_pause_before_the_run_is_a_slip_of_all_the_time_there_was(rig):
    rig.host.advance(NS_PER_S)
    rig.run(1)
    assert [text for _, text in rig.said] == [
        "this host is late: bench time stood still for 1000 ms, 0.000 x real time in the last 1.0 s"
    ]


def test_whoever_serves_says_it_with_the_bench_time_and_sums_up_at_the_end(monkeypatch, tmp_path):
    host, scheduler, said = FakeHostClock(), Scheduler(), []
    host.close = lambda: None
    monkeypatch.setattr("hilbench.serving.MonotonicHostClock", lambda: host)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    host.stall(host.host_ns + NS_PER_S, 250 * NS_PER_MS)
    run_until_stopped(scheduler, said.append, lambda: scheduler.now_ns >= 2 * NS_PER_S)
    assert said[1].endswith(
        " s  this host is late: bench time stood still for 250 ms, 0.800 x real time in the last 1.2 s"
    )
    assert said[1].startswith("     0.995")
    assert said[2].startswith("stopped after 2.0 s at 0.889 x real time;")
    assert said[2].endswith("1 slips")
