"""What a derived mutant is, and what it does to the frames of its direction."""

from __future__ import annotations

import enum
import struct
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from hilbench.clock import NS_PER_S
from measure.mutants.derived.fields import Number, Place, Reading
from measure.mutants.wire import Way
from protocols.common.checksum import Checksum
from protocols.common.items import Item, Kind

__all__ = ["Acting", "Fault", "Group", "Mutant", "Piece", "bent", "changed", "faults_of"]

LATE_S = 1.0
"""How late a message is that is late (choice): longer than a P2OS or PKT! peer may take for any answer."""
EARLY = 0.75
"""The share of its usual pause after which a message is said that is early (choice)."""
EVERY = "*"
"""Stands for a message where a mutant is about all of them."""


class Group(enum.Enum):
    """What a fault is a fault of."""

    FIELD = "field"
    MESSAGE = "message"
    CHECKSUM = "checksum"
    TIMER = "timer"
    EDGE = "edge"


class Fault(enum.Enum):
    """What is wrong: a stable name, and the words for it."""

    STUCK = "stuck", "stays what it was first", Group.FIELD
    STALE = "stale", "is that of the message before", Group.FIELD
    PLUS = "plus", "is one too many", Group.FIELD
    MINUS = "minus", "is one too few", Group.FIELD
    SIGN = "sign", "has the other sign", Group.FIELD
    ORDER = "order", "has its bytes the other way round", Group.FIELD
    NEIGHBOUR = "neighbour", "is exchanged with the field behind it", Group.FIELD

    DROPPED = "dropped", "is lost", Group.MESSAGE
    DOUBLED = "doubled", "comes twice", Group.MESSAGE
    LATE = "late", f"comes {LATE_S:g} s late", Group.MESSAGE
    EARLY = "early", f"comes after {EARLY:g} of its pause, with what was so before", Group.MESSAGE
    REORDERED = "reordered", "comes behind the next message", Group.MESSAGE

    BEGIN = "begin", "is begun with another value", Group.CHECKSUM
    SHORTER = "shorter", "leaves out the first byte", Group.CHECKSUM
    LONGER = "longer", "is over one byte more in front", Group.CHECKSUM
    SWAPPED = "swapped", "has its bytes the other way round", Group.CHECKSUM
    UNCHECKED = "unchecked", "is not looked at", Group.CHECKSUM
    FIRST_ONLY = "first-only", "is compared in its first byte alone", Group.CHECKSUM
    LAST_ONLY = "last-only", "is compared in its last byte alone", Group.CHECKSUM
    ALSO_BEGIN = "also-begin", "is taken as well if it was begun with another value", Group.CHECKSUM
    ALSO_SHORTER = "also-shorter", "is taken as well if it leaves out the first byte", Group.CHECKSUM
    ALSO_LONGER = "also-longer", "is taken as well if it is over one byte more in front", Group.CHECKSUM
    ALSO_SWAPPED = "also-swapped", "is taken as well with its bytes the other way round", Group.CHECKSUM

    HALVED = "halved", "runs out after half its time", Group.TIMER
    TWICE = "twice", "runs out after twice its time", Group.TIMER

    REFUSED = "refused", "is not taken", Group.EDGE
    STAYS = "stays", "does what it should and leads nowhere", Group.EDGE
    IDLE = "idle", "leads where it should and does nothing", Group.EDGE

    def __init__(self, slug: str, words: str, group: Group) -> None:
        self.slug = slug
        self.words = words
        self.group = group


_OF_OUT = (Fault.BEGIN, Fault.SHORTER, Fault.LONGER, Fault.SWAPPED)
_OF_IN = (
    Fault.UNCHECKED,
    Fault.FIRST_ONLY,
    Fault.LAST_ONLY,
    Fault.ALSO_BEGIN,
    Fault.ALSO_SHORTER,
    Fault.ALSO_LONGER,
    Fault.ALSO_SWAPPED,
)
_LIKE = {
    Fault.ALSO_BEGIN: Fault.BEGIN,
    Fault.ALSO_SHORTER: Fault.SHORTER,
    Fault.ALSO_LONGER: Fault.LONGER,
    Fault.ALSO_SWAPPED: Fault.SWAPPED,
}


