"""The low-power UART of the STM32H7 (RM0433 section 49; G0, G4 and L4+ have the same).

A USART with FIFOs whose rate is 256 times the kernel clock divided by BRR; it lacks oversampling by 8, timeout, LIN,
IrDA, smartcard and synchronous modes, and measuring the rate. Choice: it samples as a USART does that oversamples by
16.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any, ClassVar

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.stm32.usart import BRR, CR1, CR2, CR3, ICR, ISR, RQR
from targets.mcu.stm32.usart_fifo import FifoUsart

__all__ = ["LowPowerUart"]

_LEAST_DIVIDER = 0x300  # RM0433, LPUART_BRR
_WRITABLE = {
    CR1: 0xF3FF_7FFF,
    CR2: 0xFF0F_B010,
    CR3: 0xFEF0_F7C9,
    BRR: 0x000F_FFFF,
    RQR: 0x1E,
    ICR: 0x0012_027F,
}
_NOTES = {
    CR1: "waking up from Stop mode (UESM) is not modelled",
    CR3: "driver enable (DEM) and waking up from Stop mode are not modelled",
    ISR: "WUF is never set",
}
_AFTER_RESET = 0xC0
_ABSENT = {"GTPR", "RTOR"}


def _own(register: Register) -> Register:
    """Return a register without the bits that are not there."""
    writable = _WRITABLE.get(register.offset, register.writable)
    note = _NOTES.get(register.offset, "")
    return replace(
        register,
        reset=_AFTER_RESET if register.offset == ISR else register.reset,
        writable=writable,
        ignored=register.ignored & writable,
        fidelity=Fidelity.PARTLY if note else Fidelity.MODELLED,
        note=note,
    )


class LowPowerUart(FifoUsart):
    """The LPUART; see `FifoUsart`."""

    REGISTERS = tuple(_own(register) for register in FifoUsart.REGISTERS if register.name not in _ABSENT)
    LOCKED: ClassVar[Any] = {**FifoUsart.LOCKED, BRR: 0x000F_FFFF}
    LEAST_DIVIDER = "0x300 is the least value"

    def _divider(self) -> int | Fraction:
        """Return ticks of the kernel clock in a bit; 0 if BRR is no rate."""
        return Fraction(self[BRR], 256) if self[BRR] >= _LEAST_DIVIDER else 0
