"""RNG: random numbers, the same in every run (RM0410 section 22, RM0433 section 34).

A number takes 46 ticks of its clock from RNGEN on, and 42 from each read of DR on. Choices: the numbers come from a
generator that begins anew with every power-on from a seed of the chip's, so that a run can be repeated; the seed is
never faulty. A clock slower than HCLK / 16 (STM32H7: 32) is an error, as on silicon, and then no number comes; it is
looked at when RNGEN is set and when the clock changes, and a number under way then begins anew.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction
from typing import ClassVar

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services
from targets.mcu.timebase import Event

__all__ = ["Rng"]

CR, SR, DR = 0x00, 0x04, 0x08
RNGEN, IE, CED = 1 << 2, 1 << 3, 1 << 5
DRDY, CECS, SECS, CEIS, SEIS = 1 << 0, 1 << 1, 1 << 2, 1 << 5, 1 << 6
FIRST_TICKS, TICKS = 46, 42
SLOWEST = 16  # cycles of AHB per tick


class Rng(Peripheral):
    """The random number generator.

    Args:
        base: address of its first register.
        services: what the chip offers; its clock is ``RNG`` of `Clocks.kernel`.
        irq: interrupt: 80 (RM0410 table 46).
        seed: what the numbers depend on, such as the name of the board.
        slowest: cycles of AHB per tick from which on the clock is too slow.
        may_ignore: it has CED, by which a slow clock is no error.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("CR", CR, 0, RNGEN | IE | CED),
        Register("SR", SR, 0, CEIS | SEIS, fidelity=Fidelity.PARTLY, note="the seed is never faulty"),
        Register("DR", DR, 0, 0, fidelity=Fidelity.PARTLY, note="the numbers are the same in every run"),
    )

    def __init__(
        self,
        base: int,
        services: Services,
        *,
        irq: int = 80,
        seed: str = "",
        slowest: int = SLOWEST,
        may_ignore: bool = False,
    ) -> None:
        self._slowest = slowest
        self._may_ignore = may_ignore
        super().__init__("RNG", base, services)
        self._irq = services.irq(irq)
        self._seed = seed
        self._drawn = 0
        self._event: Event | None = None

    def registers_of(self) -> Iterable[Register]:
        """Return the registers, CR without CED where there is none."""
        for register in self.REGISTERS:
            leave_out = register.name == "CR" and not self._may_ignore
            yield replace(register, writable=register.writable & ~CED) if leave_out else register

    def reset(self) -> None:
        """Stop; the numbers go on where they were."""
        super().reset()
        self.time.cancel(self._event)
        self._event = None
        self._irq.set(False)

    def power_on(self) -> None:
        """Begin anew with the first number."""
        self._drawn = 0

    def after_clock_change(self) -> None:
        """Look at the new clock, and begin the number under way anew."""
        if self[CR] & RNGEN:
            self._check_clock()
            if not self[SR] & DRDY:
                self._start(TICKS)

    # --- registers

    def write_CR(self, value: int) -> None:
        """Switch it on or off; a number that is ready stays."""
        began = value & ~self[CR] & RNGEN
        self[CR] = value
        if began:
            self._check_clock()
            if not self[SR] & DRDY:
                self._start(FIRST_TICKS)
        elif not value & RNGEN:
            self.time.cancel(self._event)
            self._event = None
        self._drive_irq()

    def write_SR(self, value: int) -> None:
        """CEIS and SEIS are cleared by writing 0; writing 1 has no effect."""
        self[SR] &= value | ~(CEIS | SEIS)
        self._drive_irq()

    def read_DR(self) -> int:
        """Return the number if there is one, else 0; the next one is begun."""
        if not self[SR] & DRDY:
            self.note("misuse", "DR", "a read while DRDY is clear gives 0, which is no random number")
            return 0
        value, self[DR] = self[DR], 0
        self[SR] &= ~DRDY
        self._drive_irq()
        if self[CR] & RNGEN:
            self._start(TICKS)
        return value

    # --- numbers

    def _ticks(self) -> Fraction:
        """Return HCLK cycles per tick, 0 while the clock stands still."""
        return self.services.clocks.kernel("RNG") if self.clocked else Fraction(0)

    def _check_clock(self) -> None:
        cycles = self._ticks()
        if cycles and (cycles <= self._slowest * self.services.clocks.pclk("AHB") or self[CR] & CED):
            self[SR] &= ~CECS
        else:
            self[SR] |= CECS | CEIS
            text = f"its clock stands still or is slower than HCLK / {self._slowest}: no number comes"
            self.note("misuse", "SR.CECS", text)
        self._drive_irq()

    def _start(self, ticks: int) -> None:
        self.time.cancel(self._event)
        self._event = None
        if not self[SR] & CECS:
            cycles = ticks * self._ticks()
            self._event = self.time.after(-(-cycles.numerator // cycles.denominator), self._ready)

    def _ready(self) -> None:
        self._event = None
        self._drawn += 1
        self[DR] = self._number(self._drawn)
        self[SR] |= DRDY
        self._drive_irq()

    def _number(self, index: int) -> int:
        """Return the number of that place in the series; never zero."""
        digest = hashlib.sha256(f"{self._seed}/{index}".encode()).digest()
        return int.from_bytes(digest[:4], "little") or 1

    def _drive_irq(self) -> None:
        self._irq.set(bool(self[CR] & IE and self[SR] & (DRDY | CEIS | SEIS)))
