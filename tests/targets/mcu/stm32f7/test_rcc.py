"""RCC against RM0410 section 5: rates of every configuration, PLLs, kernel clocks, gates, limits by voltage scale."""

from __future__ import annotations

import dataclasses
from fractions import Fraction
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.registers import Peripheral, Register
from targets.mcu.stm32f7.clocks import ClockTree
from targets.mcu.stm32f7.rcc import Rcc
from targets.mcu.testing import FakeChip, peek, poke

US = Fraction(1, 1_000_000)
HSEON, HSEBYP, PLLON, PLLI2SON, PLLSAION = 1 << 16, 1 << 18, 1 << 24, 1 << 26, 1 << 28
MHZ = 1_000_000


class Probe(Peripheral):
    """Records what RCC tells it."""

    REGISTERS = (Register("R", 0),)

    def __init__(self, name, base, services):
        super().__init__(name, base, services)
        self.log = []

    def before_clock_change(self):
        self.log.append("before")

    def after_clock_change(self):
        self.log.append(("after", self.services.clocks.kernel("USART3")))

    def reset(self):
        super().reset()
        self.log.append("reset")


def build(*, hse_hz=8 * MHZ, **options):
    chip = FakeChip(hclk_hz=16 * MHZ)
    tree = ClockTree()
    services = dataclasses.replace(chip.services, clocks=tree)
    world = SimpleNamespace(chip=chip, tree=tree, dbp=True, supply=(1, True), nmi=[], pll=[])
    rcc = Rcc(
        0x4002_3800,
        services,
        tree,
        hse_hz=hse_hz,
        hse_start_s=10 * US,
        backup_writable=lambda: world.dbp,
        supply=lambda: world.supply,
        **{"hse_is_clock": True, **options},
    )
    rcc.on_nmi, rcc.on_pll = world.nmi.append, world.pll.append
    world.rcc, world.usart = rcc, Probe("USART3", 0x4000_4800, services)
    rcc.connect({"USART3": ("APB1", 18)}, {"USART3": world.usart, "RCC": rcc})
    world.usart.log.clear()
    return world


@pytest.fixture
def world():
    return build()


def start(world, pllcfgr, cfgr=0):
    """Switch to the PLL on the HSE."""
    rcc = world.rcc
    poke(rcc, "CR", peek(rcc, "CR") | HSEBYP)
    poke(rcc, "CR", peek(rcc, "CR") | HSEON)
    world.chip.advance_s(11 * US)
    poke(rcc, "PLLCFGR", pllcfgr | 1 << 22)
    poke(rcc, "CR", peek(rcc, "CR") | PLLON)
    world.chip.advance_s(301 * US)
    poke(rcc, "CFGR", cfgr | 2)


