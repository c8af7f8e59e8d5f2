"""I2C with TIMINGR, as in the STM32F0, F3, F7, L4 and H7: the master (RM0410 section 33).

The slave mode is not modelled. Nobody on the bus of a chip would address it. Own address 0 is what common drivers of a
master leave in OAR1, enabled, so it asks for no slave here (choice).

Choices where the manual is silent, besides those of `i2c_timing` and `i2c_wire`:

* TXDR is asked for (TXIS) as soon as its byte has gone to the shift register, one byte ahead of what is on the bus. The
  figures of section 33.4.9 show it; drivers that flush TXDR after a NACK rely on it.
* A byte that is left in TXDR after a NACK stays there, and is the first one of the next message, unless TXE was set.
* AUTOEND that is set while TC is set, without START, makes a STOP.
* STOP that is set while a byte comes in has that byte not acknowledged. STOP that is set while no transfer is under way
  waits for the next one, and is noted.
* The first byte of a 10-bit address that is not acknowledged is sent again after a repeated START.
* PECR begins anew at each START that is no repeated one.
* Without both pins in their alternate function nothing begins: START stays set. At pins that are not open-drain no
  acknowledge is heard: SDA is high where the chip lets it go.
* After arbitration was lost the bus counts as free, but while SDA is held low.
* A STOP or byte that waits because the kernel clock stands still goes on when it runs again.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction

from targets.mcu.i2c_bus import I2cBus
from targets.mcu.registers import Peripheral
from targets.mcu.services import DmaRequest, IrqLine, Services
from targets.mcu.stm32.i2c_levels import I2cLevels
from targets.mcu.stm32.i2c_message import address_bytes, count, crc8, header
from targets.mcu.stm32.i2c_registers import (
    ADDR,
    ARLO,
    AUTOEND,
    BERR,
    BUSY,
    CLEARED_BY_ICR,
    CR1,
    CR2,
    ERRIE,
    ERRORS,
    FILTERS,
    ISR,
    NACK,
    NACKF,
    OA1,
    OA1_10,
    OA1MODE,
    OA2,
    OAEN,
    OAR1,
    OAR2,
    ONLY_SET,
    OVR,
    PE,
    PECBYTE,
    PECEN,
    PECERR,
    PECR,
    RD_WRN,
    REGISTERS,
    RELOAD,
    RXDMAEN,
    RXDR,
    RXNE,
    SAME_BIT,
    SLAVE_NOTE,
    START,
    STOP,
    STOPF,
    TC,
    TCIE,
    TCR,
    TIMEOUT,
    TIMEOUTR,
    TIMINGR,
    TXDMAEN,
    TXDR,
    TXE,
    TXIS,
)
from targets.mcu.stm32.i2c_timeouts import LowTimeout
from targets.mcu.stm32.i2c_timing import Timing
from targets.mcu.stm32.i2c_wire import Wire

__all__ = ["I2c"]


class I2c(Peripheral):
    """An I2C interface.

    Args:
        name: ``I2C1``.
        base: address of CR1.
        services: what the chip offers. Used: output signals NAME_SCL and NAME_SDA, for where they lead; DMA requests
            NAME_TX and NAME_RX.
        irq_event: number of the interrupt of events,
        irq_error: and of errors.
        kernel_hz: rate of the kernel clock I2CCLK; 0 while it stands still.

    Attributes:
        bus: what it is the master of.
    """

    REGISTERS = REGISTERS

    def __init__(
        self,
        name: str,
        base: int,
        services: Services,
        *,
        irq_event: int,
        irq_error: int,
        kernel_hz: Callable[[], Fraction],
    ) -> None:
        super().__init__(name, base, services)
        self.bus = I2cBus()
        self.bus.on_stuck.append(self._stuck_changed)
        self._kernel_hz = kernel_hz
        self._pins = (services.output(f"{name}_SCL"), services.output(f"{name}_SDA"))
        self._irq_event, self._irq_error = services.irq(irq_event), services.irq(irq_error)
        self._dma_tx, self._dma_rx = services.dma(f"{name}_TX"), services.dma(f"{name}_RX")
        self._levels = (False, False, False, False)
        self._wire = self._make_wire()
        self._timeout = LowTimeout(self.time, self._timed_out)
        self._hears = True
        self._forget()

    def _make_wire(self) -> Wire:
        wire = Wire(self.time, self.bus)
        wire.on_start = self._started
        wire.on_started = self._send_address
        wire.on_sent = self._sent
        wire.on_byte = self._byte_in
        wire.on_received = self._next
        wire.on_stop = self._stopped
        wire.on_clock = self._clocked
        wire.on_lost = self._lost
        return wire

    def _forget(self) -> None:
        """Let no transfer be under way."""
        self._owns = False  # from our START to our STOP
        self._addresses = False  # the address is being sent, or a START before it
        self._ends = False  # a STOP is on its way
        self._waits = False  # for software, with SCL low
        self._reading = False
        self._left = 0  # bytes of NBYTES that have not begun yet
        self._address: list[int] = []  # bytes of the address that have not begun yet
        self._turns = False  # a repeated START follows, for the second half of a 10-bit address for reading
        self._held: int | None = None  # a byte for which RXDR is not free yet

    # --- for who looks at it

    def draw(self, on_edge: Callable[[str, int, bool], None]) -> None:
        """Have `on_edge` called with ``scl`` or ``sda``, bench time in ns and level, from now on.

        Edges come in order of time, those of a byte when it is over: none before `undrawn_ns` is missing.
        """
        self._wire.levels = I2cLevels(lambda line, at, level: on_edge(line, self.time.ns(math.ceil(at)), level))

    def undrawn_ns(self) -> int | None:
        """Return the bench time from which on edges are still to be drawn; None if there are none."""
        since = self._wire.undrawn
        return None if since is None else self.time.ns(math.ceil(since))

    # --- for who breaks it

    def disturb(self, error: str) -> None:
        """Have a fault of the bus seen: ``BERR`` (a misplaced condition), ``ARLO`` (another master) or ``OVR``.

        ARLO ends the transfer. BERR and OVR are flagged without effect on it.
        """
        if error == "ARLO":
            self._wire.release()
            self._lost()
        else:
            self[ISR] |= {"BERR": BERR, "OVR": OVR}[error]
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
        hz = self._kernel_hz()
        self._wire.set_timing(Timing.of(self[TIMINGR], self[CR1], hz, self.time.hclk_hz) if hz else None)

    def _break_off(self) -> None:
        """What PE = 0 does (RM0410 section 33.4.6)."""
        self._wire.release()
        self._timeout.high()
        self._forget()
        self[CR2] &= ~ONLY_SET
        self[ISR] = TXE
        self[PECR] = 0
        self._update()

    # --- registers

    def write_CR1(self, value: int) -> None:
        """Enable and disable; filters, interrupts, DMA."""
        changed = self[CR1] ^ value
        if changed & FILTERS and self[CR1] & value & PE:
            self.note("misuse", "CR1.DNF", "the filters may only be set while PE is 0")
        self[CR1] = value
        if changed & FILTERS:
            self._set_timing()
        if changed & PE:
            self._switched(bool(value & PE))
        self._update()

    def _switched(self, on: bool) -> None:
        if on:
            self._stuck_changed()
        else:
            self._break_off()

    def write_CR2(self, value: int) -> None:
        """What to transfer; START and STOP."""
        value |= self[CR2] & ONLY_SET
        if not self[CR1] & PE:
            value &= ~ONLY_SET
        self[CR2] = value
        if value & STOP and not value & START and not self._owns:
            self.note("misuse", "CR2.STOP", "set while no transfer is under way: it waits for the next one")
        if self[ISR] & TCR:
            self._left = count(value)
        if self._waits:
            self._next()
        self._begin()
        self._update()

    def write_OAR1(self, value: int) -> None:
        """Keep the own address; one other than 0 is noted."""
        self[OAR1] = value
        if value & OAEN and value & (OA1_10 if value & OA1MODE else OA1):
            self.note("unmodelled", "OAR1", SLAVE_NOTE)

    def write_OAR2(self, value: int) -> None:
        """Keep the second own address; one other than 0 is noted."""
        self[OAR2] = value
        if value & OAEN and value & OA2:
            self.note("unmodelled", "OAR2", SLAVE_NOTE)

    def write_TIMINGR(self, value: int) -> None:
        """Set the bit clock."""
        if self[CR1] & PE and value != self[TIMINGR]:
            self.note("misuse", "TIMINGR", "may only be written while PE is 0")
        self[TIMINGR] = value
        self._set_timing()

    def write_ISR(self, value: int) -> None:
        """Drop what is in TXDR where TXE is written with 1; TXIS can be set in slave mode only."""
        dropped = value & TXE  # `writable` lets these two through as they were written
        self[ISR] |= dropped
        self._update()

    def read_ICR(self) -> int:
        """Return 0: the register can only be written."""
        return 0

    def write_ICR(self, value: int) -> None:
        """Clear flags. ADDRCF also takes START back, and so ends the attempts to send a 10-bit address."""
        self[ISR] &= ~(value & CLEARED_BY_ICR)
        if value & ADDR:
            self[CR2] &= ~START
        self._update()

    def read_RXDR(self) -> int:
        """Return the byte that came in last; the one that waits for RXDR comes in then, and the bus goes on."""
        value = self[RXDR]
        if self[ISR] & RXNE:
            self[ISR] &= ~RXNE
            held, self._held = self._held, None
            if held is not None:
                self._take(held)
            self._update()
        return value

    def write_TXDR(self, value: int) -> None:
        """Give the next byte to send."""
        self[TXDR] = value
        if self[CR1] & PE:
            self[ISR] &= ~TXE
            if self._waits and self._left:
                self._next()
            self._update()

    # --- a transfer

    def _begin(self) -> None:
        """Begin what START asks for, if the bus is free."""
        if not self[CR2] & START or self._owns or self._wire.busy or self[ISR] & BUSY:
            return
        if not all(pin.at_pin() for pin in self._pins):
            text = "START was set, but SCL and SDA are not both at a pin: the bus does not move"
            self.note("misuse", "CR2.START", text)
            return
        self._hears = all(pin.open_drain() for pin in self._pins)
        if not self._hears:
            self.note("misuse", "SDA", "SCL and SDA are not both open-drain: no slave can pull them low")
        self._wire.start()

    def _started(self) -> None:
        """SDA has fallen for a START: take over what CR2 says."""
        if not self._owns:
            self[PECR] = 0
        self._owns = self._addresses = True
        self[ISR] |= BUSY
        control = self[CR2]
        if self._turns:
            self._turns = False
            self._address = [header(control) | 1]
        else:
            self._left = count(control)
            self._reading = bool(control & RD_WRN)
            self._address = address_bytes(control)
        self._update()

    def _send_address(self) -> None:
        byte = self._address.pop(0)
        self._count_pec(byte)
        self._wire.send_address(byte)

    def _sent(self, acknowledged: bool) -> None:
        """A byte has been sent, of the address or of the data."""
        self._watch_low()
        if not acknowledged or not self._hears:
            self._refused()
        elif self._address:
            self._turns = self._reading
            byte = self._address.pop(0)
            self._count_pec(byte)
            self._wire.send(byte)
        elif self._turns:
            self._wire.restart()
        else:
            if self._addresses:
                self._addresses = False
                self[CR2] &= ~START
            self._next()
        self._update()

    def _refused(self) -> None:
        """NACK: a STOP follows by itself (RM0410 section 33.4.9)."""
        self[ISR] |= NACKF
        if self._address and self[CR2] & START:
            self._wire.restart()
        else:
            self[CR2] &= ~START
            self._end()

    def _next(self) -> None:
        """SCL is low after a byte, or software has done what was waited for: go on, or wait."""
        complete = bool(self[ISR] & TC)
        self[ISR] &= ~(TC | TCR)
        self._waits = False
        self._watch_low()
        if self[CR2] & STOP:
            self._end()
        elif not self._left:
            self._block_done(complete)
        elif self._reading:
            self._left -= 1
            self._wire.receive()
        elif self._pec_is_next(1):
            self._left -= 1
            self._wire.send(self[PECR])
        elif not self[ISR] & TXE:
            self._left -= 1
            self[ISR] |= TXE
            self._count_pec(self[TXDR])
            self._wire.send(self[TXDR])
        else:
            self._wait(0)
        self._update()

    def _block_done(self, complete: bool) -> None:
        """NBYTES bytes have been transferred; if `complete`, TC has said so already."""
        control = self[CR2]
        if control & RELOAD and not complete:
            self._wait(TCR)
        elif control & START and (complete or not control & AUTOEND):
            self._addresses = True
            self._wire.restart()
        elif control & AUTOEND:
            self._end()
        else:
            self._wait(TC)

    def _wait(self, flag: int) -> None:
        self[ISR] |= flag
        self._waits = True
        self._timeout.low(self[TIMEOUTR], self._wire.timing)

    def _byte_in(self, byte: int) -> None:
        if self[ISR] & RXNE:
            self._held = byte
            self._timeout.low(self[TIMEOUTR], self._wire.timing)
        else:
            self._take(byte)
            self._update()

    def _take(self, byte: int) -> None:
        """Put a byte into RXDR and answer it: the last one of a transfer is not acknowledged."""
        control = self[CR2]
        if self._pec_is_next(0):
            self[ISR] |= 0 if byte == self[PECR] else PECERR
        else:
            self._count_pec(byte)
        self[RXDR] = byte
        self[ISR] |= RXNE
        last = not self._left and not control & RELOAD
        self._wire.acknowledge(not last and not control & STOP)

    def _end(self) -> None:
        self._left = 0
        self._address = []
        self._held = None
        self._turns = self._waits = False
        self._ends = True
        self._wire.stop()

    def _stopped(self) -> None:
        self._forget()
        self[CR2] &= ~(STOP | NACK | PECBYTE)
        self[ISR] = self[ISR] & ~(BUSY | TC | TCR) | STOPF
        self._begin()
        self._update()

    # --- what goes wrong

    def _lost(self) -> None:
        """SDA was low where we let it go: somebody else has the bus."""
        self._timeout.high()
        self._forget()
        self[CR2] &= ~(START | STOP | PECBYTE)
        self[ISR] = self[ISR] & ~(BUSY | TC | TCR) | ARLO | (BUSY if self.bus.stuck else 0)
        self._update()

    def _stuck_changed(self) -> None:
        """SDA falls or rises while SCL is high: for an interface that only listens, a START or a STOP."""
        if self._wire.levels is not None:
            self._wire.levels.stick(self.time.now, self.bus.stuck)
        if self[CR1] & PE and not self._owns:
            self[ISR] = self[ISR] & ~BUSY | (BUSY if self.bus.stuck else 0)
            self._begin()
            self._update()

    def _watch_low(self) -> None:
        if self._wire.held:
            self._timeout.low(self[TIMEOUTR], self._wire.timing)

    def _clocked(self) -> None:
        self._timeout.high()

    def _timed_out(self) -> None:
        """SCL was low for too long: a STOP follows by itself, as soon as SCL can rise."""
        self[ISR] |= TIMEOUT
        if not self._ends:
            self._wire.cancel()
            self[CR2] &= ~START
            self[ISR] &= ~(TC | TCR)
            self._end()
        self._update()

    # --- packet error code

    def _pec_is_next(self, left: int) -> bool:
        """Say whether the byte is the PEC with which as many bytes are left of NBYTES."""
        control = self[CR2]
        return bool(self._left == left and self[CR1] & PECEN and control & PECBYTE and not control & RELOAD)

    def _count_pec(self, byte: int) -> None:
        if self[CR1] & PECEN:
            self[PECR] = crc8(self[PECR] ^ byte)

    # --- lines

    def _update(self) -> None:
        """Drive TXIS, interrupts and DMA requests."""
        writes = self._owns and not (self._reading or self._addresses or self._ends)
        wanted = writes and self._left and not self._pec_is_next(1) and self[ISR] & TXE
        self[ISR] = isr = self[ISR] & ~TXIS | (TXIS if wanted else 0)
        cr1 = self[CR1]
        levels = (
            bool(isr & cr1 & SAME_BIT or (isr & TCR and cr1 & TCIE)),
            bool(isr & ERRORS and cr1 & ERRIE),
            bool(isr & TXIS and cr1 & TXDMAEN),
            bool(isr & RXNE and cr1 & RXDMAEN),
        )
        if levels == self._levels:
            return
        before, self._levels = self._levels, levels
        lines: tuple[IrqLine | DmaRequest, ...] = (self._irq_event, self._irq_error, self._dma_tx, self._dma_rx)
        for line, was, level in zip(lines, before, levels, strict=True):
            if level is not was:
                line.set(level)
