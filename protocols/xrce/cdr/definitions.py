"""What a `.msg` or `.srv` file says: fields and constants of messages, as ROS 2 reads them.

    # a comment
    uint8 NONE=0                  a constant
    string<=10 name "robot"       a field with a default; at most 10 bytes
    float64[3] position           three numbers
    geometry_msgs/Point[] path    any number of messages; of the own package without its name

Grammar: docs.ros.org, Interfaces; ros2/rosidl, rosidl_adapter/parser.py. `byte` and `char` are unsigned, as there. Not
read are the types `time` and `duration` of ROS 1.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass
from types import MappingProxyType

from protocols.xrce.errors import LocalProtocolError

__all__ = [
    "PRIMITIVES",
    "Constant",
    "Field",
    "FieldType",
    "MessageDefinition",
    "ServiceDefinition",
    "Value",
    "parse_message",
    "parse_service",
]

Value = bool | int | float | str
"""A value of a field or constant."""

PRIMITIVES = MappingProxyType(
    {
        "bool": "?",
        "byte": "B",
        "char": "B",
        "int8": "b",
        "uint8": "B",
        "int16": "h",
        "uint16": "H",
        "int32": "i",
        "uint32": "I",
        "int64": "q",
        "uint64": "Q",
        "float32": "f",
        "float64": "d",
    }
)
"""The types of numbers, with their codes in `struct`."""

_BOUNDS = MappingProxyType(
    {code: (-(1 << bits - 1), (1 << bits - 1) - 1) for code, bits in zip("bhiq", (8, 16, 32, 64), strict=True)}
    | {code: (0, (1 << bits) - 1) for code, bits in zip("BHIQ", (8, 16, 32, 64), strict=True)}
)
_NAME = re.compile(r"[A-Za-z]\w*")
_TEXTS = ("string", "wstring")
_TYPE = re.compile(
    r"(?P<base>[A-Za-z]\w*(?:/[A-Za-z]\w*){0,2})(?:<=(?P<bound>\d{1,10}))?(?P<array>\[(?:<=)?(?P<size>\d{0,10})\])?$"
)
_LINE = re.compile(r"(?P<type>\S+)\s+(?P<name>\w+)(?:\s*(?P<constant>=)|\s|$)(?P<value>.*)$")
_ELEMENT = r"""(?:\s*"(?:\\.|[^"\\])*"\s*|\s*'(?:\\.|[^'\\])*'\s*|[^,"']+)"""
_ELEMENTS = re.compile(rf"\[(?:\s*|{_ELEMENT}(?:,{_ELEMENT})*)\]")
_MOST = (1 << 32) - 1
"""Elements: what the count of a sequence can say."""
_SAID = re.compile(r"""(?:"(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*'|[^#])*""")  # what stands before a comment
_TRUTH = MappingProxyType({"true": True, "1": True, "false": False, "0": False})
_SEPARATOR = "---"


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldType:
    """What a field holds.

    Attributes:
        base: a name of `PRIMITIVES`, ``string``, ``wstring``, or the full name of a message, as
            ``std_msgs/msg/Header``.
        string_bound: the longest string, in bytes, of ``wstring`` in characters; None for any.
        is_array: it holds several.
        size: how many, or at most how many; None for any number.
        is_bounded: `size` is the most.
    """

    base: str
    string_bound: int | None = None
    is_array: bool = False
    size: int | None = None
    is_bounded: bool = False

    @property
    def is_message(self) -> bool:
        """It holds messages, neither numbers nor strings."""
        return self.base not in PRIMITIVES and self.base not in _TEXTS


@dataclass(frozen=True, slots=True, kw_only=True)
class Field:
    """A field, with what it holds where nothing is said; None for 0, false, an empty string or array."""

    name: str
    type: FieldType
    default: Value | tuple[Value, ...] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Constant:
    """A name for a value."""

    name: str
    type: FieldType
    value: Value


