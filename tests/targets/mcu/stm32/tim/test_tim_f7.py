"""What the timers of the STM32F7 have beyond those of the F1 (RM0410 sections 25 to 28)."""

from __future__ import annotations

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.irq_lines import IrqLines
from targets.mcu.registers import Peripheral
from targets.mcu.services import Watch
from targets.mcu.stm32.tim import Timer
from targets.mcu.stm32.tim.kinds import F7_KINDS
from targets.mcu.testing import FakeChip, peek, poke
from tests.each import each

FULL = {
    "CR1": 0x0BFF,
    "SMCR": 0x1_FFF7,
    "CCMR1": 0x0101_FFFF,
    "CCMR2": 0x0101_FFFF,
    "PSC": 0xFFFF,
    "DCR": 0x1F1F,
}
GENERAL = FULL | {"CR2": 0xF8, "DIER": 0x5F5F, "CCER": 0xBBBB}
ADVANCED = FULL | {"CR2": 0xF5_7FFD, "DIER": 0x7FFF, "CCER": 0x33_BFFF, "RCR": 0xFFFF, "CCMR3": 0x0101_FCFC}
BASIC = {"CR1": 0x088F, "CR2": 0x70, "DIER": 0x101, "PSC": 0xFFFF}
ONE = {"CR1": 0x0B8F, "DIER": 3, "CCMR1": 0x1_00FF, "CCER": 0xB, "PSC": 0xFFFF}
TWO = {"CR1": 0x0B8F, "SMCR": 0x1_00F7, "DIER": 0x47, "CCMR1": 0x0101_FFFF, "CCER": 0xBB, "PSC": 0xFFFF}
MASKS = {
    **dict.fromkeys(("TIM1", "TIM8"), ADVANCED),
    **dict.fromkeys(("TIM2", "TIM3", "TIM4", "TIM5"), GENERAL),
    **dict.fromkeys(("TIM6", "TIM7"), BASIC),
    **dict.fromkeys(("TIM9", "TIM12"), TWO),
    **dict.fromkeys(("TIM10", "TIM11", "TIM13", "TIM14"), ONE),
}
UIF, B2IF, CC5IF, CC6IF, BIF = 1, 1 << 8, 1 << 16, 1 << 17, 1 << 7


@pytest.fixture
def make_f7(make_timer):
    return lambda name, **dividers: make_timer(name, F7_KINDS, **dividers)


@each("name", MASKS)
def test_reset_values_and_reserved_bits(make_f7, name):
    top = 0xFFFF_FFFF if name in ("TIM2", "TIM5") else 0xFFFF
    for register, mask in (MASKS[name] | {"ARR": top, "CNT": top}).items():
        _, timer = make_f7(name)
        assert peek(timer, register) == (top if register == "ARR" else 0)
        poke(timer, register, 0xFFFF_FFFF & ~1 if register == "CR1" else 0xFFFF_FFFF)
        # a centre-aligned counter that stands at 0 turns up
        assert peek(timer, register) == mask & ~(0x11 if register == "CR1" else 0), register


@each(
    ("name", "missing"),
    [("TIM2", "RCR"), ("TIM6", "CCR1"), ("TIM9", "CR2"), ("TIM9", "CCR3"), ("TIM10", "SMCR"), ("TIM14", "CCR2")],
)
def test_what_a_timer_lacks(make_f7, name, missing):
    chip, timer = make_f7(name)
    _, full = make_f7("TIM1")
    offset = next(offset for offset, register in full.registers.items() if register.name == missing)
    timer.write(offset, 0xFFFF_FFFF)
    assert timer.read(offset) == 0
    assert chip.noted("reserved") == [f"{name}_0x{offset:02X}"]


@each("name", ["TIM2", "TIM5"])
def test_32_bits(make_f7, name):
    chip, timer = make_f7(name)
    poke(timer, "ARR", 0x1_0005)
    poke(timer, "CCR1", 0x1_0002)
    poke(timer, "CNT", 0xFFFE)
    poke(timer, "SR", 0)
    poke(timer, "CR1", 1)
    chip.advance(1 + 4)
    assert peek(timer, "CNT") == 0x1_0002
    assert peek(timer, "SR") & 2
    chip.advance(4)
    assert peek(timer, "CNT") == 0
    assert peek(timer, "SR") & UIF


