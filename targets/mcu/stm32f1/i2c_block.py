"""What an I2C interface of the STM32F1 has as a master and as a slave alike: flags, DR, packet error code, lines, SMBA.

Packet error code (RM0008 section 26.3.8): it counts each byte at its ninth clock, begins anew at a START that is no
repeated one, and stays readable after the STOP (choices). The byte that is the PEC is not counted (choice). One that is
to be sent follows what is in DR; by DMA it follows the last byte of the channel, and the last byte that a channel takes
is one. POS makes the byte after the present one the PEC, never the first one after ADDR.

ACK counts as it stands at the ninth clock; with POS as it stood at that of the byte before, and for the first byte at
the moment at which ADDR was cleared (choices).
"""

from __future__ import annotations

import abc
from collections.abc import Callable
from typing import ClassVar

from targets.mcu.i2c_bus import I2cBus
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services
from targets.mcu.stm32.i2c_message import crc8
from targets.mcu.stm32f1.i2c_registers import (
    ACK,
    ADDR,
    BTF,
    CR1,
    CR2,
    DMAEN,
    DR,
    ENPEC,
    ERRORS,
    EVENTS,
    ITBUFEN,
    ITERREN,
    ITEVTEN,
    LAST,
    MSL,
    PEC,
    PEC_SHIFT,
    PEC_VALUE,
    PECERR,
    POS,
    REGISTERS,
    RXNE,
    SMBALERT,
    SR1,
    SR2,
    TXE,
)
from targets.mcu.stm32f1.i2c_smbus import AlertPin, LowLimit

__all__ = ["Block"]


