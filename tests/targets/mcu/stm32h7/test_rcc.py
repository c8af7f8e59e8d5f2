"""RCC against RM0433 section 8: rates of every configuration, PLLs, kernel clocks, gates, limits by voltage scale."""

from __future__ import annotations

import dataclasses
from fractions import Fraction
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.registers import Peripheral, Register
from targets.mcu.stm32h7.clocks import KERNEL_CHOICES, ClockTree
from targets.mcu.stm32h7.rcc import Rcc
from targets.mcu.stm32h7.rcc_registers import CAUSES, RESET_FLAGS
from targets.mcu.testing import FakeChip, peek, poke
from tests.each import each

US, MHZ = Fraction(1, 1_000_000), 1_000_000
HSION, HSIRDY, HSIDIVF, CSION, CSIRDY, HSI48ON, HSI48RDY = 1, 1 << 2, 1 << 5, 1 << 7, 1 << 8, 1 << 12, 1 << 13
HSEON, HSERDY, HSEBYP, HSECSSON = 1 << 16, 1 << 17, 1 << 18, 1 << 19
PLLON, PLLRDY = (1 << 24, 1 << 26, 1 << 28), (1 << 25, 1 << 27, 1 << 29)
HSI, CSI, HSE, PLL1 = range(4)


class Probe(Peripheral):
    """Records what RCC tells it."""

    REGISTERS = (Register("R", 0),)

    def __init__(self, name, base, services):
        super().__init__(name, base, services)
        self.log = []

    def before_clock_change(self):
        self.log.append("before")

    def after_clock_change(self):
        self.log.append("after")

    def reset(self):
        super().reset()
        self.log.append("reset")


def build(*, hse_hz=8 * MHZ, **options):
    chip = FakeChip(hclk_hz=64 * MHZ)
    tree = ClockTree()
    services = dataclasses.replace(chip.services, clocks=tree)
    world = SimpleNamespace(chip=chip, tree=tree, dbp=True, scale=0, nmi=[], failures=[])
    rcc = Rcc(
        0x5802_4400,
        services,
        tree,
        hse_hz=hse_hz,
        hse_start_s=10 * US,
        backup_writable=lambda: world.dbp,
        scale=lambda: world.scale,
        **{"hse_is_clock": True, **options},
    )
    rcc.on_nmi, rcc.on_clock_failure = world.nmi.append, lambda: world.failures.append(True)
    world.rcc, world.usart = rcc, Probe("USART3", 0x4000_4800, services)
    rcc.connect({"USART3": ("APB1L", 18)}, {"USART3": world.usart, "RCC": rcc})
    world.usart.log.clear()
    return world


@pytest.fixture
def world():
    return build()


def switch_on(world, *bits, wait=200 * US):
    for bit in bits:
        poke(world.rcc, "CR", peek(world.rcc, "CR") | bit)
    world.chip.advance_s(wait)


def run_pll1(world, source=CSI, divm=1, divn=240, divp=2, rge=2):
    """Switch SYSCLK to PLL1."""
    switch_on(world, *{HSI: (), CSI: (CSION,), HSE: (HSEBYP, HSEON)}[source])
    poke(world.rcc, "PLLCKSELR", source | divm << 4 | 0x0202_0000)
    poke(world.rcc, "PLLCFGR", 0x01FF_0000 | rge << 2)
    poke(world.rcc, "PLL1DIVR", divn - 1 | (divp - 1) << 9 | 1 << 16 | 1 << 24)
    switch_on(world, PLLON[0])
    poke(world.rcc, "CFGR", PLL1)


def test_reset_values(world):
    rcc = world.rcc
    assert peek(rcc, "CR") == HSION | HSIRDY | HSIDIVF | 3 << 14
    wanted = {"PLLCKSELR": 0x0202_0200, "PLLCFGR": 0x01FF_0000, "PLL1DIVR": 0x0101_0280, "PLL3DIVR": 0x0101_0280}
    wanted |= {"CFGR": 0, "D1CFGR": 0, "D2CFGR": 0, "D3CFGR": 0, "APB4ENR": 1 << 16, "HSICFGR": 0x4000_0000}
    assert {name: peek(rcc, name) for name in wanted} == wanted
    assert world.tree.rates.hclk == 64 * MHZ


