"""RCC against RM0008 section 7: reset values, every clock configuration, ready flags, what cannot be switched off."""

from __future__ import annotations

import dataclasses
from fractions import Fraction
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.registers import Peripheral, Register
from targets.mcu.stm32f1.clocks import ClockTree
from targets.mcu.stm32f1.rcc import Rcc
from targets.mcu.testing import FakeChip, peek, poke

US = Fraction(1, 1_000_000)
MS = Fraction(1, 1000)


class Probe(Peripheral):
    """Records what RCC tells it."""

    REGISTERS = (Register("R", 0),)

    def __init__(self, name, base, services):
        super().__init__(name, base, services)
        self.log = []

    def before_clock_change(self):
        self.log.append(("before", self.time.now, self.clocked, self.services.clocks.pclk("APB1")))

    def after_clock_change(self):
        self.log.append(("after", self.time.now, self.clocked, self.services.clocks.pclk("APB1")))

    def reset(self):
        super().reset()
        self.log.append("reset")

    def reset_backup(self):
        self.log.append("reset_backup")


def build(*, hse_hz=8_000_000, **options):
    chip = FakeChip()
    tree = ClockTree()
    services = dataclasses.replace(chip.services, clocks=tree)
    world = SimpleNamespace(chip=chip, tree=tree, dbp=True, nmi=[], failures=[])
    rcc = Rcc(0x4002_1000, services, tree, hse_hz=hse_hz, backup_writable=lambda: world.dbp, **options)
    rcc.on_nmi = world.nmi.append
    rcc.on_clock_failure = lambda: world.failures.append(chip.time.now)
    world.rcc = rcc
    world.usart = Probe("USART1", 0x4001_3800, services)
    world.tim = Probe("TIM2", 0x4000_0000, services)
    gates = {"USART1": ("APB2", 14), "TIM2": ("APB1", 0), "GPIOA": ("APB2", 2)}
    rcc.connect(gates, {"USART1": world.usart, "TIM2": world.tim, "RCC": rcc}, backup=[world.tim])
    for probe in (world.usart, world.tim):
        probe.log.clear()
    return world


@pytest.fixture
def world():
    return build()


def to_72_mhz(world):
    """What SystemInit of the vendor's library does."""
    rcc, chip = world.rcc, world.chip
    poke(rcc, "CR", peek(rcc, "CR") | 1 << 16)
    chip.advance_s(2 * MS)
    poke(rcc, "CFGR", 0x001D_0400)
    poke(rcc, "CR", peek(rcc, "CR") | 1 << 24)
    chip.advance_s(200 * US)
    poke(rcc, "CFGR", peek(rcc, "CFGR") | 2)


def test_reset_values(world):
    names = ("CR", "CFGR", "CIR", "APB2RSTR", "APB1RSTR", "AHBENR", "APB2ENR", "APB1ENR", "BDCR", "CSR")
    values = {name: peek(world.rcc, name) for name in names}
    assert values == dict.fromkeys(names, 0) | {"CR": 0x83, "AHBENR": 0x14, "CSR": 0x0C00_0000}


def test_hse_takes_two_milliseconds(world):
    poke(world.rcc, "CR", 0x0001_0083)
    world.chip.advance(15_999)
    assert not peek(world.rcc, "CR") & 1 << 17
    world.chip.advance(1)
    assert peek(world.rcc, "CR") == 0x0003_0083


def test_hse_without_a_crystal_is_never_ready():
    world = build(hse_hz=None)
    poke(world.rcc, "CR", 0x0001_0083)
    world.chip.advance_s(Fraction(1))
    assert peek(world.rcc, "CR") == 0x0001_0083


def test_hserdy_goes_low_six_cycles_after_hseon(world):
    poke(world.rcc, "CR", 0x0001_0083)
    world.chip.advance_s(2 * MS)
    poke(world.rcc, "CR", 0x0000_0083)
    world.chip.advance(5)
    assert peek(world.rcc, "CR") & 1 << 17
    world.chip.advance(1)
    assert peek(world.rcc, "CR") == 0x83


def test_72_mhz_the_usual_way(world):
    to_72_mhz(world)
    assert peek(world.rcc, "CFGR") == 0x001D_040A
    assert world.chip.time.hclk_hz == 72_000_000
    assert world.tree.pclk("APB1") == 2
    assert world.tree.timer("APB1") == 1
    assert world.tree.pclk("APB2") == 1
    assert world.tree.rates.adc == 36_000_000
    assert world.tree.rates.usb == 48_000_000
    assert world.chip.notes.all == []


