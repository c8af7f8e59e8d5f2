"""The client side of a real line: whatever pyserial can open, by device path or URL.

The bench never waits for it: a port with a descriptor is written without blocking, as much as the system takes, and any
other is written by a thread (`hilbench.links.threaded`). How it is opened is in `hilbench.links.serial_device`.
"""

from __future__ import annotations

import contextlib
import errno
import io
import os
import select
import termios
from collections.abc import Callable
from functools import partial
from typing import Any

from hilbench.clock import NS_PER_MS, NS_PER_S, EventClass, Scheduler
from hilbench.errors import UnavailableError
from hilbench.links.door import READ_BYTES, Input
from hilbench.links.outgoing import Outgoing, Turn
from hilbench.links.port import Line, ModemLines, PortBase, Refused, raise_it
from hilbench.links.serial_device import (
    LineErrors,
    close_serial,
    error_number,
    far_lines,
    is_pseudo_terminal,
    line_errors,
    modem_lines,
    open_serial,
    set_modem_lines,
)
from hilbench.links.serial_target import SerialTarget, located, parse_serial_target
from hilbench.links.stamped import Stamper, Stamps
from hilbench.links.threaded import ThreadedStream

__all__ = ["WRITE_TIMEOUT_S", "SerialPort"]

WRITE_TIMEOUT_S = 1.0
LOOK_EVERY_NS = 100 * NS_PER_MS
"""How often the driver is asked for line errors and breaks, and for the lines beside the data (choice)."""
_RETRY_NS = 2 * NS_PER_MS
_BEHIND_DRIVER_BYTES = 4096
"""So much an adapter has at most that its driver does not tell of: the transmit buffer of an FT2232H (its data sheet,
section 1). Ports that only look like serial ones (USB CDC) take all at once, and are not waited for beyond that."""
_WITHOUT_BREAKS = ("socket:", "loop:")
"""URLs whose ports take a break and do nothing (pyserial 3.5, ``_update_break_state``)."""
_NO_SUCH_THING = frozenset({errno.ENOTTY, errno.EOPNOTSUPP, errno.EINVAL, None})
"""How drivers refuse a break (Linux, ``drivers/usb/serial`` and ``drivers/usb/class/cdc-acm.c``); None for pyserial."""