def test_a_32_bit_counter_wraps_at_its_own_end(make_f7):
    chip, timer = make_f7("TIM2")
    poke(timer, "ARR", 9)
    poke(timer, "CNT", 0xFFFF_FFFE)
    poke(timer, "CR1", 1)
    chip.advance(1 + 2)
    assert peek(timer, "CNT") == 0
    assert not peek(timer, "SR") & UIF


def test_a_16_bit_counter_wraps_at_its_own_end(make_f7):
    chip, timer = make_f7("TIM3")
    poke(timer, "ARR", 9)
    poke(timer, "CNT", 0xFFFE)
    poke(timer, "CR1", 1)
    chip.advance(1 + 2)
    assert peek(timer, "CNT") == 0


@each("name", ["TIM1", "TIM2", "TIM4", "TIM6", "TIM9", "TIM10"])
def test_the_copy_of_uif(make_f7, name):
    chip, timer = make_f7(name)
    poke(timer, "ARR", 9)
    poke(timer, "CR1", 0x801)
    chip.advance(5)
    assert peek(timer, "CNT") == 4
    chip.advance(10)
    assert peek(timer, "CNT") == 0x8000_0004
    assert timer.count(0x24) is None or timer.count(0x24).at(chip.time.now) == 0x8000_0004
    poke(timer, "SR", 0)
    assert peek(timer, "CNT") == 4
    poke(timer, "CR1", 1)
    chip.advance(10)
    assert peek(timer, "CNT") == 4


@each("number", [5, 6])
def test_channels_5_and_6_compare(make_f7, number):
    chip, timer = make_f7("TIM1")
    poke(timer, "ARR", 9)
    poke(timer, f"CCR{number}", 7)
    poke(timer, f"CCR{11 - number}", 20)
    poke(timer, "SR", 0)
    poke(timer, "CR1", 1)
    flag = CC5IF if number == 5 else CC6IF
    chip.advance(1 + 6)
    assert not peek(timer, "SR") & flag
    chip.advance(1)
    assert peek(timer, "SR") & flag
    poke(timer, "SR", ~flag)
    assert not peek(timer, "SR") & flag
    chip.advance(10)
    assert peek(timer, "SR") & flag
    assert not chip.irq(27).level


@each("watch", list(Watch))
def test_channels_are_high_only_while_channel_5_is(make_f7, watch):
    """Combined 3-phase PWM (RM0410 section 25.3.14)."""
    chip, timer = make_f7("TIM8")
    for number in (1, 2, 3):
        chip.output(f"TIM8_CH{number}").set_watch(watch)
    poke(timer, "CCMR1", 0x6060)
    poke(timer, "CCMR2", 0x0060)
    poke(timer, "CCMR3", 0x0070)  # channel 5 is high from its compare value on
    for number, compare in enumerate((8, 6, 7, 0, 3), 1):
        poke(timer, f"CCR{number}", compare | (0xA000_0000 if number == 5 else 0))  # channels 1 and 3
    poke(timer, "ARR", 9)
    poke(timer, "CCER", 0x111)
    poke(timer, "BDTR", 0x8000)
    poke(timer, "EGR", 1)
    poke(timer, "CR1", 1)
    seen = dict.fromkeys((1, 2, 3), "")
    chip.advance(1)
    for _ in range(20):
        for number in seen:
            chip.output(f"TIM8_CH{number}").look()
            seen[number] += str(int(chip.output(f"TIM8_CH{number}").level))
        chip.advance(1)
    assert seen == {1: "0001111100" * 2, 2: "1111110000" * 2, 3: "0001111000" * 2}


def test_asymmetric_pwm(make_f7):
    """Up by CCR1, down by CCR2, centre-aligned (RM0410 section 25.3.12)."""
    chip, timer = make_f7("TIM1")
    poke(timer, "CR1", 0x20)
    poke(timer, "CCMR1", 0x6060 | 0x1_0000)
    poke(timer, "CCMR1", 0x6000 | 0x60 | 0x1_0000)
    poke(timer, "CCR1", 2)
    poke(timer, "CCR2", 5)
    poke(timer, "ARR", 8)
    poke(timer, "CCER", 1)
    poke(timer, "BDTR", 0x8000)
    poke(timer, "CR1", 0x21)
    levels = ""
    chip.advance(1)
    for _ in range(32):
        levels += str(int(chip.output("TIM1_CH1").level))
        chip.advance(1)
    # counts 0 to 7 upwards by OC1REF (high below 2), 8 to 1 downwards by OC2REF (high up to 5)
    assert levels == ("11000000" + "00011111") * 2


