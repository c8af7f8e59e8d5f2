"""How fields stand in a submessage: small codecs out of which the layouts of all types are put together.

A payload is XCDR2 without a header of its own, so the largest alignment is 4, counted from its first byte, and a field
that may be absent has a byte before it that says whether it is there (OMG DDS-XRCE 1.0, 8.3; DDS-XTypes 1.3, 7.4.2).
What follows behind the last field that is known is passed over, as a later version may bring more.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from typing import Any

from protocols.xrce.cdr.codec import TEXT, Codec, Number
from protocols.xrce.cdr.stream import XCDR2_ALIGN, CdrReader, CdrWriter
from protocols.xrce.errors import LocalProtocolError, RemoteProtocolError

__all__ = [
    "BLOB",
    "BOOLEAN",
    "I16",
    "I32",
    "ID",
    "REST",
    "TEXT",
    "U8",
    "U16",
    "U32",
    "U64",
    "Codec",
    "Either",
    "Embedded",
    "IfLeft",
    "Named",
    "Octets",
    "Optional",
    "Pair",
    "Record",
    "Sequence",
    "payload_reader",
    "payload_writer",
]


def payload_writer(*, little_endian: bool) -> CdrWriter:
    """An empty payload."""
    return CdrWriter(little_endian=little_endian, max_align=XCDR2_ALIGN)


def payload_reader(data: bytes, *, little_endian: bool) -> CdrReader:
    """A payload to be read."""
    return CdrReader(data, little_endian=little_endian, max_align=XCDR2_ALIGN)


class Octets(Codec):
    """So many bytes."""

    def __init__(self, size: int) -> None:
        self._size = size

    def write(self, out: CdrWriter, value: Any) -> None:
        """See `Codec`."""
        if len(value) != self._size:
            raise LocalProtocolError(f"{bytes(value).hex()} is not {self._size} bytes")
        out.octets(value)

    def read(self, data: CdrReader) -> Any:
        """See `Codec`."""
        return data.octets(self._size)


class _Id(Codec):
    """Two octets that are read as a number, high one first in either byte order."""

    def write(self, out: CdrWriter, value: Any) -> None:
        """See `Codec`."""
        if not 0 <= value <= 0xFFFF:
            raise LocalProtocolError(f"{value} is not 0..65535")
        out.octets(value.to_bytes(2, "big"))

    def read(self, data: CdrReader) -> Any:
        """See `Codec`."""
        return int.from_bytes(data.octets(2), "big")


class _Blob(Codec):
    """Bytes with their count before them."""

    def write(self, out: CdrWriter, value: Any) -> None:
        """See `Codec`."""
        out.number("I", len(value))
        out.octets(value)

    def read(self, data: CdrReader) -> Any:
        """See `Codec`."""
        return data.octets(data.count())


class _Rest(Codec):
    """All the bytes that are left."""

    def write(self, out: CdrWriter, value: Any) -> None:
        """See `Codec`."""
        out.octets(value)

    def read(self, data: CdrReader) -> Any:
        """See `Codec`."""
        return data.octets(data.left)


class Named(Codec):
    """A number that has names; one without a name is refused."""

    def __init__(self, number: Codec, names: type[enum.IntEnum]) -> None:
        self._number = number
        self._names = names

    def write(self, out: CdrWriter, value: Any) -> None:
        """See `Codec`."""
        self._number.write(out, value)

    def read(self, data: CdrReader) -> Any:
        """See `Codec`."""
        value = self._number.read(data)
        try:
            return self._names(value)
        except ValueError:
            raise RemoteProtocolError(f"{value} is no {self._names.__name__}") from None


class Optional(Codec):
    """What may be absent, None."""

    def __init__(self, codec: Codec) -> None:
        self._codec = codec

    def write(self, out: CdrWriter, value: Any) -> None:
        """See `Codec`."""
        BOOLEAN.write(out, value is not None)
        if value is not None:
            self._codec.write(out, value)

    def read(self, data: CdrReader) -> Any:
        """See `Codec`."""
        return self._codec.read(data) if BOOLEAN.read(data) else None


class IfLeft(Codec):
    """A last field that some send and others do not: None if nothing is left."""

    def __init__(self, codec: Codec) -> None:
        self._codec = codec

    def write(self, out: CdrWriter, value: Any) -> None:
        """See `Codec`."""
        if value is not None:
            self._codec.write(out, value)

    def read(self, data: CdrReader) -> Any:
        """See `Codec`."""
        return self._codec.read(data) if data.left else None


class Sequence(Codec):
    """Any number of one kind: a tuple."""

    def __init__(self, codec: Codec) -> None:
        self._codec = codec

    def write(self, out: CdrWriter, value: Any) -> None:
        """See `Codec`."""
        out.number("I", len(value))
        for one in value:
            self._codec.write(out, one)

    def read(self, data: CdrReader) -> Any:
        """See `Codec`."""
        return tuple(self._codec.read(data) for _ in range(data.count()))


class Pair(Codec):
    """Two values, one behind the other: a tuple."""

    def __init__(self, first: Codec, second: Codec) -> None:
        self._both = (first, second)

    def write(self, out: CdrWriter, value: Any) -> None:
        """See `Codec`."""
        for codec, one in zip(self._both, value, strict=True):
            codec.write(out, one)

    def read(self, data: CdrReader) -> Any:
        """See `Codec`."""
        return tuple(codec.read(data) for codec in self._both)


class Record(Codec):
    """A dataclass: its fields in the order in which they stand on the line."""

    def __init__(self, kind: type, **layout: Codec) -> None:
        self.kind = kind
        self._layout = layout

    def write(self, out: CdrWriter, value: Any) -> None:
        """See `Codec`."""
        for name, codec in self._layout.items():
            codec.write(out, getattr(value, name))

    def read(self, data: CdrReader) -> Any:
        """See `Codec`."""
        return self.kind(**self.fields(data))

    def fields(self, data: CdrReader) -> dict[str, Any]:
        """Reads them without putting them together."""
        return {name: codec.read(data) for name, codec in self._layout.items()}


class Either(Codec):
    """One of several records, with its number in a byte before it."""

    def __init__(self, cases: Mapping[Any, Codec]) -> None:
        self._cases = cases
        self._numbers = {_kind_in(codec): number for number, codec in cases.items()}

    def write(self, out: CdrWriter, value: Any) -> None:
        """See `Codec`."""
        number = self._numbers.get(type(value))
        if number is None:
            raise LocalProtocolError(f"{type(value).__name__} does not belong here")
        U8.write(out, number)
        self._cases[number].write(out, value)

    def read(self, data: CdrReader) -> Any:
        """See `Codec`."""
        number = U8.read(data)
        if number not in self._cases:
            raise RemoteProtocolError(f"{number} is none of {sorted(map(int, self._cases))}")
        return self._cases[number].read(data)


class Embedded(Codec):
    """A record in bytes of its own, with their count before them; alignment begins anew in it."""

    def __init__(self, record: Record) -> None:
        self.record = record

    def write(self, out: CdrWriter, value: Any) -> None:
        """See `Codec`."""
        inner = CdrWriter(little_endian=out.little_endian, max_align=out.max_align)
        self.record.write(inner, value)
        BLOB.write(out, inner.data)

    def read(self, data: CdrReader) -> Any:
        """See `Codec`."""
        return self.record.read(CdrReader(BLOB.read(data), little_endian=data.little_endian, max_align=data.max_align))


def _kind_in(codec: Codec) -> type:
    record = codec.record if isinstance(codec, Embedded) else codec
    if not isinstance(record, Record):
        raise TypeError(f"{codec} is no record")
    return record.kind


U8, I16, U16, I32, U32, U64 = map(Number, "BhHiIQ")
BOOLEAN = Number("?")
ID, BLOB, REST = _Id(), _Blob(), _Rest()