def test_everybody_is_told_before_and_after_a_change(world):
    poke(world.rcc, "CFGR", 0x400)
    assert world.usart.log == [("before", 0, False, 1), ("after", 0, False, 2)]


def test_a_write_that_changes_no_rate_tells_nobody(world):
    poke(world.rcc, "CFGR", 0)
    assert world.usart.log == []


@given(
    source=st.sampled_from(["HSI", "HSE", "PLL"]),
    hse=st.sampled_from([4_000_000, 8_000_000, 12_000_000, 16_000_000]),
    entry=st.sampled_from(["HSI/2", "HSE", "HSE/2"]),
    mul=st.integers(0, 15),
    ahb=st.integers(0, 15),
    apb1=st.integers(0, 7),
    apb2=st.integers(0, 7),
    adc=st.integers(0, 3),
    usb=st.booleans(),
)
def test_every_configuration_against_the_tables_of_the_manual(source, hse, entry, mul, ahb, apb1, apb2, adc, usb):
    world = build(hse_hz=hse)
    rcc, chip = world.rcc, world.chip
    cfgr = {"HSI/2": 0, "HSE": 1, "HSE/2": 3}[entry] << 16 | mul << 18
    cfgr |= ahb << 4 | apb1 << 8 | apb2 << 11 | adc << 14 | usb << 22
    poke(rcc, "CR", 0x0001_0083)
    chip.advance_s(2 * MS)
    poke(rcc, "CFGR", cfgr)
    poke(rcc, "CR", 0x0101_0083)
    chip.advance_s(200 * US)
    poke(rcc, "CFGR", cfgr | {"HSI": 0, "HSE": 1, "PLL": 2}[source])

    pll_in = {"HSI/2": Fraction(4_000_000), "HSE": Fraction(hse), "HSE/2": Fraction(hse, 2)}[entry]
    pll = pll_in * (16 if mul == 15 else mul + 2)
    sysclk = {"HSI": Fraction(8_000_000), "HSE": Fraction(hse), "PLL": pll}[source]
    ahb_div = {8: 2, 9: 4, 10: 8, 11: 16, 12: 64, 13: 128, 14: 256, 15: 512}.get(ahb, 1)
    apb_div = {4: 2, 5: 4, 6: 8, 7: 16}
    hclk = sysclk / ahb_div
    rates = world.tree.rates
    assert rates.sysclk == sysclk
    assert chip.time.hclk_hz == rates.hclk == hclk
    assert rates.pclk1 == hclk / apb_div.get(apb1, 1)
    assert rates.pclk2 == hclk / apb_div.get(apb2, 1)
    for bus, field in (("APB1", apb1), ("APB2", apb2)):
        divider = apb_div.get(field, 1)
        assert world.tree.pclk(bus) == divider
        timer_hz = hclk / divider * (1 if divider == 1 else 2)
        assert hclk / world.tree.timer(bus) == timer_hz
    assert rates.adc == rates.pclk2 / {0: 2, 1: 4, 2: 6, 3: 8}[adc]
    assert rates.usb == (pll if usb else pll / Fraction(3, 2))
    assert peek(rcc, "CFGR") >> 2 & 3 == {"HSI": 0, "HSE": 1, "PLL": 2}[source]
    assert ("RCC_CFGR.SW" in chip.noted("misuse")) is (sysclk > 72_000_000)
    assert ("RCC_CFGR.PPRE1" in chip.noted("misuse")) is (rates.pclk1 > 36_000_000)


# --- switching


def test_switching_to_a_clock_that_is_not_ready_waits_for_it(world):
    poke(world.rcc, "CR", 0x0001_0083)
    poke(world.rcc, "CFGR", 1)
    assert peek(world.rcc, "CFGR") == 0x1
    world.chip.advance_s(2 * MS)
    assert peek(world.rcc, "CFGR") == 0x5


def test_what_drives_sysclk_cannot_be_switched_off(world):
    to_72_mhz(world)
    poke(world.rcc, "CR", 0)
    assert peek(world.rcc, "CR") & (1 << 16 | 1 << 24) == 1 << 16 | 1 << 24
    world.chip.advance_s(1 * MS)
    assert world.chip.time.hclk_hz == 72_000_000
    assert not peek(world.rcc, "CR") & 3  # HSI does not drive anything


