"""What the timers of the STM32H7 have that those of the F7 have not (RM0433 sections 38 to 42)."""

from __future__ import annotations

from itertools import pairwise

import pytest

from targets.mcu.stm32.tim import Timer
from targets.mcu.stm32.tim.h7_kinds import H7_KINDS
from targets.mcu.testing import FakeChip, peek, poke
from tests.each import each

BIF = 1 << 7
MOE = 1 << 15
TIM15 = {
    "CR2": 0x7FD,
    "SMCR": 0x31_00F7,
    "DIER": 0x67E7,
    "CCMR1": 0x0101_FFFF,
    "CCER": 0xBF,
    "RCR": 0xFF,
    "DCR": 0x1F1F,
}
TIM16 = {"CR2": 0x30D, "DIER": 0x3A3, "CCMR1": 0x1_00FF, "CCER": 0xF, "RCR": 0xFF, "TISEL": 0xF}
MASKS = {
    "TIM1": {"SMCR": 0x31_FFF7, "AF1": 0x3_CF07, "AF2": 0x0F07, "TISEL": 0x0F0F_0F0F, "CCR5": 0xE000_FFFF},
    "TIM2": {"SMCR": 0x31_FFF7, "AF1": 0x3_C000, "TISEL": 0x0F0F_0F0F, "ARR": 0xFFFF_FFFF, "CCR4": 0xFFFF_FFFF},
    "TIM3": {"SMCR": 0x31_FFF7, "ARR": 0xFFFF, "CCR4": 0xFFFF},
    "TIM6": {"CR2": 0x70, "DIER": 0x101},
    "TIM12": {"CR2": 0xF0, "SMCR": 0x31_00F7, "DIER": 0x47, "TISEL": 0x0F0F},
    "TIM13": {"DIER": 3, "TISEL": 0xF},
    "TIM15": TIM15,
    "TIM16": TIM16,
    "TIM17": TIM16,
}


@pytest.fixture
def make_h7(make_timer):
    return lambda name, **dividers: make_timer(name, H7_KINDS, **dividers)


@each("name", MASKS)
def test_reserved_bits(make_h7, name):
    for register, mask in MASKS[name].items():
        _, timer = make_h7(name)
        poke(timer, register, 0xFFFF_FFFF)
        assert peek(timer, register) == mask, register


def test_each_timer_hears_the_masters_of_the_manual():
    """RM0433, the tables "TIMx internal trigger connection": ITR0 to ITR3."""
    table = """TIM1 TIM15 TIM2 TIM3 TIM4|TIM2 TIM1 TIM8 TIM3 TIM4|TIM3 TIM1 TIM2 TIM15 TIM4|TIM4 TIM1 TIM2 TIM3 TIM8
    TIM5 TIM1 TIM8 TIM3 TIM4|TIM8 TIM1 TIM2 TIM4 TIM5|TIM12 TIM4 TIM5 TIM13 TIM14|TIM15 TIM1 TIM3 TIM16 TIM17"""
    rows = [row.split() for line in table.split("\n") for row in line.split("|")]
    expected = {name: tuple(masters) for name, *masters in rows}
    found = {name: tuple(kind.internal_triggers) for name, kind in H7_KINDS.items()}
    assert {name: found[name] for name in expected} == expected
    assert {found[name] for name in set(found) - set(expected)} == {(None, None, None, None)}


def test_a_source_of_the_break_other_than_its_pin_is_noted(make_h7):
    """BKINE is the pin (bit 0), which is always heard; the next bits are comparators, DFSDM and polarities."""
    for value, noted in ((0, True), (1, False), (2, True), (3, True)):
        chip, timer = make_h7("TIM1")
        poke(timer, "AF1", value)
        assert ("TIM1_AF1" in chip.noted("unmodelled")) is noted, value


def test_the_sources_of_the_break_after_reset(make_h7):
    assert [peek(make_h7(name)[1], "AF1") for name in ("TIM1", "TIM2", "TIM15", "TIM16")] == [1, 0, 1, 1]


@each(("name", "missing"), [("TIM2", 0x50), ("TIM6", 0x68), ("TIM13", 0x04), ("TIM16", 0x08)])
def test_what_a_timer_lacks(make_h7, name, missing):
    chip, timer = make_h7(name)
    timer.write(missing, 0xFFFF_FFFF)
    assert timer.read(missing) == 0
    assert chip.noted("reserved") == [f"{name}_0x{missing:02X}"]


ITRS = {  # RM0433, "TIMx internal trigger connection"; Linux, drivers/iio/trigger/stm32-timer-trigger.c
    "TIM1": "TIM15 TIM2 TIM3 TIM4",
    "TIM2": "TIM1 TIM8 TIM3 TIM4",
    "TIM3": "TIM1 TIM2 TIM15 TIM4",
    "TIM4": "TIM1 TIM2 TIM3 TIM8",
    "TIM5": "TIM1 TIM8 TIM3 TIM4",
    "TIM8": "TIM1 TIM2 TIM4 TIM5",
    "TIM12": "TIM4 TIM5 TIM13 TIM14",
    "TIM15": "TIM1 TIM3 TIM16 TIM17",
}


