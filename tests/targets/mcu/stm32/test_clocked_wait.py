"""Waits for ticks of a clock that changes its rate or stands still: each ends at the exact cycle, and none drifts."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.stm32.clocked_wait import ClockedWait
from targets.mcu.timebase import Timebase


@pytest.fixture
def time():
    return Timebase(480_000_000)


def test_a_wait_that_is_stopped_or_replaced_never_ends(time):
    ended = []
    wait = ClockedWait(time)
    wait.set_rate(Fraction(4))
    wait.start(10, lambda: ended.append("first"))
    wait.start(20, lambda: ended.append("second"))
    time.run_due(79)
    assert (ended, wait.pending) == ([], True)
    time.run_due(80)
    assert (ended, wait.pending) == (["second"], False)
    wait.start(1, lambda: ended.append("third"))
    wait.stop()
    time.run_due(1000)
    assert ended == ["second"]


rates = st.fractions(min_value=0, max_value=40, max_denominator=7).map(lambda rate: rate if rate >= 1 else Fraction(0))


@given(
    ticks=st.fractions(min_value=0, max_value=50, max_denominator=2),
    changes=st.lists(st.tuples(rates, st.integers(0, 300))),
)
def test_it_ends_when_the_ticks_have_passed_at_whatever_rates(ticks, changes):
    changes.append((Fraction(3), 1000))
    time, ended = Timebase(480_000_000), []
    wait = ClockedWait(time)
    wait.start(ticks, lambda: ended.append(time.now))
    expected, passed = None, Fraction(0)
    for rate, span in changes:
        begin = time.now
        if rate and expected is None and passed + span / rate >= ticks:
            expected = begin + math.ceil((ticks - passed) * rate)
        passed += span / rate if rate else 0
        wait.set_rate(rate)
        time.run_due(begin + span)
    assert ended == [expected]


@given(
    rate=st.fractions(min_value=1, max_value=40, max_denominator=11), spans=st.lists(st.integers(1, 900), max_size=30)
)
def test_waits_that_follow_each_other_do_not_drift(rate, spans):
    time, ends = Timebase(480_000_000), []
    wait = ClockedWait(time)
    wait.set_rate(rate)
    halves = iter(spans)

    def following():
        ends.append(time.now)
        for half in halves:
            wait.start(Fraction(half, 2), following, follows=True)
            return

    following()
    time.run_due(100_000_000)
    sums = [sum(spans[:count], Fraction(0)) / 2 * rate for count in range(len(spans) + 1)]
    assert ends == [math.ceil(end) for end in sums]
