"""Faults on the wire, as data: which frames, and what becomes of them.

A `Rule` picks frames of one direction and rewrites them; a `Tap` applies rules between a device and its port. Offsets
are those of the packet, from its first header byte: 3 is the command number or packet type, 4 the type of an argument.
A rewritten frame gets a right checksum, unless the checksum is what the rule is about.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Protocol

from hilbench.clock import NS_PER_S, Scheduler
from hilbench.links import Port
from hilbench.links.front import PortInFront
from protocols.p2os import Dropped, DropReason, Frame, FrameReader, checksum, encode_frame

LONGEST = 255
SIP = frozenset({0x32, 0x33})
IDENTIFICATION = 2
READINGS_AT = 22
"""Where a SIP says how many sonar readings follow; each has three bytes (Pioneer 2 Operations Manual)."""


class Way(enum.Enum):
    """A direction, seen from the device that is mutated."""

    IN = "to the device"
    OUT = "from the device"


Memory = dict[str, int | bytes]
"""What a rule remembers from frame to frame."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """What becomes of one frame.

    Attributes:
        data: the bytes that go on instead of it.
        late_s: how much later they do, in seconds.
        swallow: how many frames behind it are lost.
    """

    data: bytes
    late_s: float = 0.0
    swallow: int = 0


class Operation(Protocol):
    """What is done to a frame."""

    def apply(self, raw: bytes, memory: Memory) -> Result:
        """Return what becomes of the frame with these bytes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Match:
    """Which frames a rule is for: those that meet all conditions given.

    Attributes:
        numbers: command numbers or packet types; empty for all.
        at: bytes that must stand at these offsets of the packet.
        body: length of the body in bytes.
        shorter, longer: bounds of the length of the body, themselves excluded.
        every: only each so many-th of those that meet the other conditions.
        within_s: only frames that end so soon behind the one before.
        after_s: only frames that end later than this behind the one before.
        dropped: not sound frames but bytes dropped for this reason.
        ends: how the bytes must end.
        more_than_sip: only SIPs with bytes behind their last field.
        less_than_sip: only SIPs whose readings reach beyond their end.
        whole_sip: only SIPs that hold what they claim to.
    """

    numbers: frozenset[int] = frozenset()
    at: Mapping[int, int] = field(default_factory=dict)
    body: int | None = None
    shorter: int = LONGEST + 1
    longer: int = -LONGEST
    every: int = 1
    within_s: float | None = None
    after_s: float | None = None
    dropped: DropReason | None = None
    ends: bytes = b""
    more_than_sip: bool = False
    less_than_sip: bool = False
    whole_sip: bool = False

    def fits(self, raw: bytes, since_s: float) -> bool:
        """Say whether a frame meets the conditions, but for `every`; the frame before ended ``since_s`` seconds ago."""
        length = len(raw) - 5
        return (
            (not self.numbers or (length > 0 and raw[3] in self.numbers))
            and all(offset < len(raw) - 2 and raw[offset] == value for offset, value in self.at.items())
            and (self.body is None or length == self.body)
            and self.longer < length < self.shorter
            and (self.within_s is None or since_s < self.within_s)
            and (self.after_s is None or since_s > self.after_s)
            and raw.endswith(self.ends)
            and self._fits_sip(raw)
        )

    def _fits_sip(self, raw: bytes) -> bool:
        if not (self.more_than_sip or self.less_than_sip or self.whole_sip):
            return True
        over = len(raw) - (30 + 3 * raw[READINGS_AT] if len(raw) > READINGS_AT else LONGEST)
        return (
            (over > 0 or not self.more_than_sip)
            and (over < 0 or not self.less_than_sip)
            and (over >= 0 or not self.whole_sip)
        )


@dataclass(frozen=True, slots=True)
class Rule:
    """Frames going this way that match have this done to them."""

    way: Way
    match: Match
    do: Operation


# --- operations


def _frame(body: bytes) -> bytes:
    return encode_frame(body, max_count=LONGEST) if body else b""


def _body(raw: bytes) -> bytes:
    return raw[3:-2]


