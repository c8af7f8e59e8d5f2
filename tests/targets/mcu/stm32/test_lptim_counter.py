"""The counter of a low-power timer against one that makes each step by itself."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from targets.mcu.stm32.lptim_counter import ARRM, CMPM, FULL, LptimCounter
from tests.share import examples


class Naive:
    """One step at a time, by the words of the manual."""

    def __init__(self, reload, compare, count, single):
        self.reload, self.compare, self.count, self.single = reload, compare, count, single
        self.running, self.matched, self.rose = True, False, count > compare

    def step(self):
        if not self.running:
            return 0
        flags, left = 0, self.count
        if left >= self.compare and not self.matched:
            flags, self.matched = CMPM, True
        self.count = left + 1 & FULL
        if left == self.reload:
            flags |= ARRM
            self.count = 0
        if self.count == 0:
            self.matched = False
            self.running = not self.single
        self.rose = self.rose or self.count > self.compare
        return flags


def counter(reload, compare, count=0, single=False):
    made = LptimCounter()
    made.reload, made.count = reload, count
    made.set_compare(compare)
    made.running, made.single = True, single
    return made


values = st.one_of(st.integers(0, 12), st.integers(FULL - 12, FULL))


@settings(max_examples=examples(300), deadline=None)
@given(values, values, values, st.booleans(), st.lists(st.integers(1, 40), max_size=8))
def test_any_steps_are_as_many_single_ones(reload, compare, count, single, cuts):
    made, naive = counter(reload, compare, count, single), Naive(reload, compare, count, single)
    for steps in cuts:
        flags = 0
        for _ in range(steps):
            flags |= naive.step()
        assert made.advance(steps) == flags
        assert (made.count, made.running, made.rose) == (naive.count, naive.running, naive.rose)


@settings(max_examples=examples(300), deadline=None)
@given(values, values, values, st.booleans(), st.integers(0, 3), st.booleans())
def test_nothing_happens_before_the_event_that_is_announced(reload, compare, count, single, wanted, output):
    made = counter(reload, compare, count, single)
    steps = made.steps_to_event(wanted, output=output)
    high = made.high
    if steps is None:
        assert (wanted, output, single) == (0, False, False)
        return
    assert made.advance(steps - 1) & wanted == 0
    assert made.running
    assert made.high is high or not output


def test_a_match_shows_with_the_next_step_and_a_compare_value_equal_to_the_end_matches_too():
    made = counter(9, 3)
    assert [made.advance(1) for _ in range(10)] == [0, 0, 0, CMPM, 0, 0, 0, 0, 0, ARRM]
    assert counter(9, 9).advance(10) == CMPM | ARRM
    assert counter(9, 10).advance(10) == ARRM


def test_the_output_is_high_above_the_compare_value():
    made = counter(99, 49)
    levels = [(made.high, made.advance(1))[0] for _ in range(200)]
    assert levels == ([False] * 50 + [True] * 50) * 2


def test_a_compare_value_behind_the_counter_matches_at_once():
    made = counter(FULL, 10, count=5000)
    assert made.advance(1) == CMPM
    made.set_compare(6000)
    assert made.advance(999) == 0
    assert made.advance(1) == CMPM


def test_what_is_to_come_later_comes_with_the_end_of_the_period():
    made = counter(9, 3)
    made.later = (4, 1)
    assert made.advance(9) == CMPM
    assert (made.reload, made.compare) == (9, 3)
    assert made.advance(1) == ARRM
    assert (made.reload, made.compare, made.count) == (4, 1, 0)
    assert [made.advance(1) for _ in range(5)] == [0, CMPM, 0, 0, ARRM]


def test_downwards_it_goes_from_nothing_to_the_end():
    made = counter(3, 2)
    assert [(made.step(up=False), made.count) for _ in range(5)] == [(ARRM, 3), (CMPM, 2), (0, 1), (0, 0), (ARRM, 3)]
    assert [(made.step(up=True), made.count) for _ in range(4)] == [(ARRM, 0), (0, 1), (0, 2), (CMPM, 3)]
