"""I2C1 and I2C2 of the STM32F103 (RM0008 section 26): here as masters, event by event as drivers poll them.

What happens on the wires, and when, is `targets.mcu.stm32.i2c_wire`'s, as for the later families. Here is what SR1 and
SR2 say of it: EV5 (SB), EV6 (ADDR), EV8 (TXE), EV8_2 (BTF), EV7 (RXNE), EV9 (ADD10), and how each is cleared. Between
two of them SCL stays low for as long as the program takes. Slaves: `targets.mcu.stm32f1.i2c_slave`.

Choices where the manual is silent:

* SCL is high and low for what CCR says, edges take no time: TRISE is kept without effect.
* After a byte that was not acknowledged the master holds SCL low until START or STOP.
* PE that is cleared in the middle of a transfer lets go of both lines at once.
* A bus whose SDA something holds low is busy, until that is over or the interface was reset.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction

from targets.mcu.services import Services
from targets.mcu.stm32.i2c_levels import I2cLevels
from targets.mcu.stm32.i2c_timing import Timing
from targets.mcu.stm32.i2c_wire import Wire
from targets.mcu.stm32f1.i2c_registers import (
    ADD10,
    ADDR,
    AF,
    ARLO,
    BERR,
    BTF,
    BUSY,
    CCR,
    CLEARED_WITHOUT_PE,
    CR1,
    CR2,
    DR,
    ENPEC,
    FREQ,
    MSL,
    PE,
    PEC_VALUE,
    RXNE,
    SB,
    SMBUS,
    SR1,
    SR2,
    START,
    STOP,
    STOPF,
    SWRST,
    TIMEOUT,
    TRA,
    TXE,
)
from targets.mcu.stm32f1.i2c_slave import Ear, Slave
from targets.mcu.stm32f1.i2c_smbus import LOW_NS, MASTER_NS

__all__ = ["I2c"]

_HEADER, _HEADER_MASK = 0xF0, 0xF8


class I2c(Slave):
    """One of them; the arguments are those of `targets.mcu.stm32f1.i2c_block.Block`."""

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
        super().__init__(name, base, services, irq=irq, rx_left=rx_left, tx_left=tx_left)
        self.bus.interface = Ear(self)
        self.bus.on_stuck.append(self._stuck_changed)
        self._wire = self._make_wire()

    def _make_wire(self) -> Wire:
        wire = Wire(self.time, self.bus)
        wire.on_started = self._started
        wire.on_sent = self._sent
        wire.on_byte = self._byte_in
        wire.on_received = self._received
        wire.on_stop = self._stopped
        wire.on_clock = self._clocked
        wire.on_lost = self._lost
        return wire

    def _forget(self) -> None:
        super()._forget()
        self._refused = False  # the last byte was not acknowledged, either way
        self._address_bytes = 0  # of a 10-bit address that are still to come
        self._in_data = False  # the address is through
        self._arrived = 0  # the byte whose ninth clock is under way

    # --- for who looks at it

    def draw(self, on_edge: Callable[[str, int, bool], None]) -> None:
        """Have `on_edge` called with ``scl`` or ``sda``, bench time in ns and level, from now on, in order of time."""
        self._wire.levels = I2cLevels(lambda line, at, level: on_edge(line, self.time.ns(math.ceil(at)), level))

    def undrawn_ns(self) -> int | None:
        """Return the bench time from which on edges are still to be drawn; None if there are none."""
        since = self._wire.undrawn
        return None if since is None else self.time.ns(math.ceil(since))

    def disturb(self, error: str) -> None:
        """Have a fault of the bus seen: ``BERR`` (a misplaced condition), which changes nothing, or ``ARLO``."""
        if error == "ARLO":
            self._wire.release()
            self._lost()
        else:
            self[SR1] |= BERR
            self._update()

    # --- what the chip calls

    def reset(self) -> None:
        """Go to the state after reset; the bus is let go."""
        super().reset()
        self._break_off()
        self._set_timing()

    def after_clock_change(self) -> None:
        """Go on at the new rate."""
        self._set_timing()

    def _set_timing(self) -> None:
        pclk = self.services.clocks.pclk("APB1") if self.clocked else 0
        ccr, value = self[CCR], max(self[CCR] & 0xFFF, 1)
        fast = ccr & 1 << 15
        low, high = (1, 1) if not fast else (16, 9) if ccr & 1 << 14 else (2, 1)
        low, high = low * value, high * value
        timing = Timing(cycles=pclk, low=low, high=high, hold=high, restart=low + high, free=low)
        self._wire.set_timing(timing if pclk else None)

    def _break_off(self) -> None:
        self._wire.release()
        self._forget()
        self._hears = self.bus.master is not None
        self[CR1] &= ~CLEARED_WITHOUT_PE
        self[SR1] = 0
        self[SR2] = BUSY if self._hears else 0
        self._clocked()
        self._alert.update(self[CR1])
        self._stuck_changed()
        self._update()

    # --- registers

    def write_CR1(self, value: int) -> None:
        """Switch on and off; ask for START, STOP; acknowledge or not; be reset."""
        before = self[CR1]
        if self[SR1] & self._saw & STOPF:
            self[SR1] &= ~STOPF
        if value & SWRST:
            self.reset()
            self[CR1] = SWRST
            return
        self[CR1] = value | before & (START | STOP) if value & before & PE else value
        if not value & PE:
            if before & PE:
                self._break_off()
            self[CR1] = value & ~CLEARED_WITHOUT_PE
        elif not before & PE:
            self._switched_on()
        if not self[CR1] & ENPEC:
            self._set_state(PEC_VALUE, 0)
        self._alert.update(self[CR1])
        if value & STOP and not self[SR2] & MSL:
            self._leave()
        self._expects()
        self._proceed()
        self._update()

    def _switched_on(self) -> None:
        pclk1_hz = self.time.hclk_hz / max(self.services.clocks.pclk("APB1"), 1)
        if Fraction(self[CR2] & FREQ) * 1_000_000 != pclk1_hz:
            mhz = f"{float(pclk1_hz) / 1e6:g} MHz"
            self.note(
                "misuse", "CR2.FREQ", f"is {self[CR2] & FREQ}, and PCLK1 is {mhz}: set-up and hold times are wrong"
            )
        self._stuck_changed()

    def write_CCR(self, value: int) -> None:
        """Set the bit clock."""
        if self[CR1] & PE and value != self[CCR]:
            self.note("misuse", "CCR", "may only be written while PE is 0")
        self[CCR] = value
        self._set_timing()

    def read_SR2(self) -> int:
        """Return the state of the bus; after a read of SR1 this clears ADDR, even if that did not show it yet."""
        sr1_read, self._sr1_read = self._sr1_read, False
        if self[SR1] & ADDR and sr1_read:
            self._clear_addr()
            if not self[SR2] & MSL:
                self._clear_own_addr()
            elif self[SR2] & TRA:
                self[SR1] |= TXE
            self._proceed()
            self._update()
        return self[SR2]

    def read_DR(self) -> int:
        """Return the byte that came in last; one that waits behind it comes in then, and the bus goes on."""
        value = self[DR]
        if self[SR1] & RXNE:
            self._take()
            self._proceed()
            self._update()
        return value

    def write_DR(self, value: int) -> None:
        """Send an address after SB, the second byte of one after ADD10, or a byte."""
        if not self[SR2] & (MSL | TRA):
            self.note("misuse", "DR", "written by neither a master nor a slave that sends: the byte goes nowhere")
            return
        if not self[SR2] & MSL:
            self[DR] = value
            self._fill(value)
        elif self[SR1] & SB:
            self._write_address(value)
        elif self[SR1] & ADD10:
            self[SR1] &= ~ADD10
            self._address_bytes = 0
            self._leaving = value
            self._wire.send(value)
        elif self[SR2] & TRA:
            self._fill(value)
            self._proceed()
        self._update()

    def _write_address(self, value: int) -> None:
        if not self._saw & SB:
            self.note("misuse", "DR", "an address was written before SR1 was read: SB stays")
            return
        self[SR1] &= ~SB
        self._in_data = False
        self[SR2] = self[SR2] & ~TRA | (0 if value & 1 else TRA)
        self._address_bytes = 1 if value & _HEADER_MASK == _HEADER and not value & 1 else 0
        self._leaving = value
        self._wire.send_address(value)

    # --- what comes next

    @property
    def _rests(self) -> bool:
        """Whether the master holds SCL low, and nothing but START, STOP or a byte is waited for."""
        return bool(self[SR2] & MSL and not self._wire.busy and not self[SR1] & (SB | ADDR | ADD10))

    def _proceed(self) -> None:
        """Begin what can begin now."""
        control = self[CR1]
        if self._wire.busy or not control & PE:
            return
        if not self[SR2] & MSL:
            if control & START and not self[SR2] & BUSY:
                self._begin()
        elif control & STOP and (self._rests or self[SR1] & (ADDR | SB | ADD10)):
            self[SR1] &= ~(SB | ADDR | ADD10 | BTF | TXE)
            self._wire.stop()
        elif self._rests:
            self._go_on(bool(control & START))

    def _go_on(self, again: bool) -> None:
        byte = self._next_byte() if self[SR2] & TRA and not self._refused else None
        if byte is not None:
            self._wire.send(byte)
        elif again:
            self[SR1] &= ~(BTF | TXE)
            self._wire.restart()
        elif not self[SR2] & TRA and not self._refused and self._shifted is None:
            self._wire.receive()

    def _begin(self) -> None:
        if not all(pin.at_pin() for pin in self._pins):
            text = "START was set, but SCL and SDA are not both at a pin: the bus does not move"
            self.note("misuse", "CR1.START", text)
            return
        if not all(pin.open_drain() for pin in self._pins):
            self.note("misuse", "SDA", "SCL and SDA are not both open-drain: no slave can pull them low")
        if low := self.held_low():
            text = (
                f"{low} is held low at its pin, which the interface does not see; {self.name.lower()}=stuck does that"
            )
            self.note("unmodelled", "SR2.BUSY", text)
        self._wire.start()

    # --- another master

    def heard_start(self) -> None:
        """Another master has made a START; if this one does so at the same cycle, they contend (section 26.3.4)."""
        other = self.bus.master
        if self[SR2] & MSL or (other is not None and self._wire.meets(other)):
            return
        self._wire.cancel()
        super().heard_start()

    def heard_stop(self) -> None:
        """Another master has made a STOP, which may be this one's as well."""
        if not self[SR2] & MSL:
            super().heard_stop()

    # --- what the wire says

    def _started(self) -> None:
        self._refused = False
        self._waiting = self._shifted = None
        self._forget_pec()
        if not self[SR2] & MSL:
            self._set_state(PEC_VALUE, 0)
        self[CR1] &= ~START
        self[SR1] = self[SR1] & ~(TXE | BTF) | SB
        self[SR2] = (self[SR2] | MSL | BUSY) & ~TRA
        self._saw = 0
        self._update()

    def _sent(self, acknowledged: bool) -> None:
        self._gone()
        if not acknowledged:
            self[SR1] |= AF
            self._refused = True
        elif not self._in_data:
            self[SR1] |= ADD10 if self._address_bytes else ADDR
            self._in_data = not self._address_bytes
            self._saw = 0
        elif self._waiting is None and not self._pec_is_next:
            self[SR1] |= TXE | BTF
        self._proceed()
        self._update()

    def _byte_in(self, byte: int) -> None:
        self._arrived = byte
        acknowledge = self._answer(byte)
        self._refused = not acknowledge
        self._wire.acknowledge(acknowledge)

    def _received(self) -> None:
        self._keep(self._arrived)
        self._proceed()
        self._update()

    def _stopped(self) -> None:
        self[CR1] &= ~STOP
        self[SR1] &= ~(TXE | SB | ADDR | ADD10 | (0 if self._shifted is not None else BTF))
        self._set_state(~PEC_VALUE, 0)
        self._forget_pec()
        self._in_data = False
        self._stuck_changed()
        self._proceed()
        self._update()

    def _lost(self) -> None:
        """Another master, or something that holds SDA low, has won."""
        self._forget()
        self[SR1] = self[SR1] & ~(SB | ADDR | ADD10 | BTF | TXE) | ARLO
        self._hears = self._has_lost = self.bus.master is not None
        self._set_state(~PEC_VALUE, BUSY if self._hears else 0)
        self._stuck_changed()
        self._update()

    def _stuck_changed(self) -> None:
        """Be busy while something holds SDA low, or else free."""
        if self[SR2] & MSL or self._hears:
            return
        self._set_state(~PEC_VALUE, BUSY if self.bus.stuck and self[CR1] & PE else 0)
        if self[CR1] & PE:
            self._proceed()

    def _freed(self) -> None:
        """Another master has left the bus."""
        self._wire.wait_for_free()
        self._stuck_changed()

    # --- SMBus

    def _watch_clock(self) -> None:
        """See whether a master holds SCL low, or a slave of its, where SMBus has limits for that."""
        rests = not self._wire.busy
        if rests:
            self.bus.pause(True)
        if self[CR1] & SMBUS and (rests or self._wire.held):
            self._low.hold(LOW_NS)
        if self[CR1] & SMBUS and rests:
            self._own_low.hold(MASTER_NS)
        else:
            self._own_low.pause()

    def _clocked(self) -> None:
        """SCL is let go."""
        self.bus.pause(False)
        self._low.restart()
        self._own_low.restart()

    def _timed_out(self) -> None:
        """SCL was low for too long: of a master, a STOP follows as soon as it can rise; a slave lets go."""
        self._clocked()
        self[SR1] |= TIMEOUT
        if self[SR2] & MSL:
            self[CR1] = self[CR1] & ~START | STOP
            self._wire.cancel()
            self._proceed()
        else:
            self._reset_communication()
        self._update()

    def _update(self) -> None:
        if self[SR2] & MSL:
            self._watch_clock()
        super()._update()