def test_hsi_feeding_the_pll_cannot_be_switched_off(world):
    poke(world.rcc, "CFGR", 0x001C_0000)
    poke(world.rcc, "CR", 0x0100_0083)
    world.chip.advance_s(200 * US)
    poke(world.rcc, "CFGR", 0x001C_0002)
    assert world.chip.time.hclk_hz == 36_000_000
    poke(world.rcc, "CR", 0x0100_0080)
    assert peek(world.rcc, "CR") & 1


def test_the_pll_keeps_its_settings_while_it_is_on(world):
    to_72_mhz(world)
    poke(world.rcc, "CFGR", 0x0000_0402)
    assert peek(world.rcc, "CFGR") == 0x001D_040A
    assert "RCC_CFGR.PLLMUL" in world.chip.noted("misuse")


def test_the_pll_locks_only_once_its_source_is_ready(world):
    poke(world.rcc, "CFGR", 0x001D_0000)
    poke(world.rcc, "CR", 0x0101_0083)
    world.chip.advance_s(2 * MS + 199 * US)
    assert not peek(world.rcc, "CR") & 1 << 25
    world.chip.advance_s(1 * US)
    assert peek(world.rcc, "CR") & 1 << 25


def test_sw_11_is_not_taken_over(world):
    poke(world.rcc, "CFGR", 3)
    assert peek(world.rcc, "CFGR") == 0
    assert world.chip.noted() == ["RCC_CFGR.SW"]


def test_bypass_needs_a_clock_on_the_board(world):
    poke(world.rcc, "CR", 0x0004_0083)
    poke(world.rcc, "CR", 0x0005_0083)
    world.chip.advance_s(Fraction(1))
    assert not peek(world.rcc, "CR") & 1 << 17
    poke(world.rcc, "CR", 0x0004_0083)
    poke(world.rcc, "CR", 0x0000_0083)
    poke(world.rcc, "CR", 0x0001_0083)
    world.chip.advance_s(2 * MS)
    assert peek(world.rcc, "CR") & 1 << 17


def test_bypass_with_a_clock():
    world = build(hse_is_clock=True)
    poke(world.rcc, "CR", 0x0004_0083)
    poke(world.rcc, "CR", 0x0005_0083)
    world.chip.advance_s(2 * MS)
    assert peek(world.rcc, "CR") == 0x0007_0083
    assert world.chip.notes.all == []


def test_bypass_changes_only_while_hse_is_off(world):
    poke(world.rcc, "CR", 0x0001_0083)
    poke(world.rcc, "CR", 0x0005_0083)
    assert peek(world.rcc, "CR") == 0x0001_0083


# --- interrupts


def test_ready_interrupts_only_where_enabled(world):
    rcc, chip = world.rcc, world.chip
    poke(rcc, "CIR", 0x0800)  # HSERDYIE
    poke(rcc, "CSR", 1)
    poke(rcc, "CR", 0x0001_0083)
    chip.advance_s(2 * MS)
    assert peek(rcc, "CIR") == 0x0808
    assert chip.irq(5).level
    poke(rcc, "CIR", 0x0008_0800)
    assert peek(rcc, "CIR") == 0x0800
    assert not chip.irq(5).level


@pytest.mark.parametrize(
    ("flag", "register", "value", "after"),
    [
        (0, "CSR", 1, 85 * US),
        (1, "BDCR", 1, Fraction(5, 2)),
        (3, "CR", 0x0001_0083, 2 * MS),
        (4, "CR", 0x0100_0083, 200 * US),
    ],
)
def test_each_ready_interrupt(world, flag, register, value, after):
    poke(world.rcc, "CIR", 0x1F00)
    poke(world.rcc, register, value)
    world.chip.advance_s(after - Fraction(1, 8_000_000))
    assert peek(world.rcc, "CIR") == 0x1F00
    world.chip.advance(1)
    assert peek(world.rcc, "CIR") == 0x1F00 | 1 << flag


# --- clock security


def test_clock_security_falls_back_to_hsi_and_raises_the_nmi(world):
    rcc, chip = world.rcc, world.chip
    to_72_mhz(world)
    poke(rcc, "CR", peek(rcc, "CR") | 1 << 19)
    rcc.fail_hse()
    assert chip.time.hclk_hz == 8_000_000
    assert peek(rcc, "CFGR") & 0xF == 0
    assert not peek(rcc, "CR") & (1 << 16 | 1 << 17 | 1 << 24 | 1 << 25)
    assert peek(rcc, "CIR") == 0x80
    assert world.nmi[-1] is True
    assert len(world.failures) == 1
    poke(rcc, "CIR", 1 << 23)
    assert peek(rcc, "CIR") == 0
    assert world.nmi[-1] is False


