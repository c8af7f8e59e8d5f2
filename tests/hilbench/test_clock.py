from __future__ import annotations

import gc
import signal
from fractions import Fraction
from functools import partial

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.clock import (
    ClockDomain,
    EventClass,
    LatenessMeter,
    Scheduler,
    Stopwatch,
    deferred_interrupts,
    wall_time_iso,
)
from hilbench.errors import InternalError
from tests.each import each

rates = st.one_of(
    st.integers(1, 10**9),
    st.fractions(min_value=Fraction(1, 1000), max_value=10**9, max_denominator=10_000),
)


class TestClockDomain:
    @given(hz=rates, ticks=st.integers(0, 10**15))
    def test_ticks_invert_ns(self, hz, ticks):
        domain = ClockDomain(hz)
        assert domain.ticks(domain.ns(ticks)) == ticks

    @given(hz=rates, ticks=st.integers(0, 10**15))
    def test_rounded_down_and_never_accumulated(self, hz, ticks):
        exact = Fraction(ticks) * 10**9 / Fraction(hz)
        assert ClockDomain(hz).ns(ticks) <= exact < ClockDomain(hz).ns(ticks) + 1

    @given(hz=rates, ns=st.integers(0, 10**18))
    def test_last_tick_that_has_fallen(self, hz, ns):
        domain = ClockDomain(hz)
        ticks = domain.ticks(ns)
        assert domain.ns(ticks) <= ns < domain.ns(ticks + 1)

    def test_known_values(self):
        assert ClockDomain(9600).ns(10) == 1_041_666
        assert ClockDomain(9600).ns(9600) == 10**9
        assert ClockDomain(Fraction(72_000_000, 7500)).ns(9600) == 10**9

    @each("hz", [0, -1])
    def test_needs_a_rate(self, hz):
        with pytest.raises(ValueError):
            ClockDomain(hz)


entries = st.lists(
    st.tuples(st.integers(0, 5), st.sampled_from(EventClass), st.sampled_from("abc")), min_size=1, max_size=40
)


class TestQueue:
    @given(entries)
    def test_order_is_ns_class_source_sequence(self, wanted):
        scheduler = Scheduler()
        trace = []
        for number, (when_ns, order, source) in enumerate(wanted):
            key = (when_ns, order, source, number)
            scheduler.at(when_ns, lambda key=key: trace.append((*key, scheduler.now_ns)), order=order, source=source)
        scheduler.run_until(None, None)
        assert trace == [(*key, key[0]) for key in sorted(key[:4] for key in trace)]
        assert len(trace) == len(wanted)

    @given(entries, st.sets(st.integers(0, 39)), st.integers(0, 6))
    def test_cancelled_entries_and_those_after_the_deadline_do_not_run(self, wanted, cancelled, deadline_ns):
        scheduler = Scheduler()
        ran = []
        made = [scheduler.at(w, lambda n=n: ran.append(n), order=o, source=s) for n, (w, o, s) in enumerate(wanted)]
        for number in cancelled & set(range(len(made))):
            scheduler.cancel(made[number])
            scheduler.cancel(made[number])
        assert scheduler.run_until(None, deadline_ns) is False
        assert sorted(ran) == [n for n, (w, *_) in enumerate(wanted) if w <= deadline_ns and n not in cancelled]
        assert scheduler.now_ns == deadline_ns
        assert [entry.pending for entry in made] == [
            w > deadline_ns and n not in cancelled for n, (w, *_) in enumerate(wanted)
        ]

    @given(st.integers(0, 2**32))
    def test_the_same_entries_give_the_same_trace(self, seed):
        assert self.trace(seed) == self.trace(seed)

    @staticmethod
    def trace(seed):
        scheduler = Scheduler()
        trace = []

        def act(value):
            trace.append((scheduler.now_ns, value))
            if len(trace) < 50:
                for child in range(value % 3):
                    following = (value * 1103515245 + child + 12345) % 2**31
                    scheduler.after(
                        following % 7,
                        partial(act, following),
                        order=EventClass(following % 6),
                        source=str(following % 2),
                    )

        for child in range(3):
            scheduler.after(child, lambda child=child: act(seed + child))
        scheduler.run_until(None, None)
        return trace

    def test_a_timer_restarted_for_ever_does_not_pile_up(self):
        scheduler = Scheduler()
        entry = scheduler.at(10**9, lambda: None)
        for _ in range(10_000):
            scheduler.cancel(entry)
            entry = scheduler.at(10**9, lambda: None)
        assert len(scheduler._heap) < 300

    def test_the_past_is_closed(self):
        scheduler = Scheduler()
        scheduler.run_for(10)
        with pytest.raises(InternalError, match="10 ns already"):
            scheduler.at(9, lambda: None)
        with pytest.raises(InternalError):
            scheduler.run_until(None, 9)

    def test_an_entry_at_now_runs_after_the_one_that_made_it(self):
        scheduler = Scheduler()
        ran = []
        scheduler.at(
            5, lambda: (scheduler.at(5, lambda: ran.append("inner"), order=EventClass.INPUT), ran.append("outer"))
        )
        scheduler.run_until(None, 5)
        assert ran == ["outer", "inner"]


