"""RCC of the STM32F76x (RM0410 section 5), on what is common to the families (`targets.mcu.stm32.rcc_classic`).

Choices: the peripherals' clocks run on in Sleep mode whatever the xxxLPENR registers say; every reset value of those is
"all bits set". PLLI2S and PLLSAI start and get ready; of what they feed, only the 48 MHz clock has anybody who uses it.
Spread spectrum is remembered. What MCO2 has of PLLI2S is its R output.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from types import MappingProxyType
from typing import ClassVar, Unpack

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.services import Services
from targets.mcu.stm32.mco import FAST_CLOCKS, Choice
from targets.mcu.stm32.rcc import BDCR_BITS, LSE_HZ, BoardClocks
from targets.mcu.stm32.rcc_classic import (
    CR,
    CR_BITS,
    CSR_BITS,
    PLLON,
    ClassicRcc,
    ready_bits,
)
from targets.mcu.stm32f7.clock_limits import pll_violations, violations
from targets.mcu.stm32f7.clocks import (
    HSI_HZ,
    LSI_HZ,
    PLLSRC,
    ClockTree,
    PllRates,
    Rates,
    kernel_choices,
    pll_rates,
    rates_of,
)

__all__ = ["Rcc"]

PLLCFGR, CFGR, CIR = 0x04, 0x08, 0x0C
AHB1RSTR, AHB2RSTR, AHB3RSTR, APB1RSTR, APB2RSTR = 0x10, 0x14, 0x18, 0x20, 0x24
AHB1ENR, AHB2ENR, AHB3ENR, APB1ENR, APB2ENR = 0x30, 0x34, 0x38, 0x40, 0x44
AHB1LPENR, AHB2LPENR, AHB3LPENR, APB1LPENR, APB2LPENR = 0x50, 0x54, 0x58, 0x60, 0x64
BDCR, CSR, SSCGR, PLLI2SCFGR, PLLSAICFGR, DCKCFGR1, DCKCFGR2 = 0x70, 0x74, 0x80, 0x84, 0x88, 0x8C, 0x90

PLLI2SON, PLLI2SRDY, PLLSAION, PLLSAIRDY = 1 << 26, 1 << 27, 1 << 28, 1 << 29
PLL_BITS = 0x7F43_7FFF
MULTIPLIER_BITS = 0x7F03_7FC0
_MCO_DIVIDERS = (1, 1, 1, 1, 2, 3, 4, 5)
LSEDRV, TIMPRE = 3 << 3, 1 << 24

AHB1_BITS = 0x7EF4_17FF  # GPIOA-K, CRC, BKPSRAM, DTCMRAM, DMA1-2, DMA2D, Ethernet, OTG HS
AHB1_RESETS = 0x22E0_17FF
AHB2_BITS = 0x0000_00C3  # DCMI, JPEG, RNG, OTG FS
AHB3_BITS = 0x0000_0003  # FMC, QUADSPI
APB1_BITS = 0xFFFF_EFFF  # all but bit 12
APB1_RESETS = APB1_BITS & ~(1 << 10)  # RTCAPB has none
APB2_BITS = 0x64F7_7FB3  # TIM1, 8-11, USART1, 6, SDMMC1-2, ADC1-3, SPI1, 4-6, SYSCFG, SAI1-2, LTDC, DFSDM1, MDIOS
ADC1EN = 1 << 8
APB2_RESETS = APB2_BITS & ~(3 << 9)  # one for all ADCs
DTCMRAMEN, RTCAPBEN = 1 << 20, 1 << 10
OTHER_GATES = "gates of memories, of PTP, ULPI and Ethernet lines are remembered"

# Every reset of the chip also pulls NRST low, so that PINRSTF comes with each; power-on is a brown-out, too. Leaving
# Standby is a power reset that leaves BORRSTF alone (RM0410 sections 5.1 and 5.3.21).
_PIN = 1 << 26
CAUSES = {
    "PIN": _PIN,
    "POR": 7 << 25,
    "STANDBY": 3 << 26,
    "SFT": 1 << 28 | _PIN,
    "IWDG": 1 << 29 | _PIN,
    "WWDG": 1 << 30 | _PIN,
    "LPWR": 1 << 31 | _PIN,
}


class Rcc(ClassicRcc):
    """Reset and clock control.

    Args:
        base: address of its first register.
        services: what the chip offers.
        tree: the clock tree this sets; it is also the chip's `services.clocks`.
        supply: returns the voltage scale, 1 to 3, and whether over-drive is switched on.
        board: see `BasicRcc`.

    Attributes:
        on_pll: called with whether the PLL is switched on, when that changes; PWR may change the voltage scale only
            while it is off.
        on_rtc_clock: called when `rtc_hz` may have changed.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register(
            "CR",
            CR,
            0x0000_0083,
            CR_BITS | PLLI2SON | PLLSAION,
            note="HSICAL reads 0 (choice)",
        ),
        Register("PLLCFGR", PLLCFGR, 0x2400_3010, PLL_BITS, note="R is for DSI, which this chip does not have"),
        Register("CFGR", CFGR, 0, 0xFFFF_FCF3, fidelity=Fidelity.PARTLY, note=FAST_CLOCKS),
        Register("CIR", CIR, 0, 0x00FF_7F00),
        Register("AHB1RSTR", AHB1RSTR, 0, AHB1_RESETS),
        Register("AHB2RSTR", AHB2RSTR, 0, AHB2_BITS),
        Register("AHB3RSTR", AHB3RSTR, 0, AHB3_BITS),
        Register("APB1RSTR", APB1RSTR, 0, APB1_RESETS),
        Register("APB2RSTR", APB2RSTR, 0, APB2_RESETS),
        Register("AHB1ENR", AHB1ENR, DTCMRAMEN, AHB1_BITS, fidelity=Fidelity.PARTLY, note=OTHER_GATES),
        Register("AHB2ENR", AHB2ENR, 0, AHB2_BITS),
        Register("AHB3ENR", AHB3ENR, 0, AHB3_BITS),
        Register("APB1ENR", APB1ENR, RTCAPBEN, APB1_BITS),
        Register("APB2ENR", APB2ENR, 0, APB2_BITS),
        *(
            Register(name, offset, bits, bits, fidelity=Fidelity.ABSENT, note="clocks run on in Sleep mode")
            for name, offset, bits in (
                ("AHB1LPENR", AHB1LPENR, AHB1_BITS | 0x0003_A000),  # and AXI, FLITF, SRAM1, SRAM2
                ("AHB2LPENR", AHB2LPENR, AHB2_BITS),
                ("AHB3LPENR", AHB3LPENR, AHB3_BITS),
                ("APB1LPENR", APB1LPENR, APB1_BITS),
                ("APB2LPENR", APB2LPENR, APB2_BITS),
            )
        ),
        Register(
            "BDCR",
            BDCR,
            0,
            BDCR_BITS | LSEDRV,
            fidelity=Fidelity.PARTLY,
            note="LSEDRV is remembered",
        ),
        Register("CSR", CSR, CAUSES["POR"], CSR_BITS),
        Register("SSCGR", SSCGR, 0, 0xCFFF_FFFF, 1 << 31, note="the PLL keeps its rate: no spread spectrum"),
        Register("PLLI2SCFGR", PLLI2SCFGR, 0x2400_3000, MULTIPLIER_BITS, fidelity=Fidelity.PARTLY, note="feeds nobody"),
        Register(
            "PLLSAICFGR",
            PLLSAICFGR,
            0x2400_3000,
            MULTIPLIER_BITS,
            fidelity=Fidelity.PARTLY,
            note="P is the 48 MHz clock; Q and R feed nobody",
        ),
        Register("DCKCFGR1", DCKCFGR1, 0, 0x07F3_1F1F, 0x06F3_1F1F, note="clocks of SAI, LTDC and DFSDM feed nobody"),
        Register("DCKCFGR2", DCKCFGR2, 0, 0x3FFF_FFFF),
    )

    CFGR, CIR, BDCR, CSR = CFGR, CIR, BDCR, CSR
    FLAGS = CSR
    ENABLE_OF = MappingProxyType({"AHB1": AHB1ENR, "AHB2": AHB2ENR, "AHB3": AHB3ENR, "APB1": APB1ENR, "APB2": APB2ENR})
    RESET_OF = MappingProxyType(
        {AHB1RSTR: "AHB1", AHB2RSTR: "AHB2", AHB3RSTR: "AHB3", APB1RSTR: "APB1", APB2RSTR: "APB2"}
    )
    HSI_HZ, LSI_HZ = HSI_HZ, LSI_HZ
    LSE_START_S = Fraction(2)  # DS11532: typically
    # DS11532, characteristics of the HSI (2.2 us typical), LSI (40 us at most) and PLLs (200 us at most at 100 MHz, 300
    # us at 432 MHz: the latter).
    START_S = MappingProxyType(
        {"HSI": Fraction(22, 10_000_000), "LSI": Fraction(40, 1_000_000)}
        | dict.fromkeys(("PLL", "PLLI2S", "PLLSAI"), Fraction(300, 1_000_000))
    )
    READY = MappingProxyType(
        ready_bits(BDCR, CSR) | {"PLLI2S": (1 << 5, CR, PLLI2SRDY), "PLLSAI": (1 << 6, CR, PLLSAIRDY)}
    )
    RESET_FLAGS = 0xFE00_0000
    CAUSES = MappingProxyType(CAUSES)
    CLOCK_OUTPUTS = (  # RM0410 section 5.3.3
        Choice(name="MCO1", shift=21, clocks=("HSI", "LSE", "HSE", "PLL P"), prescaler=24, dividers=_MCO_DIVIDERS),
        Choice(
            name="MCO2", shift=30, clocks=("SYSCLK", "PLLI2S R", "HSE", "PLL P"), prescaler=27, dividers=_MCO_DIVIDERS
        ),
    )

    def __init__(
        self,
        base: int,
        services: Services,
        tree: ClockTree,
        *,
        supply: Callable[[], tuple[int, bool]],
        **board: Unpack[BoardClocks],
    ) -> None:
        self.tree = tree
        self.on_pll: Callable[[bool], None] = lambda _on: None
        self.on_rtc_clock: Callable[[], None] = lambda: None
        self._supply = supply
        self._kernels = kernel_choices()
        super().__init__(base, services, **board)

    @property
    def pll_on(self) -> bool:
        """True while PLLON is set."""
        return bool(self[CR] & PLLON)

    # --- registers

    def write_CR(self, value: int) -> None:
        """As in every family, and PLLI2SON, PLLSAION."""
        was_on = self.pll_on
        super().write_CR(value)
        for name, bit in (("PLLI2S", PLLI2SON), ("PLLSAI", PLLSAION)):
            self._feed_other_pll(name, bool(value & bit))
        if self.pll_on is not was_on:
            self.on_pll(self.pll_on)

    def write_PLLCFGR(self, value: int) -> None:
        """The settings of the PLL, and the divider and source of all three; only while they are off."""
        if self[CR] & (PLLON | PLLI2SON | PLLSAION) and value != self[PLLCFGR]:
            self.note("misuse", "PLLCFGR", "a PLL is on: the settings keep their values")
            return
        self[PLLCFGR] = value

    def write_PLLI2SCFGR(self, value: int) -> None:
        """The multiplier and dividers of PLLI2S."""
        self._write_multiplier(PLLI2SCFGR, PLLI2SON, value)

    def write_PLLSAICFGR(self, value: int) -> None:
        """The multiplier and dividers of PLLSAI."""
        self._write_multiplier(PLLSAICFGR, PLLSAION, value)

    def _write_multiplier(self, offset: int, on: int, value: int) -> None:
        if self[CR] & on and value != self[offset]:
            self.note("misuse", self.registers[offset].name, "the PLL is on: the settings keep their values")
            return
        self[offset] = value

    def write_CFGR(self, value: int) -> None:
        """Prescalers at once; SYSCLK when the source is ready."""
        self[CFGR] = self._keep_source(value)
        self._try_switch()
        self._set_tree()
        self.on_rtc_clock()

    def write_AHB1RSTR(self, value: int) -> None:
        """Reset the peripherals of AHB1."""
        self._write_resets(AHB1RSTR, value)

    def write_AHB2RSTR(self, value: int) -> None:
        """Reset the peripherals of AHB2."""
        self._write_resets(AHB2RSTR, value)

    def write_AHB3RSTR(self, value: int) -> None:
        """Reset the peripherals of AHB3."""
        self._write_resets(AHB3RSTR, value)

    def write_APB1RSTR(self, value: int) -> None:
        """Reset the peripherals of APB1."""
        self._write_resets(APB1RSTR, value)

    def write_APB2RSTR(self, value: int) -> None:
        """Reset the peripherals of APB2."""
        self._write_resets(APB2RSTR, value)

    def write_AHB1ENR(self, value: int) -> None:
        """Open and shut clock gates."""
        self._write_gates(AHB1ENR, value)

    def write_AHB2ENR(self, value: int) -> None:
        """Open and shut clock gates."""
        self._write_gates(AHB2ENR, value)

    def write_AHB3ENR(self, value: int) -> None:
        """Open and shut clock gates."""
        self._write_gates(AHB3ENR, value)

    def write_APB1ENR(self, value: int) -> None:
        """Open and shut clock gates."""
        self._write_gates(APB1ENR, value)

    def write_APB2ENR(self, value: int) -> None:
        """Open and shut clock gates."""
        self._write_gates(APB2ENR, value)

    def adc_enabled(self, number: int) -> bool:
        """Say whether the gate of an ADC is open, by its number from 0 on; they share an address block and a reset."""
        return bool(self[APB2ENR] & ADC1EN << number)

    def write_BDCR(self, value: int) -> None:
        """As in every family; the kernel clocks may run on the LSE."""
        super().write_BDCR(value)
        self._set_tree()
        self.on_rtc_clock()

    def write_DCKCFGR1(self, value: int) -> None:
        """TIMPRE, and dividers of clocks that nobody uses."""
        self[DCKCFGR1] = value
        self._set_tree()

    def write_DCKCFGR2(self, value: int) -> None:
        """Which peripheral runs on which clock."""
        self[DCKCFGR2] = value
        for name, choice in self._kernels.items():
            if choice.clocks[value >> choice.shift & choice.mask] == "-":
                self.note("reserved", f"DCKCFGR2.{name}SEL", "the value 11 is reserved: no clock")
        self._set_tree()

    # --- clocks

    def supply_changed(self) -> None:
        """PWR gives another voltage scale, or over-drive: look at the limits anew."""
        self._check_rates()

    def _stop_oscillators(self) -> None:
        for name in ("PLLI2S", "PLLSAI"):
            self._oscillators[name].stop_now()
        self[CR] &= ~(PLLI2SON | PLLSAION)
        super()._stop_oscillators()
        self.on_pll(False)

    def _pll_runs_on_hse(self) -> bool:
        return bool(self[PLLCFGR] & PLLSRC)

    def _entry_ready(self) -> bool:
        return (self._hse if self._pll_runs_on_hse() else self._hsi).ready

    def _check_pll(self) -> None:
        self._check_one_pll("PLL", "PLLCFGR", pll_rates(self[PLLCFGR], self.hse_hz), self[PLLCFGR])

    def _check_one_pll(self, name: str, register: str, rates: PllRates, settings: int) -> None:
        for field, text in pll_violations(name, rates, settings >> 6 & 0x1FF):
            self.note("misuse", f"{register}.{field}", text)

    def _feed_pll(self) -> None:
        super()._feed_pll()
        for name, bit in (("PLLI2S", PLLI2SON), ("PLLSAI", PLLSAION)):
            self._feed_other_pll(name, bool(self[CR] & bit))

    def _feed_other_pll(self, name: str, on: bool) -> None:
        oscillator, offset = self._oscillators[name], PLLI2SCFGR if name == "PLLI2S" else PLLSAICFGR
        on = on and self._entry_ready()
        if on and not oscillator.on:
            rates = pll_rates(self[PLLCFGR], self.hse_hz, self[offset])
            self._check_one_pll(name, f"{name}CFGR", rates, self[offset])
        oscillator.switch(on)

    def _rtc_hse_hz(self) -> Fraction:
        divider = self[CFGR] >> 16 & 0x1F
        return self.hse_hz / divider if divider > 1 else Fraction(0)

    def _on_ready(self, name: str, ready: bool) -> None:
        super()._on_ready(name, ready)
        self.on_rtc_clock()

    def _set_tree(self, *, stopped: bool | None = None) -> None:
        tree, pll = self.tree, pll_rates(self[PLLCFGR], self.hse_hz)
        all_timers = bool(self[DCKCFGR1] & TIMPRE)
        rates = rates_of(self[CFGR], self._source, self.hse_hz, pll, all_timers=all_timers)
        clocks = self._clocks(rates, pll)
        in_stop = frozenset(name for name in self._kernels if self._clock_of(name) in ("LSE", "LSI"))
        rates = replace(rates, kernels=self._kernel_rates(clocks), in_stop=in_stop)
        halted = tree.stopped if stopped is None else stopped

        def change() -> None:
            tree.set(rates, stopped=halted)
            if rates.hclk != self.time.hclk_hz:
                self.time.set_hclk(rates.hclk)

        if rates != tree.rates or halted is not tree.stopped:
            self._tell_change(change)
            self._check_rates()
        self._put_out(self[CFGR], clocks, stopped=halted)

    def _clock_of(self, peripheral: str) -> str:
        choice = self._kernels[peripheral]
        return choice.clocks[self[DCKCFGR2] >> choice.shift & choice.mask]

    def _clocks(self, rates: Rates, pll: PllRates) -> Mapping[str, Fraction]:
        none = Fraction(0)
        sai = pll_rates(self[PLLCFGR], self.hse_hz, self[PLLSAICFGR])
        i2s = pll_rates(self[PLLCFGR], self.hse_hz, self[PLLI2SCFGR])
        hsi = HSI_HZ if self._hsi.ready else none
        return {
            "APB1": rates.pclk1,
            "APB2": rates.pclk2,
            "SYSCLK": rates.sysclk,
            "HSI": hsi,
            "HSI/488": hsi / 488,
            "LSE": LSE_HZ if self._lse.ready else none,
            "LSI": self.lsi_hz if self._lsi.ready else none,
            "HSE": self.hse_hz if self._hse.ready else none,
            "PLL P": pll.p if self._pll.ready else none,
            "PLL Q": pll.q if self._pll.ready else none,
            "PLLSAI P": sai.p if self._oscillators["PLLSAI"].ready else none,
            "PLLI2S R": i2s.r if self._oscillators["PLLI2S"].ready else none,
            "-": none,
        }

    def _kernel_rates(self, clocks: Mapping[str, Fraction]) -> Mapping[str, Fraction]:
        found: dict[str, Fraction] = {}
        for name in self._kernels:
            clock = self._clock_of(name)
            found[name] = found["RNG"] if clock == "CK48" else clocks[clock]
        return found

    def _check_rates(self) -> None:
        scale, over_drive = self._supply()
        for where, text in violations(self.tree.rates, scale=scale, over_drive=over_drive):
            self.note("misuse", where, text)

    # --- resets

    def reset(self) -> None:
        """Go to the state after a reset of the chip."""
        super().reset()
        self.on_pll(False)
        self.on_rtc_clock()