@dataclass(frozen=True, slots=True)
class Drop:
    """Lose the frame."""

    def apply(self, raw: bytes, memory: Memory) -> Result:
        return Result(data=b"")


@dataclass(frozen=True, slots=True)
class Become:
    """Put another frame in its place."""

    body: bytes

    def apply(self, raw: bytes, memory: Memory) -> Result:
        return Result(data=_frame(self.body))


@dataclass(frozen=True, slots=True)
class Then:
    """Put another frame behind it."""

    body: bytes

    def apply(self, raw: bytes, memory: Memory) -> Result:
        return Result(data=raw + _frame(self.body))


@dataclass(frozen=True, slots=True)
class Before:
    """Put another frame before it."""

    body: bytes

    def apply(self, raw: bytes, memory: Memory) -> Result:
        return Result(data=_frame(self.body) + raw)


@dataclass(frozen=True, slots=True)
class Twice:
    """Say it twice."""

    def apply(self, raw: bytes, memory: Memory) -> Result:
        return Result(data=raw + raw)


@dataclass(frozen=True, slots=True)
class Late:
    """Say it so many seconds late."""

    by_s: float

    def apply(self, raw: bytes, memory: Memory) -> Result:
        return Result(data=raw, late_s=self.by_s)


@dataclass(frozen=True, slots=True)
class Put:
    """Put bytes at an offset; one below 0 counts from the end of the packet, where the checksum has two."""

    offset: int
    data: bytes

    def apply(self, raw: bytes, memory: Memory) -> Result:
        changed = raw[: self.offset] + self.data + raw[self.offset + len(self.data) :]
        return Result(data=_frame(_body(changed)))


@dataclass(frozen=True, slots=True, kw_only=True)
class Bits:
    """Clear, set and turn bits of the byte at an offset."""

    offset: int
    clear: int = 0
    set: int = 0
    turn: int = 0

    def apply(self, raw: bytes, memory: Memory) -> Result:
        value = (raw[self.offset] & ~self.clear | self.set) ^ self.turn
        return Put(self.offset, bytes((value & 0xFF,))).apply(raw, memory)


@dataclass(frozen=True, slots=True, kw_only=True)
class Word:
    """Multiply the little-endian word at an offset, add to it, take it modulo; leave values below ``least`` alone."""

    offset: int
    signed: bool = False
    times: float = 1.0
    plus: int = 0
    modulo: int = 0x10000
    least: int = -0x8000

    def apply(self, raw: bytes, memory: Memory) -> Result:
        value = int.from_bytes(raw[self.offset : self.offset + 2], "little", signed=self.signed)
        if value >= self.least:
            value = round(value * self.times) + self.plus
        return Put(self.offset, (value % self.modulo).to_bytes(2, "little")).apply(raw, memory)


@dataclass(frozen=True, slots=True)
class Swap:
    """Exchange what stands at two offsets."""

    one: int
    other: int
    size: int = 1

    def apply(self, raw: bytes, memory: Memory) -> Result:
        one, other = raw[self.one : self.one + self.size], raw[self.other : self.other + self.size]
        return Put(self.other, one).apply(Put(self.one, other).apply(raw, memory).data, memory)


@dataclass(frozen=True, slots=True)
class Stick:
    """Repeat for ever what stood at an offset the first time."""

    offset: int
    size: int

    def apply(self, raw: bytes, memory: Memory) -> Result:
        first = memory.setdefault("first", raw[self.offset : self.offset + self.size])
        assert isinstance(first, bytes)
        return Put(self.offset, first).apply(raw, memory)


@dataclass(frozen=True, slots=True)
class Cut:
    """End the body after so many bytes, or so many before its end if negative."""

    length: int

    def apply(self, raw: bytes, memory: Memory) -> Result:
        return Result(data=_frame(_body(raw)[: self.length]))


@dataclass(frozen=True, slots=True)
class Pad:
    """Put bytes behind the body."""

    data: bytes

    def apply(self, raw: bytes, memory: Memory) -> Result:
        return Result(data=_frame(_body(raw) + self.data))


