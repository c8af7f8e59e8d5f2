"""UBX frames, and how a receiver finds them and NMEA sentences among the bytes that come in.

A frame is B5 62, class, number, length (two bytes, little-endian), payload, and an eight-bit Fletcher sum over
everything from the class to the end of the payload (GPS.G6-SW-10018, sections "UBX Packet Structure" and "UBX
Checksum").
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

__all__ = ["Dropped", "Inlet", "Line", "UbxMessage", "fletcher", "frame"]

_SYNC = b"\xb5\x62"
_BEGINNING = re.compile(rb"[\xb5$]")
_HEAD = 6
_TAIL = 2
MOST_PAYLOAD = 1024
"""A longer frame is taken for noise (choice)."""
MOST_LINE = 128
"""The same of a longer sentence (choice; NMEA 0183 has 82)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class UbxMessage:
    """One message."""

    group: int
    number: int
    payload: bytes = b""


@dataclass(frozen=True, slots=True)
class Line:
    """One line that begins with ``$``, without its end."""

    data: bytes


@dataclass(frozen=True, slots=True)
class Dropped:
    """Something that began well and was nothing in the end, and why."""

    reason: str


def fletcher(data: bytes) -> bytes:
    """Return the two bytes of the checksum (RFC 1145)."""
    a = b = 0
    for byte in data:
        a = a + byte & 0xFF
        b = b + a & 0xFF
    return bytes((a, b))


def frame(message: UbxMessage) -> bytes:
    """Return a message as it stands on the line."""
    body = bytes((message.group, message.number)) + len(message.payload).to_bytes(2, "little") + message.payload
    return _SYNC + body + fletcher(body)


class Inlet:
    """Cuts what comes in. Whatever it is, it raises nothing and keeps little."""

    def __init__(self) -> None:
        self._held = b""

    def receive(self, data: bytes) -> Iterator[UbxMessage | Line | Dropped]:
        """Take bytes; return everything that is complete now."""
        held, at = self._held + data, 0
        while (start := _start(held, at)) is not None:
            at = start
            cut, found = _cut_ubx(held, at) if held[at] == _SYNC[0] else _cut_line(held, at)
            if cut == 0:
                self._held = held[at:]
                return
            at += cut
            if found is not None:
                yield found
        self._held = b""


def _start(held: bytes, at: int) -> int | None:
    """Where something may begin, from `at` on."""
    found = _BEGINNING.search(held, at)
    return found.start() if found else None


def _cut_ubx(held: bytes, at: int) -> tuple[int, UbxMessage | Dropped | None]:
    """How many bytes to cut off, 0 to wait for more, and what they are."""
    if held[at : at + len(_SYNC)] != _SYNC[: len(held) - at]:
        return 1, None
    if len(held) - at < _HEAD:
        return 0, None
    size = int.from_bytes(held[at + 4 : at + _HEAD], "little")
    if size > MOST_PAYLOAD:
        return len(_SYNC), Dropped(f"a UBX message of {size} bytes")
    end = at + _HEAD + size
    if len(held) < end + _TAIL:
        return 0, None
    if fletcher(held[at + len(_SYNC) : end]) != held[end : end + _TAIL]:
        return len(_SYNC), Dropped("a UBX message with a wrong checksum")
    return end + _TAIL - at, UbxMessage(group=held[at + 2], number=held[at + 3], payload=held[at + _HEAD : end])


def _cut_line(held: bytes, at: int) -> tuple[int, Line | Dropped | None]:
    """The same for a sentence, which another one or a UBX message cuts short."""
    line = held[at : at + MOST_LINE]
    end = line.find(b"\n")
    other = min((where for where in (line.find(b"$", 1), line.find(_SYNC)) if where >= 0), default=-1)
    if 0 <= other < end or (end < 0 <= other):
        return other, Dropped("a sentence without an end")
    if end < 0:
        return (len(line), Dropped("a sentence without an end")) if len(line) == MOST_LINE else (0, None)
    return end + 1, Line(line[:end].rstrip(b"\r"))