@each("slave", ITRS)
@each("trigger", range(4))
def test_internal_triggers(make_h7, slave, trigger):
    chip, timer = make_h7(slave)
    poke(timer, "SMCR", 6 | trigger << 4)
    for master in H7_KINDS:
        if master != ITRS[slave].split()[trigger]:
            chip.input(f"{master}_TRGO").drive(True)
    assert not peek(timer, "CR1") & 1
    chip.input(f"{ITRS[slave].split()[trigger]}_TRGO").drive(True)
    assert peek(timer, "CR1") & 1


@each(("register", "value"), [("SMCR", 1 << 20), ("TISEL", 1), ("AF1", 1 | 1 << 1), ("AF1", 1 | 1 << 14)])
def test_sources_that_are_not_modelled_say_so(make_h7, register, value):
    chip, timer = make_h7("TIM1")
    poke(timer, register, value)
    assert chip.noted("unmodelled") == [f"TIM1_{register}"]


def test_tim12_is_a_master(make_timers):
    chip, timer = make_timers("TIM12", kinds=H7_KINDS)
    heard = []
    timer.services.input("TIM12_TRGO").on_change = lambda level: heard.append((chip.time.now, level))
    poke(timer, "ARR", 9)
    poke(timer, "CR2", 0x20)
    poke(timer, "CR1", 1)
    chip.advance(25)
    assert heard == [(11, True), (11, False), (21, True), (21, False)]


@pytest.mark.parametrize(("name", "irq"), [("TIM15", 116), ("TIM16", 117), ("TIM17", 118)])
class TestWithBreak:
    def open(self, make_h7, name, bdtr=MOE):
        """PWM, high for 4 of 10 ticks, at both outputs of channel 1."""
        chip, timer = make_h7(name)
        poke(timer, "CCMR1", 0x60)
        poke(timer, "CCR1", 4)
        poke(timer, "ARR", 9)
        poke(timer, "CCER", 0x5)
        poke(timer, "BDTR", bdtr)
        poke(timer, "CR1", 1)
        return chip, timer, chip.time.now

    def test_complementary_outputs_with_dead_time(self, make_h7, name, irq):
        chip, _, start = self.open(make_h7, name, MOE | 2)
        chip.advance(25)
        for output, high in ((f"{name}_CH1", (13, 15)), (f"{name}_CH1N", (17, 21))):
            levels = dict(chip.output(output).edges)
            rises = [cycle - start for cycle, level in levels.items() if level]
            falls = [cycle - start for cycle, level in levels.items() if level is False]
            assert high[0] in rises, output
            assert high[1] in falls, output

    def test_without_moe_the_outputs_are_released(self, make_h7, name, irq):
        chip, timer, _ = self.open(make_h7, name, 0)
        chip.advance(15)
        assert chip.output(f"{name}_CH1").level is None
        poke(timer, "BDTR", MOE)
        chip.advance(20)
        assert chip.output(f"{name}_CH1").level is not None

    def test_a_break_and_its_interrupt(self, make_h7, name, irq):
        chip, timer, _ = self.open(make_h7, name, MOE | 3 << 12)
        poke(timer, "DIER", BIF)
        chip.input(f"{name}_BKIN").drive(True)
        assert not peek(timer, "BDTR") & MOE
        assert chip.output(f"{name}_CH1").level is None
        assert chip.irq(irq).level

    def test_repetitions_and_requests(self, make_h7, name, irq):
        chip, timer, _ = self.open(make_h7, name)
        poke(timer, "RCR", 2)
        poke(timer, "EGR", 1)
        poke(timer, "SR", 0)
        poke(timer, "DIER", 0x301)
        chip.advance(100)
        updates = chip.dma(f"{name}_UP").pulses
        assert {later - earlier for earlier, later in pairwise(updates)} == {30}
        assert len(chip.dma(f"{name}_CH1").pulses) in (9, 10)
        assert chip.irq(irq).level

    def test_every_compare_is_a_trigger_of_tim15(self, make_h7, name, irq):
        """OC1REF of TIM16 and TIM17 is always what their slave hears; TIM15 chooses it as a master."""
        chip, timer, start = self.open(make_h7, name)
        poke(timer, "CR2", 0x40 if name == "TIM15" else 0x300)
        chip.advance(30)
        edges = [(cycle - start, level) for cycle, level in chip.output(f"{name}_TRGO").edges if cycle > start]
        assert edges[-2:] in ([(15, False), (21, True)], [(21, True), (25, False)])


def test_the_second_channel_of_tim15_has_one_output(make_h7):
    chip, timer = make_h7("TIM15")
    poke(timer, "CCMR1", 0x6000)
    poke(timer, "CCR2", 4)
    poke(timer, "ARR", 9)
    poke(timer, "CCER", 0x50)
    poke(timer, "BDTR", MOE)
    poke(timer, "CR1", 1)
    chip.advance(3)
    assert chip.output("TIM15_CH2").level is True
    assert peek(timer, "CCER") == 0x10


def test_every_kind_is_whole():
    for name, kind in H7_KINDS.items():
        chip = FakeChip()
        timer = Timer(name, 0, chip.services, kind)
        offsets = list(timer.registers)
        assert offsets == sorted(set(offsets))
        timer.reset()
        poke(timer, "CR1", 1)
        chip.advance(70_000)
        timer.before_clock_change()
        timer.after_clock_change()
        assert not chip.noted()