def test_the_fastest_clock_by_csi_is_exact(world):
    poke(world.rcc, "D1CFGR", 8 | 4 << 4)
    poke(world.rcc, "D2CFGR", 4 << 4 | 4 << 8)
    poke(world.rcc, "D3CFGR", 4 << 4)
    run_pll1(world)
    rates, tree = world.tree.rates, world.tree
    assert (rates.sysclk, rates.hclk, rates.bus_hz, rates.pclk1) == (480 * MHZ, 480 * MHZ, 240 * MHZ, 120 * MHZ)
    assert [tree.pclk(bus) for bus in ("AHB", "APB1", "APB2", "APB3", "APB4")] == [2, 4, 4, 4, 4]
    assert tree.timer("APB1") == tree.timer("APB2") == 2, "timers at 240 MHz"
    assert tree.kernel("USART3") == 4
    assert world.chip.services.time.hclk_hz == 480 * MHZ
    assert peek(world.rcc, "CFGR") == PLL1 | PLL1 << 3
    assert not world.chip.noted()


AHB = {**dict.fromkeys(range(8), 1), 8: 2, 9: 4, 10: 8, 11: 16, 12: 64, 13: 128, 14: 256, 15: 512}
APB = {**dict.fromkeys(range(4), 1), 4: 2, 5: 4, 6: 8, 7: 16}
PRESCALERS = st.tuples(*(st.integers(0, 15) for _ in range(2)), *(st.integers(0, 7) for _ in range(4)), st.booleans())


@given(PRESCALERS)
def test_every_prescaler_divides_as_the_manual_says(settings):
    cpu, hpre, p1, p2, p3, p4, timpre = settings
    world = build()
    world.rcc.write(0x18, cpu << 8 | p3 << 4 | hpre)
    world.rcc.write(0x1C, p1 << 4 | p2 << 8)
    world.rcc.write(0x20, p4 << 4)
    world.rcc.write(0x10, timpre << 15)
    tree = world.tree
    hclk = Fraction(64 * MHZ, AHB[cpu])
    assert tree.rates.hclk == hclk
    for bus, field in (("APB1", p1), ("APB2", p2), ("APB3", p3), ("APB4", p4)):
        assert hclk / tree.pclk(bus) == hclk / AHB[hpre] / APB[field]
    factor = 4 if timpre else 2  # RM0433 8.5.8: as fast as HCLK, but at most that many times the rate of the bus
    for bus, field in (("APB1", p1), ("APB2", p2)):
        pclk = hclk / AHB[hpre] / APB[field]
        assert hclk / tree.timer(bus) == min(hclk / AHB[hpre], factor * pclk)


@given(
    divm=st.integers(1, 63),
    divn=st.integers(0, 511),
    post=st.tuples(*(st.integers(0, 127) for _ in range(3))),
    fraction=st.integers(0, 8191),
)
def test_a_pll_multiplies_by_whole_numbers_and_by_fractions(divm, divn, post, fraction):
    world = build()
    rcc = world.rcc
    poke(rcc, "PLLCKSELR", HSI | divm << 12)
    poke(rcc, "PLL2DIVR", divn | post[0] << 9 | post[1] << 16 | post[2] << 24)
    poke(rcc, "PLL2FRACR", fraction << 3)
    poke(rcc, "PLLCFGR", peek(rcc, "PLLCFGR") & ~(1 << 4))
    poke(rcc, "PLLCFGR", peek(rcc, "PLLCFGR") | 1 << 4)
    switch_on(world, PLLON[1])
    vco = Fraction(64 * MHZ, divm) * (divn + 1 + Fraction(fraction, 8192))
    poke(rcc, "D3CCIPR", 0)
    assert world.tree.kernel_hz("ADC12") == vco / (post[0] + 1)
    poke(rcc, "D2CCIP2R", 1)
    assert world.tree.kernel_hz("USART3") == vco / (post[1] + 1)


def test_a_fraction_is_taken_over_on_the_rising_edge_of_fracen(world):
    run_pll1(world)
    poke(world.rcc, "PLL1FRACR", 4096 << 3)
    assert world.tree.rates.sysclk == 480 * MHZ
    poke(world.rcc, "PLLCFGR", peek(world.rcc, "PLLCFGR") | 1)
    assert world.tree.rates.sysclk == 481 * MHZ, "half a step of 2 MHz, on the fly"
    poke(world.rcc, "PLL1FRACR", 0)
    assert world.tree.rates.sysclk == 481 * MHZ


