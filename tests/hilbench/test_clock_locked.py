from __future__ import annotations

import os
import signal
import threading

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from hilbench.bench import Bench
from hilbench.check import Inconclusive, at_most
from hilbench.clock import (
    EventClass,
    MonotonicHostClock,
    ScaledHostClock,
    Scheduler,
    Stopwatch,
    deferred_interrupts,
)
from hilbench.errors import InternalError
from hilbench.journal import Journal
from hilbench.testing import FakeHostClock
from tests.share import examples

MS = 1_000_000


class Input:
    """An input that takes down when it was read and delivers as an entry, as links do."""

    def __init__(self, scheduler, descriptor=-1):
        self.scheduler = scheduler
        self.descriptor = descriptor
        self.stamps_ns = []
        self.delivered_ns = []

    def fileno(self):
        return self.descriptor

    def on_readable(self, at_ns):
        if self.descriptor >= 0:
            os.read(self.descriptor, 100)
        self.stamps_ns.append(at_ns)
        self.scheduler.at(at_ns, lambda: self.delivered_ns.append(self.scheduler.now_ns), order=EventClass.INPUT)


@pytest.fixture
def host():
    return FakeHostClock()


@pytest.fixture
def scheduler(host):
    scheduler = Scheduler()
    scheduler.lock(host, heartbeat_ns=None)
    return scheduler


@pytest.mark.parametrize("factor", [0.25, 4])
def test_follows_a_host_whose_clock_is_scaled(host, factor):
    scheduler = Scheduler()
    scheduler.lock(ScaledHostClock(host, factor), heartbeat_ns=None)
    start_ns = host.host_ns
    seen = []
    for when_ns in (1 * MS, 8 * MS):
        scheduler.at(when_ns, lambda: seen.append(host.host_ns - start_ns))
    scheduler.run_for(12 * MS)
    assert seen == [1 * MS / factor, 8 * MS / factor]
    assert scheduler.lateness_max_ns(0) == 0


def test_follows_the_host(scheduler, host):
    start_ns = host.host_ns
    seen = []
    for when_ns in (1 * MS, 7 * MS):
        scheduler.at(when_ns, lambda: seen.append(host.host_ns - start_ns))
    scheduler.run_for(10 * MS)
    assert seen == [1 * MS, 7 * MS]
    assert host.host_ns - start_ns == 10 * MS
    assert scheduler.lateness_max_ns(0) == 0
    assert scheduler.real_time_factor == 1.0


def test_input_wakes_at_once_and_is_stamped_with_that_moment(scheduler, host):
    source = Input(scheduler)
    scheduler.add_source(source)
    host.arrive(host.host_ns + 3 * MS, source)
    assert scheduler.run_until(lambda: bool(source.delivered_ns), 10 * MS)
    assert source.stamps_ns == source.delivered_ns == [3 * MS] == [scheduler.now_ns]


def test_waits_for_input_without_a_deadline(scheduler, host):
    source = Input(scheduler)
    assert scheduler.run_until(lambda: False, None) is False
    scheduler.add_source(source)
    host.arrive(host.host_ns + 3 * MS, source)
    assert scheduler.run_until(lambda: bool(source.delivered_ns), None)


def test_a_little_late_is_caught_up_and_measured(scheduler, host):
    start_ns = host.host_ns
    ran = []
    for when_ns in range(MS, 100 * MS, MS):
        scheduler.at(when_ns, lambda: ran.append((scheduler.now_ns, host.host_ns - start_ns)))
    host.stall(start_ns + 10 * MS, 20 * MS)
    scheduler.run_for(100 * MS)
    assert [bench_ns for bench_ns, _ in ran] == list(range(MS, 100 * MS, MS))
    assert [host_ns for bench_ns, host_ns in ran if bench_ns < 10 * MS or bench_ns > 30 * MS] == [
        bench_ns for bench_ns, _ in ran if bench_ns < 10 * MS or bench_ns > 30 * MS
    ]
    assert (scheduler.slips, scheduler.slipped_ns) == (0, 0)
    assert 20 * MS <= scheduler.lateness_max_ns(0) <= 22.5 * MS
    assert scheduler.lateness_max_ns(31 * MS) == 0


