"""EXTI, SYSCFG and HSEM against RM0433 sections 20, 12 and 10."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.stm32h7.exti import Exti
from targets.mcu.stm32h7.hsem import Hsem
from targets.mcu.testing import FakeChip, peek, poke

TAKEN, CPU = 1 << 31, 3 << 8


@pytest.fixture
def chip():
    return FakeChip()


@pytest.fixture
def exti(chip):
    exti = chip.add(Exti(0x5800_0000, chip.services))
    exti.reset()
    return exti


IRQS = {
    **{line: 6 + line for line in range(5)},
    **dict.fromkeys(range(5, 10), 23),
    **dict.fromkeys(range(10, 16), 40),
    16: 1,
    17: 41,
    18: 2,
    19: 3,
    20: 137,
    21: 137,
}


@pytest.mark.parametrize(("line", "irq"), IRQS.items())
def test_each_line_has_its_interrupt(chip, exti, line, irq):
    poke(exti, "RTSR1", 1 << line)
    poke(exti, "CPUIMR1", 1 << line)
    chip.input(f"EXTI{line}").drive(True)
    assert chip.irq(irq).level
    assert peek(exti, "CPUPR1") == 1 << line
    poke(exti, "CPUPR1", 1 << line)
    assert not chip.irq(irq).level


@given(rising=st.booleans(), falling=st.booleans(), masked=st.booleans(), levels=st.lists(st.booleans(), max_size=6))
def test_edges_are_those_that_are_chosen(rising, falling, masked, levels):
    chip = FakeChip()
    exti = chip.add(Exti(0x5800_0000, chip.services))
    exti.reset()
    events = []
    exti.on_event = lambda: events.append(True)
    poke(exti, "RTSR1", rising << 13)
    poke(exti, "FTSR1", falling << 13)
    poke(exti, "CPUIMR1", 0 if masked else 1 << 13)
    poke(exti, "CPUEMR1", 1 << 13)
    level, wanted = False, 0
    for new in levels:
        wanted += (new and not level and rising) or (level and not new and falling)
        level = new
        chip.input("EXTI13").drive(new)
    assert len(events) == wanted
    assert bool(peek(exti, "CPUPR1")) is bool(wanted and not masked)


def test_direct_lines_are_unmasked_and_have_no_edges(exti):
    assert [peek(exti, f"CPUIMR{group}") for group in (1, 2, 3)] == [0xFFC0_0000, 0xFFF5_DFFF, 0x0185_FFFF]
    for name in ("RTSR", "FTSR"):
        for group in (1, 2, 3):
            poke(exti, f"{name}{group}", 0xFFFF_FFFF)
        assert [peek(exti, f"{name}{group}") for group in (1, 2, 3)] == [0x003F_FFFF, 0x000A_0000, 0x0074_0000]


def test_software_sets_each_line_once_until_it_is_cleared(chip, exti):
    poke(exti, "CPUIMR1", 1 << 3)
    poke(exti, "SWIER1", 1 << 3)
    assert (peek(exti, "CPUPR1"), peek(exti, "SWIER1"), chip.irq(9).level) == (8, 8, True)
    poke(exti, "CPUPR1", 8)
    assert (peek(exti, "CPUPR1"), peek(exti, "SWIER1"), chip.irq(9).level) == (0, 0, False)
    poke(exti, "SWIER1", 1 << 4)
    assert chip.noted("misuse") == ["EXTI_SWIER1"], "a line that nobody unmasks"


def test_domain_3_is_declared_absent(chip, exti):
    poke(exti, "D3PMR1", 1)
    assert chip.noted("unmodelled") == ["EXTI_D3PMR1"]
    assert exti.sends_events() is False
    poke(exti, "CPUEMR2", 1 << 17)
    poke(exti, "RTSR2", 1 << 17)
    assert exti.sends_events() is True


@pytest.fixture
def hsem(chip):
    return chip.add(Hsem(0x5802_6400, chip.services))


def test_a_semaphore_is_taken_in_two_steps_or_in_one(chip, hsem):
    poke(hsem, "R5", TAKEN | CPU | 7)
    assert peek(hsem, "R5") == TAKEN | CPU | 7
    poke(hsem, "R5", TAKEN | CPU | 8)
    assert peek(hsem, "R5") == TAKEN | CPU | 7, "by whoever came first"
    assert peek(hsem, "RLR5") == TAKEN | CPU | 7
    assert peek(hsem, "RLR6") == TAKEN | CPU
    poke(hsem, "R5", CPU | 8)
    assert peek(hsem, "R5") & TAKEN
    poke(hsem, "R5", CPU | 7)
    assert peek(hsem, "R5") == 0


def test_a_release_is_an_interrupt_where_it_is_enabled(chip, hsem):
    for number in (3, 4):
        hsem.read(0x80 + 4 * number)
    poke(hsem, "C1IER", 1 << 4)
    poke(hsem, "R3", CPU)
    assert (peek(hsem, "C1ISR"), peek(hsem, "C1MISR"), chip.irq(125).level) == (8, 0, False)
    poke(hsem, "R4", CPU)
    assert (peek(hsem, "C1ISR"), peek(hsem, "C1MISR"), chip.irq(125).level) == (0x18, 0x10, True)
    poke(hsem, "C1ICR", 0x18)
    assert (peek(hsem, "C1ISR"), chip.irq(125).level) == (0, False)


def test_all_semaphores_of_a_master_are_cleared_with_the_key(hsem):
    hsem.read(0x80)
    poke(hsem, "KEYR", 0x1234_0000)
    poke(hsem, "CR", 0x4321_0000 | CPU)
    assert peek(hsem, "R0") & TAKEN
    poke(hsem, "CR", 0x1234_0000 | CPU)
    assert peek(hsem, "R0") == 0
