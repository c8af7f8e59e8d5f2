"""How the peripherals of the STM32F103 are connected."""

from __future__ import annotations

import dataclasses

import pytest

from targets.boards import built_in_board
from targets.firmware import image_path
from targets.mcu.image import limits_for, load_image
from targets.mcu.machine import Machine
from targets.mcu.testing import peek, poke
from tests.each import each

BLUE_PILL = built_in_board("bluepill")


def chip_on(board):
    return Machine(board, load_image(image_path("selftest-crc"), limits_for(board.chip))).chip


@pytest.fixture
def chip():
    return chip_on(BLUE_PILL)


@each(
    ("is_clock", "bypass", "ready", "noted"),
    [
        *((True, True, True, []), (True, False, True, ["assumed"])),
        *((False, False, True, []), (False, True, False, ["misuse"])),
    ],
)
def test_hsebyp_works_where_the_board_drives_osc_in(is_clock, bypass, ready, noted):
    """RM0008 section 7.2.1: HSEBYP is for an external clock, a crystal needs the oscillator."""
    chip = chip_on(dataclasses.replace(BLUE_PILL, hse_bypass=is_clock))
    poke(chip.rcc, "CR", 0x83 | bypass << 18)
    poke(chip.rcc, "CR", 0x83 | bypass << 18 | 1 << 16)
    chip.services.time.run_due(1_000_000)
    assert bool(peek(chip.rcc, "CR") & 1 << 17) is ready
    assert [note.kind for note in chip.services.notes.all if note.where == "RCC_CR.HSEBYP"] == noted


def open_backup_domain(chip):
    poke(chip.rcc, "APB1ENR", 0x1800_0000)
    poke(chip.pwr, "CR", 0x100)


def test_a_reset_of_the_backup_domain_reaches_the_rtc_and_the_backup_registers(chip):
    rtc, time = chip.peripherals["RTC"], chip.services.time
    open_backup_domain(chip)
    poke(chip.rcc, "CSR", 1)
    time.run_due(time.now + 1_000_000)
    poke(chip.rcc, "BDCR", 0x8200)  # RTCEN on LSI
    poke(chip.bkp, "DR1", 0x1234)
    poke(rtc, "CRL", 0x10)
    poke(rtc, "CNTL", 0x5678)
    poke(rtc, "CRL", 0)
    time.run_due(time.now + 1_000_000)
    chip.reset("SFT")
    assert (peek(chip.bkp, "DR1"), peek(rtc, "CNTL")) == (0x1234, 0x5678)
    open_backup_domain(chip)
    poke(chip.rcc, "BDCR", 0x1_0000)
    assert (peek(chip.bkp, "DR1"), peek(rtc, "CNTL")) == (0, 0)


@pytest.mark.parametrize(("enabled", "main_output"), [(0x1000, 0), (0, 0x8000)])
def test_a_clock_failure_is_a_break_of_tim1(chip, enabled, main_output):
    """RM0008 section 14.3.12: the break source is the pin or the clock security system, both enabled by BKE."""
    tim1 = chip.peripherals["TIM1"]
    poke(chip.rcc, "CR", 0x9_0083)  # HSEON, CSSON
    chip.services.time.run_due(1_000_000)
    poke(chip.rcc, "APB2ENR", 0x800)
    poke(tim1, "BDTR", 0x8000 | 0x2000 | enabled)  # MOE, BKP: the pin, low, is not active
    chip.rcc.fail_hse()
    assert peek(tim1, "BDTR") & 0x8000 == main_output
    assert bool(peek(tim1, "SR") & 0x80) is bool(enabled)
