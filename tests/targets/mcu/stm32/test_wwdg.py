"""WWDG against RM0008 section 20: the timeout formula, the window, the early wake-up interrupt, its clock."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.stm32.wwdg import Wwdg
from targets.mcu.testing import FakeChip, peek, poke


@pytest.fixture
def chip():
    return FakeChip(36_000_000)


@pytest.fixture
def wwdg(chip):
    return chip.add(Wwdg(0x4000_2C00, chip.services))


def test_reset_values(wwdg):
    assert {name: peek(wwdg, name) for name in ("CR", "CFR", "SR")} == {"CR": 0x7F, "CFR": 0x7F, "SR": 0}


@given(counter=st.integers(0x40, 0x7F), base=st.integers(0, 3), divider=st.sampled_from([1, 2, 4, 8, 16]))
def test_the_timeout_formula(counter, base, divider):
    chip = FakeChip(dividers={"APB1": divider})
    wwdg = chip.add(Wwdg(0x4000_2C00, chip.services))
    chip.advance(12_345)
    poke(wwdg, "CFR", base << 7 | 0x7F)
    poke(wwdg, "CR", 0x80 | counter)
    timeout = 4096 * 2**base * ((counter & 0x3F) + 1) * divider
    chip.advance(timeout - 1)
    assert chip.resets == []
    chip.advance(1)
    assert chip.resets == ["WWDG"]


@pytest.mark.parametrize(
    ("base", "shortest_us", "longest_us"), [(0, 113, 7280), (1, 227, 14560), (2, 455, 29120), (3, 910, 58250)]
)
def test_timeouts_at_36_mhz(chip, wwdg, base, shortest_us, longest_us):
    """The figures of the manual's table of timeouts at 36 MHz, which are rounded down."""
    for counter, figure_us in ((0x40, shortest_us), (0x7F, longest_us)):
        chip.resets.clear()
        wwdg.reset()
        poke(wwdg, "CFR", base << 7 | 0x7F)
        poke(wwdg, "CR", 0x80 | counter)
        chip.advance(figure_us * 36 - 1)
        assert chip.resets == []
        chip.advance(36 * 12)
        assert chip.resets == ["WWDG"]


def test_the_counter_can_be_read_and_runs_without_the_watchdog(chip, wwdg):
    chip.advance(4095)
    assert peek(wwdg, "CR") == 0x7F
    chip.advance(1)
    assert peek(wwdg, "CR") == 0x7E
    chip.advance(4096 * 0x7E)
    assert peek(wwdg, "CR") == 0
    chip.advance(4096)
    assert peek(wwdg, "CR") == 0x7F
    assert chip.resets == []


def test_refreshing_in_the_window(chip, wwdg):
    poke(wwdg, "CFR", 0x50)
    poke(wwdg, "CR", 0xFF)
    for _ in range(5):
        chip.advance(4096 * (0x7F - 0x50))
        poke(wwdg, "CR", 0x7F)
        assert chip.resets == []
    chip.advance(4096 * (0x7F - 0x50) - 1)  # the counter is at 0x51
    poke(wwdg, "CR", 0x7F)
    assert chip.resets == ["WWDG"]


def test_the_window_does_not_count_before_the_watchdog_is_on(chip, wwdg):
    poke(wwdg, "CFR", 0x40)
    poke(wwdg, "CR", 0x7F)
    poke(wwdg, "CR", 0xFF)
    assert chip.resets == []


def test_clearing_t6_is_a_reset(chip, wwdg):
    poke(wwdg, "CR", 0xC0)
    poke(wwdg, "CR", 0xBF)
    assert chip.resets == ["WWDG"]


def test_wdga_cannot_be_cleared(chip, wwdg):
    poke(wwdg, "CR", 0xFF)
    poke(wwdg, "CR", 0x7F)
    assert peek(wwdg, "CR") == 0xFF
    assert wwdg.runs
    wwdg.reset()
    assert peek(wwdg, "CR") == 0x7F
    assert not wwdg.runs


def test_early_wakeup(chip, wwdg):
    poke(wwdg, "CFR", 0x27F)
    poke(wwdg, "CR", 0xFF)
    chip.advance(4096 * 0x3F - 1)
    assert peek(wwdg, "SR") == 0
    chip.advance(1)
    assert peek(wwdg, "CR") == 0xC0
    assert peek(wwdg, "SR") == 1
    assert chip.irq(0).level
    poke(wwdg, "CR", 0xFF)
    poke(wwdg, "SR", 1)
    assert peek(wwdg, "SR") == 1
    poke(wwdg, "SR", 0)
    assert peek(wwdg, "SR") == 0
    assert not chip.irq(0).level
    chip.advance(4096 * 0x3F)
    assert chip.irq(0).level


def test_the_flag_rises_without_the_interrupt_which_cannot_be_disabled(chip, wwdg):
    poke(wwdg, "CR", 0xC1)
    chip.advance(4096)
    assert peek(wwdg, "SR") == 1
    assert not chip.irq(0).level
    poke(wwdg, "CFR", 0x27F)
    assert chip.irq(0).level
    poke(wwdg, "CFR", 0x07F)
    assert peek(wwdg, "CFR") == 0x27F


def test_it_stops_with_its_clock_and_goes_on(chip, wwdg):
    poke(wwdg, "CR", 0xFF)
    chip.advance(4096 * 10 + 100)
    wwdg.before_clock_change()
    wwdg.clocked = False
    wwdg.after_clock_change()
    chip.advance(10_000_000)
    assert chip.resets == []
    wwdg.before_clock_change()
    wwdg.clocked = True
    wwdg.after_clock_change()
    chip.advance(4096 * 54 - 100 - 1)
    assert chip.resets == []
    chip.advance(1)
    assert chip.resets == ["WWDG"]


def test_it_keeps_its_count_over_a_change_of_the_clock(chip, wwdg):
    poke(wwdg, "CR", 0xFF)
    chip.advance(4096 * 10)
    chip.change_clock(8_000_000, APB1=4)
    assert peek(wwdg, "CR") == 0xF5
    chip.advance(4096 * 4 * 54 - 1)
    assert chip.resets == []
    chip.advance(1)
    assert chip.resets == ["WWDG"]
