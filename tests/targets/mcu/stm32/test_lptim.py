"""The low-power timer: what a program sees of it, at exact ticks of its kernel clock."""

from __future__ import annotations

from fractions import Fraction
from types import MappingProxyType

import pytest

from targets.mcu.services import Watch
from targets.mcu.stm32.lptim import LowPowerTimer, LptimKind
from targets.mcu.testing import FakeChip, peek, poke

LSE = Fraction(32_768)
TICK = 32  # cycles of HCLK
CMPM, ARRM, EXTTRIG, CMPOK, ARROK, UP, DOWN = (1 << bit for bit in range(7))
ENABLE, SNGSTRT, CNTSTRT, COUNTRST, RSTARE = (1 << bit for bit in range(5))
CKSEL, TIMOUT, WAVE, WAVPOL, PRELOAD, COUNTMODE, ENC = 1 << 0, *(1 << bit for bit in range(19, 25))
RISING, FALLING, EITHER = 1 << 17, 2 << 17, 3 << 17
KIND = LptimKind(
    irq=93,
    reset_bits=True,
    inputs=0xFF,
    triggers=MappingProxyType({0: "LPTIM1_ETR", 1: "RTC_ALRA"}),
    missing=MappingProxyType({6: "COMP1_OUT"}),
    wake_line="EXTI23",
    output_line="EXTI49",
)


class Bench:
    """A timer on a crystal, 32 cycles of HCLK to a tick."""

    def __init__(self, kind=KIND):
        self.chip = FakeChip(hclk_hz=32 * 32_768)
        self.hz = LSE
        self.awake = False
        timer = LowPowerTimer(
            "LPTIM1", 0x4000_2400, self.chip.services, kind, kernel_hz=lambda: self.hz, wakes=lambda: self.awake
        )
        self.timer = self.chip.add(timer)
        timer.reset()
        timer.after_clock_change()

    def peek(self, name):
        return peek(self.timer, name)

    def poke(self, name, value):
        poke(self.timer, name, value)

    def ticks(self, count):
        self.chip.advance(count * TICK)

    def flags(self):
        """Return the flags, and clear them."""
        found = self.peek("ISR")
        self.poke("ICR", found)
        return found

    def begin(self, reload, compare=0, *, settings=0, enables=0, start=CNTSTRT):
        """Start it as drivers do; one tick later it counts its first."""
        self.poke("CFGR", settings)
        self.poke("IER", enables)
        self.poke("CR", ENABLE)
        self.poke("ARR", reload)
        self.poke("CMP", compare)
        self.ticks(5 << (settings >> 9 & 7))
        assert self.flags() & (ARROK | CMPOK) == ARROK | CMPOK
        self.poke("CR", ENABLE | start)
        self.ticks(3)

    def in1(self, level):
        self.chip.input("LPTIM1_IN1").drive(level)

    def in2(self, level):
        self.chip.input("LPTIM1_IN2").drive(level)

    def etr(self, level):
        self.chip.input("LPTIM1_ETR").drive(level)

    def pulse_in1(self, count):
        for _ in range(count):
            self.in1(True)
            self.ticks(4)
            self.in1(False)
            self.ticks(4)


@pytest.fixture
def bench():
    return Bench()