def test_very_late_slips_and_skips_nothing(scheduler, host):
    start_ns = host.host_ns
    ran = []
    for when_ns in range(10 * MS, 60 * MS, 10 * MS):
        scheduler.at(when_ns, lambda: ran.append((scheduler.now_ns, host.host_ns - start_ns)))
    host.stall(start_ns + 30 * MS, 3000 * MS)
    scheduler.run_for(60 * MS)
    assert ran == [(10 * MS, 10 * MS), (20 * MS, 20 * MS)] + [(n * MS, (n + 3000) * MS) for n in (30, 40, 50)]
    assert (scheduler.slips, scheduler.slipped_ns) == (1, 3000 * MS)
    assert scheduler.lateness_max_ns(0) >= 3000 * MS
    assert scheduler.real_time_factor == pytest.approx(60 / 3060)


def test_input_during_a_stall_belongs_to_the_moment_time_stood_still(scheduler, host):
    source = Input(scheduler)
    scheduler.add_source(source)
    order = []
    scheduler.at(30 * MS, lambda: order.append(len(source.delivered_ns)))
    host.stall(host.host_ns + 30 * MS, 3000 * MS)
    host.arrive(host.host_ns + 1000 * MS, source)
    scheduler.run_for(60 * MS)
    assert source.stamps_ns == [30 * MS]
    assert order == [1]


def test_inputs_are_looked_at_while_running_late(scheduler, host):
    source = Input(scheduler)
    scheduler.add_source(source)
    for when_ns in range(MS, 40 * MS, MS):
        scheduler.at(when_ns, lambda: host.advance(2 * MS))
    host.arrive(host.host_ns + 10 * MS, source)
    scheduler.run_for(40 * MS)
    assert len(source.stamps_ns) == 1
    assert 10 * MS <= source.stamps_ns[0] <= 13 * MS


@example(work=[(0, 5 * MS + 1), (0, 50 * MS)], arrivals=[0, 5 * MS + 2], stalls=[])
@settings(max_examples=examples(60))
@given(
    work=st.lists(st.tuples(st.integers(0, 200 * MS), st.integers(0, 80 * MS)), max_size=25),
    arrivals=st.lists(st.integers(0, 300 * MS), max_size=10),
    stalls=st.lists(st.tuples(st.integers(0, 300 * MS), st.integers(0, 200 * MS)), max_size=5),
)
def test_time_never_runs_backwards_and_nothing_is_lost(work, arrivals, stalls):
    host = FakeHostClock()
    scheduler = Scheduler()
    scheduler.lock(host)
    source = Input(scheduler)
    scheduler.add_source(source)
    ran = []
    for when_ns, effort_ns in work:
        scheduler.at(when_ns, lambda effort_ns=effort_ns: (ran.append(scheduler.now_ns), host.advance(effort_ns)))
    for offset_ns in arrivals:
        host.arrive(host.host_ns + offset_ns, source)
    for offset_ns, duration_ns in stalls:
        host.stall(host.host_ns + offset_ns, duration_ns)
    scheduler.run_for(20_000 * MS)
    assert ran == sorted(when_ns for when_ns, _ in work)
    assert source.delivered_ns == source.stamps_ns == sorted(source.stamps_ns)
    assert bool(source.stamps_ns) == bool(arrivals)


def test_a_pause_between_runs_is_not_bench_time(scheduler, host):
    source = Input(scheduler)
    scheduler.add_source(source)
    scheduler.run_for(10 * MS)
    host.advance(3000 * MS)
    host.arrive(host.host_ns + 150 * MS, source)
    assert scheduler.run_until(lambda: bool(source.delivered_ns), 210 * MS)
    assert source.delivered_ns == [160 * MS]
    assert scheduler.slipped_ns == 3000 * MS
    assert scheduler.lateness_max_ns(10 * MS) == 0
    assert scheduler.lateness_max_ns(9 * MS) >= 3000 * MS


def test_heartbeat_measures_when_nothing_is_due(host):
    scheduler = Scheduler()
    scheduler.lock(host)
    host.stall(host.host_ns + 100 * MS, 30 * MS)
    scheduler.run_for(1000 * MS)
    assert scheduler.lateness.count >= 200
    assert 30 * MS <= scheduler.lateness_max_ns(90 * MS) <= 34 * MS
    assert scheduler.lateness.quantile_ns(0.5) == 0
    scheduler.unlock()
    scheduler.unlock()
    assert scheduler.next_ns() is None


