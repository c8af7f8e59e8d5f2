"""Values in CDR, one after the other: the primitives of XCDR1 and XCDR2, in either byte order.

Each number is aligned to its own size, counted from where the stream begins, but to `max_align` at most: 8 in XCDR1
(OMG CORBA 3.4, CDR; DDS-XTypes 1.3, 7.4.1), 4 in XCDR2 (7.4.2). A string is a 32-bit length, its bytes in UTF-8, and a
NUL that the length includes; a sequence is a 32-bit count and its elements.

Bytes that are no UTF-8 survive in strings as lone surrogates, so that what was read can be written again.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from functools import cache
from typing import Any

from protocols.xrce.errors import LocalProtocolError, RemoteProtocolError

__all__ = ["XCDR1_ALIGN", "XCDR2_ALIGN", "CdrReader", "CdrWriter"]

XCDR1_ALIGN = 8
XCDR2_ALIGN = 4

_ENCODING = "utf-8"
_BOOLEAN = "?"


def _truth(value: float) -> bool:
    """A boolean, which `struct` would make of anything."""
    if value not in (False, True):
        raise struct.error("neither true nor false")
    return bool(value)


@cache
def _packer(code: str, little_endian: bool) -> struct.Struct:
    return struct.Struct(("<" if little_endian else ">") + code)


class CdrWriter:
    """Appends values.

    Args:
        little_endian: the order of the bytes of a number.
        max_align: the largest alignment, in bytes.
    """

    def __init__(self, *, little_endian: bool = True, max_align: int = XCDR1_ALIGN) -> None:
        self.little_endian = little_endian
        self.max_align = max_align
        self._data = bytearray()

    @property
    def data(self) -> bytes:
        """What was written."""
        return bytes(self._data)

    def number(self, code: str, value: float) -> None:
        """Writes a number; `code` is that of `struct`: ? b B h H i I q Q f d.

        Raises:
            LocalProtocolError: it does not fit.
        """
        packer = _packer(code, self.little_endian)
        try:
            packed = packer.pack(_truth(value) if code == _BOOLEAN else value)
        except (struct.error, OverflowError) as error:
            raise LocalProtocolError(f"{value!r} is no number for '{code}': {error}") from None
        self._align(packer.size)
        self._data += packed

    def octets(self, data: bytes) -> None:
        """Writes bytes as they are."""
        self._data += data

    def text(self, text: str, most: int | None = None) -> None:
        """Writes a string of at most so many bytes, or of any length.

        Raises:
            LocalProtocolError: it is longer, or holds surrogates that stand for no byte.
        """
        try:
            data = text.encode(_ENCODING, "surrogateescape")
        except UnicodeEncodeError as error:
            raise LocalProtocolError(f"{text!r} cannot be written: {error}") from None
        if most is not None and len(data) > most:
            raise LocalProtocolError(f"{text!r} is longer than {most} bytes")
        self.number("I", len(data) + 1)
        self._data += data + b"\0"

    def numbers(self, code: str, values: Sequence[float]) -> None:
        """Writes numbers one behind the other, aligned as the first of them is.

        Raises:
            LocalProtocolError: one does not fit.
        """
        if not values:
            return
        order = "<" if self.little_endian else ">"
        try:
            packed = struct.pack(f"{order}{len(values)}{code}", *values)
        except (struct.error, OverflowError) as error:
            raise LocalProtocolError(f"{values!r} are no numbers for '{code}': {error}") from None
        self._align(struct.calcsize(order + code))
        self._data += packed

    def _align(self, size: int) -> None:
        self._data += bytes(-len(self._data) % min(size, self.max_align))


class CdrReader:
    """Takes values, one after the other.

    Args:
        data: all there is.
        little_endian: the order of the bytes of a number.
        max_align: the largest alignment, in bytes.
    """

    def __init__(self, data: bytes, *, little_endian: bool = True, max_align: int = XCDR1_ALIGN) -> None:
        self.little_endian = little_endian
        self.max_align = max_align
        self._data = data
        self._at = 0

    @property
    def left(self) -> int:
        """How many bytes were not taken yet."""
        return len(self._data) - self._at

    def number(self, code: str) -> int | float | bool:
        """Takes a number; see `CdrWriter.number`.

        Raises:
            RemoteProtocolError: the bytes end before, or a boolean is neither 0 nor 1.
        """
        packer = _packer("B" if code == _BOOLEAN else code, self.little_endian)
        self._align(packer.size)
        (value,) = packer.unpack(self.octets(packer.size))
        if code != _BOOLEAN:
            return value  # type: ignore[no-any-return]
        if value > 1:
            raise RemoteProtocolError(f"a boolean is {value}, neither 0 nor 1")
        return bool(value)

    def octets(self, count: int) -> bytes:
        """Takes bytes as they are.

        Raises:
            RemoteProtocolError: there are not so many.
        """
        if count > self.left:
            raise RemoteProtocolError(f"{count} bytes are wanted where {self.left} are left")
        self._at += count
        return self._data[self._at - count : self._at]

    def count(self) -> int:
        """Takes the number of elements of a sequence, which have at least a byte each.

        Raises:
            RemoteProtocolError: there cannot be so many.
        """
        count = int(self.number("I"))
        if count > self.left:
            raise RemoteProtocolError(f"a sequence of {count} where {self.left} bytes are left")
        return count

    def text(self, most: int | None = None) -> str:
        """Takes a string of at most so many bytes, or of any length; a length of 0, which some write, is the empty one.

        Raises:
            RemoteProtocolError: it is not all there, does not end in NUL, or is longer.
        """
        data = self.octets(self.count())
        if data and data[-1]:
            raise RemoteProtocolError("a string does not end in NUL")
        if most is not None and len(data) > most + 1:
            raise RemoteProtocolError(f"a string is longer than {most} bytes")
        return data[:-1].decode(_ENCODING, "surrogateescape")

    def numbers(self, code: str, count: int) -> tuple[Any, ...]:
        """Takes so many numbers.

        Raises:
            RemoteProtocolError: there are not so many.
        """
        if not count:
            return ()
        order = "<" if self.little_endian else ">"
        size = struct.calcsize(order + code)
        self._align(size)
        return struct.unpack(f"{order}{count}{code}", self.octets(count * size))

    def _align(self, size: int) -> None:
        self._at = min(self._at + -self._at % min(size, self.max_align), len(self._data))