@each("watch", [Watch.LIVE, Watch.RECORD])
def test_asymmetric_pwm_that_shows_the_direction_alone(make_f7, watch):
    chip, timer = make_f7("TIM1")
    chip.output("TIM1_CH1").set_watch(watch)
    poke(timer, "CR1", 0x20)
    poke(timer, "CCMR1", 0x6060 | 0x1_0000)
    poke(timer, "CCR2", 20)  # never while it counts up, always while it counts down
    poke(timer, "ARR", 8)
    poke(timer, "CCER", 1)
    poke(timer, "BDTR", 0x8000)
    poke(timer, "SR", 0)
    poke(timer, "CR1", 0x21)
    chip.advance(100)
    chip.output("TIM1_CH1").look()
    edges = [(cycle, level) for cycle, level in chip.output("TIM1_CH1").edges if cycle > 1]
    assert edges == [(1 + 8 * turn, turn % 2 == 1) for turn in range(1, 13)]


def test_lock_level_3_freezes_all_of_the_mode(make_f7):
    _, timer = make_f7("TIM8")
    poke(timer, "BDTR", 0x300)
    poke(timer, "CCMR1", 0x0101_7070)
    assert peek(timer, "CCMR1") == 0


class TestBreaks:
    def setup_timer(self, make_f7, bdtr):
        chip, timer = make_f7("TIM8")
        poke(timer, "CCMR1", 0x60)
        poke(timer, "CCR1", 5)
        poke(timer, "ARR", 9)
        poke(timer, "CCER", 1)
        poke(timer, "DIER", 0x80)
        poke(timer, "BDTR", 0x8000 | bdtr)
        poke(timer, "CR1", 1)
        chip.advance(3)
        return chip, timer

    @each(("pin", "bdtr", "flag"), [("BKIN", 0x3000, BIF), ("BKIN2", 0x0300_0000, B2IF)])
    def test_each_input_breaks(self, make_f7, pin, bdtr, flag):
        chip, timer = self.setup_timer(make_f7, bdtr)
        assert chip.output("TIM8_CH1").level is True
        chip.input(f"TIM8_{pin}").drive(True)
        assert chip.output("TIM8_CH1").level is None
        assert peek(timer, "SR") & (BIF | B2IF) == flag
        assert chip.irq(43).level
        poke(timer, "SR", 0)
        assert peek(timer, "SR") & flag  # as long as the input is active
        chip.input(f"TIM8_{pin}").drive(False)
        poke(timer, "SR", 0)
        assert not peek(timer, "SR") & flag
        assert not chip.irq(43).level

    @each(("egr", "flag"), [(0x80, BIF), (0x100, B2IF)])
    def test_by_software(self, make_f7, egr, flag):
        chip, timer = self.setup_timer(make_f7, 0)
        poke(timer, "EGR", egr)
        assert peek(timer, "SR") & (BIF | B2IF) == flag
        assert not peek(timer, "BDTR") & 0x8000
        assert chip.irq(43).level

    def test_the_polarity_of_the_second(self, make_f7):
        chip, timer = self.setup_timer(make_f7, 0x0100_0000)  # active low, and the input is low
        assert peek(timer, "SR") & B2IF
        assert chip.output("TIM8_CH1").level is None

    def test_lock_level_1_freezes_both(self, make_f7):
        _, timer = make_f7("TIM1")
        poke(timer, "BDTR", 0x100)
        poke(timer, "BDTR", 0x03FF_FFFF & ~0x300)
        assert peek(timer, "BDTR") == 0x0000_8D00 & ~0x100 | 0x100

    def test_filters_are_noted(self, make_f7):
        chip, timer = make_f7("TIM1")
        poke(timer, "BDTR", 0x1_0000)
        assert chip.noted("unmodelled") == ["TIM1_BDTR"]