def faults_of(group: Group, way: Way) -> tuple[Fault, ...]:
    """Return the faults that there are of a kind in a direction."""
    if group is Group.CHECKSUM:
        return _OF_OUT if way is Way.OUT else _OF_IN
    found = tuple(fault for fault in Fault if fault.group is group)
    return found if way is Way.OUT else tuple(fault for fault in found if fault is not Fault.EARLY)


@dataclass(frozen=True, slots=True, kw_only=True)
class Mutant:
    """A peer with one fault.

    Attributes:
        fault: what is wrong.
        way: the direction of its frames, seen from the peer that is wrong.
        message: which of them, by the name that the decoder gives it; of a timer or an edge, its machine.
        name: the field, timer or edge; empty for a whole message.
        places: where the field stands, and the one behind it that it may be exchanged with, by the frame's length.
    """

    fault: Fault
    way: Way
    message: str
    name: str = ""
    places: Mapping[int, tuple[Place, ...]] = field(default_factory=dict, compare=False)

    @property
    def id(self) -> str:
        """A stable name."""
        way = {Way.OUT: "says", Way.IN: "hears"}[self.way]
        parts = [self.message, *([self.name] if self.name else []), self.fault.slug]
        prefix = [way] if self.fault.group in (Group.FIELD, Group.MESSAGE, Group.CHECKSUM) else []
        return ":".join([*prefix, *parts]).replace(" ", "_")

    @property
    def what(self) -> str:
        """What it does wrong, for people."""
        fault = self.fault
        if fault.group is Group.CHECKSUM:
            return f"the checksum of what it {'says' if self.way is Way.OUT else 'hears'} {fault.words}"
        if fault.group in (Group.TIMER, Group.EDGE):
            return f"{fault.group.value} {self.name} of {self.message} {fault.words}"
        side = "says" if self.way is Way.OUT else "hears"
        of = f"'{self.name}' of {self.message}" if self.name else self.message
        return f"of what it {side}, {of} {fault.words}"


# --- one field


def changed(fault: Fault, raw: bytes, places: Sequence[Place], before: bytes | None, first: bytes) -> bytes:
    """Return a frame with a field as the fault makes it; its checksum stays as it was.

    Args:
        fault: of a field.
        raw: the frame.
        places: of the field, and of the one behind it.
        before: the field's bytes in the frame of this message before; None in the first.
        first: the field's bytes in the first of these frames.
    """
    place = places[0]
    data = place.of(raw)
    if fault is Fault.NEIGHBOUR:
        other = places[1]
        return other.put(place.put(raw, other.of(raw)), data)
    if fault is Fault.STUCK:
        return place.put(raw, first if len(first) == len(data) else data)
    if fault is Fault.STALE:
        return place.put(raw, data if before is None or len(before) != len(data) else before)
    if fault is Fault.ORDER:
        return place.put(raw, data[::-1])
    return place.put(raw, _other_number(fault, data, place.number or Number(order="big")))


def _other_number(fault: Fault, data: bytes, number: Number) -> bytes:
    if number.real:
        code = ("<" if number.order == "little" else ">") + {4: "f", 8: "d"}[len(data)]
        (value,) = struct.unpack(code, data)
        if fault is Fault.SIGN and value == 0:
            return data  # -0.0 is the same number
        made = -value if fault is Fault.SIGN else value + (1.0 if fault is Fault.PLUS else -1.0)
        try:
            return struct.pack(code, made)
        except OverflowError:
            return data
    value = int.from_bytes(data, number.order)
    made = -value if fault is Fault.SIGN else value + (1 if fault is Fault.PLUS else -1)
    return (made % (1 << 8 * len(data))).to_bytes(len(data), number.order)


# --- the checksum


def bent(rule: Checksum, fault: Fault) -> Checksum:
    """Return a rule that is a little wrong."""
    if fault is Fault.BEGIN:
        return replace(rule, begin=rule.begin ^ ((1 << 8 * rule.size) - 1))
    if fault is Fault.SHORTER:
        return replace(rule, first=rule.first + 1)
    if fault is Fault.LONGER:
        return replace(rule, first=rule.first - 1)
    assert fault is Fault.SWAPPED
    return replace(rule, order="little" if rule.order == "big" else "big")


