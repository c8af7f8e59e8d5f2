"""PWR and BKP against RM0008 sections 5 and 6."""

from __future__ import annotations

from fractions import Fraction

import pytest

from targets.mcu.services import Watch
from targets.mcu.stm32f1.bkp import Bkp
from targets.mcu.stm32f1.pwr import DeepSleep, Pwr
from targets.mcu.stm32f1.rtc import Rtc
from targets.mcu.testing import FakeChip, peek, poke

DATA = [f"DR{number}" for number in range(1, 11)]


@pytest.fixture
def chip():
    return FakeChip()


@pytest.fixture
def pwr(chip):
    return Pwr(0x4000_7000, chip.services)


@pytest.fixture
def bkp(chip, pwr):
    return Bkp(0x4000_6C00, chip.services, backup_writable=pwr.backup_writable)


@pytest.fixture
def open_bkp(bkp, pwr):
    poke(pwr, "CR", 0x100)
    return bkp


# --- PWR


def test_reset_values_of_pwr(pwr):
    assert (peek(pwr, "CR"), peek(pwr, "CSR")) == (0, 0)


@pytest.mark.parametrize(
    ("cr", "mode", "wakeup_us"),
    [
        (0, DeepSleep.STOP, "3.6"),
        (1, DeepSleep.STOP_LOW_POWER, "5.4"),
        (2, DeepSleep.STANDBY, "50"),
        (3, DeepSleep.STANDBY, "50"),
    ],
)
def test_deep_sleep_modes(pwr, cr, mode, wakeup_us):
    poke(pwr, "CR", cr)
    assert pwr.deep_sleep() is mode
    assert mode.wakeup_s * 1_000_000 == Fraction(wakeup_us)


def test_standby_and_its_flags(chip, pwr):
    poke(pwr, "CSR", 0x100)
    assert pwr.enter_standby()
    assert peek(pwr, "CSR") == 0x102
    chip.input("WKUP").drive(True)
    assert peek(pwr, "CSR") == 0x103
    assert chip.resets == ["STANDBY"]
    pwr.reset()
    chip.input("WKUP").drive(False)
    chip.input("WKUP").drive(True)
    assert chip.resets == ["STANDBY"]
    assert peek(pwr, "CSR") == 0x003
    assert not pwr.enter_standby()  # WUF is still set
    poke(pwr, "CR", 0x4)
    assert peek(pwr, "CSR") == 0x002
    poke(pwr, "CR", 0x8)
    assert peek(pwr, "CSR") == 0
    assert peek(pwr, "CR") == 0


def test_wkup_needs_its_enable_and_an_edge(chip, pwr):
    pin = chip.input("WKUP")
    pin.drive(True)
    assert peek(pwr, "CSR") == 0
    poke(pwr, "CSR", 0x100)
    assert peek(pwr, "CSR") == 0x101  # enabling it while the pin is high is an event
    poke(pwr, "CR", 0x4)
    poke(pwr, "CSR", 0x100)
    pin.drive(False)
    assert peek(pwr, "CSR") == 0x100
    pin.drive(True)
    assert peek(pwr, "CSR") == 0x101
    poke(pwr, "CSR", 0)
    poke(pwr, "CR", 0x4)
    pin.drive(False)
    pin.drive(True)
    assert peek(pwr, "CSR") == 0
    assert chip.resets == []


def test_power_on_clears_the_flags(pwr):
    pwr.enter_standby()
    pwr.power_on()
    assert peek(pwr, "CSR") == 0


def test_the_voltage_detector_is_noted(chip, pwr):
    poke(pwr, "CR", 0x10)
    assert chip.noted("unmodelled") == ["PWR_CR"]


# --- BKP


def test_reset_values_of_bkp(bkp):
    assert [peek(bkp, name) for name in [*DATA, "RTCCR", "CR", "CSR"]] == [0] * 13


def test_writes_need_dbp(chip, bkp, pwr):
    poke(bkp, "DR1", 0x1234)
    assert peek(bkp, "DR1") == 0
    assert chip.noted("misuse") == ["BKP_DR"]
    poke(pwr, "CR", 0x100)
    for number, name in enumerate(DATA):
        poke(bkp, name, 0xABCD_1200 + number)
    assert [peek(bkp, name) for name in DATA] == [0x1200 + number for number in range(10)]


def test_data_survives_a_reset_but_not_one_of_the_backup_domain(open_bkp):
    poke(open_bkp, "DR10", 0xBEEF)
    open_bkp.reset()
    assert peek(open_bkp, "DR10") == 0xBEEF
    open_bkp.reset_backup()
    assert peek(open_bkp, "DR10") == 0