def test_settings_of_a_pll_hold_while_it_is_on_and_those_of_others_do_not(world):
    run_pll1(world)
    before = {name: peek(world.rcc, name) for name in ("PLLCKSELR", "PLLCFGR", "PLL1DIVR")}
    poke(world.rcc, "PLLCKSELR", 0)
    poke(world.rcc, "PLLCFGR", 0)
    poke(world.rcc, "PLL1DIVR", 0)
    assert peek(world.rcc, "PLLCKSELR") == before["PLLCKSELR"] & 0x3F3, "DIVM2 and DIVM3 are free"
    assert peek(world.rcc, "PLLCFGR") == before["PLLCFGR"] & 0x0007_000E
    assert peek(world.rcc, "PLL1DIVR") == before["PLL1DIVR"]
    poke(world.rcc, "PLL3DIVR", 5)
    assert peek(world.rcc, "PLL3DIVR") == 5


def test_an_output_that_is_not_enabled_gives_nothing(world):
    poke(world.rcc, "PLLCFGR", 0x01FF_0000 & ~(1 << 20))
    switch_on(world, PLLON[1])
    poke(world.rcc, "D2CCIP2R", 1)
    assert world.tree.kernel_hz("USART3") == 0


def test_oscillators_take_their_time_and_say_when_they_are_ready(world):
    rcc, irq = world.rcc, world.chip.irq(5)
    poke(rcc, "CIER", 1 << 4 | 1 << 5)
    switch_on(world, CSION, HSI48ON, wait=1 * US)
    assert not peek(rcc, "CR") & (CSIRDY | HSI48RDY)
    world.chip.advance_s(Fraction(3, 2) * US)
    assert peek(rcc, "CR") & (CSIRDY | HSI48RDY) == CSIRDY
    assert (irq.level, peek(rcc, "CIFR")) == (True, 1 << 4)
    world.chip.advance_s(2 * US)
    assert peek(rcc, "CR") & HSI48RDY
    poke(rcc, "CICR", 0x7FF)
    assert (irq.level, peek(rcc, "CIFR"), peek(rcc, "CICR")) == (False, 0, 0)


def test_a_pll_is_ready_after_its_lock_time_and_sysclk_switches_then(world):
    rcc = world.rcc
    poke(rcc, "PLLCKSELR", HSI | 8 << 4)
    poke(rcc, "PLLCFGR", 0x01FF_000C)
    poke(rcc, "PLL1DIVR", 49 | 1 << 9)
    poke(rcc, "CR", HSION | PLLON[0])
    poke(rcc, "CFGR", PLL1)
    world.chip.advance_s(149 * US)
    assert (peek(rcc, "CR") & PLLRDY[0], peek(rcc, "CFGR") >> 3) == (0, HSI)
    world.chip.advance_s(2 * US)
    assert (peek(rcc, "CR") & PLLRDY[0], peek(rcc, "CFGR") >> 3) == (PLLRDY[0], PLL1)
    assert world.tree.rates.hclk == 200 * MHZ


def test_what_drives_sysclk_cannot_be_switched_off(world):
    run_pll1(world)
    poke(world.rcc, "CR", 0)
    assert peek(world.rcc, "CR") & (PLLON[0] | CSION | HSION) == PLLON[0] | CSION, "the HSI is not needed"
    assert "RCC_CR" in world.chip.noted("misuse")


def test_hsidiv_divides_and_holds_while_a_pll_runs_on_it(world):
    poke(world.rcc, "CR", HSION | 2 << 3)
    assert world.tree.rates.hclk == 16 * MHZ
    poke(world.rcc, "PLLCKSELR", HSI | 4 << 4 | 4 << 12 | 4 << 20)
    switch_on(world, PLLON[1])
    poke(world.rcc, "CR", peek(world.rcc, "CR") & ~(3 << 3))
    assert world.tree.rates.hclk == 16 * MHZ
    assert "RCC_CR.HSIDIV" in world.chip.noted("misuse")


def test_a_reserved_source_is_not_taken_over(world):
    poke(world.rcc, "CFGR", 5)
    assert peek(world.rcc, "CFGR") == 0
    assert world.chip.noted("misuse") == ["RCC_CFGR.SW"]


