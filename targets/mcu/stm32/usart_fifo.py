"""USARTs with FIFOs and a prescaler (RM0433 section 48, on the STM32H7; G0, G4 and L4+ have the same).

With FIFOEN clear they are those of `usart`, but for PRESC. With FIFOEN set, 16 words wait to be sent, and 17 may have
come in: 16 in the FIFO and one in RDR. (Of USART_ISR.RXFT the manual says "the 17th received data does not cause an
overrun error".)

Choices where the manual is silent:

* PE, FE and NF of a word are set when RDR shows it, and stay until they are cleared by ICR.
* A word written to a full FIFO is lost; that is noted.
* TXFT is clear while UE is, as the value after reset has it; TXFE is set then, if FIFOEN is.
* TXFE that was cleared by TXFECF is set again when the FIFO becomes empty the next time.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import replace
from fractions import Fraction
from typing import Any, ClassVar

from targets.mcu.registers import Register
from targets.mcu.services import Services
from targets.mcu.stm32 import usart
from targets.mcu.stm32.usart import CR1, CR2, CR3, ISR, OVRDIS, RDR, RXFRQ, RXNE, TXE, TXFRQ, UE, Usart

__all__ = ["FifoUsart"]

PRESC = 0x2C
FIFOEN, TXFEIE, RXFFIE = 1 << 29, 1 << 30, 1 << 31
TXFTIE, TCBGTIE, RXFTIE = 1 << 23, 1 << 24, 1 << 28
SLVEN, DIS_NSS = 1 << 0, 1 << 3
TXFE, RXFF, TCBGT, RXFT, TXFT = (1 << bit for bit in range(23, 28))
TXFECF, TCBGTCF, UDRCF = 1 << 5, 1 << 7, 1 << 13  # of ICR

_LEVELS = RXNE | TXE | RXFF | RXFT | TXFT
TX_WORDS, RX_WORDS = 16, 17
THRESHOLDS = (2, 4, 8, 12, 14, 16)
"""Words received, or places that are empty, by RXFTCFG and TXFTCFG: an eighth of the FIFO, a quarter, ..., all."""
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
    ENABLES: ClassVar = {
        **Usart.ENABLES,
        CR1: Usart.ENABLES[CR1] | TXFEIE | RXFFIE,
        CR3: Usart.ENABLES[CR3] | TXFTIE | RXFTIE | 7 << 25 | 7 << 29,
    }
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
        self._received: deque[tuple[int, int]] = deque()
        self._to_send: deque[int] = deque()  # behind the word that the transmitter holds
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
        self._received.clear()
        self._to_send.clear()

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

    # --- sending

    def write_TDR(self, value: int) -> None:
        """Put a word at the end of what is to be sent."""
        if not self._has_fifos or not self[CR1] & UE or not self._kept.holds:
            self[ISR] &= ~TXFE
            super().write_TDR(value)
        elif self._waiting == TX_WORDS:
            self.note("misuse", "TDR", "written while the FIFO is full: the word is lost")
        else:
            self._to_send.append(self._encoded(value))
            self._update()

    @property
    def _waiting(self) -> int:
        return len(self._to_send) + bool(self._kept.holds)

    def _loaded(self) -> None:
        if self._to_send:
            self._kept.holding, self._kept.holds = self._to_send.popleft(), True
        elif self._has_fifos:
            self[ISR] |= TXFE
        super()._loaded()

    # --- receiving

    def _keep(self, word: int, errors: int) -> bool:
        if not self._has_fifos or self[CR3] & OVRDIS:
            return super()._keep(word, errors)
        if self._is_full():
            return False
        self._received.append((word, errors))
        if len(self._received) == 1:
            self._show_first()
        return True

    def _is_full(self) -> bool:
        if not self._has_fifos or self[CR3] & OVRDIS:
            return super()._is_full()
        return len(self._received) == RX_WORDS

    def _show_first(self) -> None:
        word, errors = self._received[0]
        self[RDR] = word
        self[ISR] |= RXNE | errors

    def read_RDR(self) -> int:
        """Return the oldest word and go on to the next."""
        word = self[RDR]
        self[ISR] &= ~RXNE
        if self._received:
            self._received.popleft()
            if self._received:
                self._show_first()
                self.time.cut()  # the next read gives another word: this is no loop to pass over
        self._update()
        return word

    def write_RQR(self, value: int) -> None:
        """Ask for a break, mute mode, or that all received or waiting data be thrown away."""
        if value & RXFRQ:
            self._received.clear()
        if value & TXFRQ:
            self._to_send.clear()
            self[ISR] |= TXFE if self._has_fifos else 0
        super().write_RQR(value)

    # --- flags and lines

    def write_ICR(self, value: int) -> None:
        """Clear flags by writing 1; those of the FIFOs stand at other bits than in ISR."""
        if value & TXFECF:
            self[ISR] &= ~TXFE
        if value & TCBGTCF:
            self[ISR] &= ~TCBGT
        super().write_ICR(value & usart.CLEARED_BY_ICR)

    def _update(self) -> None:
        if self._has_fifos:
            self[ISR] = self[ISR] & ~_LEVELS | self._levels_of_fifos()
        super()._update()

    def _levels_of_fifos(self) -> int:
        control = self[CR3]
        # With OVRDIS the FIFO is passed by: RXNE tells of RDR alone (RM0433, USART_CR3).
        received = len(self._received) or bool(self[ISR] & RXNE)
        empty = TX_WORDS - self._waiting
        return (
            (RXNE if received else 0)
            | (RXFF if received == RX_WORDS else 0)
            | (RXFT if received >= _threshold(control >> 25) else 0)
            | (TXE if empty else 0)
            | (TXFT if self[CR1] & UE and empty >= _threshold(control >> 29) else 0)
        )

    def _serves_unseen(self, cr1: int, cr2: int, cr3: int) -> bool:
        # A read of RDR shows the next word with its errors, and levels may pass their thresholds.
        return not cr1 & FIFOEN and super()._serves_unseen(cr1, cr2, cr3)

    def _flags_that_interrupt(self, cr1: int, cr2: int, cr3: int) -> int:
        return (
            super()._flags_that_interrupt(cr1, cr2, cr3)
            | (TXFE if cr1 & TXFEIE else 0)
            | (RXFF if cr1 & RXFFIE else 0)
            | (RXFT if cr3 & RXFTIE else 0)
            | (TXFT if cr3 & TXFTIE else 0)
        )


def _threshold(field: int) -> int:
    return THRESHOLDS[min(field & 7, len(THRESHOLDS) - 1)]