def test_lock_and_unlock_carry_the_sources_along(host):
    scheduler = Scheduler()
    source = Input(scheduler)
    scheduler.add_source(source)
    scheduler.lock(host)
    with pytest.raises(InternalError):
        scheduler.lock(host)
    assert host.watched == [source]
    scheduler.unlock()
    assert host.watched == []
    scheduler.lock(host)
    scheduler.remove_source(source)
    scheduler.remove_source(source)
    assert host.watched == []


@pytest.mark.real_time("the clock of the host itself: never early, and awake when something comes")
class TestRealHost:
    @pytest.fixture
    def real(self):
        host = MonotonicHostClock()
        scheduler = Scheduler()
        scheduler.lock(host)
        yield scheduler
        host.close()

    def test_never_early(self):
        # The watch starts before bench time is tied to the host, so a stall in between cannot make an entry look early.
        host, scheduler, watch = MonotonicHostClock(), Scheduler(), Stopwatch()
        scheduler.lock(host)
        elapsed_s = []
        for step in range(1, 11):
            scheduler.at(step * 2 * MS, lambda: elapsed_s.append(watch.elapsed_s()))
        scheduler.run_for(20 * MS)
        host.close()
        assert all(host_s >= step * 0.002 for step, host_s in enumerate(elapsed_s, 1))

    def test_a_byte_wakes_the_loop(self, real):
        reader, writer = os.pipe()
        source = Input(real, reader)
        real.add_source(source)
        timer = threading.Timer(0.01, os.write, (writer, b"x"))
        timer.start()
        assert real.run_until(lambda: bool(source.delivered_ns), 60_000 * MS)
        assert real.now_ns < 60_000 * MS
        real.remove_source(source)
        timer.join()
        os.close(reader)
        os.close(writer)

    def test_an_interrupt_ends_a_long_wait(self, real):
        real.unlock()
        host = MonotonicHostClock()
        real.lock(host, heartbeat_ns=None)
        timer = threading.Timer(0.01, os.kill, (os.getpid(), signal.SIGINT))
        real.at(real.now_ns, timer.start)  # not before the interrupt is expected
        with pytest.raises(KeyboardInterrupt), deferred_interrupts(real):
            real.run_for(3600_000 * MS)
        timer.join()
        host.close()


def stall(host, by_ns):
    """What a host does to a process it does not run: its clock goes on."""
    host.host_ns += by_ns


def test_what_slipped_adds_up_from_any_moment(host):
    scheduler = Scheduler()
    scheduler.lock(host)
    for when_ms in (10, 20, 30):
        scheduler.at(when_ms * MS, lambda: stall(host, 60 * MS))
    scheduler.run_for(100 * MS)
    assert scheduler.slips == 3
    assert scheduler.slipped_since_ns(0) == scheduler.slipped_ns
    after_second = scheduler.slipped_since_ns(25 * MS)
    assert 0 < after_second < scheduler.slipped_ns
    assert scheduler.slipped_since_ns(scheduler.now_ns) == 0


def test_a_span_with_many_slips_is_as_uncertain_as_all_of_them(host):
    """Ten stalls of 150 ms: 2.4 s of bench time were 3.9 s for a robot; no limit in between can be judged."""
    bench = Bench(Scheduler(), Journal())
    bench.scheduler.lock(host)
    for number in range(10):
        bench.scheduler.at((100 + 200 * number) * MS, lambda: stall(host, 150 * MS))
    start_ns, host_start_ns = bench.now_ns, host.host_ns
    bench.run_for(2.4)
    really_s = (host.host_ns - host_start_ns) / 1e9
    assert really_s == pytest.approx(3.9, abs=0.2)
    assert 2.4 + bench.uncertainty_s(start_ns) >= really_s
    with pytest.raises(Inconclusive):
        at_most(2.4, 2.917, unit="s", what="stopped after", uncertainty=bench.uncertainty_s(start_ns))


def test_a_pause_between_runs_spoils_the_spans_that_hold_it_and_no_other(scheduler, host):
    scheduler.run_for(10 * MS)
    stall(host, 200 * MS)
    scheduler.run_for(10 * MS)
    assert scheduler.slipped_since_ns(0) == 200 * MS
    assert scheduler.slipped_since_ns(10 * MS) == 0