def settings(m, n, p, q=9):
    return m | n << 6 | (p // 2 - 1) << 16 | q << 24


def test_reset_values(world):
    values = {register.name: peek(world.rcc, register.name) for register in world.rcc.REGISTERS}
    expected = dict.fromkeys(values, 0) | {
        "CR": 0x83,
        "PLLCFGR": 0x2400_3010,
        "AHB1ENR": 0x0010_0000,
        "APB1ENR": 0x0000_0400,
        "CSR": 0x0E00_0000,
        "PLLI2SCFGR": 0x2400_3000,
        "PLLSAICFGR": 0x2400_3000,
    }
    lowpower = {name: value for name, value in values.items() if name.endswith("LPENR")}
    assert values == expected | lowpower
    assert lowpower["AHB1LPENR"] == 0x7EF7_B7FF  # RM0410 section 5.3.15: AXILPEN is bit 13


def test_216_mhz_the_usual_way(world):
    start(world, settings(8, 432, 2), 0b101 << 10 | 0b100 << 13)
    assert world.chip.time.hclk_hz == 216 * MHZ
    assert (world.tree.pclk("APB1"), world.tree.pclk("APB2")) == (4, 2)
    assert (world.tree.timer("APB1"), world.tree.timer("APB2")) == (2, 1)
    assert world.tree.kernel("RNG") == Fraction(216, 48)
    assert world.chip.noted("misuse") == []
    assert peek(world.rcc, "CFGR") & 0xF == 0b1010
    assert world.pll == [True]


@given(
    m=st.integers(2, 63),
    n=st.integers(50, 432),
    p=st.sampled_from([2, 4, 6, 8]),
    ahb=st.integers(0, 15),
    apb1=st.integers(0, 7),
    apb2=st.integers(0, 7),
    timpre=st.booleans(),
)
def test_every_rate_is_what_the_figure_says(m, n, p, ahb, apb1, apb2, timpre):
    world = build()
    poke(world.rcc, "DCKCFGR1", timpre << 24)
    start(world, settings(m, n, p), ahb << 4 | apb1 << 10 | apb2 << 13)
    sysclk = Fraction(8 * MHZ * n, m * p)
    hclk = sysclk / [*[1] * 8, 2, 4, 8, 16, 64, 128, 256, 512][ahb]
    assert world.chip.time.hclk_hz == hclk
    for bus, value in (("APB1", apb1), ("APB2", apb2)):
        divider = [1, 1, 1, 1, 2, 4, 8, 16][value]
        pclk = hclk / divider
        if timpre:
            timer = hclk if divider <= 4 else 4 * pclk
        else:
            timer = pclk if divider == 1 else 2 * pclk
        assert hclk / world.tree.pclk(bus) == pclk
        assert hclk / world.tree.timer(bus) == timer


@pytest.mark.parametrize(
    ("choice", "rate"),
    [(0b00, 54 * MHZ), (0b01, 216 * MHZ), (0b10, 16 * MHZ), (0b11, 32_768)],
)
def test_kernel_clocks_of_usarts(world, choice, rate):
    start(world, settings(8, 432, 2), 0b101 << 10 | 0b100 << 13)
    poke(world.rcc, "BDCR", 1)
    world.chip.advance_s(Fraction(2))
    poke(world.rcc, "DCKCFGR2", choice << 4)
    assert world.tree.kernel_hz("USART3") == rate
    assert world.tree.kernel("USART3") == Fraction(216 * MHZ, rate)
    assert world.tree.kernel_hz("USART1") == 108 * MHZ


def test_a_kernel_clock_comes_and_goes_with_its_oscillator(world):
    poke(world.rcc, "DCKCFGR2", 0b11 << 4)
    assert world.tree.kernel_hz("USART3") == 0
    world.usart.log.clear()
    poke(world.rcc, "BDCR", 1)
    world.chip.advance_s(Fraction(3))
    assert world.usart.log == ["before", ("after", Fraction(16 * MHZ, 32_768))]
    poke(world.rcc, "BDCR", 0)
    world.chip.advance(16 * MHZ // 32_768 * 7)
    assert world.tree.kernel_hz("USART3") == 0


def test_kernel_clocks_of_i2c_and_the_reserved_value(world):
    for choice, rate in ((0b00, 16 * MHZ), (0b01, 16 * MHZ), (0b10, 16 * MHZ), (0b11, 0)):
        poke(world.rcc, "DCKCFGR2", choice << 18)
        assert world.tree.kernel_hz("I2C2") == rate
    assert world.chip.noted("reserved") == ["RCC_DCKCFGR2.I2C2SEL"]


def test_the_48_mhz_clock_of_pllsai(world):
    start(world, settings(8, 432, 2))
    poke(world.rcc, "PLLSAICFGR", 192 << 6 | 1 << 16)
    poke(world.rcc, "CR", peek(world.rcc, "CR") | PLLSAION)
    poke(world.rcc, "DCKCFGR2", 1 << 27)
    assert world.tree.kernel_hz("RNG") == 0
    world.chip.advance_s(301 * US)
    assert peek(world.rcc, "CR") & 1 << 29
    assert world.tree.kernel_hz("RNG") == world.tree.kernel_hz("SDMMC1") == 48 * MHZ


@pytest.mark.parametrize("ready", [25, 27, 29])
def test_each_pll_gets_ready_and_says_so(world, ready):
    poke(world.rcc, "CIR", 0x7F00)
    poke(world.rcc, "CR", peek(world.rcc, "CR") | 1 << ready - 1)
    world.chip.advance_s(299 * US)
    assert not peek(world.rcc, "CR") >> ready & 1
    world.chip.advance_s(2 * US)
    assert peek(world.rcc, "CR") >> ready & 1
    assert world.chip.irq(5).level
    assert peek(world.rcc, "CIR") & 0x7F == 1 << (ready - 25) // 2 + 4
    poke(world.rcc, "CIR", 0x7F << 16)
    assert not world.chip.irq(5).level


def test_settings_hold_while_a_pll_is_on(world):
    poke(world.rcc, "CR", peek(world.rcc, "CR") | PLLI2SON)
    poke(world.rcc, "PLLI2SCFGR", 100 << 6)
    poke(world.rcc, "PLLCFGR", 8)
    assert (peek(world.rcc, "PLLI2SCFGR"), peek(world.rcc, "PLLCFGR")) == (0x2400_3000, 0x2400_3010)
    assert world.chip.noted("misuse") == ["RCC_PLLI2SCFGR", "RCC_PLLCFGR"]


@pytest.mark.parametrize(
    ("pllcfgr", "said"),
    [
        (settings(3, 216, 2), "PLLCFGR.PLLM"),
        (settings(10, 216, 2), "PLLCFGR.PLLM"),
        (settings(4, 49, 2), "PLLCFGR.PLLN"),
        (settings(8, 433, 2), "PLLCFGR.PLLN"),
        (settings(8, 99, 2), "PLLCFGR.PLLN"),
    ],
)
def test_settings_out_of_range(world, pllcfgr, said):
    start(world, pllcfgr)
    assert f"RCC_{said}" in world.chip.noted("misuse")


@pytest.mark.parametrize(
    ("supply", "mhz", "good"),
    [
        ((1, True), 216, True),
        ((1, False), 181, False),
        ((1, False), 180, True),
        ((2, True), 180, True),
        ((2, False), 169, False),
        ((3, False), 144, True),
        ((3, False), 145, False),
    ],
)
def test_the_highest_rate_at_a_voltage_scale(world, supply, mhz, good):
    world.supply = supply
    start(world, settings(8, 2 * mhz, 2), 0b101 << 10 | 0b100 << 13)
    noted = [note.text for note in world.chip.notes.all if note.where == "RCC_CFGR.SW"]
    assert (not noted) is good


def test_buses_above_their_limits(world):
    start(world, settings(8, 432, 2), 0b100 << 10)
    assert world.chip.noted("misuse") == ["RCC_CFGR.PPRE1", "RCC_CFGR.PPRE2"]


def test_csr_says_why(world):
    for cause, flags in (("SFT", 0x14), ("IWDG", 0x24), ("WWDG", 0x44), ("LPWR", 0x84), ("PIN", 0x04), ("POR", 0x0E)):
        poke(world.rcc, "CSR", 1 << 24)
        world.rcc.reset_by(cause)
        assert peek(world.rcc, "CSR") >> 24 & 0xFE == flags


def test_gates_and_resets(world):
    assert not world.usart.clocked
    poke(world.rcc, "APB1ENR", 1 << 18)
    assert world.usart.clocked
    world.usart.log.clear()
    poke(world.rcc, "APB1RSTR", 1 << 18)
    assert world.usart.log == ["reset"]
    poke(world.rcc, "APB2ENR", 1 << 27)
    assert world.chip.noted("reserved") == ["RCC_APB2ENR"], "DSI is in the F769 only"


def test_what_drives_sysclk_cannot_be_switched_off(world):
    start(world, settings(8, 432, 2), 0b101 << 10 | 0b100 << 13)
    poke(world.rcc, "CR", 0)
    assert peek(world.rcc, "CR") & (HSEON | PLLON) == HSEON | PLLON
    assert world.tree.rates.hclk == 216 * MHZ


def test_the_failure_of_the_hse_takes_the_plls_along(world):
    start(world, settings(8, 432, 2), 0b101 << 10 | 0b100 << 13)
    poke(world.rcc, "CR", peek(world.rcc, "CR") | 1 << 19 | PLLSAION)
    world.chip.advance_s(301 * US)
    world.rcc.fail_hse()
    assert peek(world.rcc, "CR") & 0x3F03_0003 == 0x1000_0003, "PLLSAION stays, nothing is ready but HSI"
    assert (world.chip.time.hclk_hz, world.nmi[-1]) == (16 * MHZ, True)


def test_stop_mode_stops_all_of_them(world):
    start(world, settings(8, 432, 2), 0b101 << 10 | 0b100 << 13)
    poke(world.rcc, "CR", peek(world.rcc, "CR") | PLLSAION | PLLI2SON)
    world.rcc.stop()
    assert peek(world.rcc, "CR") & 0x3F03_0003 == 3
    assert (world.tree.pclk("APB1"), world.tree.timer("APB2"), world.tree.kernel_hz("USART3")) == (0, 0, 0)
    assert world.pll[-1] is False
    world.rcc.resume()
    assert (world.tree.pclk("APB1"), world.tree.kernel_hz("USART3")) == (4, 4 * MHZ)


def test_a_crystal_is_no_clock_and_a_clock_no_crystal():
    crystal = build(hse_is_clock=False)
    poke(crystal.rcc, "CR", 0x83 | HSEBYP)
    poke(crystal.rcc, "CR", 0x83 | HSEBYP | HSEON)
    crystal.chip.advance_s(Fraction(1))
    assert not peek(crystal.rcc, "CR") & 1 << 17
    clock = build()
    poke(clock.rcc, "CR", 0x83 | HSEON)
    clock.chip.advance_s(11 * US)
    assert peek(clock.rcc, "CR") & 1 << 17
    assert clock.chip.noted("assumed") == ["RCC_CR.HSEBYP"]


@pytest.mark.parametrize(
    ("divider", "rate"), [(0, None), (1, None), (2, 4 * MHZ), (8, MHZ), (31, Fraction(8 * MHZ, 31))]
)
def test_the_rtc_on_the_hse(world, divider, rate):
    start(world, settings(8, 432, 2))
    poke(world.rcc, "CFGR", divider << 16 | 2)
    poke(world.rcc, "BDCR", 0x300 | 1 << 15)
    assert world.rcc.rtc_hz() == rate


@pytest.mark.parametrize(
    ("output", "bits", "hz"),
    [
        ("MCO1", 0 << 21, 16 * MHZ),
        ("MCO1", 1 << 21, 0),  # LSE is off
        ("MCO1", 2 << 21, 8 * MHZ),
        ("MCO1", 3 << 21 | 7 << 24, 216 * MHZ // 5),
        ("MCO1", 3 << 21 | 4 << 24, 108 * MHZ),
        ("MCO2", 0 << 30 | 3 << 27, 216 * MHZ),
        ("MCO2", 0 << 30 | 6 << 27, 54 * MHZ),
        ("MCO2", 1 << 30, 96 * MHZ),
        ("MCO2", 2 << 30 | 5 << 27, Fraction(8 * MHZ, 3)),
        ("MCO2", 3 << 30, 216 * MHZ),
    ],
)
def test_clocks_at_pins(world, output, bits, hz):
    """RM0410 section 5.3.3."""
    world.supply = (1, True)
    start(world, settings(8, 432, 2))
    poke(world.rcc, "PLLI2SCFGR", 192 << 6 | 2 << 28)
    poke(world.rcc, "CR", peek(world.rcc, "CR") | PLLI2SON)
    world.chip.advance_s(301 * US)
    poke(world.rcc, "CFGR", bits | 2 | 5 << 10 | 4 << 13)
    signal = world.chip.output(output)
    assert (signal.wave.hz if signal.wave else 0) == hz
    assert signal.level is False
    assert not world.chip.noted("unmodelled")


def test_a_clock_at_a_pin_goes_with_its_oscillator(world):
    poke(world.rcc, "CR", peek(world.rcc, "CR") | HSEBYP)
    poke(world.rcc, "CFGR", 2 << 21)
    assert world.chip.output("MCO1").wave is None
    poke(world.rcc, "CR", peek(world.rcc, "CR") | HSEON)
    world.chip.advance_s(11 * US)
    assert world.chip.output("MCO1").wave.hz == 8 * MHZ
    world.rcc.stop()
    assert world.chip.output("MCO1").wave is None
    assert world.chip.output("MCO2").wave is None, "SYSCLK stands still"
    world.rcc.resume()
    assert world.chip.output("MCO2").wave.hz == 16 * MHZ


def test_what_the_settings_of_the_other_plls_keep(world):
    """RM0410 sections 5.3.23 and 5.3.24: R in bits 30:28, Q in 27:24, P in 17:16, N in 14:6."""
    for name in ("PLLI2SCFGR", "PLLSAICFGR"):
        poke(world.rcc, name, 0xFFFF_FFFF)
        assert peek(world.rcc, name) == 0x7F03_7FC0, name