class Block(Peripheral, abc.ABC):
    """See the module.

    Args:
        name: ``I2C1``.
        base: address of CR1.
        services: what the chip offers. Used: both interrupts, requests ``I2C1_RX`` and ``I2C1_TX``, the signals
            ``I2C1_SCL``, ``I2C1_SDA`` and ``I2C1_SMBA``.
        irq: number of the event interrupt; that of errors is the next one.
        rx_left: returns how many bytes DMA has still to fetch, for LAST and the PEC,
        tx_left: and to bring, before the transfer under way; for the PEC.

    Attributes:
        bus: where it is the master, or a slave.
        held_low: returns which of its lines something outside of the bus holds low, or nothing.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = REGISTERS

    def __init__(
        self,
        name: str,
        base: int,
        services: Services,
        *,
        irq: int,
        rx_left: Callable[[], int] = lambda: 0,
        tx_left: Callable[[], int] = lambda: 0,
    ) -> None:
        super().__init__(name, base, services)
        self.bus = I2cBus()
        self.held_low: Callable[[], str] = lambda: ""
        self._pins = (services.output(f"{name}_SCL"), services.output(f"{name}_SDA"))
        self._irq_event, self._irq_error = services.irq(irq), services.irq(irq + 1)
        self._tx_request, self._rx_request = services.dma(f"{name}_TX"), services.dma(f"{name}_RX")
        self._rx_left, self._tx_left = rx_left, tx_left
        self._alert = AlertPin(name, services, self._alerted)
        self._low, self._own_low = LowLimit(self.time, self._timed_out), LowLimit(self.time, self._timed_out)
        self._lines = (False, False, False, False)
        self._forget()

    def _forget(self) -> None:
        self._saw: int = 0  # flags that the last read of SR1 has shown
        self._sr1_read = False  # since the last read of SR2
        self._waiting: int | None = None  # what was written to DR and is not on its way yet
        self._shifted: int | None = None  # a byte that came in while DR was full
        self._leaving: int | None = None  # the byte that is being sent; None for the PEC
        self._next_ack = self._next_pec = False  # what POS has kept of ACK and PEC
        self._pec_by_dma = False  # the PEC follows, for DMA has brought its last byte
        self._pec_wrong = False

    # --- registers

    def write_CR2(self, value: int) -> None:
        """Enable interrupts and requests; say what PCLK1 is."""
        self[CR2] = value
        self._update()

    def read_SR1(self) -> int:
        """Return the flags; ADDR, SB, ADD10, BTF and STOPF are cleared by what follows this."""
        self._saw, self._sr1_read = self[SR1], True
        return self[SR1]

    def write_SR1(self, value: int) -> None:
        """Clear error flags by writing 0."""
        self[SR1] &= value | ~ERRORS
        self._update()

    def _set_state(self, mask: int, value: int) -> None:
        """Put these bits of SR2 in the place of those."""
        self[SR2] = self[SR2] & ~mask | value

    # --- bytes

    def _clear_addr(self) -> None:
        self[SR1] &= ~ADDR
        self._next_ack, self._next_pec = bool(self[CR1] & ACK), False

    def _fill(self, value: int) -> None:
        """DR was written by a transmitter."""
        self._waiting = value
        self._pec_by_dma = self._pec_with_dma and self._tx_left() == 1
        self[SR1] &= ~(TXE | BTF)

    def _next_byte(self) -> int | None:
        """Take what is sent next, of DR or the PEC; None if there is nothing."""
        if self._waiting is not None:
            self._leaving, self._waiting = self._waiting, None
            if not self._pec_is_next:
                self[SR1] |= TXE
            return self._leaving
        if not self._pec_is_next:
            return None
        self._leaving = None
        self._forget_pec()
        self[SR1] &= ~(TXE | BTF)
        return self[SR2] >> PEC_SHIFT

    def _gone(self) -> None:
        """A byte was sent."""
        if self._leaving is not None:
            self._count(self._leaving)

    def _answer(self, byte: int) -> bool:
        """Return whether a byte that comes in is to be acknowledged; compare it if it is the PEC."""
        control = self[CR1]
        acknowledge, is_pec = bool(control & ACK), bool(control & PEC)
        if control & POS:
            acknowledge, is_pec = self._next_ack, self._next_pec
        self._next_ack, self._next_pec = bool(control & ACK), bool(control & PEC)
        if self[CR2] & DMAEN and self._rx_left() - bool(self[SR1] & RXNE) == 1:
            acknowledge = acknowledge and not (self[CR2] & LAST and self[SR2] & MSL)
            is_pec = is_pec or self._pec_with_dma
        self._pec_wrong = is_pec and byte != self[SR2] >> PEC_SHIFT
        if is_pec:
            self._forget_pec()
        else:
            self._count(byte)
        return acknowledge and not self._pec_wrong

    def _keep(self, byte: int) -> None:
        """Put a byte that has come in where there is room."""
        if self._pec_wrong:
            self[SR1] |= PECERR
        if self[SR1] & RXNE:
            self._shifted = byte
            self[SR1] |= BTF
        else:
            self[DR] = byte
            self[SR1] |= RXNE

    def _take(self) -> None:
        """DR was read: a byte that waits behind it comes in."""
        self[SR1] &= ~(RXNE | BTF)
        held, self._shifted = self._shifted, None
        if held is not None:
            self[DR] = held
            self[SR1] |= RXNE

    # --- packet error code

    def _count(self, byte: int) -> None:
        if self[CR1] & ENPEC:
            self._set_state(PEC_VALUE, crc8(self[SR2] >> PEC_SHIFT ^ byte) << PEC_SHIFT)

    @property
    def _pec_with_dma(self) -> bool:
        return bool(self[CR1] & ENPEC and self[CR2] & DMAEN)

    @property
    def _pec_is_next(self) -> bool:
        """Whether the PEC follows what is in DR and in the shift register."""
        return bool(self[CR1] & PEC) or self._pec_by_dma

    def _forget_pec(self) -> None:
        self[CR1] &= ~PEC
        self._pec_by_dma = False

    # --- SMBus

    def _alerted(self) -> None:
        """SMBA fell, at a host."""
        self[SR1] |= SMBALERT
        self._update()

    @abc.abstractmethod
    def _timed_out(self) -> None:
        """SCL was low for too long."""

    # --- lines

    def _update(self) -> None:
        flags, enables = self[SR1], self[CR2]
        dma = bool(enables & DMAEN)
        lines = (
            bool(enables & ITEVTEN and (flags & EVENTS or (enables & ITBUFEN and flags & (RXNE | TXE)))),
            bool(enables & ITERREN and flags & ERRORS),
            bool(dma and flags & TXE),
            bool(dma and flags & RXNE),
        )
        if lines != self._lines:
            self._lines = lines
            event, error, tx, rx = lines
            self._irq_event.set(event)
            self._irq_error.set(error)
            self._tx_request.set(tx)
            self._rx_request.set(rx)