@each(
    ("name", "register", "value", "rate"),
    [
        ("USART3", "D2CCIP2R", 3, 64 * MHZ),
        ("USART3", "D2CCIP2R", 4, 4 * MHZ),
        ("USART3", "D2CCIP2R", 5, 32_768),
        ("USART3", "D2CCIP2R", 6, 0),
        ("USART1", "D2CCIP2R", 4 << 3, 4 * MHZ),
        ("I2C1", "D2CCIP2R", 2 << 12, 64 * MHZ),
        ("I2C4", "D3CCIPR", 3 << 8, 4 * MHZ),
        ("RNG", "D2CCIP2R", 0, 48 * MHZ),
        ("CEC", "D2CCIP2R", 2 << 22, Fraction(4 * MHZ, 122)),
        ("ADC12", "D3CCIPR", 2 << 16, 64 * MHZ),  # per_ck is the HSI after a reset
        ("FDCAN1", "D2CCIP1R", 0, 8 * MHZ),
        ("LPTIM1", "D2CCIP2R", 4 << 28, 0),  # LSI, which is off
    ],
)
def test_kernel_clocks(name, register, value, rate):
    world = build(lse_start_s=10 * US)
    switch_on(world, CSION, HSI48ON, HSEBYP, HSEON)
    poke(world.rcc, "BDCR", 1)
    world.chip.advance_s(20 * US)
    poke(world.rcc, register, value)
    assert world.tree.kernel_hz(name) == rate
    assert (f"RCC_{register}.{name}SEL" in world.chip.noted("reserved")) is (value == 6)


def test_every_kernel_choice_has_a_clock_for_each_value():
    assert all(len(choice.clocks) == choice.mask + 1 for choice in KERNEL_CHOICES.values())
    assert len(KERNEL_CHOICES) == 44


def test_per_ck_follows_its_own_choice(world):
    switch_on(world, CSION)
    poke(world.rcc, "D3CCIPR", 2 << 16)
    poke(world.rcc, "D1CCIPR", 1 << 28)
    assert world.tree.kernel_hz("ADC12") == 4 * MHZ


@pytest.mark.parametrize("place", ["APB1LENR", "C1_APB1LENR"])
def test_a_gate_opens_at_both_of_its_places(world, place):
    assert not world.usart.clocked
    poke(world.rcc, place, 1 << 18)
    assert world.usart.clocked
    assert peek(world.rcc, "APB1LENR") == peek(world.rcc, "C1_APB1LENR") == 1 << 18
    assert world.usart.log == ["before", "after"]


def test_a_reset_register_resets_and_gates_that_do_not_exist_are_said(world):
    poke(world.rcc, "APB1LRSTR", 1 << 18)
    poke(world.rcc, "APB1LRSTR", 0)
    assert world.usart.log == ["reset", "reset"]
    poke(world.rcc, "APB3ENR", 1 << 4)  # DSI, which others have
    assert world.chip.noted("reserved") == ["RCC_APB3ENR"]


def test_limits_go_by_voltage_scale(world):
    world.scale = 1
    run_pll1(world)
    assert {"RCC_CFGR.SW", "RCC_D1CFGR.HPRE", "RCC_D2CFGR.D2PPRE1"} <= set(world.chip.noted("misuse"))
    assert not set(world.chip.noted("misuse")) & {"RCC_PLL1DIVR.DIVN1", "RCC_PLLCFGR.PLL1RGE"}


def test_a_pll_out_of_its_range_is_said(world):
    run_pll1(world, divn=500, divp=5, rge=0)
    assert {"RCC_PLL1DIVR.DIVN1", "RCC_PLLCFGR.PLL1RGE", "RCC_PLL1DIVR.DIVP1"} <= set(world.chip.noted("misuse"))


def test_the_clock_security_system(world):
    run_pll1(world, source=HSE, divm=2, divn=200)
    switch_on(world, HSECSSON)
    assert world.tree.rates.hclk == 400 * MHZ
    world.rcc.fail_hse()
    assert world.tree.rates.hclk == 64 * MHZ
    assert peek(world.rcc, "CR") & (HSEON | PLLON[0] | HSERDY | PLLRDY[0]) == 0
    assert peek(world.rcc, "CIFR") & 1 << 10
    assert (world.nmi[-1], world.failures) == (True, [True])
    poke(world.rcc, "CICR", 1 << 10)
    assert world.nmi[-1] is False


@pytest.mark.parametrize(("choice", "rate"), [(0, 64 * MHZ), (1 << 6, 4 * MHZ)])
def test_stop_mode_is_left_on_the_oscillator_that_stopwuck_chooses(world, choice, rate):
    run_pll1(world)
    poke(world.rcc, "CFGR", PLL1 | choice)
    world.rcc.stop()
    assert world.tree.pclk("APB1") == 0
    world.rcc.resume()
    assert world.tree.rates.hclk == rate
    assert peek(world.rcc, "CFGR") & 0x3F == (9 if choice else 0)
    assert not peek(world.rcc, "CR") & PLLON[0]


