"""An I2C interface of the STM32F1 as a slave (RM0008 section 26.3.2), event by event: EV1 to EV4.

Another interface on the same two wires is the master. Its bus calls `Ear` for each condition, and for each byte at its
ninth clock. While the slave has nothing to send (EV1, EV3_1, BTF) or no room for what comes (BTF), it holds SCL low;
with NOSTRETCH it does not, and OVR says what is lost or sent twice.

Choices where the manual is silent:

* Without ACK no address is answered, and ADDR is not set.
* After a byte that either side has not acknowledged, the slave has no part in the message: no STOPF follows.
* What is in DR when a message ends, or was not acknowledged, is not sent in the next one.
* STOP while SCL is held lets go of it at once.
* A master that lets go of the bus without a STOP leaves it free.
* A START while the other master makes its own counts as one of both at the same cycle alone; else it waits.
"""

from __future__ import annotations

import abc

from targets.mcu.stm32f1.i2c_addresses import ALERT_RESPONSE, header_matches, own_address, second_byte
from targets.mcu.stm32f1.i2c_block import Block
from targets.mcu.stm32f1.i2c_registers import (
    ACK,
    ADDMODE,
    ADDR,
    ADDRESS,
    AF,
    BTF,
    BUSY,
    CR1,
    DR,
    ENDUAL,
    ENGC,
    MSL,
    NOSTRETCH,
    OAR1,
    OAR2,
    OF_A_MESSAGE,
    OVR,
    PE,
    PEC_VALUE,
    RXNE,
    SMBALERT,
    SMBUS,
    SR1,
    SR2,
    STOP,
    STOPF,
    TRA,
    TXE,
)
from targets.mcu.stm32f1.i2c_smbus import LOW_NS, SLAVE_NS

__all__ = ["Ear", "Slave"]

_ALONE = "no master reaches this slave: only another I2C interface of its chip can, wired to both of its pins"


class Ear:
    """What another master's bus has of a slave: `targets.mcu.i2c_bus.I2cInterface`, without the times.

    Args:
        slave: whose it is.
    """

    def __init__(self, slave: Slave) -> None:
        self._slave = slave

    def started(self, _now_ns: int) -> None:
        """A START, or a repeated one."""
        self._slave.heard_start()

    def address(self, address: int, read: bool, _now_ns: int) -> bool:
        """Return whether to acknowledge an address."""
        return self._slave.was_addressed(address, read)

    def write(self, byte: int, _now_ns: int) -> bool:
        """Return whether to acknowledge a byte."""
        return self._slave.was_written(byte)

    def read(self, _now_ns: int) -> int:
        """Return the next byte."""
        return self._slave.is_read()

    def answered(self, acknowledged: bool, _now_ns: int) -> None:
        """The byte was acknowledged, or not."""
        self._slave.was_answered(acknowledged)

    def end(self, _now_ns: int) -> None:
        """The message is over; a START or a STOP follows at once."""

    def paused(self, low: bool) -> None:
        """The master holds SCL low, or does not any more."""
        self._slave.heard_pause(low)

    def stopped(self, _now_ns: int) -> None:
        """A STOP."""
        self._slave.heard_stop()

    def released(self, _now_ns: int) -> None:
        """The master has let go of both lines."""
        self._slave.heard_release()


