"""IWDG against RM0008 section 19: the timeouts of table 96, keys, updates."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.stm32.iwdg import Iwdg
from targets.mcu.testing import FakeChip, peek, poke
from tests.each import each

# RM0008 table 96: prescaler bits, shortest timeout in ms (RL = 0), longest (RL = 0xFFF), at 40 kHz.
TABLE_96 = [
    (0, "0.1", "409.6"),
    (1, "0.2", "819.2"),
    (2, "0.4", "1638.4"),
    (3, "0.8", "3276.8"),
    (4, "1.6", "6553.6"),
    (5, "3.2", "13107.2"),
    (6, "6.4", "26214.4"),
    (7, "6.4", "26214.4"),
]
CYCLE_S = Fraction(1, 8_000_000)


@pytest.fixture
def chip():
    return FakeChip()


@pytest.fixture
def iwdg(chip):
    return chip.add(Iwdg(0x4000_3000, chip.services))


def configure(chip, iwdg, prescaler, reload):
    """The order of the vendor's library: start, open, set, wait, reload."""
    poke(iwdg, "KR", 0xCCCC)
    poke(iwdg, "KR", 0x5555)
    poke(iwdg, "PR", prescaler)
    poke(iwdg, "RLR", reload)
    chip.advance_s(Fraction(5, 40_000))
    assert peek(iwdg, "SR") == 0
    poke(iwdg, "KR", 0xAAAA)


def test_reset_values(iwdg):
    assert {name: peek(iwdg, name) for name in ("KR", "PR", "RLR", "SR")} == {"KR": 0, "PR": 0, "RLR": 0xFFF, "SR": 0}


@each("row", TABLE_96)
def test_timeouts_of_table_96(row):
    for reload, timeout_ms in ((0, row[1]), (0xFFF, row[2])):
        chip = FakeChip()
        iwdg = Iwdg(0x4000_3000, chip.services)
        configure(chip, iwdg, row[0], reload)
        chip.advance_s(Fraction(timeout_ms) / 1000 - CYCLE_S)
        assert chip.resets == []
        chip.advance(1)
        assert chip.resets == ["IWDG"]


@given(
    prescaler=st.integers(0, 7), reload=st.integers(0, 0xFFF), hclk=st.sampled_from([8_000_000, 72_000_000, 56_000_001])
)
def test_the_timeout_does_not_depend_on_hclk(prescaler, reload, hclk):
    chip = FakeChip()
    iwdg = chip.add(Iwdg(0x4000_3000, chip.services))
    configure(chip, iwdg, prescaler, reload)
    since_s = chip.time.seconds(chip.time.now)
    chip.change_clock(hclk)
    chip.advance_s(Fraction((reload + 1) * 4 * 2 ** min(prescaler, 6), 40_000) + Fraction(1, 1000))
    assert chip.resets == ["IWDG"]
    due_s = since_s + Fraction((reload + 1) * 4 * 2 ** min(prescaler, 6), 40_000)
    assert chip.time.seconds(chip.time.cycle_at(due_s)) - due_s < 1 / Fraction(hclk)


def test_it_starts_from_the_reset_value_of_the_counter(chip, iwdg):
    poke(iwdg, "KR", 0xCCCC)
    chip.advance_s(Fraction("0.4096") - CYCLE_S)
    assert chip.resets == []
    chip.advance(1)
    assert chip.resets == ["IWDG"]


def test_reloading_puts_the_reset_off(chip, iwdg):
    configure(chip, iwdg, 0, 399)  # 40 ms
    for _ in range(10):
        chip.advance_s(Fraction(39, 1000))
        poke(iwdg, "KR", 0xAAAA)
    assert chip.resets == []
    chip.advance_s(Fraction(40, 1000))
    assert chip.resets == ["IWDG"]


def test_starting_again_changes_nothing(chip, iwdg):
    configure(chip, iwdg, 0, 399)
    chip.advance_s(Fraction(39, 1000))
    poke(iwdg, "KR", 0xCCCC)
    chip.advance_s(Fraction(1, 1000))
    assert chip.resets == ["IWDG"]


@pytest.mark.parametrize("key", [None, 0xAAAA, 0xCCCC, 0x1234])
def test_writes_need_the_key_right_before(chip, iwdg, key):
    if key is not None:
        poke(iwdg, "KR", 0x5555)
        poke(iwdg, "KR", key)
    poke(iwdg, "PR", 3)
    poke(iwdg, "RLR", 100)
    chip.advance_s(Fraction(1, 1000))
    assert (peek(iwdg, "PR"), peek(iwdg, "RLR")) == (0, 0xFFF)
    assert chip.noted("misuse") == ["IWDG_PR", "IWDG_RLR"]


def test_updates_take_five_periods_of_the_lsi(chip, iwdg):
    poke(iwdg, "KR", 0x5555)
    poke(iwdg, "PR", 3)
    assert peek(iwdg, "SR") == 1
    poke(iwdg, "RLR", 100)
    assert peek(iwdg, "SR") == 3
    assert (peek(iwdg, "PR"), peek(iwdg, "RLR")) == (0, 0xFFF)
    poke(iwdg, "PR", 4)  # lost
    chip.advance(999)
    assert peek(iwdg, "SR") == 3
    chip.advance(1)  # 125 us
    assert peek(iwdg, "SR") == 0
    assert (peek(iwdg, "PR"), peek(iwdg, "RLR")) == (3, 100)
    assert chip.noted("misuse") == ["IWDG_PR"]


def test_set_reload_and_start_without_waiting(chip, iwdg):
    """The order of many programs; the reload follows the updates."""
    poke(iwdg, "KR", 0x5555)
    poke(iwdg, "PR", 2)
    poke(iwdg, "RLR", 249)
    poke(iwdg, "KR", 0xAAAA)
    poke(iwdg, "KR", 0xCCCC)
    chip.advance_s(Fraction(100, 1000) + Fraction(125, 1_000_000) - CYCLE_S)
    assert chip.resets == []
    chip.advance(1)
    assert chip.resets == ["IWDG"]


def test_a_reset_stops_it(chip, iwdg):
    configure(chip, iwdg, 0, 10)
    assert iwdg.runs
    iwdg.reset()
    assert not iwdg.runs
    chip.advance_s(Fraction(30))
    assert chip.resets == []


def test_the_option_bytes_may_start_it(chip):
    started = []
    iwdg = Iwdg(0x4000_3000, chip.services, starts_by_itself=lambda: True, start_lsi=lambda: started.append(True))
    iwdg.reset()
    assert started == [True]
    chip.advance_s(Fraction("0.4096"))
    assert chip.resets == ["IWDG"]


def test_an_update_without_the_lsi_is_noted(chip):
    iwdg = Iwdg(0x4000_3000, chip.services, lsi_on=lambda: False)
    poke(iwdg, "KR", 0x5555)
    poke(iwdg, "PR", 3)
    assert chip.noted("assumed") == ["IWDG_PR"]