class TestRunning:
    def test_condition_is_looked_at_after_each_entry(self):
        scheduler = Scheduler()
        ran = []
        for when_ns in (10, 20, 30):
            scheduler.at(when_ns, lambda when_ns=when_ns: ran.append(when_ns))
        assert scheduler.run_until(lambda: len(ran) == 2, 100) is True
        assert (ran, scheduler.now_ns) == ([10, 20], 20)
        assert scheduler.run_until(lambda: True, 100) is True
        assert scheduler.now_ns == 20
        assert scheduler.run_until(lambda: False, 100) is False
        assert (ran, scheduler.now_ns) == ([10, 20, 30], 100)

    def test_an_entry_at_the_deadline_counts(self):
        scheduler = Scheduler()
        ran = []
        scheduler.at(10, lambda: ran.append(1), order=EventClass.CHECK)
        assert scheduler.run_until(lambda: bool(ran), 10) is True

    def test_ends_when_nothing_can_happen(self):
        scheduler = Scheduler()
        scheduler.at(10, lambda: None)
        assert scheduler.run_until(lambda: False, None) is False
        assert scheduler.now_ns == 10

    def test_does_not_nest(self):
        scheduler = Scheduler()
        scheduler.at(1, lambda: scheduler.run_for(1))
        with pytest.raises(InternalError, match="tried to run"):
            scheduler.run_for(10)
        scheduler.run_for(10)

    def test_free_running_refuses_real_inputs(self):
        scheduler = Scheduler()
        scheduler.add_source(object())
        with pytest.raises(InternalError, match="not locked"):
            scheduler.run_for(1)

    def test_an_exception_leaves_the_scheduler_usable(self):
        scheduler = Scheduler()
        scheduler.at(1, lambda: 1 / 0)
        scheduler.at(2, lambda: None)
        with pytest.raises(ZeroDivisionError):
            scheduler.run_for(10)
        assert scheduler.now_ns == 1
        scheduler.run_for(9)
        assert scheduler.next_ns() is None


class TestInterrupt:
    def test_takes_effect_between_entries(self):
        scheduler = Scheduler()
        ran = []

        def act():
            scheduler.interrupt()
            ran.append("whole")

        scheduler.at(1, act)
        scheduler.at(2, lambda: ran.append("next"))
        with pytest.raises(KeyboardInterrupt):
            scheduler.run_for(10)
        assert ran == ["whole"]
        scheduler.run_for(10)
        assert ran == ["whole", "next"]

    def test_a_second_one_stops_an_entry_that_hangs(self):
        scheduler = Scheduler()

        def hang():
            while True:
                scheduler.interrupt()

        scheduler.at(1, hang)
        with pytest.raises(KeyboardInterrupt):
            scheduler.run_for(10)

    def test_signals_are_deferred_to_the_boundary(self):
        scheduler = Scheduler()
        ran = []

        def act():
            signal.raise_signal(signal.SIGINT)
            gc.get_count()
            ran.append("whole")

        before = signal.getsignal(signal.SIGINT)
        scheduler.at(1, act)
        with pytest.raises(KeyboardInterrupt), deferred_interrupts(scheduler):
            scheduler.run_for(10)
        assert ran == ["whole"]
        assert signal.getsignal(signal.SIGINT) is before

    def test_what_follows_an_interrupt_does_not_tear_its_way_out_apart(self):
        scheduler, closed = Scheduler(), []
        scheduler.at(1, lambda: signal.raise_signal(signal.SIGINT))
        with pytest.raises(KeyboardInterrupt), deferred_interrupts(scheduler):
            try:
                scheduler.run_for(10)
            finally:
                signal.raise_signal(signal.SIGINT)
                closed.append("whole")
        assert closed == ["whole"]

    def test_the_first_one_interrupts_also_between_two_runs(self):
        scheduler = Scheduler()
        with pytest.raises(KeyboardInterrupt), deferred_interrupts(scheduler):
            scheduler.run_for(10)
            signal.raise_signal(signal.SIGINT)


class TestLatenessMeter:
    @given(st.lists(st.tuples(st.integers(0, 10**12), st.integers(0, 100)), max_size=60), st.integers(0, 100))
    def test_bounds(self, samples, since_ns):
        meter = LatenessMeter()
        for late_ns, at_ns in sorted(samples, key=lambda sample: sample[1]):
            meter.record(late_ns, at_ns)
        true_max = max((late for late, at in samples if at >= since_ns), default=0)
        assert true_max <= meter.max_since_ns(since_ns) <= true_max * 1.125
        ordered = sorted(late for late, _ in samples)
        for share in (0.5, 0.99, 1.0):
            true = ordered[max(0, -(-int(share * 100) * len(ordered) // 100) - 1)] if ordered else 0
            assert true <= meter.quantile_ns(share) <= true * 1.125
        assert meter.max_ns == max(ordered, default=0)
        assert meter.count == len(ordered)


def test_free_running_bench_has_no_host_figures():
    scheduler = Scheduler()
    scheduler.run_for(10**9)
    assert scheduler.real_time_factor is None
    assert (scheduler.slips, scheduler.slipped_ns, scheduler.lateness_max_ns(0)) == (0, 0, 0)
    assert not scheduler.locked


def test_host_time_for_reports():
    assert Stopwatch().elapsed_s() >= 0
    assert wall_time_iso().endswith("+00:00")