class SerialPort(PortBase):
    """A port of this machine, or whatever a pyserial URL leads to.

    The line is up from the start; it goes down, for good, when the device disappears or the far end hangs up. See
    `hilbench.links.reconnecting` for one that comes again.

    Args:
        scheduler: Owner of bench time, locked to the host's clock before it runs.
        target: What to open, or its text; see `parse_serial_target`.
        name: For the journal and for messages; the target's URL by default.
        write_timeout_s: How long the line may take nothing, in bench seconds, before what waits is lost and counted.
        opened: The port, if `open_serial` has opened it already.
        watch_lines: Look every 100 ms whether the far end has changed a line beside the data (`Port.on_modem`). Many
            USB adapters are asked for them, and the bench waits for the answer: so only where somebody wants to know.
        stamps: Wants to know when bytes came and left; None if nobody does. What comes has the bench time then at which
            it came, though this bench reads it later. A port without a descriptor is read without stamps.

    Raises:
        UsageError: the target is not one.
        UnavailableError: the port does not exist, is in use, or may not be opened.
    """

    def __init__(
        self,
        scheduler: Scheduler,
        target: SerialTarget | str,
        *,
        name: str | None = None,
        write_timeout_s: float = WRITE_TIMEOUT_S,
        watch_lines: bool = False,
        stamps: Stamps | None = None,
        opened: Any = None,
    ) -> None:
        self.target = parse_serial_target(target) if isinstance(target, str) else target
        super().__init__(name or self.target.url)
        self._scheduler = scheduler
        self._write_timeout_ns = round(write_timeout_s * NS_PER_S)
        self._serial = open_serial(located(self.target), write_timeout_s) if opened is None else opened
        self._baud = self._baud_now = self.target.baud
        self._out = Outgoing()
        self._taken_ns = self._out_by_ns = 0
        self._beyond_before = 0
        self._writing = False
        self._breaking = False
        self._native = hasattr(self._serial, "fd")
        self._has_wire = self._native and not is_pseudo_terminal(self._serial.fd)
        self._stream: ThreadedStream | None = None
        self._descriptor = self._own_descriptor()
        if self._descriptor is None:
            self._stream = ThreadedStream(self._serial, drain_s=write_timeout_s)
        self._stamps = stamps if self._stream is None else None
        self._stamper: Stamper | None = None
        if self._stamps is not None and self._descriptor is not None:
            with contextlib.suppress(OSError):
                self._stamper = self._stamps.open(self._descriptor)
        self._came_ns = self._asked_ns = self._asked_last_ns = 0
        self._input = Input(descriptor=(self._stamper or self._stream or self._serial).fileno(), read=self._read)
        self._errors = self._count_errors()
        self._watches_lines = watch_lines
        self._levels = self.modem_lines if watch_lines else None
        self.line_is_up = True
        scheduler.add_source(self._input)
        if self._errors is not None or watch_lines:
            self._look_later()

    def _own_descriptor(self) -> int | None:
        """Return what can be read and written without pyserial; None if there is no such thing."""
        if self.target.url.lower().startswith("spy:"):
            return None  # shows what passes through pyserial
        try:
            return int(self._serial.fileno())
        except (AttributeError, io.UnsupportedOperation):
            return None

    @property
    def baud(self) -> int:
        """Bits per second of the port; it is set when the bytes written before are out, at once if they are.

        Raises:
            UnavailableError: when set: the port cannot; `on_refused` is called with it where bytes were still to go.
        """
        return self._baud

    @baud.setter
    def baud(self, baud: int) -> None:
        if baud == self._baud:
            return  # a far port is asked over the network, and the bench would wait for its answer
        if self._idle:
            self._set_baud(baud)
            self._baud = baud
        else:
            self._baud = baud
            self._take_turn(Turn(act=partial(self._set_baud, baud), refused=partial(self._rate_refused, baud)))

    def write(self, data: bytes) -> None:
        """Queue bytes; they go to the system in the next entry, and wait if it takes no more."""
        self._take_to_send(data, self._scheduler.now_ns)
        if not self.line_is_up:
            self.counters.lost += len(data)
            return
        if self._out.idle:
            self._asked_ns = self._scheduler.now_ns
        self._asked_last_ns = self._scheduler.now_ns
        self._out.add(data)
        self._go_on()

    @property
    def pending(self) -> int:
        """Bytes written that the system has not taken, or, where it tells, has not sent."""
        return len(self._out) + self._beyond

    def send_break(self, duration_ns: int, refused: Refused = raise_it) -> None:
        """Hold the line low for `duration_ns` when the bytes written before are out; lost where the device is gone.

        Raises:
            UnavailableError: the port cannot: a pseudo-terminal, a socket, or a driver without breaks. `refused` is
                told what only shows when bytes before it are out.
        """
        self._take_to_send(b"", self._scheduler.now_ns)
        if not self.line_is_up:
            return
        if self._breakless:
            self._refuse_break(self._breakless)
        if self._idle:
            self._begin_break(duration_ns)
        else:
            self._take_turn(Turn(act=partial(self._begin_break, duration_ns), refused=refused))

    def close(self) -> None:
        """Give the port back; a second call does nothing."""
        if self.closed:
            return
        self._end_break()
        self._hand_over_all()
        self._end_break()  # nobody else would: it outlives whoever asked for it
        self.closed = True
        self.line_is_up = False
        self._scheduler.remove_source(self._input)
        if self._stamper is not None:
            self._stamper.close()
        if self._stream is not None:
            self.counters.lost += self._stream.close()
        else:
            close_serial(self._serial)
        self.counters.lost += self._out.clear()

    # --- lines beside the data

    @property
    def modem_lines(self) -> ModemLines | None:
        """The levels of the lines beside the data; None on a port that has none."""
        if self.closed:
            return None
        if self._native:
            return modem_lines(self._serial.fd)
        # Only one that tells of its lines by itself: for an answer the bench would wait.
        return None if "poll_modem" in self.target.url else far_lines(self._serial)

    def set_lines(self, *, dtr: bool | None = None, rts: bool | None = None) -> None:
        """Set DTR and RTS, True for asserted, both at once where that can be done; None leaves one as it is.

        Raises:
            UnavailableError: the port has no such lines, or is gone.
        """
        try:
            if self._native:
                set_modem_lines(self._serial.fd, dtr=dtr, rts=rts)
                return
            if dtr is not None:
                self._serial.dtr = dtr
            if rts is not None:
                self._serial.rts = rts
        except (OSError, TypeError, ValueError) as error:  # the latter: refused by a far port
            message = "DTR and RTS cannot be set: the port has no such lines, or is gone"
            raise UnavailableError(message, where=self.name) from error

    # --- out

    @property
    def _beyond(self) -> int:
        """Bytes that the system has taken and, where it tells, has not sent."""
        with contextlib.suppress(OSError):
            if self._stream is not None:
                return self._stream.writing
            if self._native and not self.closed:
                return int(self._serial.out_waiting)
        return 0

    @property
    def _is_out(self) -> bool:
        """Whether all that the system has taken is on the wire: a UART has some bytes more than its driver tells."""
        return not self._beyond and self._scheduler.now_ns >= self._out_by_ns

    @property
    def _idle(self) -> bool:
        return self._out.idle and not self._breaking and self._is_out

    def _take_turn(self, turn: Turn) -> None:
        """Do something when the bytes written before are out."""
        self._out.add_turn(turn)
        self._go_on()

    def _rate_refused(self, baud: int, error: UnavailableError) -> None:
        if self._baud == baud:  # else another is wished for by now
            self._baud = self._baud_now
        self.on_refused(baud, error)

    def _go_on(self) -> None:
        if not self._writing:
            self._writing = True
            self._taken_ns = self._scheduler.now_ns
            self._scheduler.after(0, self._write_on, order=EventClass.BYTE, source=self.name)

    def _write_on(self) -> None:
        self._writing = False
        if self.closed or self._breaking:
            return
        try:
            stuck = not self._moves()
        except OSError:
            self._line_lost()
            return
        turn = self._next_turn(stuck=stuck)
        if turn is not None:
            try:
                turn.act()
            except UnavailableError as error:
                turn.refused(error)
            self._taken_ns = self._scheduler.now_ns
        self._write_later(_RETRY_NS if turn is None else 0)

    def _next_turn(self, *, stuck: bool) -> Turn | None:
        """Return what is to be done now; what a port that is stuck does not take is lost.

        A far port that is stuck is asked for nothing: that would have to wait for its writer, and the bench with it.
        """
        if stuck and self._stream is not None:
            self.counters.lost += self._out.clear_bytes()
        elif stuck:
            self.counters.lost += len(self._out.first)
            self._out.first.clear()
            return self._out.next_turn()
        return self._out.next_turn() if self._is_out else None

    def _write_later(self, pause_ns: int) -> None:
        if not self._out.idle and not self._breaking and not self.closed:
            self._writing = True
            self._scheduler.after(pause_ns, self._write_on, order=EventClass.BYTE, source=self.name)

    def _moves(self) -> bool:
        """Hand over what the system takes; say whether bytes have moved within the time that they may stand still."""
        now_ns = self._scheduler.now_ns
        taken, beyond = self._hand_over(), self._beyond
        if self._stream is None:  # else there is nobody who tells how many are beyond
            self._out_by_ns = min(self._out_by_ns, now_ns + self._line_now.bytes_ns(beyond + _BEHIND_DRIVER_BYTES))
        if taken or beyond < self._beyond_before or now_ns < self._out_by_ns:
            self._taken_ns = now_ns
        self._beyond_before = beyond
        return now_ns - self._taken_ns <= self._write_timeout_ns

    def _hand_over(self) -> int:
        """Give the system as much as it takes without waiting; return how many bytes that were."""
        if not self._out.first:
            return 0
        if self._stream is not None:
            taken = self._stream.offer(bytes(self._out.first[:READ_BYTES]))
        else:
            # Not pyserial's write: with a timeout it does not say how much it wrote, without one it can hang.
            assert self._descriptor is not None
            try:
                taken = os.write(self._descriptor, self._out.first)
            except BlockingIOError:
                return 0
        del self._out.first[:taken]
        if self._stamps is not None:
            scheduler, asked_ns = self._scheduler, self._asked_ns
            stood_ns = scheduler.slipped_since_ns(asked_ns)
            # Bytes of several writes may have waited: the last one counts as late as the first.
            self._stamps.left(self._asked_last_ns, scheduler.now_ns + scheduler.behind_ns + stood_ns - asked_ns)
        if self._has_wire:
            self._out_by_ns = max(self._out_by_ns, self._scheduler.now_ns) + self._line_now.bytes_ns(taken)
        return taken

    def _hand_over_all(self) -> None:
        """Give the system what it takes without waiting, and do what stands between as far as it need not wait."""
        with contextlib.suppress(OSError, UnavailableError):
            self._hand_over()
            while self._stream is None and self._is_out and not self._breaking and (turn := self._out.next_turn()):
                turn.act()
                self._hand_over()

    @property
    def _line_now(self) -> Line:
        """How the bytes that go out now are sent."""
        settings = self.target.settings
        return Line(baud=self._baud_now, parity=settings.parity, stop_bits=settings.stop_bits)

    def _set_baud(self, baud: int) -> None:
        try:
            self._serial.baudrate = baud
        except (OSError, ValueError, OverflowError, termios.error) as error:
            raise UnavailableError(f"cannot be set to {baud} baud: {error}", where=self.name) from error
        self._baud_now = baud

    @property
    def _breakless(self) -> str:
        """Why no break can be sent here though nobody would refuse one; empty where one can."""
        if self._native:
            return "a pseudo-terminal knows none" if is_pseudo_terminal(self._serial.fd) else ""
        return "a socket knows none" if self.target.url.lower().startswith(_WITHOUT_BREAKS) else ""

    def _begin_break(self, duration_ns: int) -> None:
        try:
            self._serial.break_condition = self._breaking = True
        except (OSError, termios.error, NotImplementedError, ValueError) as error:  # the latter: refused by a far port
            self._breaking = False
            if error_number(error) in _NO_SUCH_THING:
                self._refuse_break(f"the port says: {error}")
            return  # the device is going
        self._scheduler.after(duration_ns, self._end_break, order=EventClass.BYTE, source=self.name)

    def _end_break(self) -> None:
        if self._breaking and not self.closed:
            self._breaking = False
            with contextlib.suppress(OSError, termios.error, ValueError):
                self._serial.break_condition = False
            if not self._out.idle:
                self._go_on()

    # --- in

    def _read(self, at_ns: int) -> None:
        if self._stamper is not None:
            self._read_stamped(self._stamper, at_ns)
            return
        try:
            data = self._stream.take() if self._stream is not None else self._take()
        except BlockingIOError:
            return
        except OSError:
            self._gone(at_ns)
            return
        self._in_order(at_ns, partial(self._deliver, data, at_ns))

    def _read_stamped(self, stamper: Stamper, at_ns: int) -> None:
        """Take what was read elsewhere: it comes in its turn among what is still to be done, at the time it has."""
        assert self._stamps is not None
        try:
            while (read := stamper.take()) is not None:
                self._came_ns = max(self._came_ns, self._scheduler.bench_ns(read.by_ns))
                self._stamps.came(self._came_ns, read)
                when_ns = max(self._came_ns, self._scheduler.now_ns)
                self._in_order(when_ns, partial(self._deliver, read.data, self._came_ns))
        except OSError:
            self._gone(max(self._came_ns, at_ns))  # what has come meanwhile is heard before

    def _gone(self, at_ns: int) -> None:
        self._scheduler.remove_source(self._input)
        self._in_order(at_ns, self._line_lost)

    def _take(self) -> bytes:
        """Return what the system has; raises OSError when it has hung up."""
        assert self._descriptor is not None
        data = os.read(self._descriptor, READ_BYTES)
        if not data and not self._hung_up:
            raise BlockingIOError  # somebody else has thrown away what was to be read (tcflush(3))
        if not data:
            raise OSError("readable without a byte: the other end is gone")
        return data

    @property
    def _hung_up(self) -> bool:
        """Whether a port that gives no byte is gone; a socket that does has ended."""
        if not self._native:
            return True
        poll = select.poll()
        poll.register(self._serial.fd, 0)  # hang-ups and errors are always reported
        return bool(poll.poll(0))

    def _in_order(self, at_ns: int, action: Callable[[], None]) -> None:
        self._scheduler.at(at_ns, action, order=EventClass.INPUT, source=self.name)

    def _line_lost(self) -> None:
        if self.closed:
            return
        self._scheduler.remove_source(self._input)
        self.counters.lost += self._out.clear()
        self._set_line(False, self._scheduler.now_ns)

    # --- what the driver counts

    def _count_errors(self) -> LineErrors | None:
        return line_errors(self._serial.fd) if self._native and not self.closed else None

    def _look_later(self) -> None:
        self._scheduler.after(LOOK_EVERY_NS, self._look, order=EventClass.INPUT, source=self.name)

    def _look(self) -> None:
        if self.closed or not self.line_is_up:
            return
        if self._watches_lines:
            self._look_at_lines()
        before, self._errors = self._errors, self._count_errors()
        if before is not None and self._errors is not None:
            self._add_errors(before, self._errors)
        self._look_later()

    def _look_at_lines(self) -> None:
        before, now = self._levels, self.modem_lines
        if now is None:
            return
        self._levels = now
        if before is None or before.of_far_end != now.of_far_end:
            self.on_modem(now, self._scheduler.now_ns)

    def _add_errors(self, before: LineErrors, now: LineErrors) -> None:
        self.counters.framing_errors += now.framing - before.framing
        self.counters.parity_errors += now.parity - before.parity
        self.counters.receive_overruns += now.overrun - before.overrun
        for _ in range(now.breaks - before.breaks):
            self.counters.breaks += 1
            self.on_break(self._scheduler.now_ns)
