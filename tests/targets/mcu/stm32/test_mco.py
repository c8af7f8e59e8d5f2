"""Clocks at pins: each edge of a slow one at its time, whoever looks; rate and duty of a fast one."""

from __future__ import annotations

from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.services import Watch, Wave
from targets.mcu.stm32.mco import Choice, ClockOutput
from targets.mcu.testing import FakeChip
from tests.each import each

MHZ = 1_000_000
LSE = Fraction(32_768)
CHOICE = Choice(name="MCO", shift=4, clocks=(None, "A", "B", "-"), prescaler=0, dividers=(0, 1, 2, 3))
A, B = 1 << 4 | 1, 2 << 4 | 1


class Bench:
    def __init__(self, watch=Watch.LIVE):
        self.chip = FakeChip(8 * MHZ)
        self.output = ClockOutput(self.chip.services, CHOICE)
        self.signal = self.chip.output("MCO")
        self.signal.set_watch(watch)

    def follow(self, cfgr, **clocks):
        self.output.follow(cfgr, {"A": LSE, "B": Fraction(8 * MHZ), "-": Fraction(0)} | clocks)


def edges_of(chip, since_s, half_s, count):
    return [(chip.time.cycle_at(since_s + number * half_s), bool(number % 2)) for number in range(1, count + 1)]


@each("watch", [Watch.LIVE, Watch.RECORD])
def test_each_edge_of_a_slow_clock_comes_at_the_first_cycle_not_before_it(watch):
    bench = Bench(watch)
    bench.chip.advance(1000)
    bench.follow(A)
    bench.chip.advance_s(Fraction(1, 1000))
    bench.signal.look()
    half_s = 1 / LSE / 2
    assert bench.signal.edges == [(1000, False), *edges_of(bench.chip, Fraction(1000, 8 * MHZ), half_s, 65)]
    assert bench.signal.wave is None


looks = st.one_of(
    st.tuples(st.just("wait"), st.integers(1, 3000)),
    st.tuples(st.just("watch"), st.sampled_from(Watch)),
    st.tuples(st.just("look"), st.none()),
)


@given(st.lists(looks, max_size=20))
def test_the_level_is_the_same_whoever_looks(steps):
    bench, straight = Bench(), Bench()
    for one in (bench, straight):
        one.follow(A)
    for action, argument in steps:
        if action == "wait":
            bench.chip.advance(argument)
            straight.chip.advance(argument)
        elif action == "watch":
            bench.signal.set_watch(argument)
        bench.signal.look()
        assert bench.signal.level is straight.signal.level


def test_edges_stay_in_their_places_when_hclk_changes():
    bench = Bench(Watch.RECORD)
    bench.follow(A)
    bench.chip.advance(200)
    bench.output.refresh()
    bench.chip.change_clock(72 * MHZ)
    bench.chip.advance_s(Fraction(1, 10_000))
    bench.signal.look()
    half_s = 1 / LSE / 2
    assert bench.signal.edges[1:] == [(123, True), *edges_of(bench.chip, Fraction(0), half_s, 8)[1:]]


def test_of_a_fast_clock_rate_and_duty_are_told():
    bench = Bench()
    bench.follow(B)
    assert bench.signal.wave == Wave(hz=Fraction(8 * MHZ), duty=Fraction(1, 2))
    bench.chip.advance(1000)
    assert bench.signal.edges == [(0, False)]
    assert bench.chip.time.next_cycle() is None
    bench.follow(B, B=Fraction(0))
    assert (bench.signal.wave, bench.signal.level) == (None, False)


@each(("divider", "rate"), [(0, 0), (1, 300_000), (2, 150_000), (3, 100_000)])
def test_prescaler_and_the_limit(divider, rate):
    bench = Bench()
    bench.follow(2 << 4 | divider, B=Fraction(300_000))
    assert (bench.signal.wave.hz if bench.signal.wave else None) == (rate if rate > 100_000 else None)
    assert (bench.chip.time.next_cycle() == 40) is (rate == 100_000)


def test_no_output_is_released_and_a_clock_that_is_reserved_stands_still():
    bench = Bench()
    bench.follow(A)
    bench.chip.advance(200)
    bench.follow(3 << 4 | 1)
    assert bench.signal.level is False
    bench.follow(0)
    assert bench.signal.level is None
    bench.chip.advance(1000)
    assert [level for _cycle, level in bench.signal.edges] == [False, True, False, None]
