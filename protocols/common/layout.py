"""Which bytes of a frame are what: its envelope by the protocol's framing, its fields by trying.

A field's bytes are those that change it when they change. That needs no second description of each message, and cannot
disagree with the decoder. It takes one decoding for each byte: for a frame that somebody looks at, not for a stream.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from itertools import groupby
from typing import Any

__all__ = ["Body", "Region", "Sizes", "laid_out"]

_FLIPS = (0x01, 0x80)

Fields = Mapping[str, str]
Sizes = Sequence[tuple[str, int]]
"""Names, and how many bytes each has, in order and without a gap."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Region:
    """Some bytes in a row.

    Attributes:
        name: what they are.
        start: of the first one in the frame.
        data: the bytes.
    """

    name: str
    start: int
    data: bytes


def laid_out(raw: bytes, sizes: Sizes) -> list[Region]:
    """Return the bytes of a frame by their names; what the sizes do not reach is left out."""
    found, start = [], 0
    for name, size in sizes:
        found.append(Region(name=name, start=start, data=raw[start : start + size]))
        start += size
    return found


class Body:
    """Some bytes that say something.

    Args:
        data: the bytes.
        read: makes a dataclass of them.
        senseless: what it raises of bytes that make no sense.
    """

    def __init__(self, data: bytes, read: Callable[[bytes], Any], senseless: type[Exception]) -> None:
        self._data = data
        self._read = read
        self._senseless = senseless
        self._whole = self._fields(data)

    def sizes(self, first: str) -> list[tuple[str, int]]:
        """Return names and lengths of the fields; the first byte, which says what the rest is, is called `first`."""
        names = [first, *map(self.name_of, range(1, len(self._data)))]
        return [(name, len(list(group))) for name, group in groupby(names)] if self._data else []

    def name_of(self, at: int) -> str:
        """Return which field a byte belongs to: ``structure`` if to several, ``unused`` if to none."""
        if self._whole is None:
            return "unread"
        for flip in _FLIPS:
            other = self._fields(self._data[:at] + bytes((self._data[at] ^ flip,)) + self._data[at + 1 :])
            if other is None:
                return "structure"
            changed = [name for name in self._whole if other.get(name) != self._whole[name]]
            if changed:
                return changed[0] if len(changed) == 1 else "structure"
        return "unused"

    def _fields(self, data: bytes) -> Fields | None:
        """Return what they say, field by field; None if they cannot be read."""
        try:
            message = self._read(data)
        except self._senseless:
            return None
        return {field.name: repr(getattr(message, field.name)) for field in fields(message)}
