"""SDIO without a card: how commands end (RM0008 section 22)."""

from __future__ import annotations

import pytest

from targets.mcu.fidelity import Fidelity
from targets.mcu.stm32f1.sdio import Sdio
from targets.mcu.testing import FakeChip, peek, poke

CMDSENT, CTIMEOUT, CMDACT = 1 << 7, 1 << 2, 1 << 11
SHORT, WAITINT, CPSMEN = 1 << 6, 1 << 8, 1 << 10


@pytest.fixture
def chip():
    return FakeChip(72_000_000)


@pytest.fixture
def sdio(chip):
    sdio = chip.add(Sdio(0x4001_8000, chip.services))
    poke(sdio, "POWER", 3)
    poke(sdio, "CLKCR", 0x1B2)  # 400 kHz: HCLK / (178 + 2)
    return sdio


@pytest.mark.parametrize(("command", "clocks", "flag"), [(0, 48, CMDSENT), (SHORT | 8, 48 + 64, CTIMEOUT)])
def test_a_command_ends_without_an_answer(chip, sdio, command, clocks, flag):
    poke(sdio, "CMD", CPSMEN | command)
    chip.advance(180 * clocks - 1)
    assert peek(sdio, "STA") == CMDACT
    chip.advance(1)
    assert peek(sdio, "STA") == flag
    poke(sdio, "ICR", 0x5FF)
    assert peek(sdio, "STA") == 0


def test_the_clock_may_bypass_its_divider(chip, sdio):
    poke(sdio, "CLKCR", 0x5B2)
    poke(sdio, "CMD", CPSMEN)
    chip.advance(48)
    assert peek(sdio, "STA") == CMDSENT


@pytest.mark.parametrize(
    ("register", "value"), [("POWER", 0), ("CLKCR", 0xB2), ("CMD", CPSMEN | SHORT | WAITINT), ("CMD", SHORT)]
)
def test_nothing_ends(chip, sdio, register, value):
    poke(sdio, register, value)
    if register != "CMD":
        poke(sdio, "CMD", CPSMEN | SHORT)
    chip.advance(1_000_000)
    assert not peek(sdio, "STA") & ~CMDACT


def test_its_interrupt_is_that_of_a_flag_in_mask(chip, sdio):
    poke(sdio, "MASK", CTIMEOUT)
    poke(sdio, "CMD", CPSMEN | SHORT)
    chip.advance(180 * 112)
    assert chip.irq(49).level
    poke(sdio, "ICR", CTIMEOUT)
    assert not chip.irq(49).level


def test_a_reset_ends_a_command(chip, sdio):
    poke(sdio, "CMD", CPSMEN)
    sdio.reset()
    chip.advance(100_000)
    assert peek(sdio, "STA") == 0


def test_what_moves_data_is_absent(chip, sdio):
    absent = {register.name for register in sdio.registers.values() if register.fidelity is Fidelity.ABSENT}
    assert absent >= {"DTIMER", "DLEN", "DCTRL", "DCOUNT", "FIFO", "FIFOCNT", "RESP1"}
    poke(sdio, "DCTRL", 1)
    poke(sdio, "CMD", CPSMEN)
    assert chip.noted("unmodelled") == ["SDIO_DCTRL", "SDIO_CMD"]
