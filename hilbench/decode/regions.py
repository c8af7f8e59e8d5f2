"""Which bytes of a frame are what: its envelope by the protocol's framing, its fields by trying.

A field's bytes are those that change it when they change. That needs no second description of each message, and cannot
disagree with the decoder. It takes one decoding for each byte: for a frame that somebody looks at, not for a stream.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from itertools import groupby
from typing import Any

from hilbench.decode.pkt_decoder import pkt_format
from hilbench.decode.reading import DecodeOptions
from protocols import autoware, carla, p2os, pkt

__all__ = ["Region", "regions"]

_FLIPS = (0x01, 0x80)

_NO_FIELD = frozenset({"structure", "unused", "unread"})

Fields = Mapping[str, str]
Parts = list[tuple[str, int]]
"""Names and lengths."""
Read = Callable[[bytes], Any]

_SENSELESS = (
    autoware.RemoteProtocolError,
    carla.RemoteProtocolError,
    p2os.RemoteProtocolError,
    pkt.RemoteProtocolError,
)


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


def regions(protocol: str, raw: bytes, *, sent: bool, options: DecodeOptions) -> list[Region]:
    """Return what the bytes of a sound frame are, in order and without a gap.

    Args:
        protocol: ``p2os``, ``pkt``, ``carla`` or ``autoware``.
        raw: the frame.
        sent: whether the host sent it.
        options: how it is read.
    """
    match protocol:
        case "p2os":
            parts = _of_p2os(raw, sent=sent)
        case "carla":
            parts = _of_carla(raw)
        case "autoware":
            parts = _of_autoware(raw)
        case _:
            parts = _of_pkt(raw, options)
    found, start = [], 0
    for name, size in parts:
        found.append(Region(name=name, start=start, data=raw[start : start + size]))
        start += size
    return found


def _of_p2os(raw: bytes, *, sent: bool) -> Parts:
    middle = _body(raw[3:-2], p2os.decode_command if sent else _packet, "number" if sent else "type")
    return [("header", 2), ("count", 1), *middle, ("checksum", 2)]


def _of_pkt(raw: bytes, options: DecodeOptions) -> Parts:
    framing, schema = pkt_format(options)
    has_length = framing is pkt.Framing.LEN
    body = raw[5 if has_length else 4 : -3]
    is_report = bool(body) and body[0] >= pkt.ReportId.GENERAL
    read = pkt.decode_report if is_report else pkt.decode_command
    middle = _body(body, lambda data: read(data, schema), "id" if is_report else "opcode")
    return [("sync word", 4), *([("length", 1)] if has_length else []), *middle, ("CRC", 2), ("end", 1)]


def _of_carla(raw: bytes) -> Parts:
    """Return letters and values; a value is called what it means in the mode of its frame."""
    is_status = len(raw) <= carla.STATUS_BYTES
    layout = carla.STATUS_LAYOUT if is_status else carla.COMMAND_LAYOUT
    read = carla.decode_status if is_status else _carla_command
    whole = _fields(raw, read)
    parts, at = [("start", 1)], 1
    for field in layout.fields:
        name = _name_of(raw, at + 1, whole, read) if field.size > 1 else field.name
        parts += [(f"letter {chr(field.tag)}", 1), (field.name if name in _NO_FIELD else name, field.size)]
        at += 1 + field.size
    parts.append(("end", 1))
    padding = len(raw) - at - 1
    return [*parts, ("NUL", padding)] if padding > 0 else parts


def _carla_command(raw: bytes) -> Any:
    frame = carla.decode_command(raw)
    return carla.command_in(frame) or frame


def _of_autoware(raw: bytes) -> Parts:
    """Return the parts of a frame as it stands on the line, where an escaped byte takes two."""
    sizes, at = [], 0
    while at < len(raw):
        sizes.append(2 if raw[at] == autoware.ESCAPE else 1)
        at += sizes[-1]
    payload = next(iter(autoware.FrameReader().receive(raw)))
    if not isinstance(payload, autoware.Frame):
        return [("unread", len(raw))]
    middle = _body(payload.payload, autoware.decode_message, "id")
    plain = [("flag", 1), ("source", 1), ("remote", 1), ("length", 2), *middle, ("CRC", 2)]
    parts, byte = [], 0
    for name, count in plain:
        parts.append((name, sum(sizes[byte : byte + count])))
        byte += count
    return parts


def _packet(body: bytes) -> Any:
    return p2os.decode_packet(body, connected=False)


def _body(body: bytes, read: Read, first: str) -> Parts:
    """Return names and lengths of the fields of a body; its first byte says what it is."""
    if not body:
        return []
    whole = _fields(body, read)
    names = [first, *(_name_of(body, at, whole, read) for at in range(1, len(body)))]
    return [(name, len(list(group))) for name, group in groupby(names)]


def _name_of(body: bytes, at: int, whole: Fields | None, read: Read) -> str:
    if whole is None:
        return "unread"
    for flip in _FLIPS:
        other = _fields(body[:at] + bytes((body[at] ^ flip,)) + body[at + 1 :], read)
        if other is None:
            return "structure"
        changed = [name for name in whole if other.get(name) != whole[name]]
        if changed:
            return changed[0] if len(changed) == 1 else "structure"
    return "unused"


def _fields(body: bytes, read: Read) -> Fields | None:
    """Return what a body says, field by field; None if it cannot be read."""
    try:
        message = read(body)
    except _SENSELESS:
        return None
    return {field.name: repr(getattr(message, field.name)) for field in fields(message)}
