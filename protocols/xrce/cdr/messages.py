"""Messages in CDR, by their definitions: dictionaries in, bytes out, and back.

    types = MessageTypes()
    types.add(parse_message("demo/msg/Values", "float64[] values"))
    data = types.encode("demo/msg/Values", {"values": [1.0, 2.0]})
    message = types.decode("demo/msg/Values", data)

A message is a dictionary of its fields; arrays are lists, those of `uint8`, `byte` and `char` bytes. A message without
fields is one byte 0, as the C structures of ROS 2 need a member. Of `wstring` characters have two sizes in use: it is
neither written nor read. In XRCE the data stand without a header, and the byte
order is in the flags of the submessage; elsewhere there are four bytes before them (`encapsulate`).

All of it is XCDR1 (OMG DDS-XTypes 1.3, 7.4.1), which ROS 2 has on the line: final structures, alignment up to 8.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any

from protocols.xrce.cdr.codec import Codec, Number
from protocols.xrce.cdr.definitions import PRIMITIVES, FieldType, MessageDefinition
from protocols.xrce.cdr.stream import CdrReader, CdrWriter
from protocols.xrce.errors import LocalProtocolError, RemoteProtocolError

__all__ = ["MessageTypes", "decapsulate", "encapsulate"]

_HEADER_BYTES = 4
_IDENTIFIERS = {b"\0\0": False, b"\0\1": True}
_BYTES = "B"
_DEEPEST = 100
"""Messages in each other: a choice, far below what Python can call."""
_DUMMY = Number("B")


def encapsulate(data: bytes, *, little_endian: bool = True) -> bytes:
    """Data with the four bytes before them that DDS and recordings have (OMG DDSI-RTPS 2.3, 10.2)."""
    return bytes((0, little_endian, 0, 0)) + data


def decapsulate(data: bytes) -> tuple[bytes, bool]:
    """The data behind their four bytes, and whether they are little-endian.

    Raises:
        RemoteProtocolError: they are too short, or in another encoding than XCDR1 of a final structure.
    """
    little_endian = _IDENTIFIERS.get(data[:2])
    if little_endian is None or len(data) < _HEADER_BYTES:
        raise RemoteProtocolError(f"{data[:_HEADER_BYTES].hex(' ')} does not begin CDR")
    return data[_HEADER_BYTES:], little_endian


class MessageTypes:
    """Definitions that know each other."""

    def __init__(self) -> None:
        self._definitions: dict[str, MessageDefinition] = {}
        self._codecs: dict[str, _Message] = {}

    def add(self, definition: MessageDefinition) -> None:
        """Takes a definition, also before those of the messages in it.

        Raises:
            LocalProtocolError: there is another one of this name.
        """
        known = self._definitions.setdefault(definition.name, definition)
        if known != definition:
            raise LocalProtocolError(f"{definition.name} is defined twice, and not alike")

    def __getitem__(self, name: str) -> MessageDefinition:
        """The definition of a message, by its full name; LocalProtocolError without one."""
        if name not in self._definitions:
            raise LocalProtocolError(f"{name} is not defined")
        return self._definitions[name]

    def encode(self, name: str, message: Mapping[str, Any], *, little_endian: bool = True) -> bytes:
        """A message in CDR; a field that is not in it has its default.

        Raises:
            LocalProtocolError: the message, or one in it, is not defined; a field is not in it, or does not fit.
        """
        out = CdrWriter(little_endian=little_endian)
        self._codec(name).write(out, message)
        return out.data

    def decode(self, name: str, data: bytes, *, little_endian: bool = True) -> dict[str, Any]:
        """The message in CDR; bytes behind it are passed over.

        Raises:
            LocalProtocolError: the message, or one in it, is not defined.
            RemoteProtocolError: the data end before, or make no sense.
        """
        message: dict[str, Any] = self._codec(name).read(CdrReader(data, little_endian=little_endian))
        return message

    def _codec(self, name: str, within: tuple[str, ...] = ()) -> _Message:
        """How a message is written and read, put together when it is first needed."""
        if name in within:
            raise LocalProtocolError(f"{name} holds itself, by {' and '.join(within[within.index(name) :])}")
        if len(within) == _DEEPEST:
            raise LocalProtocolError(f"{name} is {_DEEPEST} messages deep in {within[0]}")
        if name not in self._codecs:
            inner = (*within, name)
            fields = {field.name: (self._field(field.type, inner), field.default) for field in self[name].fields}
            self._codecs[name] = _Message(fields)
        return self._codecs[name]

    def _field(self, kind: FieldType, within: tuple[str, ...]) -> _Field:
        code = PRIMITIVES.get(kind.base)
        if code is not None:
            return _Numbers(code, kind) if kind.is_array else _One(Number(code), 0.0 if code in "fd" else 0)
        if kind.base == "wstring":
            raise LocalProtocolError("wstring is neither written nor read here")
        if kind.base == "string":
            one = _One(_BoundedText(kind.string_bound), "")
        else:
            one = _One(self._codec(kind.base, within), {})
        return _Several(one, kind) if kind.is_array else one


class _Field(Codec):
    """A codec that knows what stands where nothing is said."""

    @property
    @abstractmethod
    def empty(self) -> Any:
        """That."""


class _One(_Field):
    def __init__(self, codec: Codec, empty: Any) -> None:
        self._codec = codec
        self._empty = empty

    @property
    def empty(self) -> Any:
        return self._empty

    def write(self, out: CdrWriter, value: Any) -> None:
        self._codec.write(out, value)

    def read(self, data: CdrReader) -> Any:
        return self._codec.read(data)


class _BoundedText(Codec):
    """A string of at most so many bytes."""

    def __init__(self, most: int | None) -> None:
        self._most = most

    def write(self, out: CdrWriter, value: Any) -> None:
        if not isinstance(value, str):
            raise LocalProtocolError(f"{value!r} is no string")
        out.text(value, self._most)

    def read(self, data: CdrReader) -> Any:
        return data.text(self._most)


class _Array(_Field):
    """Several of a kind: so many, at most so many, or any number."""

    def __init__(self, kind: FieldType) -> None:
        self._fixed = None if kind.is_bounded else kind.size
        self._most = kind.size if kind.is_bounded else None

    def _write_count(self, out: CdrWriter, count: int) -> None:
        if self._fixed is not None:
            if count != self._fixed:
                raise LocalProtocolError(f"{count} values where there are {self._fixed}")
            return
        if self._most is not None and count > self._most:
            raise LocalProtocolError(f"{count} values where there are {self._most} at most")
        out.number("I", count)

    def _read_count(self, data: CdrReader) -> int:
        if self._fixed is not None:
            return self._fixed
        count = data.count()
        if self._most is not None and count > self._most:
            raise RemoteProtocolError(f"a sequence of {count} where there are {self._most} at most")
        return count


class _Numbers(_Array):
    """Numbers: a list, or bytes."""

    def __init__(self, code: str, kind: FieldType) -> None:
        super().__init__(kind)
        self._code = code

    @property
    def empty(self) -> Any:
        count = self._fixed or 0
        return bytes(count) if self._code == _BYTES else [0] * count

    def write(self, out: CdrWriter, value: Any) -> None:
        try:
            values = bytes(value) if self._code == _BYTES and not isinstance(value, int) else tuple(value)
        except (TypeError, ValueError) as error:
            raise LocalProtocolError(f"{value!r} are no numbers: {error}") from None
        self._write_count(out, len(values))
        if isinstance(values, bytes):
            out.octets(values)
        elif self._code == "?":
            for one in values:
                out.number(self._code, one)
        else:
            out.numbers(self._code, values)

    def read(self, data: CdrReader) -> Any:
        count = self._read_count(data)
        if self._code == _BYTES:
            return data.octets(count)
        if self._code == "?":
            return [data.number(self._code) for _ in range(count)]
        return list(data.numbers(self._code, count))


class _Several(_Array):
    """Strings or messages: a list."""

    def __init__(self, one: _Field, kind: FieldType) -> None:
        super().__init__(kind)
        self._one = one

    @property
    def empty(self) -> Any:
        return [self._one.empty] * (self._fixed or 0)

    def write(self, out: CdrWriter, value: Any) -> None:
        if isinstance(value, str | bytes | Mapping) or not hasattr(value, "__len__"):
            raise LocalProtocolError(f"{value!r} is no list")
        self._write_count(out, len(value))
        for one in value:
            self._one.write(out, one)

    def read(self, data: CdrReader) -> Any:
        return [self._one.read(data) for _ in range(self._read_count(data))]


class _Message(Codec):
    """A structure: a dictionary."""

    def __init__(self, fields: Mapping[str, tuple[_Field, Any]]) -> None:
        self._fields = fields

    def write(self, out: CdrWriter, value: Any) -> None:
        if not isinstance(value, Mapping):
            raise LocalProtocolError(f"{value!r} is no message")
        if unknown := value.keys() - self._fields.keys():
            raise LocalProtocolError(f"there is no field {', '.join(sorted(map(str, unknown)))}")
        for name, (codec, default) in self._fields.items():
            absent = codec.empty if default is None and name not in value else default
            try:
                codec.write(out, value.get(name, absent))
            except LocalProtocolError as error:
                raise LocalProtocolError(f"{name}: {error}") from None
        if not self._fields:
            _DUMMY.write(out, 0)

    def read(self, data: CdrReader) -> Any:
        if not self._fields:
            _DUMMY.read(data)
        return {name: codec.read(data) for name, (codec, _) in self._fields.items()}
