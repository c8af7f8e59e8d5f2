"""RCC of the STM32H743 and H753 (RM0433 section 8), on what is common to the families (`targets.mcu.stm32.rcc`).

Choices: SYSCLK switches at once when the wanted source is ready; a reserved value of SW is not taken over; HSIDIV holds
at once; the clocks of peripherals run on in Sleep mode whatever the xxxLPENR registers say; nobody watches the LSE; the
bits that allocate memories of D2 are remembered, and the memories answer without them. The kernel clocks are those of
`targets.mcu.stm32h7.clocks`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from types import MappingProxyType
from typing import ClassVar, Unpack

from targets.mcu.registers import Register
from targets.mcu.services import Services
from targets.mcu.stm32.mco import Choice
from targets.mcu.stm32.rcc import BDRST, LSE_HZ, LSERDY, LSION, LSIRDY, BoardClocks
from targets.mcu.stm32h7 import rcc_registers as at
from targets.mcu.stm32h7.clock_limits import violations
from targets.mcu.stm32h7.clocks import (
    CSI_HZ,
    HSI48_HZ,
    HSI_HZ,
    KERNEL_CHOICES,
    LSI_HZ,
    ClockTree,
    PllRates,
    Rates,
    Source,
    rates_of,
)
from targets.mcu.stm32h7.rcc_plls import PLLS, RccWithPlls

__all__ = ["Rcc"]

_LINES = 0x3FF  # what CIER can let through
_KERNEL_REGISTERS = {"D1CCIPR": at.D1CCIPR, "D2CCIP1R": at.D2CCIP1R, "D2CCIP2R": at.D2CCIP2R, "D3CCIPR": at.D3CCIPR}

# DS12117, characteristics of HSI, CSI, HSI48, LSI and the PLLs, the slower figure of each table; from memory.
_START_S = {
    "HSI": Fraction(2, 1_000_000),
    "CSI": Fraction(2, 1_000_000),
    "HSI48": Fraction(35, 10_000_000),
    "LSI": Fraction(130, 1_000_000),
    **dict.fromkeys(PLLS, Fraction(150, 1_000_000)),
}


class Rcc(RccWithPlls):
    """Reset and clock control.

    Args:
        base: address of its first register.
        services: what the chip offers.
        tree: the clock tree this sets; it is also the chip's `services.clocks`.
        scale: returns the voltage scale, 0 to 3; 0 is scale 1 with over-drive.
        board: see `BasicRcc`.

    Attributes:
        on_rtc_clock: called when `rtc_hz` may have changed.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = at.REGISTERS

    BDCR, CSR, FLAGS = at.BDCR, at.CSR, at.RSR
    ENABLE_OF, RESET_OF = at.ENABLE_OF, at.RESET_OF
    HSI_HZ, LSI_HZ = HSI_HZ, LSI_HZ
    LSE_START_S = Fraction(2)  # DS12117: typically
    START_S = MappingProxyType(_START_S)
    CYCLES_TO_STOP = MappingProxyType(dict.fromkeys(("HSI", "CSI", "HSI48", "HSE", "LSE"), 6) | {"LSI": 3})
    READY = MappingProxyType(
        {
            "LSI": (1 << 0, at.CSR, LSIRDY),
            "LSE": (1 << 1, at.BDCR, LSERDY),
            "HSI": (1 << 2, at.CR, at.HSIRDY),
            "HSE": (1 << 3, at.CR, at.HSERDY),
            "CSI": (1 << 4, at.CR, at.CSIRDY),
            "HSI48": (1 << 5, at.CR, at.HSI48RDY),
            **{name: (1 << 6 + index, at.CR, at.PLLRDY[index]) for index, name in enumerate(PLLS)},
        }
    )
    RESET_FLAGS, CAUSES = at.RESET_FLAGS, at.CAUSES
    CLOCK_OUTPUTS = (  # RM0433 section 8.7.6; reserved values are no clock
        Choice(
            name="MCO1",
            shift=22,
            clocks=("HSI", "LSE", "HSE", "PLL1 Q", "HSI48", "-", "-", "-"),
            prescaler=18,
            dividers=range(16),
        ),
        Choice(
            name="MCO2",
            shift=29,
            clocks=("SYSCLK", "PLL2 P", "HSE", "PLL1 P", "CSI", "LSI", "-", "-"),
            prescaler=25,
            dividers=range(16),
        ),
    )

    def __init__(
        self,
        base: int,
        services: Services,
        tree: ClockTree,
        *,
        scale: Callable[[], int],
        **board: Unpack[BoardClocks],
    ) -> None:
        self.tree = tree
        self.on_rtc_clock: Callable[[], None] = lambda: None
        self._scale = scale
        self._source = Source.HSI
        super().__init__(base, services, **board)

    # --- registers, those for CPU 1 too

    def __getitem__(self, offset: int) -> int:
        """Return the value kept for the register at `offset`, or at the one of which it is an alias."""
        return super().__getitem__(_home(offset))

    def read(self, offset: int) -> int:
        """Read the word at `offset`."""
        return super().read(_home(offset))

    def write(self, offset: int, value: int) -> None:
        """Write the word at `offset`; a gate or reset that this chip does not have is noted."""
        home = _home(offset)
        if home in at.RESET_OF:
            if home == at.CPU_RESET_AT and value & at.CPU_RESET:
                self.note("unmodelled", "AHB3RSTR.CPURST", "the CPU is not reset by itself")
            self._write_resets(home, value & self.registers[home].writable)
            return
        super().write(home, value)
        if home in at.ENABLE_OF.values():
            self._apply_gates()

    def write_CR(self, value: int) -> None:
        """Switch oscillators; what drives SYSCLK, or is selected to, cannot be switched off."""
        kept = self._needed_bits() & self[at.CR] & ~value
        if kept:
            self.note("misuse", "CR", f"bits 0x{kept:X}: an oscillator that drives SYSCLK cannot be switched off")
        value |= kept | (self[at.CR] & at.HSECSSON)  # which only a reset clears
        old = self[at.CR]
        if (value ^ old) & at.HSEBYP and old & at.HSEON:
            self.note("misuse", "CR.HSEBYP", "can be changed only while HSEON = 0; it keeps its value")
            value ^= at.HSEBYP
        if (value ^ old) & at.HSIDIV and self._some_pll_runs_on(Source.HSI):
            self.note("misuse", "CR.HSIDIV", "a PLL runs on the HSI: it keeps its value")
            value = (value & ~at.HSIDIV) | (old & at.HSIDIV)
        if value & at.HSEON & ~old and self._hse_is_clock and not value & at.HSEBYP:
            self.note("assumed", "CR.HSEBYP", "OSC_IN is driven by a clock: the oscillator is assumed to pass it on")
        self[at.CR] = value
        self._hse.works = self._hse_healthy and self._bypass_fits()
        for name, bit in (("HSI", at.HSION), ("CSI", at.CSION), ("HSI48", at.HSI48ON), ("HSE", at.HSEON)):
            self._oscillators[name].switch(bool(value & bit))
        self._feed_plls()
        self._set_tree()

    def write_HSICFGR(self, value: int) -> None:
        """HSITRIM."""
        self._trim(at.HSICFGR, value, "HSITRIM")

    def write_CSICFGR(self, value: int) -> None:
        """CSITRIM."""
        self._trim(at.CSICFGR, value, "CSITRIM")

    def _trim(self, offset: int, value: int, field: str) -> None:
        if value != self.registers[offset].reset:
            self.note("unmodelled", f"{self.registers[offset].name}.{field}", "is remembered; the rate stays as it is")
        self[offset] = value

    def write_CFGR(self, value: int) -> None:
        """Choose SYSCLK, which switches when the source is ready, and what depends on TIMPRE and RTCPRE."""
        if value & at.SW > Source.PLL1:
            self.note("misuse", "CFGR.SW", f"{value & at.SW:03b} is reserved; SW keeps its value")
            value = (value & ~at.SW) | (self[at.CFGR] & at.SW)
        self[at.CFGR] = value
        self._try_switch()
        self._set_tree()
        self.on_rtc_clock()

    def write_D1CFGR(self, value: int) -> None:
        """Prescalers hold at once."""
        self._write_tree(at.D1CFGR, value)

    def write_D2CFGR(self, value: int) -> None:
        """Prescalers hold at once."""
        self._write_tree(at.D2CFGR, value)

    def write_D3CFGR(self, value: int) -> None:
        """Prescalers hold at once."""
        self._write_tree(at.D3CFGR, value)

    def write_D1CCIPR(self, value: int) -> None:
        """Kernel clocks."""
        self._write_kernels(at.D1CCIPR, value)

    def write_D2CCIP1R(self, value: int) -> None:
        """Kernel clocks."""
        self._write_kernels(at.D2CCIP1R, value)

    def write_D2CCIP2R(self, value: int) -> None:
        """Kernel clocks."""
        self._write_kernels(at.D2CCIP2R, value)

    def write_D3CCIPR(self, value: int) -> None:
        """Kernel clocks."""
        self._write_kernels(at.D3CCIPR, value)

    def _write_tree(self, offset: int, value: int) -> None:
        self[offset] = value
        self._set_tree()

    def _write_kernels(self, offset: int, value: int) -> None:
        register = self.registers[offset].name
        for name, choice in KERNEL_CHOICES.items():
            chosen = value >> choice.shift & choice.mask
            if choice.register == register and chosen and choice.clocks[chosen] == "-":
                self.note("reserved", f"{register}.{name}SEL", f"the value {chosen:b} is reserved: no clock")
        self._write_tree(offset, value)

    # --- interrupts

    def read_CICR(self) -> int:
        """Write-only: reads 0."""
        return 0

    def write_CICR(self, value: int) -> None:
        """Clear flags by writing 1."""
        self[at.CIFR] &= ~value
        self._update_lines()

    def write_CIER(self, value: int) -> None:
        """Enable interrupts; only what happens from now on sets a flag that is not yet set."""
        self[at.CIER] = value
        self._update_lines()

    def _update_lines(self) -> None:
        flags = self[at.CIFR]
        self._irq.set(bool(flags & self[at.CIER] & _LINES))
        self.on_nmi(bool(flags & at.HSECSSF))

    # --- backup domain, LSI and reset flags

    def write_BDCR(self, value: int) -> None:
        """As in every family; the kernel clocks may run on the LSE."""
        super().write_BDCR(value)
        self._set_tree()
        self.on_rtc_clock()

    def _reset_backup_domain(self) -> None:
        super()._reset_backup_domain()
        self[at.BDCR] &= BDRST

    def write_CSR(self, value: int) -> None:
        """LSION."""
        self[at.CSR] = value
        self._lsi.switch(bool(value & LSION) or self._lsi_forced)

    def write_RSR(self, value: int) -> None:
        """RMVF clears the reset flags."""
        self[at.RSR] = value & ~(at.RESET_FLAGS if value & at.RMVF else 0) & ~at.RMVF

    # --- clocks

    def scale_changed(self) -> None:
        """PWR gives another voltage scale: look at the limits anew."""
        self._check_rates()

    def _on_ready(self, name: str, ready: bool) -> None:
        flag, offset, bit = self.READY[name]
        self[offset] = self[offset] | bit if ready else self[offset] & ~bit
        if ready and self[at.CIER] & flag:
            self[at.CIFR] |= flag
            self._update_lines()
        if name in ("HSI", "CSI", "HSE"):
            self._feed_plls()
        if ready:
            self._try_switch()
        self._set_tree()
        self.on_rtc_clock()

    def _try_switch(self) -> None:
        wanted = Source(self[at.CFGR] & at.SW)
        if self._oscillators[wanted.name].ready:
            self._source = wanted
            self[at.CFGR] = (self[at.CFGR] & ~0x38) | wanted << 3

    def _needed_bits(self) -> int:
        """Return the bits of CR that hold up SYSCLK: of the source in use, and of the one selected."""
        needed = 0
        for source in (self._source, Source(self[at.CFGR] & at.SW)):
            if source is Source.PLL1:
                needed |= at.PLLON[0]
                chosen = self._pll_source()
                if chosen is None:
                    continue
                source = chosen
            needed |= {Source.HSI: at.HSION, Source.CSI: at.CSION, Source.HSE: at.HSEON}[source]
        return needed

    def _rtc_hse_hz(self) -> Fraction:
        divider = self[at.CFGR] >> 8 & 0x3F
        return self.hse_hz / divider if divider > 1 else Fraction(0)

    def _set_tree(self, *, stopped: bool | None = None) -> None:
        tree, plls = self.tree, [self._pll_rates(index) for index in range(3)]
        sysclk = plls[0].p if self._source is Source.PLL1 else self._rate_of(self._source)
        if not sysclk:
            self.note("misuse", "CFGR.SW", "SYSCLK has no clock: silicon stands still, the model runs on as before")
            sysclk = tree.rates.sysclk
        all_timers = bool(self[at.CFGR] & at.TIMPRE)
        rates = rates_of(sysclk, self[at.D1CFGR], self[at.D2CFGR], self[at.D3CFGR], all_timers=all_timers)
        clocks = self._clocks(rates, plls)
        in_stop = frozenset(name for name in KERNEL_CHOICES if self._clock_of(name) in ("LSE", "LSI"))
        rates = replace(rates, kernels=self._kernel_rates(clocks), in_stop=in_stop)
        halted = tree.stopped if stopped is None else stopped

        def change() -> None:
            tree.set(rates, stopped=halted)
            if rates.hclk != self.time.hclk_hz:
                self.time.set_hclk(rates.hclk)

        if rates != tree.rates or halted is not tree.stopped:
            self._tell_change(change)
            self._check_rates()
        self._put_out(self[at.CFGR], clocks, stopped=halted)

    def _clock_of(self, peripheral: str) -> str:
        choice = KERNEL_CHOICES[peripheral]
        return choice.clocks[self[_KERNEL_REGISTERS[choice.register]] >> choice.shift & choice.mask]

    def _clocks(self, rates: Rates, plls: list[PllRates]) -> Mapping[str, Fraction]:
        ready = {name: oscillator.ready for name, oscillator in self._oscillators.items()}
        clocks = {
            "HSI": self._rate_of(Source.HSI),
            "CSI": CSI_HZ,
            "HSI48": HSI48_HZ,
            "HSE": self.hse_hz,
            "LSE": LSE_HZ,
            "LSI": self.lsi_hz,
        }
        for name, one in zip(PLLS, plls, strict=True):
            clocks |= {f"{name} P": one.p, f"{name} Q": one.q, f"{name} R": one.r}
        clocks = {name: rate if ready[name.split()[0]] else Fraction(0) for name, rate in clocks.items()}
        clocks |= {"CSI/122": clocks["CSI"] / 122, "-": Fraction(0)}
        per = ("HSI", "CSI", "HSE", "-")[self[at.D1CCIPR] >> 28 & 3]
        clocks["PER"] = clocks.get(per, Fraction(0))
        clocks |= {bus: rates.hclk / divider for bus, divider in rates.dividers().items()}
        return clocks | {"SYSCLK": rates.sysclk}

    def _kernel_rates(self, clocks: Mapping[str, Fraction]) -> Mapping[str, Fraction]:
        return {name: clocks.get(self._clock_of(name), Fraction(0)) for name in KERNEL_CHOICES}

    def _check_rates(self) -> None:
        for where, text in violations(self.tree.rates, self._scale()):
            self.note("misuse", where, text)

    # --- resets, Stop mode, failure of the HSE

    def _forget_source(self) -> None:
        self._source = Source.HSI
        self._fractions = [0, 0, 0]

    def reset(self) -> None:
        """Go to the state after a reset of the chip."""
        super().reset()
        self.on_rtc_clock()

    def _stop_oscillators(self) -> None:
        self[at.CR] &= ~(at.HSEON | at.PLLON[0] | at.PLLON[1] | at.PLLON[2])
        for name in (*reversed(PLLS), "HSE", "HSI48"):
            self._oscillators[name].stop_now()
        self[at.CR] &= ~at.HSI48ON

    def _back_to_start(self) -> None:
        """Go on with HSI, or with CSI if STOPWUCK says so."""
        self._go_on_with(Source.CSI if self[at.CFGR] & at.STOPWUCK else Source.HSI)

    def _go_on_with(self, source: Source) -> None:
        self[at.CR] |= at.CSION if source is Source.CSI else at.HSION
        self[at.CFGR] = (self[at.CFGR] & ~0x3F) | source << 3 | source
        self._source = source
        self._oscillators[source.name].run_now()

    def _is_guarded(self) -> bool:
        return bool(self[at.CR] & at.HSECSSON)

    def _runs_on_hse(self) -> bool:
        source = self._pll_source() if self._source is Source.PLL1 else self._source
        return source is Source.HSE

    def _on_failure(self) -> None:
        """The clock security system acts (RM0433 section 8.5.3): off with HSE and the PLLs on it, HSI, an NMI."""
        if self._runs_on_hse():
            self._go_on_with(Source.HSI)
        if self._pll_source() is Source.HSE:
            self[at.CR] &= ~(at.PLLON[0] | at.PLLON[1] | at.PLLON[2])
        self[at.CR] &= ~at.HSEON
        self._hse.stop_now()
        self._feed_plls()
        self[at.CIFR] |= at.HSECSSF
        self._update_lines()
        self._set_tree()
        self.on_clock_failure()

    def _bypass_fits(self) -> bool:
        if not self[at.CR] & at.HSEBYP or self._hse_is_clock:
            return True
        self.note("misuse", "CR.HSEBYP", "the board has a crystal, not a clock, at OSC_IN: HSE will not become ready")
        return False


def _home(offset: int) -> int:
    """Return the offset of a register by that of its alias for CPU 1."""
    return offset - at.ALIAS if offset - at.ALIAS in at.ALIASED else offset
