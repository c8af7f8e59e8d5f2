"""USARTs with FIFOs and a prescaler (RM0433 section 48, on the STM32H7; G0, G4 and L4+ have the same).

The FIFOs are in ``usart_isr.c``. With FIFOEN clear these are the USARTs of `usart`, but for PRESC. With FIFOEN set, 16
words wait to be sent, and 17 may have come in: 16 in the FIFO and one in RDR. (Of USART_ISR.RXFT the manual says "the
17th received data does not cause an overrun error".)

Choices where the manual is silent:

* PE, FE and NF of a word are set when RDR shows it, and stay until they are cleared by ICR.
* A word written to a full FIFO is lost; that is noted.
* TXFE is set while UE is clear, if FIFOEN is set.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from fractions import Fraction
from typing import Any, ClassVar

from targets.mcu.registers import Register
from targets.mcu.services import Services
from targets.mcu.stm32 import usart
from targets.mcu.stm32.usart import CR1, CR2, ISR, TXFRQ, UE, Usart

__all__ = ["FifoUsart"]

PRESC = 0x2C
FIFOEN = 1 << 29
TCBGTIE = 1 << 24
SLVEN, DIS_NSS = 1 << 0, 1 << 3
TXFE, TCBGT = 1 << 23, 1 << 25
TXFECF, TCBGTCF, UDRCF = 1 << 5, 1 << 7, 1 << 13  # of ICR

PRESCALERS = (1, 2, 4, 6, 8, 10, 12, 16, 32, 64, 128, 256)
"""By PRESC; the values that are not allowed stand for the last one (RM0433, USART_PRESC)."""


def _registers() -> tuple[Register, ...]:
    """What differs from the USART without FIFOs."""
    by_name = {register.name: register for register in Usart.REGISTERS}
    changed: dict[str, dict[str, Any]] = {
        "CR1": {"writable": 0xFFFF_FFFF},
        "CR2": {
            "writable": 0xFFFF_FF79,
            "ignored": by_name["CR2"].ignored | SLVEN | DIS_NSS,
            "note": "no clock is put out or taken (CLKEN, SLVEN), and the rate is not measured (ABREN)",
        },
        "CR3": {
            "writable": 0xFFFE_FFFF,
            "ignored": usart.IREN | usart.SCEN | usart.DEM | usart.WUFIE | TCBGTIE,
        },
        "ISR": {"reset": usart.AFTER_RESET | TCBGT, "note": "EOBF, UDR, ABRE, ABRF and WUF are never set"},
        "ICR": {"writable": usart.CLEARED_BY_ICR | TXFECF | TCBGTCF | UDRCF},
    }
    return (
        *(replace(register, **changed.get(name, {})) for name, register in by_name.items()),
        Register("PRESC", PRESC, writable=0xF),
    )


class FifoUsart(Usart):
    """A USART or UART with FIFOs; see `Usart`.

    Args:
        name: ``USART3`` or ``UART4``.
        base: address of CR1.
        services: what the chip offers.
        irq: number of its interrupt.
        kernel_hz: returns the rate of the clock that PRESC and BRR divide; 0 while it stands still.
        synchronous: it is a USART, with smartcard mode and a clock; a UART has neither.
    """

    REGISTERS = _registers()
    LOCKED: ClassVar = {
        **Usart.LOCKED,
        CR1: Usart.LOCKED[CR1] | FIFOEN,
        CR2: Usart.LOCKED[CR2] | SLVEN,
        PRESC: 0xF,
    }

    def __init__(
        self,
        name: str,
        base: int,
        services: Services,
        *,
        irq: int,
        kernel_hz: Callable[[], Fraction],
        synchronous: bool = True,
    ) -> None:
        self._synchronous = synchronous
        super().__init__(name, base, services, irq=irq, kernel_hz=kernel_hz)

    def registers_of(self) -> Iterable[Register]:
        """Return the registers; without smartcard mode TCBGT is reserved."""
        for register in self.REGISTERS:
            reserved = register.name == "ISR" and not self._synchronous
            yield replace(register, reset=usart.AFTER_RESET) if reserved else register

    def reset(self) -> None:
        """Go to the state after reset."""
        self._flush()
        super().reset()

    def _flush(self) -> None:
        self._kept.unread = self._kept.unsent = 0

    @property
    def _has_fifos(self) -> bool:
        return bool(self._values[CR1] & FIFOEN)

    # --- configuration

    def write_PRESC(self, value: int) -> None:
        """Divide the kernel clock before BRR does."""
        self.before_clock_change()
        self[PRESC] = self._permitted(PRESC, value)
        self.after_clock_change()

    def _bit_cycles(self) -> int | Fraction:
        return super()._bit_cycles() * PRESCALERS[min(self[PRESC], len(PRESCALERS) - 1)]

    def write_CR1(self, value: int) -> None:
        """Enable, disable, frame, and choose FIFOs while UE is clear."""
        before = self[CR1]
        super().write_CR1(value)
        if (before ^ self[CR1]) & FIFOEN:
            self[ISR] = self[ISR] & ~TXFE | (TXFE if self._has_fifos else 0)
            self._update()

    def _stop(self) -> None:
        self._flush()
        super()._stop()
        if self._has_fifos:
            self[ISR] |= TXFE

    # --- flags and data

    def write_TDR(self, value: int) -> None:
        """Lose a word that C does not take."""
        if self[CR1] & UE:
            self.note("misuse", "TDR", "written while the FIFO is full: the word is lost")
            return
        self[ISR] &= ~TXFE
        super().write_TDR(value)

    def write_RQR(self, value: int) -> None:
        """Ask for a break, mute mode, or that all received or waiting data be thrown away."""
        if value & TXFRQ and self._has_fifos:
            self[ISR] |= TXFE
        super().write_RQR(value)