def test_a_failure_without_clock_security_is_noted(world):
    to_72_mhz(world)
    world.rcc.fail_hse()
    assert not peek(world.rcc, "CR") & 1 << 17
    assert world.chip.noted("unmodelled") == ["RCC_CR.CSSON"]


def test_a_repaired_crystal_starts_again(world):
    poke(world.rcc, "CR", 0x0001_0083)
    world.rcc.fail_hse()
    world.chip.advance_s(5 * MS)
    assert not peek(world.rcc, "CR") & 1 << 17
    world.rcc.repair_hse()
    world.chip.advance_s(2 * MS)
    assert peek(world.rcc, "CR") & 1 << 17


# --- gates and resets


def test_gates_open_and_shut_their_peripherals(world):
    assert not world.usart.clocked
    poke(world.rcc, "APB2ENR", 0x4000)
    assert world.usart.clocked
    assert not world.tim.clocked
    assert world.usart.log == [("before", 0, False, 1), ("after", 0, True, 1)]
    poke(world.rcc, "APB2ENR", 0)
    assert not world.usart.clocked


def test_resetting_a_peripheral(world):
    poke(world.rcc, "APB1RSTR", 1)
    assert world.tim.log == ["reset"]
    poke(world.rcc, "APB1RSTR", 0)
    assert world.tim.log == ["reset", "reset"]
    assert world.usart.log == []


def test_enabling_what_the_chip_does_not_have_is_noted(world):
    poke(world.rcc, "APB2ENR", 1 << 8)
    assert peek(world.rcc, "APB2ENR") == 0
    assert world.chip.noted("reserved") == ["RCC_APB2ENR"]


def test_a_reset_of_the_chip_brings_back_hsi_and_shuts_the_gates(world):
    to_72_mhz(world)
    poke(world.rcc, "APB2ENR", 0x4000)
    world.rcc.reset()
    world.rcc.reset_by("IWDG")
    assert world.chip.time.hclk_hz == 8_000_000
    assert not world.usart.clocked
    assert peek(world.rcc, "CR") == 0x83
    assert peek(world.rcc, "CFGR") == 0


@pytest.mark.parametrize(
    ("cause", "flags"),
    [("PIN", 0x04), ("POR", 0x0C), ("SFT", 0x14), ("IWDG", 0x24), ("WWDG", 0x44), ("LPWR", 0x84)],
)
def test_reset_flags_show_the_cause_until_they_are_removed(world, cause, flags):
    poke(world.rcc, "CSR", 1 << 24)
    assert peek(world.rcc, "CSR") >> 24 & 0xFC == 0
    world.rcc.reset()
    world.rcc.reset_by(cause)
    assert peek(world.rcc, "CSR") >> 24 == flags


def test_reset_flags_add_up(world):
    world.rcc.reset()
    world.rcc.reset_by("IWDG")
    assert peek(world.rcc, "CSR") >> 24 == 0x2C


# --- backup domain


def test_bdcr_obeys_dbp(world):
    world.dbp = False
    poke(world.rcc, "BDCR", 0x8101)
    assert peek(world.rcc, "BDCR") == 0
    world.dbp = True
    poke(world.rcc, "BDCR", 0x8101)
    assert peek(world.rcc, "BDCR") == 0x8101


def test_the_rtc_clock_is_chosen_once(world):
    poke(world.rcc, "BDCR", 0x100)
    poke(world.rcc, "BDCR", 0x200)
    assert peek(world.rcc, "BDCR") == 0x100
    poke(world.rcc, "BDCR", 0x1_0000)
    assert world.tim.log == ["reset_backup"]
    poke(world.rcc, "BDCR", 0)
    poke(world.rcc, "BDCR", 0x200)
    assert peek(world.rcc, "BDCR") == 0x200


def test_the_backup_domain_survives_a_reset_but_not_power_on(world):
    poke(world.rcc, "BDCR", 0x8101)
    world.chip.advance_s(Fraction(5, 2))
    world.rcc.reset()
    assert peek(world.rcc, "BDCR") == 0x8103
    assert world.rcc.rtc_hz() == 32_768
    world.rcc.reset_by("POR")
    assert peek(world.rcc, "BDCR") == 0
    assert world.rcc.rtc_hz() is None


