"""What goes wrong on a line: faults as data, the same every time for the same seed.

Faults of bytes (drop, flip, duplicate, delay, noise, truncate) strike bytes as they start to shift out: those from
`at_s` on, or from byte number `byte` on, or each with a `probability`. Faults of the line (break, disconnect, baud)
begin at `at_s` and last `duration_s`.
"""

from __future__ import annotations

import enum
import random
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Protocol

from hilbench.clock import NS_PER_S, Entry, EventClass, Scheduler
from hilbench.errors import UnavailableError, UsageError
from hilbench.links.front import PortInFront
from hilbench.links.port import Line, Port, Refused, raise_it
from hilbench.links.uart import Fate, Injector, Transmitter, resample


class FaultKind(enum.Enum):
    """What can go wrong."""

    DROP = "drop"
    """`count` bytes are lost."""
    FLIP = "flip"
    """Bit `bit` of `count` bytes is inverted."""
    DUPLICATE = "duplicate"
    """`count` bytes come twice."""
    DELAY = "delay"
    """The line idles for `duration_s` before a byte."""
    NOISE = "noise"
    """`count` random bytes come before a byte."""
    TRUNCATE = "truncate"
    """A byte and all that waits behind it are lost."""
    BREAK = "break"
    """The line is held low for `duration_s`."""
    DISCONNECT = "disconnect"
    """The line is interrupted, both ways, for `duration_s`."""
    BAUD = "baud"
    """The sender runs at `baud` for `duration_s`."""


_LINE_KINDS = frozenset({FaultKind.BREAK, FaultKind.DISCONNECT, FaultKind.BAUD})


class Direction(enum.Enum):
    """Which wire; for a port that is wrapped, `a` is this side of it."""

    A_TO_B = "a->b"
    B_TO_A = "b->a"


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """One fault.

    Attributes:
        kind: What goes wrong.
        direction: On which wire; a disconnection takes both.
        at_s: From when on, in bench seconds.
        byte: From which byte of its direction on, counted from 0.
        probability: Of striking any byte, 0 to 1.
        count: How many bytes it takes, 1 or more.
        bit: Which bit is inverted, 0 (the lowest, sent first) to 7.
        duration_s: How long, in seconds.
        baud: Rate of the sender, bit/s.

    Raises:
        UsageError: not exactly one of `at_s`, `byte` and `probability`; a value out of range.
    """

    kind: FaultKind
    direction: Direction = Direction.A_TO_B
    at_s: float | None = None
    byte: int | None = None
    probability: float | None = None
    count: int = 1
    bit: int = 0
    duration_s: float = 0.0
    baud: int = 0

    def __post_init__(self) -> None:
        where = f"fault {self.kind.value}"
        triggers = [trigger for trigger in (self.at_s, self.byte, self.probability) if trigger is not None]
        if len(triggers) != 1:
            raise UsageError("needs exactly one of at_s, byte and probability", where=where)
        if self.kind in _LINE_KINDS and self.at_s is None:
            raise UsageError("is a fault of the line and needs at_s", where=where)
        if triggers[0] < 0 or (self.probability or 0) > 1:
            raise UsageError(f"{triggers[0]} is out of range", where=where)
        if self.count < 1 or not 0 <= self.bit <= 7 or self.duration_s < 0:
            raise UsageError("count is 1 or more, bit 0 to 7, duration_s 0 or more", where=where)
        if self.kind is FaultKind.BAUD and self.baud <= 0:
            raise UsageError("needs the baud the sender runs at", where=where)

    @property
    def duration_ns(self) -> int:
        """How long, in ns."""
        return round(self.duration_s * NS_PER_S)


class FaultyLine(Protocol):
    """What the faults of the line act on."""

    def hang_up(self) -> None:
        """Interrupt the line."""

    def restore(self) -> None:
        """Bring it up again."""

    def break_line(self, direction: Direction, duration_ns: int, refused: Refused) -> None:
        """Hold one wire low for `duration_ns`; UnavailableError where that cannot be done.

        Where that only shows later, `refused` is called with why.
        """

    def set_wire_baud(self, direction: Direction, baud: int | None) -> None:
        """Let a sender run at another rate; None for its own."""