class TestBasic:
    def test_it_counts_requests_and_interrupts(self, make_f7):
        chip, timer = make_f7("TIM6", APB1=4)
        poke(timer, "PSC", 1)
        poke(timer, "ARR", 9)
        poke(timer, "EGR", 1)
        poke(timer, "SR", 0)
        poke(timer, "DIER", 0x101)
        poke(timer, "CR1", 1)
        start = chip.time.now
        chip.advance(200)
        rises = chip.dma("TIM6_UP").pulses
        assert [cycle - start for cycle in rises] == [42, 82, 122, 162]  # the first tick comes one tick after CEN
        assert chip.irq(54).level

    def test_trgo(self, make_timers):
        chip, six = make_timers("TIM6", kinds=F7_KINDS)
        heard = []
        six.services.input("TIM6_TRGO").on_change = lambda level: heard.append((chip.time.now, level))
        poke(six, "ARR", 9)
        poke(six, "CR2", 0x20)
        poke(six, "CR1", 1)
        chip.advance(25)
        assert heard == [(11, True), (11, False), (21, True), (21, False)]

    def test_a_master_mode_that_it_lacks(self, make_f7):
        chip, timer = make_f7("TIM7")
        poke(timer, "CR2", 0x40)
        poke(timer, "CR1", 1)
        chip.advance(100)
        assert chip.noted("reserved") == ["TIM7_CR2.MMS"]


class TestSmall:
    @each(("name", "irq"), [("TIM9", 24), ("TIM10", 25), ("TIM11", 26), ("TIM12", 43), ("TIM13", 44)])
    def test_pwm_and_interrupt(self, make_f7, name, irq):
        chip, timer = make_f7(name)
        poke(timer, "ARR", 9)
        poke(timer, "CCR1", 3)
        poke(timer, "CCMR1", 0x60)
        poke(timer, "CCER", 1)
        poke(timer, "DIER", 2)
        poke(timer, "CR1", 1)
        start = chip.time.now
        chip.advance(20)
        edges = [(cycle - start, level) for cycle, level in chip.output(f"{name}_CH1").edges]
        assert edges == [(0, True), (4, False), (11, True), (14, False)]
        assert chip.irq(irq).level

    def test_one_counts_what_another_compares(self, make_timers):
        """TIM9 on ITR2, the output of TIM10, as in external clock mode 1."""
        chip, nine, ten = make_timers("TIM9", "TIM10", kinds=F7_KINDS)
        poke(ten, "ARR", 9)
        poke(ten, "CCR1", 5)
        poke(ten, "CCMR1", 0x60)
        poke(nine, "SMCR", 0x27)
        poke(nine, "CR1", 1)
        poke(ten, "CR1", 1)
        chip.advance(35)
        assert peek(nine, "CNT") == 3

    def test_an_encoder_mode_is_reserved(self, make_f7):
        chip, timer = make_f7("TIM9")
        poke(timer, "SMCR", 3)
        poke(timer, "CR1", 1)
        chip.advance(11)
        assert peek(timer, "CNT") == 10
        assert chip.noted("reserved") == ["TIM9_SMCR.SMS"]

    def test_capture(self, make_f7):
        chip, timer = make_f7("TIM13")
        poke(timer, "CCMR1", 1)
        poke(timer, "CCER", 1)
        poke(timer, "CR1", 1)
        chip.advance(8)
        chip.input("TIM13_CH1").drive(True)
        assert peek(timer, "SR") & 2
        assert peek(timer, "CCR1") == 7


def test_reset_and_trigger(make_timers):
    """SMS = 1000: a rising edge of the trigger begins anew and starts the counter."""
    chip, one, two = make_timers("TIM1", "TIM2", kinds=F7_KINDS)
    poke(two, "CNT", 50)
    poke(two, "SMCR", 0x1_0000)
    poke(one, "EGR", 1)
    chip.advance(10)
    assert peek(two, "CNT") == 9
    assert peek(two, "CR1") & 1
    poke(one, "EGR", 1)
    chip.advance(3)
    assert peek(two, "CNT") == 3