def test_lse_needs_a_crystal():
    world = build(lse=False)
    poke(world.rcc, "BDCR", 1)
    assert world.rcc.starting == {}
    world.chip.advance_s(Fraction(10))
    assert peek(world.rcc, "BDCR") == 1


def test_what_starts_and_when_it_is_ready(world):
    """Asked at 1 s, of what was switched on at 0 s; a change of the clock meanwhile changes nothing."""
    poke(world.rcc, "BDCR", 1)
    ready_s = world.rcc.starting["LSE"]
    poke(world.rcc, "CFGR", 0x80)  # HPRE
    world.chip.advance_s(Fraction(1))
    assert world.rcc.starting == {"LSE": ready_s}
    world.chip.advance_s(ready_s - Fraction(1))
    assert world.rcc.starting == {}
    assert peek(world.rcc, "BDCR") & 2
    poke(world.rcc, "BDCR", 0)
    assert world.rcc.starting == {}


@pytest.mark.parametrize(("choice", "rate"), [(2, 40_000), (3, 62_500)])
def test_rtc_sources(world, choice, rate):
    poke(world.rcc, "CSR", 1)
    poke(world.rcc, "CR", 0x0001_0083)
    world.chip.advance_s(2 * MS)
    poke(world.rcc, "BDCR", 0x8000 | choice << 8)
    assert world.rcc.rtc_hz() == rate


def test_the_watchdog_keeps_the_lsi_on(world):
    world.rcc.force_lsi()
    world.chip.advance_s(85 * US)
    poke(world.rcc, "CSR", 0)
    world.chip.advance_s(1 * MS)
    assert peek(world.rcc, "CSR") & 2
    world.rcc.reset()
    assert not peek(world.rcc, "CSR") & 3


# --- misuse, Stop mode


def test_overclocking_is_noted(world):
    poke(world.rcc, "CR", 0x0001_0083)
    world.chip.advance_s(2 * MS)
    poke(world.rcc, "CFGR", 0x003D_0000)
    poke(world.rcc, "CR", 0x0101_0083)
    world.chip.advance_s(200 * US)
    poke(world.rcc, "CFGR", 0x003D_0002)
    poke(world.rcc, "APB2ENR", 0x200)
    poke(world.rcc, "APB1ENR", 1 << 23)
    assert set(world.chip.noted("misuse")) == {
        "RCC_CFGR.PLLMUL",
        "RCC_CFGR.SW",
        "RCC_CFGR.PPRE1",
        "RCC_CFGR.PPRE2",
        "RCC_CFGR.ADCPRE",
        "RCC_CFGR.USBPRE",
    }


def test_stop_mode_halts_every_clock_and_leaves_on_hsi(world):
    to_72_mhz(world)
    world.rcc.stop()
    assert world.tree.pclk("AHB") == world.tree.pclk("APB1") == world.tree.timer("APB2") == 0
    world.rcc.resume()
    assert world.tree.pclk("AHB") == 1
    assert world.chip.time.hclk_hz == 8_000_000
    assert peek(world.rcc, "CFGR") & 0xF == 0
    assert peek(world.rcc, "CR") & 0x0303_0003 == 3


@pytest.mark.parametrize(("choice", "hz"), [(4, 72_000_000), (5, 8_000_000), (6, 8_000_000), (7, 36_000_000)])
def test_the_clock_at_a_pin(world, choice, hz):
    """RM0008 section 7.3.2."""
    signal = world.chip.output("MCO")
    assert (signal.level, signal.wave) == (None, None)
    to_72_mhz(world)
    poke(world.rcc, "CFGR", peek(world.rcc, "CFGR") | choice << 24)
    assert signal.level is False
    assert signal.wave.hz == hz
    assert world.chip.noted("misuse") == (["RCC_CFGR.MCO"] if hz > 50_000_000 else [])
    poke(world.rcc, "CFGR", peek(world.rcc, "CFGR") & ~(7 << 24))
    assert (signal.level, signal.wave) == (None, None)


def test_the_clock_at_a_pin_goes_with_its_oscillator(world):
    poke(world.rcc, "CFGR", 6 << 24)
    signal = world.chip.output("MCO")
    assert signal.wave is None
    poke(world.rcc, "CR", peek(world.rcc, "CR") | 1 << 16)
    world.chip.advance_s(2 * MS)
    assert signal.wave.hz == 8_000_000
    world.rcc.fail_hse()
    assert (signal.level, signal.wave) == (False, None)
