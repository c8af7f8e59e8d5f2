"""The fields of a frame, and how numbers stand in them: from the record of a protocol, by trying.

Names and places are those of the record's `regions`; where it has none, a field's bytes are those that change it when
they change. Byte order and sign are found in the same way: a number is read as the decoder reads it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from itertools import groupby
from typing import Any, Literal

from hilbench.plugins.protocol import ProtocolPlugin
from protocols.common.checksum import Checksum
from protocols.common.decoding import Speaker
from protocols.common.items import Item, Kind
from protocols.common.layout import laid_out

__all__ = ["Number", "Place", "Reading"]

_ONE = {4: bytes.fromhex("3F800000"), 8: bytes.fromhex("3FF0000000000000")}
"""1.0 as an IEEE 754 number of so many bytes, the highest first."""
_WORDS = (1, 2, 4, 8)
_FLIPS = (0x01, 0x80)
_STRUCTURE = "structure"
_NO_FIELD = frozenset({_STRUCTURE, "unused", "unread"})
"""What `protocols.common.layout.Body` calls bytes that it cannot name."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Number:
    """How a number stands in its bytes.

    Attributes:
        order: which byte comes first.
        signed: it is a whole number that may be below 0, in two's complement.
        real: it is an IEEE 754 number.
    """

    order: Literal["big", "little"]
    signed: bool = False
    real: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """Where a field stands in the frames of a message that have one length.

    Attributes:
        name: of the field; a name that comes again has its turn behind it, as in ``unused 2``.
        start: of its first byte in the frame.
        size: in bytes.
        number: how its number stands there; None if it is none.
    """

    name: str
    start: int
    size: int
    number: Number | None = None

    @property
    def stop(self) -> int:
        """Of the byte behind it."""
        return self.start + self.size

    def of(self, raw: bytes) -> bytes:
        """Return its bytes."""
        return raw[self.start : self.stop]

    def put(self, raw: bytes, data: bytes) -> bytes:
        """Return the frame with other bytes here."""
        return raw[: self.start] + data + raw[self.stop :]


