"""The queue of a chip against one that sorts a list, and what a change of the clock does to what is in it."""

from __future__ import annotations

import sys
from fractions import Fraction

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import Bundle, RuleBasedStateMachine, invariant, rule

from targets.mcu.timebase import Timebase

CYCLES = st.integers(0, 40)


class Queue(RuleBasedStateMachine):
    """Whatever is entered, moved and cancelled happens in the order of cycle, order, and being entered."""

    entries = Bundle("entries")

    def __init__(self):
        super().__init__()
        self.time = Timebase(1000)
        self.expected = []  # (cycle, order, how many were entered before, name)
        self.entered = 0
        self.happened = []

    @rule(target=entries, after=CYCLES, order=st.sampled_from((-1, 0, 1)), follows=st.none() | CYCLES)
    def enter(self, after, order, follows):
        return self._enter(self.time.now + after, order, follows)

    def _enter(self, cycle, order, follows):
        name, self.entered = self.entered, self.entered + 1
        self.expected.append((cycle, order, name, follows))

        def happen():
            assert self.time.now == cycle
            self.happened.append(name)
            if follows is not None:
                self._enter(self.time.now + follows, order, None)

        return self.time.at(cycle, happen, order=order), name

    @rule(entry=entries)
    def cancel(self, entry):
        event, name = entry
        assert event.pending == any(name == other for *_, other, _ in self.expected)
        self.time.cancel(event)
        self.time.cancel(event)
        assert not event.pending
        self.expected = [one for one in self.expected if one[2] != name]

    @rule(cycles=CYCLES)
    def go_on(self, cycles):
        end, due = self.time.now + cycles, []
        before = list(self.expected)
        assert self.time.run_due(end) == any(cycle <= end for cycle, *_ in before)
        assert self.time.now == end
        while (first := min(self.expected, default=None)) is not None and first[0] <= end:
            self.expected.remove(first)
            due.append(first[2])
        assert self.happened == due
        self.happened.clear()

    @invariant()
    def the_next_is_known(self):
        assert self.time.next_cycle() == (min(self.expected)[0] if self.expected else None)


TestQueue = Queue.TestCase


def test_many_events_that_never_come_about_cost_no_memory_for_ever():
    time = Timebase(1000)
    for _ in range(10_000):
        time.cancel(time.at(1 << 40, lambda: None))
    assert time.at(1 << 40, lambda: None).number < 64


def test_bench_time_stays_where_it_is_when_the_clock_changes():
    time, happened = Timebase(1000), []
    for name, at_s in (("a", Fraction(1, 10)), ("b", Fraction(1, 3))):
        time.at_time(at_s, lambda name=name: happened.append((name, time.now)))
    time.at_ns(200_000_000, lambda: happened.append(("c", time.now)))
    time.at(350, lambda: happened.append(("cycle", time.now)))
    time.run_due(50)
    time.set_hclk(Fraction(4000))  # cycle 50 is at 50 ms, and so is all that follows four times as fast
    time.run_due(2000)
    assert happened == [("a", 250), ("cycle", 350), ("c", 650), ("b", 50 + -(-(1000 - 150) * 4 // 3))]


def test_what_an_action_raises_comes_out_and_the_rest_still_happens():
    time, happened = Timebase(1000), []

    def fail():
        raise LookupError

    time.at(1, fail)
    time.at(1, lambda: happened.append(1))
    with pytest.raises(LookupError):
        time.run_due(10)
    time.run_due(10)
    assert happened == [1]


def test_a_signal_at_the_entry_of_an_event_is_raised():
    time = Timebase(1000)
    time.at(1, lambda: None)
    before = sys.gettrace()

    def interrupt(frame, _event, _argument):
        if frame.f_code is Timebase._happen.__code__:
            sys.settrace(before)
            raise KeyboardInterrupt

    sys.settrace(interrupt)
    try:
        with pytest.raises(KeyboardInterrupt):
            time.run_due(1)
    finally:
        sys.settrace(before)
