"""A line inside the bench: two ends, a wire each way, every byte at the instant a UART would have it complete."""

from __future__ import annotations

import functools

from hilbench.clock import NS_PER_S, EventClass, Scheduler
from hilbench.links.faults import Direction, FaultPlan
from hilbench.links.port import Line, PortBase, Refused, raise_it
from hilbench.links.uart import Injector, Sampler, Transmitter

REAL_TIME_GROUP_NS = 100_000
"""For a line on a bench in real time (choice): bytes come one by one at 115200 baud and below, by nines at
921600, where an entry for each byte is more than a processor takes."""


class MemoryPort(PortBase):
    """One end of a `MemoryLink`."""

    def __init__(
        self,
        scheduler: Scheduler,
        name: str,
        line: Line,
        *,
        tx_depth: int | None,
        injector: Injector | None,
        group_ns: int = 0,
    ) -> None:
        super().__init__(name)
        self.line_is_up = True
        self._scheduler = scheduler
        self._baud = line.baud
        self._peer: MemoryPort | None = None
        self._sampler: Sampler | None = None
        self._transmitter = Transmitter(
            scheduler,
            name,
            line,
            self._out,
            on_break=self._break_out,
            depth=tx_depth,
            injector=injector,
            group_ns=group_ns,
        )

    @property
    def baud(self) -> int:
        """Bits per second this end sends and listens with; 0 for no pace, and to understand any rate."""
        return self._baud

    @baud.setter
    def baud(self, baud: int) -> None:
        self._baud = baud
        self._transmitter.baud = baud

    @property
    def wire_baud(self) -> int:
        """The rate at which this end really sends: `baud`, but for a fault that sets it to something else."""
        return self._transmitter.baud

    @wire_baud.setter
    def wire_baud(self, baud: int) -> None:
        self._transmitter.baud = baud

    @property
    def pending(self) -> int:
        """Bytes written that are not out yet."""
        return self._transmitter.pending

    def write(self, data: bytes) -> None:
        """Queue bytes behind those that are not out yet; what finds no room in the queue is counted as overrun."""
        self._take_to_send(data, self._scheduler.now_ns)
        self.counters.overruns += len(data) - self._transmitter.write(data)

    def withdraw(self, keep: int) -> None:
        """Take back what is not out yet, but for the next `keep` bytes and the one that is on the line."""
        self.counters.withdrawn += self._transmitter.withdraw(keep)

    def send_break(self, duration_ns: int, _refused: Refused = raise_it) -> None:
        """Hold the line low for `duration_ns`, after the bytes written so far."""
        self._take_to_send(b"", self._scheduler.now_ns)
        self._transmitter.send_break(duration_ns)

    def close(self) -> None:
        """Hang up; the other end is notified."""
        if self.closed:
            return
        self.closed = True
        self.line_is_up = False
        self.counters.lost += self._transmitter.clear()
        peer = self._peer
        if peer is not None:
            self._scheduler.after(0, lambda: peer.line_changed(False), order=EventClass.INPUT, source=self.name)

    def join(self, peer: MemoryPort) -> None:
        """Make `peer` the other end."""
        self._peer = peer

    def line_changed(self, up: bool) -> None:
        """Learn that the line came up or went down; what was under way is lost when it goes down."""
        if not up:
            self.counters.lost += self._transmitter.clear()
            self._sampler = None
        self._set_line(up and not self.closed, self._scheduler.now_ns)

    def hear(self, data: bytes, sent_baud: int, at_ns: int) -> None:
        """Take bytes off the wire, the last of which ended at `at_ns`."""
        if sent_baud == self._baud or not sent_baud or not self._baud:
            self._sampler = None
            self._deliver(data, at_ns)
            return
        if self._sampler is None or (self._sampler.sent_baud, self._sampler.own_baud) != (sent_baud, self._baud):
            self._sampler = Sampler(sent_baud, self._baud)
        byte_ns = 10 * NS_PER_S // sent_baud
        for index, value in enumerate(data):
            self._sampler.feed(at_ns - (len(data) - index) * byte_ns, value)
        self._sample(at_ns)

    def hear_break(self, at_ns: int) -> None:
        """Take a break off the wire, which ended at `at_ns`."""
        if not self.closed:
            self.counters.breaks += 1
            self.on_break(at_ns)

    def _sample(self, known_ns: int) -> None:
        sampler = self._sampler
        if sampler is None:
            return
        sampled = sampler.take(known_ns)
        if sampler.wake_ns is not None and (self._peer is None or not self._peer.pending):
            when_ns = max(sampler.wake_ns, self._scheduler.now_ns)
            self._scheduler.at(when_ns, self._line_stayed_idle, order=EventClass.BYTE, source=self.name)
        if sampled:
            self.counters.framing_errors += sum(byte.framing_error for byte in sampled)
            self._deliver(bytes(byte.value for byte in sampled), self._scheduler.now_ns)

    def _line_stayed_idle(self) -> None:
        if self._peer is None or not self._peer.pending:
            self._sample(self._scheduler.now_ns)

    def _out(self, data: bytes, at_ns: int) -> None:
        if self._peer is None or self._peer.closed or not self.line_is_up:
            self.counters.lost += len(data)
        else:
            self._peer.hear(data, self._transmitter.baud, at_ns)

    def _break_out(self, at_ns: int) -> None:
        if self._peer is not None and self.line_is_up:
            self._peer.hear_break(at_ns)