def test_the_backup_domain_is_protected_and_reset_by_its_bit(world):
    world.dbp = False
    poke(world.rcc, "BDCR", 1)
    assert peek(world.rcc, "BDCR") == 0
    world.dbp = True
    poke(world.rcc, "BDCR", 0x8101)
    poke(world.rcc, "BDCR", 1 << 16)
    assert peek(world.rcc, "BDCR") == 1 << 16


def test_hse_without_bypass_on_a_board_that_drives_it(world):
    switch_on(world, HSEON)
    assert peek(world.rcc, "CR") & HSERDY
    assert world.chip.noted("assumed") == ["RCC_CR.HSEBYP"]


def test_a_crystal_does_not_work_with_the_bypass():
    world = build(hse_is_clock=False)
    switch_on(world, HSEBYP, HSEON)
    assert not peek(world.rcc, "CR") & HSERDY
    assert world.chip.noted("misuse") == ["RCC_CR.HSEBYP"]


@pytest.mark.parametrize(
    ("output", "source", "divider", "hz"),
    [
        ("MCO1", 0, 0, 0),
        ("MCO1", 0, 1, 64 * MHZ),
        ("MCO1", 0, 15, Fraction(64 * MHZ, 15)),
        ("MCO1", 1, 1, 0),  # LSE is off
        ("MCO1", 2, 2, 4 * MHZ),
        ("MCO1", 3, 10, 48 * MHZ),
        ("MCO1", 4, 1, 48 * MHZ),
        ("MCO1", 5, 1, 0),
        ("MCO2", 0, 8, 60 * MHZ),
        ("MCO2", 1, 1, 0),  # PLL2 is off
        ("MCO2", 2, 1, 8 * MHZ),
        ("MCO2", 3, 12, 40 * MHZ),
        ("MCO2", 4, 4, MHZ),
        ("MCO2", 5, 1, 0),  # LSI is off
        ("MCO2", 7, 1, 0),
    ],
)
def test_clocks_at_pins(world, output, source, divider, hz):
    """RM0433 section 8.7.6."""
    switch_on(world, HSI48ON, HSEBYP, HSEON)
    poke(world.rcc, "D1CFGR", 8)
    run_pll1(world)
    shift = 18 if output == "MCO1" else 25
    poke(world.rcc, "CFGR", PLL1 | divider << shift | source << shift + 4)
    signal = world.chip.output(output)
    assert (signal.wave.hz if signal.wave else 0) == hz
    assert signal.level is False


def test_the_lsi_at_a_pin_has_edges(world):
    poke(world.rcc, "CSR", 1)
    world.chip.advance_s(200 * US)
    since = world.chip.time.now
    poke(world.rcc, "CFGR", 5 << 29 | 1 << 25)
    world.chip.advance(4000)
    assert world.chip.output("MCO2").edges == [
        (0, False),
        (since + 1000, True),
        (since + 2000, False),
        (since + 3000, True),
        (since + 4000, False),
    ]


def test_what_a_reset_leaves_in_rsr():
    """RM0433 section 8.4.4, the table of what identifies a reset; Standby is a choice."""
    assert dict(CAUSES) == {
        "POR": 0x00FA_0000,
        "PIN": 0x0042_0000,
        "SFT": 0x0142_0000,
        "IWDG": 0x0442_0000,
        "WWDG": 0x1042_0000,
        "LPWR": 0x4042_0000,
        "STANDBY": 0x001A_0000,
    }
    assert RESET_FLAGS == 0x55FA_0000


def test_what_can_be_reset(world):
    """RM0433 sections 8.7.29 to 8.7.37; bit 31 of AHB3RSTR is the CPU's."""
    masks = {name: register.writable for name, register in by_name(world.rcc).items() if name.endswith("RSTR")}
    assert {name: masks[f"{name}RSTR"] for name in ("AHB1", "AHB2", "AHB3", "AHB4", "APB3", "APB4")} == {
        "AHB1": 0x0A00_8023,  # DMA1, DMA2, ADC12, Ethernet, USB1, USB2
        "AHB2": 0x0000_0271,  # DCMI, CRYP, HASH, RNG, SDMMC2
        "AHB3": 0x8001_5031,  # MDMA, DMA2D, JPEG, FMC, QUADSPI, SDMMC1
        "AHB4": 0x0328_07FF,  # ports A to K, CRC, BDMA, ADC3, HSEM
        "APB3": 0x0000_0008,  # LTDC
        "APB4": 0x0020_DEAA,  # SYSCFG, LPUART1, SPI6, I2C4, LPTIM2-5, COMP, VREFBUF, SAI4
    }


def by_name(peripheral):
    return {register.name: register for register in peripheral.registers.values()}
