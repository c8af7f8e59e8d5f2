"""The checksum of a frame as data: what it is over, where it stands, how it is reckoned.

It makes a changed frame sound again, and tells one rule from another that is a little wrong.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

__all__ = ["Checksum"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Checksum:
    """A rule. Places are those of a slice of the frame, in bytes: one below 0 counts from the end.

    Attributes:
        value: returns the checksum of some bytes, begun with a value.
        begin: what it begins with.
        first: the first byte that it is over.
        stop: the byte behind the last one that it is over.
        at: its own first byte.
        size: its own bytes.
        order: which of these comes first.
    """

    value: Callable[[bytes, int], int]
    begin: int
    first: int
    stop: int
    at: int
    size: int
    order: Literal["big", "little"]

    def of(self, raw: bytes) -> bytes:
        """Return what should stand in the place of the checksum of a frame; what stands there is not looked at."""
        value = self.value(raw[self.first : self.stop], self.begin)
        return (value % (1 << 8 * self.size)).to_bytes(self.size, self.order)

    def in_frame(self, raw: bytes) -> bytes:
        """Return what stands in the place of the checksum."""
        at = self.at % len(raw) if raw else 0
        return raw[at : at + self.size]

    def put(self, raw: bytes, said: bytes) -> bytes:
        """Return the frame with these bytes in the place of its checksum."""
        at = self.at % len(raw)
        return raw[:at] + said + raw[at + self.size :]

    def mended(self, raw: bytes) -> bytes:
        """Return the frame with the checksum that it should have; too short a one as it is."""
        if len(raw) < self.first + self.size or not raw:
            return raw
        return self.put(raw, self.of(raw))