class MemoryLink:
    """Two ports joined by a line. The line is up from the start.

    Args:
        scheduler: Owner of bench time.
        line: Baud rate of both ends (each may change its own) and bits per byte.
        name: For the journal; the ends are called NAME.a and NAME.b.
        tx_depth: Bytes each end's transmit queue holds; None for no limit.
        faults: What goes wrong on it, and when.
        group_ns: Bytes that end within this span come together, when the last of them is complete: for a bench in real
            time, where every entry costs. 0 for each at its instant.
    """

    def __init__(
        self,
        scheduler: Scheduler,
        line: Line | None = None,
        *,
        name: str = "link",
        tx_depth: int | None = None,
        faults: FaultPlan | None = None,
        group_ns: int = 0,
    ) -> None:
        self.name = name
        self.line = line or Line()
        self._scheduler = scheduler
        self.a, self.b = (
            MemoryPort(
                scheduler,
                f"{name}.{end}",
                self.line,
                tx_depth=tx_depth,
                injector=faults.injector(direction) if faults else None,
                group_ns=group_ns,
            )
            for end, direction in (("a", Direction.A_TO_B), ("b", Direction.B_TO_A))
        )
        self.a.join(self.b)
        self.b.join(self.a)
        if faults:
            faults.arm(scheduler, self)

    def hang_up(self) -> None:
        """Interrupt the line; both ends are notified, in an entry of their own, and what was under way is lost."""
        self._change(up=False)

    def restore(self) -> None:
        """Bring the line up again; both ends are notified, in an entry of their own."""
        self._change(up=True)

    def break_line(self, direction: Direction, duration_ns: int, refused: Refused) -> None:
        """Hold one wire low for `duration_ns`, after the bytes written so far."""
        self._sender(direction).send_break(duration_ns, refused)

    def set_wire_baud(self, direction: Direction, baud: int | None) -> None:
        """Let one end send at another rate than its own, in bit/s; None for its own again."""
        sender = self._sender(direction)
        sender.wire_baud = sender.baud if baud is None else baud

    def _sender(self, direction: Direction) -> MemoryPort:
        return self.a if direction is Direction.A_TO_B else self.b

    def close(self) -> None:
        """Close both ends."""
        self.a.close()
        self.b.close()

    def _change(self, *, up: bool) -> None:
        for port in (self.a, self.b):
            action = functools.partial(port.line_changed, up)
            self._scheduler.after(0, action, order=EventClass.INPUT, source=port.name)
