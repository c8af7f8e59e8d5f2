"""The checksum of a frame as data: the bytes that it covers, its place, and how it is computed.

It corrects the checksum of a changed frame, and recognises common mistakes in a rejected one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Literal

__all__ = ["Checksum"]


_FEWEST_BYTES = 2
"""Of a checksum that tells one mistake from another."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Checksum:
    """A checksum rule. Positions are in bytes, as in a slice of the frame: a negative one counts from the end.

    Attributes:
        value: returns the checksum of bytes, from an initial value: ``value(data, begin)``.
        begin: the initial value.
        first: position of the first byte that it covers.
        stop: position after the last byte that it covers.
        at: position of the checksum itself.
        size: length of the checksum, in bytes.
        order: byte order of the checksum.
    """

    value: Callable[[bytes, int], int]
    begin: int
    first: int
    stop: int
    at: int
    size: int
    order: Literal["big", "little"]

    def of(self, raw: bytes) -> bytes:
        """Return the correct checksum of a frame; the present one is ignored."""
        return self._bytes(self.value(raw[self.first : self.stop], self.begin))

    def in_frame(self, raw: bytes) -> bytes:
        """Return the present checksum of a frame."""
        at = self.at % len(raw) if raw else 0
        return raw[at : at + self.size]

    def put(self, raw: bytes, said: bytes) -> bytes:
        """Return the frame with these bytes as its checksum."""
        at = self.at % len(raw)
        return raw[:at] + said + raw[at + self.size :]

    def mended(self, raw: bytes) -> bytes:
        """Return the frame with its correct checksum; a frame that is too short is returned unchanged."""
        if len(raw) < self.first + self.size or not raw:
            return raw
        return self.put(raw, self.of(raw))

    def mistake(self, raw: bytes) -> str:
        """Return which common mistake explains a rejected frame; "" if none does.

        A checksum of one byte is not examined: one of some twenty mistakes would fit by chance too often.

        Args:
            raw: the frame; the bytes after its checksum may be missing.
        """
        behind = max(0, -self.at - self.size)
        if self.size < _FEWEST_BYTES:
            return ""
        for missing in range(behind + 1):
            whole = raw + bytes(missing)
            if len(whole) > self.first + self.size + behind:
                said, right = self.in_frame(whole), self.of(whole)
                for what, wrong in self._mistakes(whole):
                    if said == wrong != right:
                        return what
        return ""

    def _mistakes(self, raw: bytes) -> Iterator[tuple[str, bytes]]:
        """Yield what is often done wrong, and the checksum that comes of it."""
        right = self.of(raw)
        yield "the bytes of its checksum are swapped", right[::-1]
        if self.begin:  # of a sum, that it begins with another value is the same as a byte that is off by one
            yield f"its checksum begins with 0 instead of {self.begin:X} hex", replace(self, begin=0).of(raw)
        value = int.from_bytes(right, self.order)
        yield "its checksum is inverted", self._bytes(~value)
        yield "its checksum is negated", self._bytes(-value)
        end = self.stop % len(raw)
        for first, stop in self._ranges(end):
            over = f"its checksum is over its bytes {first + 1} to {stop} instead of {self.first + 1} to {end}"
            yield over, replace(self, first=first, stop=stop).of(raw)

    def _ranges(self, end: int) -> Iterator[tuple[int, int]]:
        """Yield other stretches that it may be over: begun elsewhere in the head, or a byte shorter or longer."""
        for first in range(self.first + 2):
            for stop in (end - 1, end, end + 1):
                if first < stop and (first, stop) != (self.first, end):
                    yield first, stop

    def _bytes(self, value: int) -> bytes:
        return (value % (1 << 8 * self.size)).to_bytes(self.size, self.order)