def test_a_gate_of_an_input_of_both_edges_is_open_while_it_is_high(make_f7):
    chip, timer = make_f7("TIM3")
    poke(timer, "CCMR1", 1)
    poke(timer, "CCER", 0xA)
    poke(timer, "SMCR", 0x55)
    poke(timer, "CR1", 1)
    chip.advance(10)
    assert peek(timer, "CNT") == 0
    chip.input("TIM3_CH1").drive(True)
    chip.advance(10)
    assert peek(timer, "CNT") == 10
    chip.input("TIM3_CH1").drive(False)
    chip.advance(10)
    assert peek(timer, "CNT") == 10


def test_a_reserved_slave_mode(make_f7):
    chip, timer = make_f7("TIM2")
    poke(timer, "SMCR", 0x1_0001)
    assert chip.noted("reserved") == ["TIM2_SMCR.SMS"]


@each(("mode", "nearest"), [(8, 6), (9, 7), (10, 0)])
def test_modes_that_are_missing_are_noted(make_f7, mode, nearest):
    chip, timer = make_f7("TIM3")
    _, plain = make_f7("TIM3")
    poke(timer, "CCMR1", (mode & 7) << 12 | 1 << 24)
    poke(plain, "CCMR1", nearest << 12)
    assert chip.noted("unmodelled") == ["TIM3_CCMR1.OC2M"]
    assert timer._counting.units[1].mode == plain._counting.units[1].mode == nearest


@each(("name", "value"), [("TIM2", 0x400), ("TIM5", 0x40), ("TIM11", 1)])
def test_options_are_noted(make_f7, name, value):
    chip, timer = make_f7(name)
    poke(timer, "OR", value)
    assert chip.noted("unmodelled") == [f"{name}_OR"]


ITRS = {  # RM0410, the tables "TIMx internal trigger connection"
    "TIM1": "TIM5 TIM2 TIM3 TIM4",
    "TIM2": "TIM1 TIM8 TIM3 TIM4",
    "TIM3": "TIM1 TIM2 TIM5 TIM4",
    "TIM4": "TIM1 TIM2 TIM3 TIM8",
    "TIM5": "TIM2 TIM3 TIM4 TIM8",
    "TIM8": "TIM1 TIM2 TIM4 TIM5",
    "TIM12": "TIM4 TIM5 TIM13 TIM14",
}


@each("slave", ITRS)
@each("trigger", range(4))
def test_internal_triggers(make_f7, slave, trigger):
    chip, timer = make_f7(slave)
    poke(timer, "SMCR", 6 | trigger << 4)
    for master in F7_KINDS:
        if master != ITRS[slave].split()[trigger]:
            chip.input(f"{master}_TRGO").drive(True)
    assert not peek(timer, "CR1") & 1
    chip.input(f"{ITRS[slave].split()[trigger]}_TRGO").drive(True)
    assert peek(timer, "CR1") & 1


def test_timers_that_share_an_interrupt():
    chip = FakeChip()
    lines = IrqLines(chip.irq)
    services = dataclasses.replace(chip.services, irq=lines.line)
    one, nine = (Timer(name, 0x4001_0000, services, F7_KINDS[name]) for name in ("TIM1", "TIM9"))
    poke(nine, "DIER", 1)
    poke(nine, "EGR", 1)
    poke(one, "DIER", 0x80)
    poke(one, "EGR", 0x80)
    assert chip.irq(24).level
    poke(one, "SR", 0)
    assert chip.irq(24).level
    poke(nine, "SR", 0)
    assert not chip.irq(24).level


@given(apb=st.sampled_from([1, 2, 4, 8]))
def test_the_clock_is_that_of_the_bus(make_timer, apb):
    chip, timer = make_timer("TIM5", F7_KINDS, APB1=apb)
    poke(timer, "CR1", 1)
    chip.advance(1000)
    assert peek(timer, "CNT") == 1000 // max(apb // 2, 1) - 1


def test_every_kind_is_whole():
    for name, kind in F7_KINDS.items():
        chip = FakeChip()
        timer = Timer(name, 0, chip.services, kind)
        assert isinstance(timer, Peripheral)
        offsets = list(timer.registers)
        assert offsets == sorted(set(offsets))
        timer.reset()
        poke(timer, "CR1", 1)
        chip.advance(70_000)
        timer.before_clock_change()
        timer.after_clock_change()
        assert not chip.noted()