def _takes(rule: Checksum, fault: Fault, raw: bytes) -> bool:
    """A frame whose checksum is wrong is taken all the same."""
    said, right = rule.in_frame(raw), rule.of(raw)
    if fault is Fault.UNCHECKED:
        return True
    if fault is Fault.FIRST_ONLY:
        return said[:1] == right[:1]
    if fault is Fault.LAST_ONLY:
        return said[-1:] == right[-1:]
    return said == bent(rule, _LIKE[fault]).of(raw)


# --- a direction


@dataclass(frozen=True, slots=True)
class Piece:
    """Bytes that go on, and how much later, in seconds."""

    data: bytes
    late_s: float = 0.0


class Acting:
    """A mutant at work on one direction of a line.

    Args:
        mutant: what it does.
        reading: how the frames of this direction are read.
    """

    def __init__(self, mutant: Mutant, reading: Reading) -> None:
        self._mutant = mutant
        self._reading = reading
        self._first: bytes | None = None
        self._before: bytes | None = None
        self._held: list[Piece] = []
        self._last_ns: int | None = None
        self._said_early = False

    def take(self, items: Iterable[Item], now_ns: int) -> list[Piece]:
        """Take what came in a row, in order and without a gap; return what goes on."""
        mutant = self._mutant
        if mutant.fault.group is Group.CHECKSUM and mutant.way is Way.IN:
            return [Piece(self._forgiven(items))]
        found: list[Piece] = []
        for item in items:
            if item.kind is Kind.DROPPED:
                found.append(Piece(item.raw))
            elif mutant.message not in (EVERY, item.name):
                found += [Piece(item.raw), *self._let_go()]
            else:
                found += self._one(item.raw, now_ns)
        return found

    def _one(self, raw: bytes, now_ns: int) -> list[Piece]:
        fault = self._mutant.fault
        if fault.group is Group.FIELD:
            return [Piece(self._field(raw))]
        if fault.group is Group.CHECKSUM:
            rule = self._reading.checksum
            return [Piece(raw if rule is None else rule.put(raw, bent(rule, fault).of(raw)))]
        act: dict[Fault, Callable[[], list[Piece]]] = {
            Fault.DROPPED: list,
            Fault.DOUBLED: lambda: [Piece(raw), Piece(raw)],
            Fault.LATE: lambda: [Piece(raw, LATE_S)],
            Fault.EARLY: lambda: self._early(raw, now_ns),
            Fault.REORDERED: lambda: self._hold(raw),
        }
        return act[fault]()

    def _field(self, raw: bytes) -> bytes:
        places = self._mutant.places.get(len(raw))
        if places is None:
            return raw
        data = places[0].of(raw)
        if self._first is None:
            self._first = data
        made = changed(self._mutant.fault, raw, places, self._before, self._first)
        self._before = data
        return raw if made == raw else self._reading.mended(made)

    def _early(self, raw: bytes, now_ns: int) -> list[Piece]:
        """Say the next one before its time, as this one was; the next one itself is lost then."""
        last_ns, self._last_ns = self._last_ns, now_ns
        found = [] if self._said_early else [Piece(raw)]
        self._said_early = last_ns is not None and now_ns > last_ns
        if last_ns is not None and self._said_early:
            found.append(Piece(raw, EARLY * (now_ns - last_ns) / NS_PER_S))
        return found

    def _hold(self, raw: bytes) -> list[Piece]:
        """Keep it back until something else has passed; what is of its kind pushes it on."""
        held, self._held = self._held, [Piece(raw)]
        return held

    def _let_go(self) -> list[Piece]:
        held, self._held = self._held, []
        return held

    def _forgiven(self, items: Iterable[Item]) -> bytes:
        """Mend the frames with a wrong checksum that are taken all the same."""
        found, rest = bytearray(), b""
        for item in items:
            if item.kind is Kind.DROPPED:
                rest += item.raw
                continue
            found += self._mended_in(rest) + item.raw
            rest = b""
        return bytes(found + self._mended_in(rest))

    def _mended_in(self, rest: bytes) -> bytes:
        rule = self._reading.checksum
        if rule is None:
            return rest
        for start in range(len(rest) - rule.first - rule.size):
            raw = rest[start:]
            whole = rule.mended(raw)
            if raw != whole and self._reading.frame(whole) is not None:
                return rest[:start] + whole if _takes(rule, self._mutant.fault, raw) else rest
        return rest