def _ignore(_fault: Fault, _direction: Direction, _at_ns: int) -> None:
    """Stand in for a callback that nobody has set."""


def _ignore_refusal(_fault: Fault, _reason: str, _at_ns: int) -> None:
    """Stand in for a callback that nobody has set."""


class FaultPlan:
    """The faults of one link.

    Args:
        faults: What goes wrong.
        seed: Decides what chance decides.
        epoch_ns: Bench time from which the `at_s` of the faults count, in ns.

    Attributes:
        on_fault: Called whenever a fault strikes, with the fault, the wire and the bench time in ns.
        on_refused: Called when a fault cannot strike, with the fault, why, and the bench time in ns: a break at a port
            that knows none. It may have been said to strike, where that shows when the bytes before it are out.
    """

    def __init__(self, faults: tuple[Fault, ...], *, seed: int = 0, epoch_ns: int = 0) -> None:
        self.faults = faults
        self.seed = seed
        self.epoch_ns = epoch_ns
        self.on_fault: Callable[[Fault, Direction, int], None] = _ignore
        self.on_refused: Callable[[Fault, str, int], None] = _ignore_refusal
        self._armed: list[Entry] = []
        self._lasting: list[tuple[Entry, Callable[[], None]]] = []

    def injector(self, direction: Direction) -> Injector | None:
        """Return what decides on the bytes of one wire; None if nothing ever happens to them."""
        faults = [fault for fault in self.faults if fault.direction is direction and fault.kind not in _LINE_KINDS]
        return ByteFaults(self, direction, faults) if faults else None

    def arm(self, scheduler: Scheduler, line: FaultyLine) -> None:
        """Schedule the faults of the line."""
        for fault in self.faults:
            if fault.kind in _LINE_KINDS and fault.at_s is not None:
                when_ns = max(scheduler.now_ns, self.epoch_ns + round(fault.at_s * NS_PER_S))
                strike = partial(self._strike, scheduler, line, fault)
                self._armed.append(scheduler.at(when_ns, strike, order=EventClass.INPUT, source="fault"))

    def disarm(self, scheduler: Scheduler) -> None:
        """Take back the faults of the line that have not begun, and let those that have last."""
        for entry in self._armed:
            scheduler.cancel(entry)
        self._armed.clear()

    def take_back(self, scheduler: Scheduler) -> int:
        """Take back the faults of the line and return how many of them ended now.

        A break that has begun goes on: the port holds it for as long as it was told to.
        """
        self.disarm(scheduler)
        ended = [(entry, end) for entry, end in self._lasting if entry.pending]
        self._lasting.clear()
        for entry, end in ended:
            scheduler.cancel(entry)
            end()
        return len(ended)

    def _strike(self, scheduler: Scheduler, line: FaultyLine, fault: Fault) -> None:
        if fault.kind is FaultKind.BREAK:
            self._break(scheduler, line, fault)
            return
        self.on_fault(fault, fault.direction, scheduler.now_ns)
        if fault.kind is FaultKind.DISCONNECT:
            line.hang_up()
            end = line.restore
        else:
            line.set_wire_baud(fault.direction, fault.baud)
            end = partial(line.set_wire_baud, fault.direction, None)
        self._lasting.append((scheduler.after(fault.duration_ns, end, order=EventClass.INPUT, source="fault"), end))

    def _break(self, scheduler: Scheduler, line: FaultyLine, fault: Fault) -> None:
        def refused(error: UnavailableError) -> None:
            self.on_refused(fault, str(error), scheduler.now_ns)

        try:
            line.break_line(fault.direction, fault.duration_ns, refused)
        except UnavailableError as error:
            refused(error)
        else:
            self.on_fault(fault, fault.direction, scheduler.now_ns)