@dataclass(frozen=True, slots=True)
class Leave:
    """Leave out the byte at an offset."""

    offset: int

    def apply(self, raw: bytes, memory: Memory) -> Result:
        return Result(data=_frame(_body(raw[: self.offset] + raw[self.offset + 1 :])))


@dataclass(frozen=True, slots=True)
class FillSip:
    """Fill a SIP that is too short for its readings with zeros."""

    def apply(self, raw: bytes, memory: Memory) -> Result:
        wanted = min(25 + 3 * raw[READINGS_AT], LONGEST - 2)
        return Result(data=_frame(_body(raw).ljust(wanted, b"\0")))


@dataclass(frozen=True, slots=True, kw_only=True)
class Sonars:
    """Renumber, stretch, repeat or leave out the readings of a SIP."""

    plus: int = 0
    times: float = 1.0
    copies: int = 1
    keep: int = 32

    def apply(self, raw: bytes, memory: Memory) -> Result:
        count = raw[READINGS_AT]
        start = READINGS_AT + 1
        readings = [raw[start + 3 * i : start + 3 * i + 3] for i in range(count)]
        changed = [
            bytes(((reading[0] + self.plus) & 0xFF,))
            + min(0xFFFF, round(int.from_bytes(reading[1:], "little") * self.times)).to_bytes(2, "little")
            for reading in readings
        ]
        changed = (changed * self.copies)[: self.keep]
        body = raw[3:READINGS_AT] + bytes((len(changed),)) + b"".join(changed) + raw[start + 3 * count : -2]
        return Result(data=_frame(body))


@dataclass(frozen=True, slots=True)
class Count:
    """Make the count wrong by so much; the checksum stays."""

    plus: int

    def apply(self, raw: bytes, memory: Memory) -> Result:
        return Result(data=raw[:2] + bytes(((raw[2] + self.plus) & 0xFF,)) + raw[3:])


@dataclass(frozen=True, slots=True)
class Noise:
    """Put bytes that are no frame before it."""

    data: bytes

    def apply(self, raw: bytes, memory: Memory) -> Result:
        return Result(data=self.data + raw)


@dataclass(frozen=True, slots=True)
class Checksum:
    """Turn bits of the checksum."""

    turn: int

    def apply(self, raw: bytes, memory: Memory) -> Result:
        value = int.from_bytes(raw[-2:], "big") ^ self.turn
        return Result(data=raw[:-2] + value.to_bytes(2, "big"))


@dataclass(frozen=True, slots=True)
class Mend:
    """Make a wrong checksum right; with ``swapped`` only one whose bytes are in the wrong order."""

    swapped: bool = False

    def apply(self, raw: bytes, memory: Memory) -> Result:
        whole = len(raw) > 5 and len(raw) == raw[2] + 3
        right = checksum(_body(raw)).to_bytes(2, "big")
        if not whole or (self.swapped and raw[-2:] != right[::-1]):
            return Result(data=raw)
        return Result(data=raw[:-2] + right)


@dataclass(frozen=True, slots=True)
class MendIn:
    """Make a checksum right that is wrong in none of these bits."""

    mask: int

    def apply(self, raw: bytes, memory: Memory) -> Result:
        mended = Mend().apply(raw, memory).data
        wrong = int.from_bytes(raw[-2:], "big") ^ int.from_bytes(mended[-2:], "big")
        return Result(data=raw if wrong & self.mask else mended)


@dataclass(frozen=True, slots=True)
class Lose:
    """Lose some byte values wherever they stand; the checksum stays as it was."""

    values: bytes

    def apply(self, raw: bytes, memory: Memory) -> Result:
        return Result(data=raw.translate(None, self.values))


@dataclass(frozen=True, slots=True)
class OnceMoreEachSession:
    """Say a SIP as often as the robot has told who it is: once in the first session, twice in the second."""

    def apply(self, raw: bytes, memory: Memory) -> Result:
        sessions = memory.get("sessions", 0)
        assert isinstance(sessions, int)
        if raw[3] == IDENTIFICATION:
            memory["sessions"] = sessions + 1
        return Result(data=raw * sessions if raw[3] in SIP else raw)