@pytest.mark.parametrize("tpal", [0, 1])
def test_tampering_clears_the_data(chip, open_bkp, tpal):
    pin = chip.input("TAMPER")
    pin.drive(bool(tpal))  # not active
    poke(open_bkp, "CSR", 0x4)
    poke(open_bkp, "DR3", 0x55)
    poke(open_bkp, "CR", 1 | tpal << 1)
    assert peek(open_bkp, "DR3") == 0x55
    pin.drive(not tpal)
    assert [peek(open_bkp, name) for name in DATA] == [0] * 10
    assert peek(open_bkp, "CSR") == 0x304
    assert chip.irq(2).level
    poke(open_bkp, "CSR", 0x6)
    assert peek(open_bkp, "CSR") == 0x104
    assert not chip.irq(2).level
    poke(open_bkp, "CSR", 0x5)
    assert peek(open_bkp, "CSR") == 0x4


def test_an_active_pin_counts_when_it_is_enabled(chip, open_bkp):
    chip.input("TAMPER").drive(True)
    poke(open_bkp, "DR3", 0x55)
    poke(open_bkp, "CR", 1)
    assert peek(open_bkp, "DR3") == 0
    assert peek(open_bkp, "CSR") == 0x100
    assert not chip.irq(2).level


# --- what the RTC puts out (RM0008 sections 6.3.2 and 6.4.2)

CCO, ASOE, ASOS = 1 << 7, 1 << 8, 1 << 9


class Outputs:
    """BKP and the RTC at 32 Hz with seconds of 8 ticks, connected as in the chip; HCLK is 3200 Hz."""

    def __init__(self):
        self.chip = FakeChip(3200)
        self.hz = Fraction(32)
        self.rtc = self.chip.add(Rtc(0x4000_2800, self.chip.services, rtc_hz=lambda: self.hz))
        self.bkp = self.chip.add(
            Bkp(0x4000_6C00, self.chip.services, backup_writable=lambda: True, rtc_hz=lambda: self.hz)
        )
        self.on = []
        self.rtc.on_pulse = self.bkp.pulse
        self.bkp.on_output = self.taken
        self.rtc.clock_changed()
        poke(self.rtc, "CRL", 0x10)
        poke(self.rtc, "PRLH", 0)
        poke(self.rtc, "PRLL", 7)
        poke(self.rtc, "ALRH", 0)
        poke(self.rtc, "ALRL", 3)
        poke(self.rtc, "CRL", 0)
        self.chip.advance(300)
        self.pin = self.chip.output("TAMPER")
        self.begin = self.chip.time.now

    def taken(self, on, flag):
        self.on.append(on)
        self.rtc.tell(flag)

    def edges(self, ticks):
        self.chip.advance(100 * ticks)
        self.pin.look()
        return [((cycle - self.begin) / 100, level) for cycle, level in self.pin.edges if cycle > self.begin]


@pytest.fixture
def outputs():
    return Outputs()


@pytest.mark.parametrize("watch", Watch)
def test_the_clock_divided_by_64(outputs, watch):
    outputs.pin.set_watch(watch)
    poke(outputs.bkp, "RTCCR", CCO)
    assert outputs.on == [True]
    edges = outputs.edges(100)
    assert edges == ([(32, True), (64, False), (96, True)] if watch is not Watch.NOBODY else [(100, True)])
    outputs.hz = Fraction(0)
    outputs.rtc.clock_changed()
    outputs.bkp.rtc_clock_changed()
    assert outputs.pin.level is False
    poke(outputs.bkp, "RTCCR", 0)
    assert outputs.on == [True, False]
    assert outputs.pin.level is None


def test_each_second_is_a_pulse_of_a_tick(outputs):
    poke(outputs.bkp, "RTCCR", ASOE | ASOS)
    assert outputs.edges(24) == [(7, True), (8, False), (15, True), (16, False), (23, True), (24, False)]


def test_so_is_each_alarm(outputs):
    poke(outputs.bkp, "RTCCR", ASOE)
    assert outputs.edges(80) == [(31, True), (32, False)]
    outputs.bkp.reset()
    assert outputs.on == [True]
    outputs.bkp.reset_backup()
    assert outputs.on == [True, False]


def test_not_beside_tamper_detection(outputs):
    poke(outputs.bkp, "CR", 1)
    poke(outputs.bkp, "RTCCR", CCO)
    assert outputs.chip.noted("misuse") == ["BKP_RTCCR"]


def test_nor_is_tamper_detection_beside_it(outputs):
    poke(outputs.bkp, "RTCCR", CCO)
    poke(outputs.bkp, "CR", 1)
    assert outputs.chip.noted("misuse") == ["BKP_CR"]
