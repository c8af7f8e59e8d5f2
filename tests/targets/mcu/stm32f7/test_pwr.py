"""PWR against RM0410 section 4: voltage scale, over-drive, wake-up pins, deep sleep; the backup SRAM behind its key."""

from __future__ import annotations

from fractions import Fraction

import pytest

from targets.mcu.stm32.backup_sram import BackupSram
from targets.mcu.stm32f7.pwr import DeepSleep, Pwr
from targets.mcu.testing import FakeChip, peek, poke

US = Fraction(1, 1_000_000)
ODEN, ODSWEN, ODRDY, ODSWRDY = 1 << 16, 1 << 17, 1 << 16, 1 << 17
SCALES = {1: 3 << 14, 2: 2 << 14, 3: 1 << 14}


class World:
    def __init__(self):
        self.chip = FakeChip(hclk_hz=16_000_000)
        self.pwr = self.chip.add(Pwr(0x4000_7000, self.chip.services))
        self.supplies = []
        self.pwr.on_supply = lambda: self.supplies.append(self.pwr.supply())


@pytest.fixture
def world():
    return World()


def test_reset_values(world):
    assert [peek(world.pwr, name) for name in ("CR1", "CSR1", "CR2", "CSR2")] == [0xC000, 0x4000, 0, 0]
    assert world.pwr.supply() == (1, False)


def test_a_voltage_scale_holds_from_when_the_pll_is_switched_on(world):
    poke(world.pwr, "CR1", SCALES[3])
    assert world.pwr.supply() == (1, False)
    world.pwr.pll_switched(True)
    assert world.pwr.supply() == (3, False)
    poke(world.pwr, "CR1", SCALES[1])
    assert peek(world.pwr, "CR1") == SCALES[3]
    assert world.chip.noted("misuse") == ["PWR_CR1.VOS"]
    world.pwr.pll_switched(False)
    poke(world.pwr, "CR1", SCALES[2])
    world.pwr.pll_switched(True)
    assert world.supplies == [(3, False), (2, False)]


def test_over_drive_takes_45_us(world):
    poke(world.pwr, "CR1", SCALES[1] | ODEN)
    assert peek(world.pwr, "CSR1") & (ODRDY | ODSWRDY) == ODRDY
    poke(world.pwr, "CR1", SCALES[1] | ODEN | ODSWEN)
    world.chip.advance_s(44 * US)
    assert world.pwr.supply() == (1, False)
    world.chip.advance_s(1 * US)
    assert world.pwr.supply() == (1, True)
    poke(world.pwr, "CR1", SCALES[1])
    assert peek(world.pwr, "CSR1") & (ODRDY | ODSWRDY) == 0
    assert world.supplies == [(1, True), (1, False)]


def test_over_drive_in_the_wrong_order_is_never_ready(world):
    poke(world.pwr, "CR1", SCALES[1] | ODSWEN)
    world.chip.advance_s(Fraction(1))
    assert world.pwr.supply() == (1, False)
    assert world.chip.noted("misuse") == ["PWR_CR1.ODSWEN"]


def test_stop_mode_ends_over_drive(world):
    poke(world.pwr, "CR1", SCALES[1] | ODEN)
    poke(world.pwr, "CR1", SCALES[1] | ODEN | ODSWEN)
    world.chip.advance_s(45 * US)
    world.pwr.enter_stop()
    assert (peek(world.pwr, "CR1"), world.pwr.supply()) == (SCALES[1], (1, False))


@pytest.mark.parametrize(
    ("control", "mode"),
    [
        (0, DeepSleep.STOP),
        (1 << 0, DeepSleep.STOP_LOW_POWER),
        (1 << 9, DeepSleep.STOP_FLASH_OFF),
        (1 << 9 | 1 << 0, DeepSleep.STOP_LOW_POWER_FLASH_OFF),
        (1 << 1, DeepSleep.STANDBY),
    ],
)
def test_what_sleepdeep_leads_to(world, control, mode):
    poke(world.pwr, "CR1", SCALES[1] | control)
    assert world.pwr.deep_sleep() is mode
    assert mode.is_standby is (control == 2)


@pytest.mark.parametrize(("pin", "number"), [(1, 0), (4, 3)])
@pytest.mark.parametrize("falling", [False, True])
def test_a_pin_ends_standby_at_its_edge(world, pin, number, falling):
    wkup = world.pwr._inputs[number]
    wkup.drive(falling)
    poke(world.pwr, "CR2", falling << 8 + number)
    poke(world.pwr, "CSR2", 1 << 8 + number)
    assert world.pwr.may_wake()
    assert world.pwr.enter_standby()
    wkup.drive(not falling)
    assert world.chip.resets == ["STANDBY"]
    world.pwr.reset()
    assert (peek(world.pwr, "CSR2") & 0x3F, peek(world.pwr, "CSR1") & 2) == (1 << number, 2)
    poke(world.pwr, "CR2", 1 << number)
    poke(world.pwr, "CR1", SCALES[1] | 1 << 3)
    assert (peek(world.pwr, "CSR2") & 0x3F, peek(world.pwr, "CSR1") & 2, peek(world.pwr, "CR2")) == (0, 0, 0)


def test_a_flag_that_is_set_wakes_at_once(world):
    world.pwr._inputs[0].drive(True)
    poke(world.pwr, "CSR2", 1 << 8)
    assert peek(world.pwr, "CSR2") == 0x101, "enabled while high"
    assert not world.pwr.enter_standby()


def test_the_rtc_ends_standby_if_it_may(world):
    assert world.pwr.enter_standby()
    world.pwr.wake_by_rtc()
    assert world.chip.resets == []
    assert world.chip.noted("misuse") == ["PWR_CSR1.EIWUP"]
    poke(world.pwr, "CSR1", 1 << 8)
    world.pwr.wake_by_rtc()
    assert (world.chip.resets, peek(world.pwr, "CSR1") & 1) == (["STANDBY"], 1)


def test_the_backup_regulator_is_ready_at_once(world):
    poke(world.pwr, "CSR1", 1 << 9)
    assert peek(world.pwr, "CSR1") & 1 << 3
    poke(world.pwr, "CSR1", 0)
    assert not peek(world.pwr, "CSR1") & 1 << 3


def test_backup_sram_takes_any_width_behind_its_key(world):
    sram = BackupSram(0x4002_4000, world.chip.services, writable=world.pwr.backup_writable)
    sram.write(0, 0x1234_5678)
    assert (sram.read(0), world.chip.noted("misuse")) == (0, ["BKPSRAM_SRAM"])
    poke(world.pwr, "CR1", SCALES[1] | 1 << 8)
    sram.write(0, 0x1234_5678)
    sram.write_part(1, 1, 0xAB)
    sram.write_part(0xFFE, 2, 0xCDEF)
    assert (sram.read(0), sram.read_part(2, 2), sram.read(0xFFC)) == (0x1234_AB78, 0x1234, 0xCDEF_0000)
    sram.reset()
    assert sram.read(0) == 0x1234_AB78