class TestRegisters:
    def test_reset_values(self, bench):
        names = ("ISR", "ICR", "IER", "CFGR", "CR", "CMP", "ARR", "CNT", "CFGR2")
        assert [bench.peek(name) for name in names] == [0, 0, 0, 0, 0, 0, 1, 0, 0]

    def test_reserved_bits_stay_clear(self, bench):
        for name, kept in (("CFGR", 0x01FE_EEDF), ("IER", 0x7F), ("CFGR2", 0xFF)):
            bench.poke(name, 0xFFFF_FFFF)
            assert bench.peek(name) == kept

    def test_a_timer_without_encoder_and_inputs_lacks_their_bits(self):
        bench = Bench(LptimKind(irq=140, encoder=False, pin_input=False, triggers=MappingProxyType({})))
        bench.poke("CFGR", 0xFFFF_FFFF)
        bench.poke("IER", 0xFFFF_FFFF)
        assert (bench.peek("CFGR"), bench.peek("IER")) == (0x00FE_EEDF, 0x1F)
        bench.timer.write(0x24, 1)
        assert bench.chip.noted("reserved") == ["LPTIM1_0x24"]

    def test_values_are_lost_while_it_is_disabled(self, bench):
        bench.poke("ARR", 7)
        bench.poke("CMP", 7)
        assert (bench.peek("ARR"), bench.peek("CMP")) == (1, 0)
        assert bench.chip.noted("misuse") == ["LPTIM1_ARR", "LPTIM1_CMP"]

    def test_it_is_not_started_while_it_is_disabled(self, bench):
        bench.poke("CR", CNTSTRT)
        assert bench.peek("CR") == 0
        bench.poke("CR", ENABLE | CNTSTRT)
        bench.ticks(20)
        assert bench.peek("CR") == ENABLE
        assert bench.peek("CNT") == 0
        assert bench.chip.noted("misuse") == ["LPTIM1_CR"]

    def test_settings_that_change_while_it_is_enabled_are_noted_and_wait_for_the_next_enable(self, bench):
        bench.begin(0xFFFF)
        bench.poke("CFGR", 1 << 9)
        assert bench.peek("CFGR") == 1 << 9
        bench.ticks(10)
        assert bench.peek("CNT") == 10
        bench.poke("IER", ARRM)
        assert bench.chip.noted("misuse") == ["LPTIM1_CFGR", "LPTIM1_IER"]
        bench.poke("CR", 0)
        assert (bench.peek("CNT"), bench.peek("ARR"), bench.peek("CR")) == (0, 0xFFFF, 0)
        bench.begin(0xFFFF, settings=1 << 9)
        bench.ticks(10)
        assert bench.peek("CNT") == 5