class Slave(Block):
    """See the module; the arguments are those of `Block`."""

    def _forget(self) -> None:
        super()._forget()
        self._addressed = False  # takes part in the message
        self._header = False  # the first byte of its 10-bit address has come
        self._known = False  # its 10-bit address has come since the first START
        self._empty = False  # the shift register is, of a transmitter
        self._hears = False  # another master is on the bus
        self._paused = False  # which holds SCL low between two bytes
        self._has_lost = False  # to that one, since the last START: no address is answered

    # --- what the other master does

    def heard_start(self) -> None:
        """A START, or a repeated one: a message ends, and another one may begin."""
        if not self._hears:
            self._known = False
            self._set_state(PEC_VALUE, 0)
        self._end_message()
        self._hears, self._has_lost = True, False
        self._own_low.restart()
        self._set_state(BUSY, BUSY)
        self._update()

    def was_addressed(self, address: int, read: bool) -> bool:
        """Return whether to acknowledge an address: EV1, or the header of one of ten bits."""
        control = self[CR1]
        if not self.clocked or control & (PE | ACK) != PE | ACK or self[SR2] & MSL or self._has_lost:
            return False
        byte = address << 1 | read
        if header_matches(self[OAR1], address):
            if not read:
                self._header = True
                self._count(byte)
                return True
            return self._known and self._match(0, byte)
        self._known = False
        found = own_address(control, self[OAR1], self[OAR2], address, read)
        if found is None:
            return False
        if address == ALERT_RESPONSE and control & SMBUS:
            self[SR1] |= SMBALERT
        return self._match(found, byte)

    def _match(self, state: int, byte: int) -> bool:
        self._count(byte)
        self._addressed = True
        self._saw = 0
        self[SR1] |= ADDR
        self._set_state(OF_A_MESSAGE, state | (TRA if byte & 1 and not self._header else 0))
        self._header = False
        self._update()
        return True

    def was_written(self, byte: int) -> bool:
        """Take a byte, EV2, or the second one of an address; return whether to acknowledge it."""
        if self._header:
            self._known = byte == second_byte(self[OAR1]) and bool(self[CR1] & ACK)
            if not self._known:
                self._header = False
                return False
            return self._match(0, byte)
        if not self._addressed:
            return False
        acknowledge = self._answer(byte)
        if self[SR1] & RXNE and self[CR1] & NOSTRETCH:
            self[SR1] |= OVR
        else:
            self._keep(byte)
        if not acknowledge or self[CR1] & STOP:
            self._addressed = False
        self._update()
        return acknowledge

    def is_read(self) -> int:
        """Return what is sent next: of DR, the PEC, or without stretching the same again."""
        byte = self._next_byte()
        if byte is None:
            self[SR1] |= OVR
            byte = self._leaving = self[DR]
        self._empty = False
        self._update()
        return byte

    def was_answered(self, acknowledged: bool) -> None:
        """The master has acknowledged the byte, or not: EV3 goes on, or EV3_2."""
        self._gone()
        if not acknowledged:
            self[SR1] |= AF
        if not acknowledged or self[CR1] & STOP:
            self._addressed = False
        else:
            self._empty = True
            if self._waiting is None and not self._pec_is_next:
                self[SR1] |= TXE | (0 if self[CR1] & NOSTRETCH else BTF)
        self._update()

    def heard_pause(self, low: bool) -> None:
        """The master holds SCL low, or does not any more."""
        if low is not self._paused:
            self._paused = low
            self._update()

    def heard_stop(self) -> None:
        """A STOP: EV4, if this was a message for the interface."""
        if self._addressed:
            self[SR1] |= STOPF
            self._saw = 0
        self[CR1] &= ~STOP
        self._bus_free()

    def heard_release(self) -> None:
        """The master has let go of both lines."""
        self._bus_free()

    def _bus_free(self) -> None:
        self._end_message()
        self._hears = self._known = self._has_lost = self._paused = False
        self._freed()
        self._update()

    def _end_message(self) -> None:
        if self[SR2] & TRA:
            self[SR1] &= ~(TXE | BTF)
            self._waiting = None
        self._addressed = self._header = self._empty = False
        self._forget_pec()
        self._set_state(OF_A_MESSAGE, 0)

    @abc.abstractmethod
    def _freed(self) -> None:
        """The other master has left the bus: BUSY ends, and START is heard."""

    # --- what the program does

    def _clear_own_addr(self) -> None:
        """ADDR was cleared: EV3_1 for a transmitter."""
        if self[SR2] & TRA:
            self._empty = True
            if self._waiting is None and not self._pec_is_next:
                self[SR1] |= TXE

    def _expects(self) -> None:
        """Note it if the interface waits to be addressed where no master can reach it."""
        own = self[OAR1] & (ADDMODE | ADDRESS) or self[OAR2] & ENDUAL or self[CR1] & ENGC
        if own and self[CR1] & ACK and not self[SR2] & MSL and not self.bus.joined():
            self.note("unmodelled", "OAR1", _ALONE)

    def _leave(self) -> None:
        """STOP was set: let go of the lines, unless a byte is under way."""
        if self._holds:
            self._addressed = False

    # --- SCL

    @property
    def _holds(self) -> bool:
        """Whether SCL is held low."""
        if not self._addressed or self[CR1] & NOSTRETCH:
            return False
        idle = self[SR2] & TRA and self._empty and self._waiting is None and not self._pec_is_next
        return bool(self[SR1] & ADDR or self._shifted is not None or idle)

    def _update(self) -> None:
        holds = self._holds
        if not self[SR2] & MSL:
            self._watch_own(holds)
        self.bus.hold(holds)
        super()._update()

    def _watch_own(self, holds: bool) -> None:
        limited = self[CR1] & (SMBUS | PE) == SMBUS | PE
        if limited and (holds or self._paused):
            self._low.hold(LOW_NS)
        else:
            self._low.restart()
        if limited and holds:
            self._own_low.hold(SLAVE_NS)
        else:
            self._own_low.pause()

    def _reset_communication(self) -> None:
        """What a timeout does to a slave."""
        self._addressed = self._empty = False
        self[SR1] &= ~(ADDR | BTF | TXE)
        self._set_state(OF_A_MESSAGE, 0)