@dataclass(frozen=True, slots=True, kw_only=True)
class MessageDefinition:
    """A message; its name is full, as ``std_msgs/msg/String``."""

    name: str
    fields: tuple[Field, ...] = ()
    constants: tuple[Constant, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class ServiceDefinition:
    """A service: the messages of request and response, with `_Request` and `_Response` behind its name."""

    name: str
    request: MessageDefinition
    response: MessageDefinition


def parse_message(name: str, text: str) -> MessageDefinition:
    """What a `.msg` file says.

    Args:
        name: of the message, as ``package/msg/Name`` or ``package/Name``.
        text: of the file.

    Raises:
        LocalProtocolError: a line cannot be read, or a name stands there twice; the message names file and line.
    """
    package, kind, short = _full_name(name, "msg").split("/")
    return _parse(f"{package}/{kind}/{short}", text.removeprefix("\ufeff").splitlines(), 1)


def parse_service(name: str, text: str) -> ServiceDefinition:
    """What a `.srv` file says.

    Args:
        name: of the service, as ``package/srv/Name`` or ``package/Name``.
        text: of the file.

    Raises:
        LocalProtocolError: see `parse_message`; or there is not one line of three dashes.
    """
    full = _full_name(name, "srv")
    lines = text.removeprefix("\ufeff").splitlines()
    borders = [at for at, line in enumerate(lines) if line.strip() == _SEPARATOR]
    if len(borders) != 1:
        raise LocalProtocolError(f"{full}: a service has one line {_SEPARATOR}, not {len(borders)}")
    (border,) = borders
    return ServiceDefinition(
        name=full,
        request=_parse(f"{full}_Request", lines[:border], 1),
        response=_parse(f"{full}_Response", lines[border + 1 :], border + 2),
    )


def _full_name(name: str, kind: str) -> str:
    parts = name.split("/")
    if len(parts) == 2:
        parts.insert(1, kind)
    if len(parts) != 3 or not all(map(_NAME.fullmatch, parts)):
        raise LocalProtocolError(f"{name!r} is no name as package/{kind}/Name")
    return "/".join(parts)


def _parse(name: str, lines: list[str], first: int) -> MessageDefinition:
    package = name.partition("/")[0]
    fields: list[Field] = []
    constants: list[Constant] = []
    for number, line in enumerate(lines, first):
        try:
            found = _parse_line(line, package, {*(one.name for one in fields), *(one.name for one in constants)})
        except LocalProtocolError as error:
            raise LocalProtocolError(f"{name}, line {number}: {error}") from None
        if isinstance(found, Constant):
            constants.append(found)
        elif found is not None:
            fields.append(found)
    return MessageDefinition(name=name, fields=tuple(fields), constants=tuple(constants))


def _parse_line(line: str, package: str, known: Collection[str]) -> Field | Constant | None:
    before_comment = _SAID.match(line)
    said = before_comment.group().strip() if before_comment else ""
    if not said:
        return None
    found = _LINE.match(said)
    if found is None or not _NAME.fullmatch(found["name"]):
        raise LocalProtocolError(f"{said!r} is no field and no constant")
    if found["name"] in known:
        raise LocalProtocolError(f"{found['name']} stands there twice")
    kind, value = _parse_type(found["type"], package), found["value"].strip()
    if not found["constant"]:
        default = _parse_default(kind, value) if value else None
        return Field(name=found["name"], type=kind, default=default)
    if kind.is_array or kind.is_message:
        raise LocalProtocolError(f"a constant cannot be {found['type']}")
    return Constant(name=found["name"], type=kind, value=_parse_value(kind, value))


def _parse_type(text: str, package: str) -> FieldType:
    found = _TYPE.match(text)
    if found is None or found["base"] in ("time", "duration"):
        raise LocalProtocolError(f"{text!r} is no type that is known here")
    base = found["base"]
    if base not in (*PRIMITIVES, *_TEXTS):
        base = _full_name(base if "/" in base else f"{package}/{base}", "msg")
    if found["bound"] and base not in _TEXTS:
        raise LocalProtocolError(f"{text!r}: only a string has a bound of its own")
    size = int(found["size"]) if found["size"] else None
    is_bounded = "<=" in (found["array"] or "")
    if size == 0 or (size or 0) > _MOST or (is_bounded and size is None):
        raise LocalProtocolError(f"{text!r} is no size of an array")
    return FieldType(
        base=base,
        string_bound=int(found["bound"]) if found["bound"] else None,
        is_array=bool(found["array"]),
        size=size,
        is_bounded=is_bounded,
    )


def _parse_default(kind: FieldType, text: str) -> Value | tuple[Value, ...]:
    if not kind.is_array:
        return _parse_value(kind, text)
    if not _ELEMENTS.fullmatch(text):
        raise LocalProtocolError(f"{text!r} is no default of an array")
    values = tuple(_parse_value(kind, one.strip()) for one in re.findall(_ELEMENT, text[1:-1].strip()))
    if kind.size is not None and not (len(values) == kind.size or (kind.is_bounded and len(values) < kind.size)):
        raise LocalProtocolError(f"{len(values)} defaults for an array of {kind.size}")
    return values


def _parse_value(kind: FieldType, text: str) -> Value:
    if kind.base in _TEXTS:
        return _parse_text(kind, text)
    code = PRIMITIVES.get(kind.base)
    if code is None:
        raise LocalProtocolError(f"a {kind.base} has no default")
    try:
        if code == "?":
            return _TRUTH[text.lower()]
        if code in "fd":
            return float(text)
        number = int(text) if text.lstrip("+-").isdigit() else int(text, 0)
    except (KeyError, ValueError):
        raise LocalProtocolError(f"{text!r} is no {kind.base}") from None
    least, most = _BOUNDS[code]
    if not least <= number <= most:
        raise LocalProtocolError(f"{number} is not {least}..{most}, as {kind.base} is")
    return number


def _parse_text(kind: FieldType, text: str) -> str:
    quote = text[:1]
    if quote and quote in "\"'":
        if len(text) == 1 or text[-1] != quote:
            raise LocalProtocolError(f"{text} has a quote at one end")
        text = text[1:-1].replace(f"\\{quote}", quote)
    if kind.string_bound is not None and len(text.encode()) > kind.string_bound:
        raise LocalProtocolError(f"{text!r} is longer than {kind.string_bound} bytes")
    return text