class TestSynchronization:
    def test_a_value_arrives_with_the_third_tick_after_the_two_that_enabling_takes(self, bench):
        bench.poke("CR", ENABLE)
        bench.poke("ARR", 0xFFFF)
        bench.chip.advance(5 * TICK - 1)
        assert bench.peek("ISR") == 0
        bench.chip.advance(1)
        assert bench.peek("ISR") == ARROK

    @pytest.mark.parametrize("prescaler", [0, 3])
    def test_later_it_takes_two_to_three_periods_of_the_counter_clock(self, bench, prescaler):
        period = TICK << prescaler
        bench.begin(0xFFFF, settings=prescaler << 9)
        bench.flags()
        bench.ticks((1 << prescaler) - 3)  # to the edge of the counter clock
        bench.chip.advance(period // 2)
        bench.poke("CMP", 100)
        assert bench.peek("CMP") == 100
        bench.chip.advance(2 * period + period // 2 - 1)
        assert not bench.flags() & CMPOK
        bench.chip.advance(1)
        assert bench.flags() & CMPOK

    def test_without_a_kernel_clock_no_flag_comes_until_it_runs(self, bench):
        bench.hz = Fraction(0)
        bench.timer.after_clock_change()
        bench.poke("CR", ENABLE)
        bench.poke("ARR", 0xFFFF)
        bench.ticks(1000)
        assert bench.peek("ISR") == 0
        assert bench.chip.noted("misuse") == ["LPTIM1_CR.ENABLE"]
        bench.hz = LSE
        bench.timer.after_clock_change()
        bench.ticks(5)
        assert bench.peek("ISR") == ARROK

    def test_with_its_gate_shut_it_stands_still(self, bench):
        bench.begin(0xFFFF)
        bench.ticks(10)
        bench.timer.before_clock_change()
        bench.timer.clocked = False
        bench.timer.after_clock_change()
        bench.ticks(10)
        bench.timer.before_clock_change()
        bench.timer.clocked = True
        bench.timer.after_clock_change()
        bench.ticks(5)
        assert bench.peek("CNT") == 15

    @pytest.mark.parametrize("ticks", [2, 3])
    def test_a_value_that_disabling_cuts_off_is_noted(self, bench, ticks):
        bench.begin(9, 4)
        bench.flags()
        bench.poke("ARR", 99)
        bench.ticks(ticks)
        arrived = bool(bench.flags() & ARROK)
        bench.poke("CR", 0)
        assert bench.chip.noted("misuse") == ([] if arrived else ["LPTIM1_ARR"])
        assert arrived is (ticks == 3)

    def test_a_second_write_before_the_flag_is_noted_and_takes_the_place_of_the_first(self, bench):
        bench.begin(0xFFFF, 0xFFFF)
        bench.poke("CMP", 10)
        bench.ticks(1)
        bench.poke("CMP", 20)
        bench.ticks(2)
        assert not bench.flags() & CMPOK
        bench.ticks(1)
        assert bench.flags() & CMPOK
        assert bench.chip.noted("misuse") == ["LPTIM1_CMP"]
        bench.ticks(16)
        assert bench.peek("CNT") == 20
        assert not bench.flags()
        bench.ticks(1)
        assert bench.flags() == CMPM


class TestCounting:
    def test_it_begins_three_kernel_clocks_after_the_start(self, bench):
        bench.poke("CR", ENABLE)
        bench.poke("ARR", 0xFFFF)
        bench.ticks(10)
        bench.poke("CR", ENABLE | CNTSTRT)
        assert bench.peek("CR") == ENABLE | CNTSTRT
        bench.ticks(3)
        assert (bench.peek("CR"), bench.peek("CNT")) == (ENABLE, 0)
        bench.ticks(1)
        assert bench.peek("CNT") == 1

    @pytest.mark.parametrize("prescaler", range(8))
    def test_prescaler(self, bench, prescaler):
        bench.begin(0xFFFF, settings=prescaler << 9)
        bench.ticks(50 << prescaler)
        assert bench.peek("CNT") == 50

    def test_continuous(self, bench):
        bench.begin(99, 49)
        bench.ticks(49)
        assert bench.flags() == 0
        bench.ticks(1)
        assert bench.flags() == CMPM
        bench.ticks(49)
        assert (bench.flags(), bench.peek("CNT")) == (0, 99)
        bench.ticks(1)
        assert (bench.flags(), bench.peek("CNT")) == (ARRM, 0)
        bench.ticks(1050)
        assert bench.peek("CNT") == 50
        assert bench.flags() == CMPM | ARRM

    def test_single_and_again(self, bench):
        bench.begin(9, 4, start=SNGSTRT)
        bench.ticks(10)
        assert bench.flags() == CMPM | ARRM
        bench.ticks(100)
        assert (bench.flags(), bench.peek("CNT")) == (0, 0)
        bench.poke("CR", ENABLE | SNGSTRT)
        bench.ticks(8)
        assert bench.peek("CNT") == 5

    def test_single_to_continuous_and_back_on_the_fly(self, bench):
        bench.begin(9, start=SNGSTRT)
        bench.ticks(5)
        bench.poke("CR", ENABLE | CNTSTRT)
        bench.ticks(8)
        assert bench.peek("CNT") == 3
        bench.poke("CR", ENABLE | SNGSTRT)
        bench.ticks(50)
        assert bench.peek("CNT") == 0

    def test_preload_waits_for_the_end_of_the_period(self, bench):
        bench.begin(9, 4, settings=PRELOAD)
        bench.poke("ARR", 19)
        bench.ticks(3)
        assert bench.flags() & ARROK
        bench.ticks(7)
        assert bench.flags() & ARRM
        bench.ticks(19)
        assert (bench.flags() & ARRM, bench.peek("CNT")) == (0, 19)
        bench.ticks(1)
        assert bench.flags() & ARRM

    def test_without_preload_it_holds_at_once(self, bench):
        bench.begin(99, 200)
        bench.poke("ARR", 9)
        bench.ticks(10)
        assert (bench.flags(), bench.peek("CNT")) == (ARROK | ARRM, 0)

    def test_a_compare_value_behind_the_counter_matches_as_soon_as_it_arrives(self, bench):
        bench.begin(0xFFFF, 0xFFFF)
        bench.ticks(1000)
        bench.poke("CMP", 100)
        bench.ticks(3)
        assert bench.flags() == CMPOK
        bench.ticks(1)
        assert bench.flags() == CMPM

    def test_the_counter_is_reset_with_the_third_kernel_clock(self, bench):
        bench.begin(0xFFFF, 0xFFFF)
        bench.ticks(10)
        bench.poke("CR", ENABLE | COUNTRST)
        bench.ticks(2)
        assert (bench.peek("CR"), bench.peek("CNT")) == (ENABLE | COUNTRST, 12)
        bench.ticks(1)
        assert (bench.peek("CR"), bench.peek("CNT")) == (ENABLE, 0)

    def test_reset_after_read(self, bench):
        bench.begin(0xFFFF, 0xFFFF)
        bench.poke("CR", ENABLE | RSTARE)
        bench.ticks(10)
        assert [bench.peek("CNT"), bench.peek("CNT")] == [10, 0]

    def test_another_rate_keeps_the_count(self, bench):
        bench.begin(0xFFFF, 0xFFFF)
        bench.ticks(10)
        bench.timer.before_clock_change()
        bench.hz = 2 * LSE
        bench.timer.after_clock_change()
        bench.ticks(10)
        assert bench.peek("CNT") == 30

    def test_nothing_is_entered_for_matches_that_nobody_can_see(self, bench):
        for name in ("LPTIM1_OUT", "lptim1_out", "EXTI49"):
            bench.chip.output(name).set_watch(Watch.NOBODY)
        bench.begin(1, 0)
        bench.ticks(2)
        assert bench.peek("ISR") == CMPM | ARRM
        assert bench.chip.time.next_cycle() is None
        bench.ticks(1001)
        bench.poke("ICR", ARRM)
        bench.ticks(1)
        assert bench.peek("ISR") == CMPM | ARRM


class TestInterrupts:
    def test_a_flag_asserts_interrupt_and_line_until_it_is_cleared(self, bench):
        bench.begin(9, 4, enables=ARRM)
        bench.ticks(9)
        irq, line = bench.chip.irq(93), bench.chip.output("EXTI23")
        assert not irq.level
        assert not line.level
        bench.ticks(1)
        assert irq.level
        assert line.level
        bench.poke("ICR", ARRM)
        assert not irq.level
        assert not line.level

    def test_one_that_is_enabled_after_its_flag_is_not_asserted_before_the_next(self, bench):
        bench.begin(9, 4)
        bench.ticks(10)
        assert bench.peek("ISR") == CMPM | ARRM
        bench.poke("IER", ARRM)
        assert not bench.chip.irq(93).level
        bench.ticks(10)
        assert bench.chip.irq(93).level

    def test_in_stop_it_goes_through_exti_alone_unless_that_lets_a_direct_line_wake(self, bench):
        bench.begin(9, 4, enables=ARRM)
        bench.chip.change_clock(APB1=0)
        bench.ticks(10)
        assert bench.chip.output("EXTI23").level
        assert not bench.chip.irq(93).level
        bench.chip.change_clock(APB1=1)
        assert bench.chip.irq(93).level
        bench.poke("ICR", ARRM)
        bench.chip.change_clock(APB1=0)
        bench.awake = True
        bench.ticks(10)
        assert bench.chip.irq(93).level


class TestOutput:
    def edges(self, bench):
        for other in ("EXTI49", "lptim1_out"):
            assert bench.chip.output(other).edges == bench.chip.output("LPTIM1_OUT").edges
        return [(cycle // TICK, level) for cycle, level in bench.chip.output("LPTIM1_OUT").edges]

    def test_pwm(self, bench):
        bench.begin(9, 3)  # which takes 8 ticks
        bench.ticks(20)
        assert self.edges(bench) == [(0, False), (12, True), (18, False), (22, True), (28, False)]

    def test_one_pulse(self, bench):
        bench.begin(9, 3, start=SNGSTRT)
        bench.ticks(30)
        assert self.edges(bench) == [(0, False), (12, True), (18, False)]

    def test_set_once(self, bench):
        bench.begin(9, 3, settings=WAVE, start=SNGSTRT)
        bench.ticks(30)
        assert self.edges(bench) == [(0, False), (12, True)]
        bench.poke("CR", 0)
        assert self.edges(bench)[2:] == [(38, False)]

    def test_polarity_holds_before_it_is_enabled(self, bench):
        bench.poke("CFGR", WAVPOL)
        assert self.edges(bench) == [(0, False), (0, True)]
        bench.begin(9, 3, settings=WAVPOL)
        bench.ticks(10)
        assert self.edges(bench)[2:] == [(12, False), (18, True)]

    def test_compare_at_the_end_gives_none(self, bench):
        bench.begin(9, 9)
        bench.ticks(30)
        assert self.edges(bench) == [(0, False)]

    def test_the_fastest_is_half_the_clock(self, bench):
        bench.begin(1, 0)
        bench.ticks(4)
        assert self.edges(bench)[1:] == [(9, True), (10, False), (11, True), (12, False)]


class TestTriggers:
    @pytest.mark.parametrize(
        ("trigen", "counts"), [(RISING, [True, True]), (FALLING, [False, True]), (EITHER, [True, True])]
    )
    def test_an_edge_starts_it_two_clocks_later(self, bench, trigen, counts):
        bench.begin(0xFFFF, 0xFFFF, settings=trigen)
        bench.ticks(10)
        assert bench.peek("CNT") == 0
        found = []
        for level in (True, False):
            bench.etr(level)
            bench.ticks(2)
            before = bench.peek("CNT")
            bench.ticks(1)
            found.append(bench.peek("CNT") > before)
        assert found == counts
        assert bench.flags() == EXTTRIG

    def test_while_it_runs_a_trigger_is_ignored_without_a_flag(self, bench):
        bench.begin(0xFFFF, 0xFFFF, settings=RISING)
        bench.etr(True)
        bench.ticks(10)
        assert bench.flags() == EXTTRIG
        bench.etr(False)
        bench.etr(True)
        bench.ticks(10)
        assert (bench.flags(), bench.peek("CNT")) == (0, 18)

    def test_without_a_start_bit_a_trigger_does_nothing(self, bench):
        bench.begin(0xFFFF, settings=RISING, start=0)
        bench.etr(True)
        bench.ticks(10)
        assert (bench.flags(), bench.peek("CNT")) == (0, 0)

    def test_each_trigger_after_the_end_starts_a_single_count(self, bench):
        bench.begin(9, 4, settings=RISING, start=SNGSTRT)
        for _ in range(2):
            bench.etr(True)
            bench.etr(False)
            bench.ticks(20)
            assert (bench.flags(), bench.peek("CNT")) == (EXTTRIG | CMPM | ARRM, 0)

    def test_set_once_is_started_once(self, bench):
        bench.begin(9, 4, settings=RISING | WAVE, start=SNGSTRT)
        found = []
        for _ in range(2):
            bench.etr(True)
            bench.etr(False)
            bench.ticks(20)
            found.append(bench.flags())
        assert found == [EXTTRIG | CMPM | ARRM, 0]

    def test_timeout(self, bench):
        bench.begin(0xFFFF, 20, settings=RISING | TIMOUT)
        for _ in range(5):
            bench.etr(True)
            bench.etr(False)
            bench.ticks(15)
            assert bench.flags() == EXTTRIG
        bench.ticks(7)
        assert bench.flags() == 0
        bench.ticks(1)
        assert bench.flags() == CMPM

    def test_an_alarm_of_the_rtc_is_a_trigger(self, bench):
        bench.begin(0xFFFF, 0xFFFF, settings=RISING | 1 << 13)
        bench.etr(True)
        bench.ticks(10)
        assert bench.peek("CNT") == 0
        bench.chip.input("RTC_ALRA").drive(True)
        bench.ticks(10)
        assert bench.peek("CNT") == 8

    def test_a_trigger_that_is_not_modelled_is_noted(self, bench):
        bench.begin(0xFFFF, settings=RISING | 6 << 13)
        note = next(note for note in bench.chip.notes.all if note.kind == "unmodelled")
        assert (note.where, "COMP1_OUT" in note.text) == ("LPTIM1_CFGR.TRIGSEL", True)

    def test_a_filter_wants_as_many_samples(self, bench):
        bench.begin(0xFFFF, 0xFFFF, settings=RISING | 3 << 6)
        bench.etr(True)
        bench.ticks(7)
        bench.etr(False)
        bench.ticks(20)
        assert bench.flags() == 0
        bench.etr(True)
        bench.ticks(8)
        assert bench.flags() == EXTTRIG


class TestInputs:
    def test_an_outside_clock_loses_its_first_five_edges(self, bench):
        bench.hz = Fraction(0)  # it needs no other
        bench.timer.after_clock_change()
        bench.poke("CFGR", CKSEL)
        bench.poke("CR", ENABLE)
        bench.poke("ARR", 0xFFFF)
        bench.poke("CR", ENABLE | CNTSTRT)
        bench.pulse_in1(20)
        assert bench.peek("CNT") == 15
        assert bench.peek("ISR") == ARROK | CMPM
        assert not bench.chip.noted()

    def test_an_outside_clock_is_divided_too(self, bench):
        bench.poke("CFGR", CKSEL | 1 << 1 | 2 << 9)
        bench.poke("CR", ENABLE)
        bench.poke("ARR", 0xFFFF)
        bench.pulse_in1(20)
        assert bench.peek("ISR") == ARROK
        bench.poke("CR", ENABLE | CNTSTRT)
        bench.pulse_in1(43)
        assert bench.peek("CNT") == 10

    @pytest.mark.parametrize(("polarity", "count"), [(0, 20), (1, 20), (2, 40), (3, 0)])
    def test_sampled_edges_are_all_counted(self, bench, polarity, count):
        bench.begin(0xFFFF, 0xFFFF, settings=COUNTMODE | polarity << 1)
        bench.pulse_in1(20)
        assert bench.peek("CNT") == count

    def test_sampled_edges_match_too(self, bench):
        bench.begin(3, 1, settings=COUNTMODE)
        found = []
        for _ in range(4):
            bench.pulse_in1(1)
            found.append(bench.flags())
        assert found == [0, CMPM, 0, ARRM]

    def test_what_is_shorter_than_a_sample_is_lost_and_what_the_filter_refuses(self, bench):
        bench.begin(0xFFFF, 0xFFFF, settings=COUNTMODE)
        bench.in1(True)
        bench.chip.advance(TICK // 2 - 1)
        bench.in1(False)
        bench.ticks(10)
        assert bench.peek("CNT") == 0
        bench.poke("CR", 0)
        bench.begin(0xFFFF, 0xFFFF, settings=COUNTMODE | 3 << 3)
        bench.pulse_in1(10)  # four samples each
        assert bench.peek("CNT") == 0

    def test_inputs_that_come_from_no_pin_are_noted(self, bench):
        bench.poke("CFGR2", 1)
        bench.begin(0xFFFF, settings=COUNTMODE)
        assert bench.chip.noted("unmodelled") == ["LPTIM1_CFGR2"]

    def test_impossible_settings_are_noted(self, bench):
        for settings, where in (
            (CKSEL | 2 << 1, "LPTIM1_CFGR.CKPOL"),
            (COUNTMODE | 1 << 9, "LPTIM1_CFGR.PRESC"),
            (CKSEL | ENC, "LPTIM1_CFGR.ENC"),
        ):
            bench.poke("CFGR", settings)
            bench.poke("CR", ENABLE)
            bench.poke("CR", 0)
            assert bench.chip.noted("misuse")[-1] == where


class TestEncoder:
    UPWARDS = ((True, False), (True, True), (False, True), (False, False))

    def turn(self, bench, steps):
        for _ in range(abs(steps) // 4):
            for in1, in2 in self.UPWARDS if steps > 0 else (*self.UPWARDS[2::-1], self.UPWARDS[3]):
                bench.in1(in1)
                bench.in2(in2)
                bench.ticks(4)

    @pytest.mark.parametrize(("mode", "share"), [(0, 2), (1, 2), (2, 1)])
    def test_the_three_modes_count_as_the_table_says(self, bench, mode, share):
        bench.begin(0xFFFF, 0xFFFF, settings=ENC | mode << 1)
        self.turn(bench, 32)
        assert bench.peek("CNT") == 32 // share
        assert bench.flags() == 0
        self.turn(bench, -32)
        assert bench.peek("CNT") == 0
        assert bench.flags() == DOWN
        self.turn(bench, 32)
        assert bench.flags() == UP

    def test_it_goes_round_at_both_ends(self, bench):
        bench.begin(9, 50, settings=ENC | 2 << 1)
        self.turn(bench, -4)
        assert (bench.peek("CNT"), bench.flags()) == (6, DOWN | ARRM)
        self.turn(bench, 4)
        assert (bench.peek("CNT"), bench.flags()) == (0, UP | ARRM)


def test_a_reset_ends_everything(bench):
    bench.begin(9, 4, settings=WAVPOL, enables=ARRM)
    bench.ticks(10)
    bench.timer.reset()
    names = ("ISR", "IER", "CFGR", "CR", "CMP", "ARR", "CNT")
    assert [bench.peek(name) for name in names] == [0, 0, 0, 0, 0, 1, 0]
    assert not bench.chip.irq(93).level
    assert bench.chip.output("LPTIM1_OUT").level is False
    assert bench.chip.time.next_cycle() is None