class _Trigger:
    """Knows which bytes one fault strikes."""

    def __init__(self, fault: Fault, seed: str, epoch_ns: int) -> None:
        self.fault = fault
        self._from_ns = None if fault.at_s is None else epoch_ns + round(fault.at_s * NS_PER_S)
        self.random = random.Random(seed)
        # Noise and delay come before one byte; the others take `count` bytes in a row.
        self._run = 1 if fault.kind in (FaultKind.NOISE, FaultKind.DELAY, FaultKind.TRUNCATE) else fault.count
        self._left = 0
        self._spent = False

    def strikes(self, index: int, at_ns: int) -> bool:
        fault = self.fault
        if not self._left and not self._spent:
            if fault.probability is not None:
                begins = self.random.random() < fault.probability
            elif fault.byte is not None:
                begins = index >= fault.byte
            else:
                begins = self._from_ns is not None and at_ns >= self._from_ns
            if begins:
                self._left = self._run
                self._spent = fault.probability is None
        if not self._left:
            return False
        self._left -= 1
        return True


class ByteFaults:
    """Decides what becomes of the bytes of one wire; an `Injector`."""

    def __init__(self, plan: FaultPlan, direction: Direction, faults: list[Fault]) -> None:
        self._plan = plan
        self._direction = direction
        self._triggers = [
            _Trigger(fault, f"{plan.seed}/{direction.value}/{number}", plan.epoch_ns)
            for number, fault in enumerate(faults)
        ]
        self._index = -1

    def fate(self, value: int, at_ns: int) -> Fate | None:
        """Return what becomes of the byte that starts to shift out at `at_ns`; None if nothing happens to it."""
        self._index += 1
        struck = [trigger for trigger in self._triggers if trigger.strikes(self._index, at_ns)]
        if not struck:
            return None
        values: tuple[int, ...] = (value,)
        for trigger in struck:
            self._plan.on_fault(trigger.fault, self._direction, at_ns)
            values = _struck(values, trigger)
        pause_ns = sum(trigger.fault.duration_ns for trigger in struck if trigger.fault.kind is FaultKind.DELAY)
        cut = any(trigger.fault.kind is FaultKind.TRUNCATE for trigger in struck)
        return Fate(values=values, pause_ns=pause_ns, cut=cut)


def _struck(values: tuple[int, ...], trigger: _Trigger) -> tuple[int, ...]:
    fault = trigger.fault
    if fault.kind in (FaultKind.DROP, FaultKind.TRUNCATE):
        return ()
    if fault.kind is FaultKind.FLIP:
        return tuple(value ^ 1 << fault.bit for value in values)
    if fault.kind is FaultKind.DUPLICATE:
        return values * 2
    if fault.kind is FaultKind.NOISE:
        return tuple(trigger.random.randbytes(fault.count)) + values
    return values


