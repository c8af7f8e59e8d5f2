"""The independent watchdog with a window, at 32 kHz (RM0410 section 30)."""

from __future__ import annotations

from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.stm32.iwdg import Iwdg
from targets.mcu.testing import FakeChip, peek, poke
from tests.each import each

LSI_HZ = 32_000
UPDATE_S = Fraction(5, LSI_HZ)


def make(prescaler=0, reload=0xFFF, window=None):
    """A watchdog that runs, as RM0410 section 30.3.2 has it configured; it has just been reloaded."""
    chip = FakeChip(216_000_000)
    iwdg = chip.add(Iwdg(0x4000_3000, chip.services, lsi_hz=LSI_HZ, window=True))
    poke(iwdg, "KR", 0xCCCC)
    poke(iwdg, "KR", 0x5555)
    poke(iwdg, "PR", prescaler)
    poke(iwdg, "RLR", reload)
    chip.advance_s(UPDATE_S)
    assert peek(iwdg, "SR") == 0
    if window is None:
        poke(iwdg, "KR", 0xAAAA)
    else:
        poke(iwdg, "WINR", window)
        assert peek(iwdg, "SR") == 4
        chip.advance_s(UPDATE_S)
        assert peek(iwdg, "SR") == 0
    return chip, iwdg


def test_reset_values():
    chip = FakeChip()
    iwdg = Iwdg(0x4000_3000, chip.services, window=True)
    assert [peek(iwdg, name) for name in ("KR", "PR", "RLR", "SR", "WINR")] == [0, 0, 0xFFF, 0, 0xFFF]


def test_without_a_window_there_is_no_such_register():
    chip = FakeChip()
    iwdg = Iwdg(0x4000_3000, chip.services)
    iwdg.write(0x10, 5)
    assert iwdg.read(0x10) == 0
    assert chip.noted("reserved") == ["IWDG_0x10"]


# RM0410 table "Min/max IWDG timeout period at 32 kHz (LSI)"
@each(("prescaler", "shortest_ms", "longest_ms"), [(0, "0.125", 512), (3, 1, 4096), (6, 8, 32768)])
def test_timeouts(prescaler, shortest_ms, longest_ms):
    for reload, timeout_ms in ((0, shortest_ms), (0xFFF, longest_ms)):
        chip, _ = make(prescaler, reload)
        chip.advance_s(Fraction(timeout_ms) / 1000 - Fraction(1, 216_000_000))
        assert chip.resets == []
        chip.advance(1)
        assert chip.resets == ["IWDG"]


@given(reload=st.integers(1, 0xFFF), window=st.integers(0, 0xFFF), after=st.integers(0, 0xFFF))
def test_a_reload_above_the_window_resets(reload, window, after):
    after = min(after, reload)
    chip, iwdg = make(0, reload, window)
    chip.advance_s(Fraction(4 * after + 1, LSI_HZ))  # the counter stands at reload - after
    assert chip.resets == []
    poke(iwdg, "KR", 0xAAAA)
    assert chip.resets == (["IWDG"] if reload - after > window else [])


def test_a_reload_within_the_window_begins_anew():
    chip, iwdg = make(0, 100, 50)
    for _ in range(5):
        chip.advance_s(Fraction(4 * 60, LSI_HZ))
        poke(iwdg, "KR", 0xAAAA)
    assert chip.resets == []
    chip.advance_s(Fraction(4 * 101, LSI_HZ))
    assert chip.resets == ["IWDG"]


def test_the_window_needs_the_key():
    chip, iwdg = make()
    poke(iwdg, "WINR", 5)
    assert chip.noted("misuse") == ["IWDG_WINR"]
    chip.advance_s(UPDATE_S)
    assert peek(iwdg, "WINR") == 0xFFF


def test_a_new_window_reloads():
    chip, iwdg = make(0, 100)
    chip.advance_s(Fraction(4 * 90, LSI_HZ))
    poke(iwdg, "KR", 0x5555)
    poke(iwdg, "WINR", 50)
    chip.advance_s(UPDATE_S + Fraction(4 * 100, LSI_HZ))
    assert chip.resets == []
    chip.advance_s(Fraction(4, LSI_HZ))
    assert chip.resets == ["IWDG"]


def test_a_watchdog_that_does_not_run_is_never_too_early():
    chip = FakeChip()
    iwdg = Iwdg(0x4000_3000, chip.services, lsi_hz=LSI_HZ, window=True)
    poke(iwdg, "KR", 0x5555)
    poke(iwdg, "WINR", 5)
    chip.advance_s(UPDATE_S)
    poke(iwdg, "KR", 0xAAAA)
    assert chip.resets == []