@dataclass(frozen=True, slots=True)
class Swallow:
    """Let it pass, but lose so many frames behind it."""

    count: int = 1

    def apply(self, raw: bytes, memory: Memory) -> Result:
        return Result(data=raw, swallow=self.count)


# --- the tap


class _Lane:
    """One direction: finds the frames, applies the rules, hands on what is left.

    Args:
        rules: those of this direction.
        max_count: the largest count taken for a frame.
        now_ns: tells bench time.
        hand_on: takes the bytes, and how much later they are to go on, in seconds.
    """

    def __init__(
        self,
        rules: tuple[Rule, ...],
        max_count: int,
        now_ns: Callable[[], int],
        hand_on: Callable[[bytes, float], None],
    ) -> None:
        self._rules = rules
        self._reader = FrameReader(max_count=max_count)
        self._now_ns = now_ns
        self._hand_on = hand_on
        self._memories: list[Memory] = [{} for _ in rules]
        self._swallow = 0
        self._last_ns = -(10**18)

    def take(self, data: bytes) -> None:
        if not self._rules:
            self._hand_on(data, 0.0)
            return
        for item in self._reader.receive(data, self._now_ns()):
            self._take_item(item)

    def _take_item(self, item: Frame | Dropped) -> None:
        reason = item.reason if isinstance(item, Dropped) else None
        raw = item.data if isinstance(item, Dropped) else item.raw
        if self._swallow and reason is None:
            self._swallow -= 1
            return
        since_s = (self._now_ns() - self._last_ns) / NS_PER_S
        late_s = 0.0
        for rule, memory in zip(self._rules, self._memories, strict=True):
            if raw and rule.match.dropped is reason and rule.match.fits(raw, since_s) and _is_its_turn(rule, memory):
                result = rule.do.apply(raw, memory)
                raw, late_s = result.data, late_s + result.late_s
                self._swallow += result.swallow
        if reason is None:
            self._last_ns = self._now_ns()
        if raw:
            self._hand_on(raw, late_s)


def _is_its_turn(rule: Rule, memory: Memory) -> bool:
    turn = memory.get("turn", 0)
    assert isinstance(turn, int)
    memory["turn"] = turn + 1
    return (turn + 1) % rule.match.every == 0


class Tap(PortInFront):
    """A port that is another port, but for what the rules make of its frames.

    Args:
        scheduler: whose time it lives in.
        port: the port that it stands before.
        rules: what it does.
        longest_in: the largest count taken for a frame on its way to the device.
    """

    def __init__(self, scheduler: Scheduler, port: Port, rules: tuple[Rule, ...], longest_in: int) -> None:
        super().__init__(port)
        self._scheduler = scheduler
        self.counters = port.counters
        self._in = self._lane(rules, Way.IN, longest_in, self._to_device)
        self._out = self._lane(rules, Way.OUT, LONGEST, self._to_line)

    def _lane(
        self, rules: tuple[Rule, ...], way: Way, max_count: int, hand_on: Callable[[bytes, float], None]
    ) -> _Lane:
        return _Lane(tuple(rule for rule in rules if rule.way is way), max_count, self._now_ns, hand_on)

    def write(self, data: bytes) -> None:
        """Take what the device says."""
        self._out.take(data)

    def _received(self, data: bytes, _at_ns: int) -> None:
        self._in.take(data)

    def _now_ns(self) -> int:
        return self._scheduler.now_ns

    def _to_line(self, data: bytes, late_s: float) -> None:
        self._after(late_s, partial(self.port.write, data))

    def _to_device(self, data: bytes, late_s: float) -> None:
        self._after(late_s, lambda: self.on_receive(data, self._scheduler.now_ns))

    def _after(self, late_s: float, action: Callable[[], None]) -> None:
        if late_s:
            self._scheduler.after(round(late_s * NS_PER_S), action, source="mutant")
        else:
            action()
