"""RCC of the STM32F103 (RM0008 section 7), on what is common to the families (`targets.mcu.stm32.rcc_classic`)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from fractions import Fraction
from types import MappingProxyType
from typing import ClassVar, Unpack

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.services import Services
from targets.mcu.stm32.mco import FAST_CLOCKS, Choice
from targets.mcu.stm32.rcc import BDCR_BITS, BoardClocks
from targets.mcu.stm32.rcc_classic import CR, CR_BITS, CSR_BITS, PLLON, ClassicRcc, ready_bits
from targets.mcu.stm32f1.clock_limits import violations
from targets.mcu.stm32f1.clocks import HSI_HZ, LSI_HZ, ClockTree, pll_hz, rates_of
from targets.mcu.stm32f1.densities import MEDIUM, Density

__all__ = ["Rcc"]

CFGR, CIR, APB2RSTR, APB1RSTR, AHBENR, APB2ENR, APB1ENR, BDCR, CSR = range(4, 0x28, 4)
CFGR2 = 0x2C

PLLSRC, PLLXTPRE, USBPRE, PLL_SETTINGS = 1 << 16, 1 << 17, 1 << 22, 0x3F << 16
# Every reset of the chip also pulls NRST low, so that PINRSTF comes with each (RM0008 section 7.1.1, figure 7). Leaving
# Standby is a power reset (section 7.1.2).
CAUSES = {
    "PIN": 1 << 26,
    "POR": 3 << 26,
    "STANDBY": 3 << 26,
    "SFT": 5 << 26,
    "IWDG": 9 << 26,
    "WWDG": 17 << 26,
    "LPWR": 33 << 26,
}
_MCO_SYSCLK, FASTEST_MCO_HZ = 0b100, 50_000_000  # RM0008 section 7.3.2, MCO
ADCS, USB = 3 << 9, 1 << 23
SRAM_AND_FLITF = 0x14


class Rcc(ClassicRcc):
    """Reset and clock control.

    Args:
        base: address of its first register.
        services: what the chip offers.
        tree: the clock tree this sets; it is also the chip's `services.clocks`.
        density: says which peripherals have a gate.
        board: see `BasicRcc`.

    Attributes:
        on_rtc_clock: called when `rtc_hz` may have changed.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("CR", CR, 0x0000_0083, CR_BITS, note="HSICAL reads 0 (choice)"),
        Register("CFGR", CFGR, 0, 0x077F_FFF3, fidelity=Fidelity.PARTLY, note=FAST_CLOCKS),
        Register("CIR", CIR, 0, 0x009F_1F00),
        Register("BDCR", BDCR, 0, BDCR_BITS),
        Register("CSR", CSR, CAUSES["POR"], CSR_BITS),
    )

    CFGR, CIR, BDCR, CSR = CFGR, CIR, BDCR, CSR
    FLAGS = CSR
    ENABLE_OF = MappingProxyType({"AHB": AHBENR, "APB2": APB2ENR, "APB1": APB1ENR})
    RESET_OF = MappingProxyType({APB2RSTR: "APB2", APB1RSTR: "APB1"})
    HSI_HZ, LSI_HZ = HSI_HZ, LSI_HZ
    LSE_START_S = Fraction(5, 2)  # DS5319: typically, at 25 degrees
    # DS5319, tables of the HSI (1 to 2 us), LSI (at most 85 us) and PLL (lock time at most 200 us).
    START_S = MappingProxyType(
        {"HSI": Fraction(2, 1_000_000), "LSI": Fraction(85, 1_000_000), "PLL": Fraction(200, 1_000_000)}
    )
    READY = MappingProxyType(ready_bits(BDCR, CSR))
    RESET_FLAGS = 0xFC00_0000
    CAUSES = MappingProxyType(CAUSES)
    CLOCK_OUTPUTS = (
        Choice(name="MCO", shift=24, clocks=(*[None] * 4, "SYSCLK", "HSI", "HSE", "PLL/2")),
        Choice(name="LSI", shift=0, clocks=("LSI",)),  # inside the chip: TIM5 may measure it
    )

    def __init__(
        self,
        base: int,
        services: Services,
        tree: ClockTree,
        density: Density = MEDIUM,
        **board: Unpack[BoardClocks],
    ) -> None:
        self.tree = tree
        self._density = density
        self.on_rtc_clock: Callable[[], None] = lambda: None
        super().__init__(base, services, **board)

    def registers_of(self) -> Iterable[Register]:
        """Return the registers, with the gates of this density."""
        ahb, apb1, apb2 = (self._density.bits(bus) for bus in ("AHB", "APB1", "APB2"))
        gates = (
            Register("APB2RSTR", APB2RSTR, 0, apb2),
            Register("APB1RSTR", APB1RSTR, 0, apb1),
            Register(
                "AHBENR",
                AHBENR,
                SRAM_AND_FLITF,
                ahb | SRAM_AND_FLITF,
                fidelity=Fidelity.PARTLY,
                note="SRAM, FLITF: gates are remembered",
            ),
            Register("APB2ENR", APB2ENR, 0, apb2),
            Register("APB1ENR", APB1ENR, 0, apb1),
        )
        own: tuple[Register, ...] = self.REGISTERS
        if self._density.value_line:
            without_usb = (
                replace(one, writable=one.writable & ~USBPRE) if one.offset == CFGR else one for one in self.REGISTERS
            )
            own = (*without_usb, Register("CFGR2", CFGR2, 0, 0xF))
        return sorted((*own, *gates), key=lambda register: register.offset)

    def reset(self) -> None:
        """Go to the state after a reset of the chip."""
        super().reset()
        self.on_rtc_clock()

    # --- registers

    def write_BDCR(self, value: int) -> None:
        """As in every family; the RTC may run on another clock."""
        super().write_BDCR(value)
        self.on_rtc_clock()

    def write_CFGR(self, value: int) -> None:
        """Prescalers at once; SYSCLK when the source is ready; the PLL only while it is off."""
        old = self[CFGR]
        if self[CR] & PLLON and (value ^ old) & PLL_SETTINGS:
            self.note("misuse", "CFGR.PLLMUL", "the PLL is on: PLLSRC, PLLXTPRE and PLLMUL keep their values")
            value = (value & ~PLL_SETTINGS) | (old & PLL_SETTINGS)
        self[CFGR] = self._keep_source(value)
        if self._density.value_line:
            self[CFGR2] = self[CFGR2] & ~1 | (1 if value & PLLXTPRE else 0)
        self._try_switch()
        self._set_tree()

    def write_CFGR2(self, value: int) -> None:
        """Divide HSE before the PLL, while that is off; the lowest bit is PLLXTPRE too (RM0041 section 6.3.11)."""
        if self[CR] & PLLON and value != self[CFGR2]:
            self.note("misuse", "CFGR2.PREDIV1", "the PLL is on: PREDIV1 keeps its value")
            return
        self[CFGR2] = value
        self[CFGR] = self[CFGR] & ~PLLXTPRE | (PLLXTPRE if value & 1 else 0)
        self._set_tree()

    def _prediv(self) -> int | None:
        return (self[CFGR2] & 0xF) + 1 if self._density.value_line else None

    def write_APB2RSTR(self, value: int) -> None:
        """Reset the peripherals of APB2."""
        self._write_resets(APB2RSTR, value)

    def write_APB1RSTR(self, value: int) -> None:
        """Reset the peripherals of APB1."""
        self._write_resets(APB1RSTR, value)

    def write_AHBENR(self, value: int) -> None:
        """Open and shut clock gates."""
        self._write_gates(AHBENR, value)

    def write_APB2ENR(self, value: int) -> None:
        """Open and shut clock gates."""
        self._write_gates(APB2ENR, value)

    def write_APB1ENR(self, value: int) -> None:
        """Open and shut clock gates."""
        self._write_gates(APB1ENR, value)

    def _write_gates(self, offset: int, value: int) -> None:
        super()._write_gates(offset, value)
        self._check_rates()

    # --- clocks

    def _pll_runs_on_hse(self) -> bool:
        return bool(self[CFGR] & PLLSRC)

    def _check_pll(self) -> None:
        mhz, most = pll_hz(self[CFGR], self.hse_hz, self._prediv()) / 1_000_000, self._density.limits.sysclk
        if not 16 <= mhz <= most:  # DS5319 and DS5944, PLL characteristics
            self.note("misuse", "CFGR.PLLMUL", f"the PLL makes 16 to {most} MHz, not {float(mhz):g} MHz")

    def _on_ready(self, name: str, ready: bool) -> None:
        super()._on_ready(name, ready)
        self.on_rtc_clock()

    def _rtc_hse_hz(self) -> Fraction:
        return self.hse_hz / 128

    def _set_tree(self, *, stopped: bool | None = None) -> None:
        tree = self.tree
        rates = rates_of(self[CFGR], self._source, self.hse_hz, self._prediv())
        halted = tree.stopped if stopped is None else stopped

        def change() -> None:
            tree.set(rates, stopped=halted)
            if rates.hclk != self.time.hclk_hz:
                self.time.set_hclk(rates.hclk)

        if rates != tree.rates or halted is not tree.stopped:
            self._tell_change(change)
            self._check_rates()
        none = Fraction(0)
        clocks = {
            "SYSCLK": rates.sysclk,
            "HSI": HSI_HZ if self._hsi.ready else none,
            "HSE": self.hse_hz if self._hse.ready else none,
            "LSI": self.lsi_hz if self._lsi.ready else none,
            "PLL/2": pll_hz(self[CFGR], self.hse_hz, self._prediv()) / 2 if self._pll.ready else none,
        }
        self._put_out(self[CFGR], clocks, stopped=halted)
        if self[CFGR] >> 24 & 7 == _MCO_SYSCLK and rates.sysclk > FASTEST_MCO_HZ:
            self.note("misuse", "CFGR.MCO", "SYSCLK is faster than the 50 MHz that the pin can put out")

    def _check_rates(self) -> None:
        adc_on, usb_on = bool(self[APB2ENR] & ADCS), bool(self[APB1ENR] & USB)
        limits = self._density.limits
        for where, text in violations(self.tree.rates, adc_on=adc_on, usb_on=usb_on, limits=limits):
            self.note("misuse", where, text)
