"""Which bytes of a frame are what: its envelope by the protocol's framing, its fields by trying.

A field's bytes are those that change it when they change. That needs no second description of each message, and cannot
disagree with the decoder. It takes one decoding for each byte: for a frame that somebody looks at, not for a stream.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from itertools import groupby
from typing import Any

from hilbench.decode.decoders import DecodeOptions
from protocols import p2os, pkt

__all__ = ["Region", "regions"]

_FLIPS = (0x01, 0x80)

Fields = Mapping[str, str]
Read = Callable[[bytes], Any]


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
        protocol: ``p2os`` or ``pkt``.
        raw: the frame.
        sent: whether the host sent it.
        options: how it is read.
    """
    if protocol == "p2os":
        parts = [("header", 2), ("count", 1)]
        body = raw[3:-2]
        middle = _body(body, p2os.decode_command if sent else _packet, "number" if sent else "type")
        end = [("checksum", 2)]
    else:
        has_length = options.framing is pkt.Framing.LEN
        parts = [("sync word", 4), *([("length", 1)] if has_length else [])]
        body = raw[5 if has_length else 4 : -3]
        is_report = bool(body) and body[0] >= pkt.ReportId.GENERAL
        read = pkt.decode_report if is_report else pkt.decode_command
        middle = _body(body, lambda data: read(data, options.schema), "id" if is_report else "opcode")
        end = [("CRC", 2), ("end", 1)]
    found, start = [], 0
    for name, size in (*parts, *middle, *end):
        found.append(Region(name=name, start=start, data=raw[start : start + size]))
        start += size
    return found


def _packet(body: bytes) -> Any:
    return p2os.decode_packet(body, connected=False)


def _body(body: bytes, read: Read, first: str) -> list[tuple[str, int]]:
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
    except (p2os.RemoteProtocolError, pkt.RemoteProtocolError):
        return None
    return {field.name: repr(getattr(message, field.name)) for field in fields(message)}