class FaultyPort(PortInFront):
    """Any port, with faults between it and its owner.

    The wire from `a` to `b` is what the owner writes, the one from `b` to `a` what it receives.

    Args:
        scheduler: Owner of bench time.
        port: The port; its callbacks belong to the wrapper from now on.
        plan: What goes wrong.
    """

    def __init__(self, scheduler: Scheduler, port: Port, plan: FaultPlan) -> None:
        self._interrupted = False
        super().__init__(port, f"{port.name}.faulty")
        self._plan = plan
        self._scheduler = scheduler
        self._wire_baud: dict[Direction, int] = {}
        unpaced = Line(baud=0)
        self._out = Transmitter(scheduler, f"{self.name}.out", unpaced, self._pass_on, injector=self._judge_sent(plan))
        self._in = Transmitter(
            scheduler, f"{self.name}.in", unpaced, self._pass_in, injector=plan.injector(Direction.B_TO_A)
        )
        plan.arm(scheduler, self)

    def _judge_sent(self, plan: FaultPlan) -> Injector | None:
        """Return what decides on bytes when they are written: those that wait at the port are out of reach."""
        return plan.injector(Direction.A_TO_B)

    def _stand_before(self, port: Port) -> None:
        super()._stand_before(port)
        self.line_is_up = port.line_is_up and not self._interrupted

    def write(self, data: bytes) -> None:
        """Hand bytes to the port, as far as faults let them through."""
        self._take_to_send(data, self._scheduler.now_ns)
        self._out.write(data)

    @property
    def pending(self) -> int:
        """Bytes written that are not out yet, here and at the port."""
        return self._out.pending + self.port.pending

    def withdraw(self, keep: int) -> None:
        """Take back what is not out yet, but for the next `keep` bytes."""
        at_port = self.port.pending
        self.counters.withdrawn += self._out.withdraw(max(0, keep - at_port))
        self.port.withdraw(min(keep, at_port))

    def send_break(self, duration_ns: int, refused: Refused = raise_it) -> None:
        """Hold the line low for `duration_ns`."""
        self._take_to_send(b"", self._scheduler.now_ns)
        try:
            self.port.send_break(duration_ns, refused)
        except UnavailableError:
            self.counters.breaks_unsent += 1
            raise

    def close(self) -> None:
        """Close the port."""
        if not self.closed:
            self.counters.lost += self._out.clear()
            self._in.clear()
        super().close()

    def reopen(self, port: Port) -> None:
        """Go on with another port in the place of the one that was closed; an interruption is over, faults go on."""
        self.closed = self._interrupted = False
        self._stand_before(port)

    def detach(self) -> None:
        """Leave the port, open as it is, to its next owner; what is under way is lost, and no fault begins any more."""
        self._plan.disarm(self._scheduler)
        self.closed = True
        self._out.clear()
        self._in.clear()

    # --- faults of the line

    def hang_up(self) -> None:
        """Interrupt the line: the owner is notified, and nothing passes either way."""
        self._interrupted = True
        self._line_changed(False, self._scheduler.now_ns)

    def restore(self) -> None:
        """Bring the line up again, if it is up at the port."""
        self._interrupted = False
        self._line_changed(self.port.line_is_up, self._scheduler.now_ns)

    def break_line(self, direction: Direction, duration_ns: int, refused: Refused) -> None:
        """Hold one wire low for `duration_ns`; see `FaultyLine`."""
        if self.closed:
            return
        if direction is Direction.A_TO_B:
            self.port.send_break(duration_ns, refused)
        else:
            end_ns = self._scheduler.now_ns + duration_ns
            heard = partial(self._hear_break, duration_ns, end_ns)
            self._scheduler.at(end_ns, heard, order=EventClass.BYTE, source=self.name)

    def set_wire_baud(self, direction: Direction, baud: int | None) -> None:
        """Let what passes one way look as sent at another rate; None for the port's own."""
        self._wire_baud.pop(direction, None)
        if baud is not None:
            self._wire_baud[direction] = baud

    # --- what passes

    def _pass_on(self, data: bytes, _at_ns: int) -> None:
        if self._interrupted:
            self.counters.lost += len(data)
            return
        self.port.write(self._garbled(data, Direction.A_TO_B))

    def _pass_in(self, data: bytes, at_ns: int) -> None:
        if not self._interrupted:
            self._deliver(self._garbled(data, Direction.B_TO_A), at_ns)

    def _received(self, data: bytes, _at_ns: int) -> None:
        self._in.write(data)

    def _line_changed(self, up: bool, at_ns: int) -> None:
        self._set_line(up and not self._interrupted, at_ns)

    def _broke(self, at_ns: int) -> None:
        self._hear_break(self.port.break_ns, at_ns)

    def _hear_break(self, duration_ns: int, at_ns: int) -> None:
        if not self._interrupted and not self.closed:
            self.counters.breaks += 1
            self.break_ns = duration_ns
            self.on_break(at_ns)

    def _garbled(self, data: bytes, direction: Direction) -> bytes:
        sampled = resample(data, self._wire_baud.get(direction, self.baud), self.baud)
        self.counters.framing_errors += sum(byte.framing_error for byte in sampled)
        return bytes(byte.value for byte in sampled)
