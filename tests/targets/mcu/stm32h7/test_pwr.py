"""PWR against RM0433 section 6: Run*, the supply that is chosen once, voltage scales, wake-up pins, deep sleep."""

from __future__ import annotations

import dataclasses
from fractions import Fraction
from types import SimpleNamespace

import pytest

from targets.mcu.stm32h7.pwr import DeepSleep, Pwr
from targets.mcu.testing import FakeChip, peek, poke

US = Fraction(1, 1_000_000)
ACTVOSRDY, VOSRDY, LDOEN, SCUEN, BYPASS = 1 << 13, 1 << 13, 1 << 1, 1 << 2, 1
SCALE1, SCALE2, SCALE3 = 3 << 14, 2 << 14, 1 << 14
SBF = 7 << 6


@pytest.fixture
def world():
    chip = FakeChip(hclk_hz=64_000_000)
    pwr = chip.add(Pwr(0x5802_4800, chip.services))
    world = SimpleNamespace(chip=chip, pwr=pwr, scales=[], over_drive=False)
    pwr.over_drive = lambda: world.over_drive
    pwr.on_scale = lambda: world.scales.append(pwr.scale())
    pwr.power_on()
    pwr.reset()
    return world


def supply(world):
    poke(world.pwr, "CR3", LDOEN)
    world.chip.advance_s(20 * US)


def test_after_power_on_no_voltage_is_ready(world):
    names = ("CR1", "CSR1", "CR3", "D3CR", "CPUCR")
    assert [peek(world.pwr, name) for name in names] == [0xF000_C000, 0x4000, LDOEN | SCUEN, 0x4000, 0]
    poke(world.pwr, "D3CR", SCALE1)
    world.chip.advance_s(1000 * US)
    assert peek(world.pwr, "D3CR") == SCALE1, "and never is, until CR3 was written"
    assert world.pwr.scale() == 3
    assert world.chip.noted("misuse") == ["PWR_D3CR.VOS"]


def test_writing_the_supply_makes_the_voltage_ready_after_a_while(world):
    poke(world.pwr, "CR3", LDOEN)
    assert not peek(world.pwr, "CSR1") & ACTVOSRDY
    world.chip.advance_s(20 * US)
    assert peek(world.pwr, "CSR1") == ACTVOSRDY | SCALE3
    assert peek(world.pwr, "D3CR") == VOSRDY | SCALE3
    assert peek(world.pwr, "CR3") == LDOEN


def test_the_supply_is_chosen_once_until_power_off(world):
    supply(world)
    poke(world.pwr, "CR3", BYPASS | SCUEN)
    assert peek(world.pwr, "CR3") == LDOEN
    assert world.chip.noted("misuse") == ["PWR_CR3"]
    world.pwr.reset()
    assert peek(world.pwr, "CR3") == LDOEN
    assert peek(world.pwr, "CSR1") & ACTVOSRDY, "a reset of the system is no power-off"
    world.pwr.power_on()
    assert peek(world.pwr, "CR3") == LDOEN | SCUEN
    assert not peek(world.pwr, "CSR1") & ACTVOSRDY


def test_scales_rise_when_they_are_ready_and_fall_at_once(world):
    supply(world)
    poke(world.pwr, "D3CR", SCALE1)
    assert (peek(world.pwr, "D3CR"), world.pwr.scale()) == (SCALE1, 3)
    world.chip.advance_s(20 * US)
    assert (peek(world.pwr, "D3CR"), world.pwr.scale()) == (SCALE1 | VOSRDY, 1)
    assert peek(world.pwr, "CSR1") == ACTVOSRDY | SCALE1
    poke(world.pwr, "D3CR", SCALE2)
    assert world.pwr.scale() == 2
    assert world.scales == [1, 2]


def test_scale_0_is_scale_1_with_over_drive(world):
    supply(world)
    poke(world.pwr, "D3CR", SCALE1)
    world.chip.advance_s(20 * US)
    world.over_drive = True
    world.pwr.over_drive_changed()
    assert not peek(world.pwr, "D3CR") & VOSRDY
    world.chip.advance_s(20 * US)
    assert (peek(world.pwr, "D3CR") & VOSRDY, world.pwr.scale()) == (VOSRDY, 0)
    assert not world.chip.noted()


def test_over_drive_at_another_scale_does_nothing(world):
    supply(world)
    world.over_drive = True
    world.pwr.over_drive_changed()
    world.chip.advance_s(20 * US)
    assert world.pwr.scale() == 3
    assert world.chip.noted("misuse") == ["SYSCFG_PWRCR.ODEN"]


def test_a_change_under_way_is_replaced_by_the_next(world):
    supply(world)
    poke(world.pwr, "D3CR", SCALE1)
    world.chip.advance_s(5 * US)
    poke(world.pwr, "D3CR", SCALE3)
    world.chip.advance_s(100 * US)
    assert (world.pwr.scale(), world.scales) == (3, [])


def test_the_backup_domain_opens_by_dbp_and_regulators_are_ready(world):
    assert not world.pwr.backup_writable()
    poke(world.pwr, "CR1", 1 << 8)
    assert world.pwr.backup_writable()
    poke(world.pwr, "CR2", 1)
    assert peek(world.pwr, "CR2") == 1 | 1 << 16
    poke(world.pwr, "CR3", LDOEN | 1 << 24)
    assert peek(world.pwr, "CR3") == LDOEN | 1 << 24 | 1 << 26


@pytest.mark.parametrize(("pdds", "mode"), [(0, DeepSleep.STOP), (3, DeepSleep.STOP), (7, DeepSleep.STANDBY)])
def test_standby_takes_all_domains(world, pdds, mode):
    poke(world.pwr, "CPUCR", pdds)
    assert world.pwr.deep_sleep() is mode
    assert world.chip.noted("unmodelled") == (["PWR_CPUCR.PDDS"] if pdds == 3 else [])


@pytest.mark.parametrize(("polarity", "level"), [(0, True), (1, False)])
def test_a_pin_ends_standby_by_the_edge_that_is_chosen(world, polarity, level):
    resets = []
    pwr = Pwr(0x5802_4800, _with_reset(world.chip, resets))
    world.chip.input("WKUP4").drive(not level)
    poke(pwr, "WKUPEPR", 1 << 3 | polarity << 11)
    assert pwr.enter_standby()
    world.chip.input("WKUP4").drive(level)
    assert resets == ["STANDBY"]
    assert peek(pwr, "WKUPFR") == 1 << 3
    assert peek(pwr, "CPUCR") & SBF == SBF
    poke(pwr, "WKUPCR", 1 << 3)
    assert peek(pwr, "WKUPFR") == 0
    poke(pwr, "CPUCR", 1 << 9)
    assert peek(pwr, "CPUCR") == 0


def _with_reset(chip, resets):
    return dataclasses.replace(chip.services, chip_reset=resets.append)


def test_a_flag_that_is_still_set_prevents_standby(world):
    world.chip.input("WKUP1").drive(True)
    poke(world.pwr, "WKUPEPR", 1)
    assert peek(world.pwr, "WKUPFR") == 1, "a pin that is at its level when it is enabled is an event"
    assert not world.pwr.enter_standby()