class Reading:
    """How the frames of one direction are read.

    Args:
        protocol: what is spoken.
        speaker: who sends them, ``host`` or ``target``.
        options: how frames are read; the usual ones if None.

    Attributes:
        checksum: how they are checked; None where they are not, or not by one rule.
    """

    def __init__(self, protocol: ProtocolPlugin, speaker: Speaker, options: Any = None) -> None:
        self._protocol = protocol
        self._speaker = speaker
        self._options = protocol.options() if options is None else options
        self.checksum: Checksum | None = protocol.checksum(self._options) if protocol.checksum is not None else None

    def stream(self) -> Callable[[bytes], list[Item]]:
        """Return what finds the frames of a stream."""
        decoder = self._protocol.decoder(self._options, self._speaker)
        return lambda data: list(decoder.feed(data))

    def whole(self, data: bytes) -> list[Item]:
        """Read bytes behind which nothing comes."""
        decoder = self._protocol.decoder(self._options, self._speaker)
        return [*decoder.feed(data), *decoder.finish()]

    def frame(self, data: bytes) -> Item | None:
        """Read bytes that are one frame and nothing else; None if they are not."""
        items = self.whole(data)
        return items[0] if len(items) == 1 and items[0].kind is not Kind.DROPPED and items[0].raw == data else None

    def mended(self, raw: bytes) -> bytes:
        """Return a changed frame with the checksum that it should have."""
        return raw if self.checksum is None else self.checksum.mended(raw)

    def places(self, raws: Sequence[bytes]) -> list[Place]:
        """Return the fields of sound frames of one message and length, less their checksum.

        A byte that one frame does not tell the field of is called as in another: a number that is rounded does not
        change with its lowest byte wherever it is 0.
        """
        named = zip(*(self._names(raw) for raw in raws), strict=True)
        names = [next((name for name in of_byte if name not in _NO_FIELD), of_byte[0]) for of_byte in named]
        found: list[Place] = []
        turns: dict[str, int] = {}
        for region in laid_out(raws[0], [(name, len(list(group))) for name, group in groupby(names)]):
            turn = turns[region.name] = turns.get(region.name, 0) + 1
            name = region.name if turn == 1 else f"{region.name} {turn}"
            found += self._parts(raws[0], Place(name=name, start=region.start, size=len(region.data)))
        own = (place for place in found if not self._is_checksum(place, len(raws[0])))
        return [replace(place, number=self._number(raws[0], place)) for place in own]

    def _parts(self, raw: bytes, place: Place) -> list[Place]:
        """A field that is several numbers, as one for each, called as in ``rpm[0]``; any other as it is."""
        value = (self._said(raw) or {}).get(place.name)
        count = len(value) if isinstance(value, tuple) and all(map(_is_number, value)) else 1
        if count < 2 or place.size % count:
            return [place]
        size = place.size // count
        return [
            Place(name=f"{place.name}[{turn}]", start=place.start + turn * size, size=size) for turn in range(count)
        ]

    def _names(self, raw: bytes) -> list[str]:
        """Which field each byte of a frame belongs to."""
        regions = self._protocol.regions(raw, self._options, sent=self._speaker == "host")
        if len(regions) < 2:
            said = self._said(raw) or {}
            return [self._name_of(raw, at, said) for at in range(len(raw))]
        return [region.name for region in regions for _ in region.data]

    def _is_checksum(self, place: Place, length: int) -> bool:
        return self.checksum is not None and place.start == self.checksum.at % length

    def _said(self, raw: bytes) -> Mapping[str, object] | None:
        """What a frame says once its checksum is mended; None if it is no frame then, or no readable one."""
        item = self.frame(self.mended(raw))
        return item.fields if item is not None and item.kind is Kind.FRAME else None

    # --- names and places, by trying

    def _name_of(self, raw: bytes, at: int, said: Mapping[str, object]) -> str:
        for flip in _FLIPS:
            changed = raw[:at] + bytes((raw[at] ^ flip,)) + raw[at + 1 :]
            other = self._said(changed)
            if other is None or other.keys() != said.keys():
                return _STRUCTURE
            names = [name for name in said if repr(other[name]) != repr(said[name])]
            if names:
                return names[0] if len(names) == 1 else _STRUCTURE
        return "unused"

    # --- numbers, by trying

    def _number(self, raw: bytes, place: Place) -> Number | None:
        """How a number stands in a field; None if the decoder reads none, or not whatever stands there."""
        if place.size not in _WORDS:
            return None

        def read(data: bytes) -> float | None:
            value = _value(self._said(place.put(raw, data)), place.name)
            return float(value) if _is_number(value) else None  # type: ignore[arg-type]

        nothing, below = read(bytes(place.size)), read(b"\xff" * place.size)
        rest = bytes(place.size - 1)
        first, last = read(b"\x01" + rest), read(rest + b"\x01")
        if nothing is None or first is None or last is None or nothing in (first, last):
            return self._real(place, read) if place.size in _ONE else None
        order: Literal["big", "little"] = "little" if abs(first - nothing) < abs(last - nothing) else "big"
        if place.size in _ONE and (real := self._real(place, read)) is not None:
            return real
        rises = (last if order == "big" else first) > nothing
        return Number(order=order, signed=below is not None and (below < nothing) == rises)

    def _real(self, place: Place, read: Callable[[bytes], float | None]) -> Number | None:
        one = _ONE[place.size]
        nothing = read(bytes(place.size))
        for order, data in (("big", one), ("little", one[::-1])):
            value, double = read(data), read(_doubled(data, order))
            if None not in (value, double, nothing) and value != nothing:
                assert value is not None
                assert double is not None
                assert nothing is not None
                if abs(double - nothing - 2 * (value - nothing)) <= 1e-9 * abs(value - nothing):
                    return Number(order=order, real=True)  # type: ignore[arg-type]
        return None


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, (bool, Enum))


def _value(said: Mapping[str, object] | None, name: str) -> object:
    """What a message says in a field, or in a part of one."""
    name, _, part = name.partition("[")
    value = None if said is None else said.get(name)
    return value[int(part[:-1])] if part and isinstance(value, tuple) else value


def _doubled(data: bytes, order: str) -> bytes:
    """1.0 as it stands, made 2.0: its exponent is one more."""
    return {4: bytes.fromhex("40000000"), 8: bytes.fromhex("4000000000000000")}[len(data)][
        :: 1 if order == "big" else -1
    ]
