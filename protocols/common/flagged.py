"""Frames between flags with escaped bytes, addresses, a length and a CRC, and the reader that finds them in any stream.

    7E  source  destination  length low  length high  payload  CRC low  CRC high

Behind the flag, each 7E and 7D is sent as 7D and the byte with bit 5 turned over: addresses, length and CRC as well.
Length and CRC are those of the payload before that. So a flag always begins a frame, and a receiver that lost its place
finds it at the next one (eProsima/Micro-XRCE-DDS-Client,
src/c/profile/transport/stream_framing/stream_framing_protocol.c).

What the reader promises:

- every byte received is reported exactly once, in order, in a `Frame` or in a `Dropped`;
- the results depend on the bytes only, never on how they were cut into pieces;
- between calls it keeps at most one unfinished frame or `NOISE_RUN` bytes of noise;
- the work is linear in the bytes received.

As in the original's reader, a flag within a frame begins another one, also behind a 7D; a 7D is undone whatever follows
it; a frame for another address or longer than the limit is passed over up to the next flag.
"""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

from protocols.common.layout import Body, Region, laid_out

__all__ = [
    "COUNTER_OF_DROP",
    "CRC_BYTES",
    "NOISE_RUN",
    "DropReason",
    "Dropped",
    "FlaggedOptions",
    "Frame",
    "FrameReader",
    "crc16",
    "encode_frame",
    "frame_regions",
    "longest_frame",
]

NOISE_RUN = 256
"""Noise is reported in runs of at most this many bytes."""
CRC_BYTES = 2
"""Bytes of a CRC on the wire, before escaping."""

_FLAG = b"\x7e"
_ESCAPE = 0x7D
_TURNED = 0x20
_ADDRESS_BYTES = 2
_HEADER_BYTES = 4
_MOST = 0xFFFF
_POLYNOMIAL = 0xA001


@dataclass(frozen=True, slots=True, kw_only=True)
class FlaggedOptions:
    """How frames are made and found; a protocol derives its own from it.

    Attributes:
        MISUSE: the class of the protocol's errors for a wrong figure and a payload that is too long.
        local_address: of this end; 0 at both ends in the original (Micro-XRCE-DDS-Client, custom_transport.c).
        remote_address: of the other end.
        max_payload: the largest payload, in bytes; by default whatever the length field can say.
    """

    MISUSE: ClassVar[type[Exception]] = ValueError

    local_address: int = 0
    remote_address: int = 0
    max_payload: int = _MOST

    def __post_init__(self) -> None:
        """Checks the figures; `MISUSE` names the wrong one."""
        for name in ("local_address", "remote_address"):
            if not 0 <= getattr(self, name) <= 0xFF:
                raise self.MISUSE(f"{name} {getattr(self, name)} is not 0..255")
        if not 1 <= self.max_payload <= _MOST:
            raise self.MISUSE(f"max_payload {self.max_payload} is not 1..{_MOST}")


def _entry(index: int) -> int:
    for _ in range(8):
        index = index >> 1 ^ (_POLYNOMIAL if index & 1 else 0)
    return index


_TABLE = tuple(_entry(index) for index in range(256))


def crc16(payload: bytes) -> int:
    """The CRC of a payload, 0..65535; 0 of an empty one, BB3D hex of the nine digits "123456789".

    CRC-16/ARC: polynomial 8005 hex, reflected (A001), begins with 0, nothing turned over at the end; on the wire over
    the payload alone, before escaping, low byte first (stream_framing_protocol.c, `uxr_update_crc`).
    """
    crc = 0
    for byte in payload:
        crc = crc >> 8 ^ _TABLE[(crc ^ byte) & 0xFF]
    return crc


def encode_frame(payload: bytes, options: FlaggedOptions) -> bytes:
    """The whole frame around a payload.

    Raises:
        MISUSE of the options: the payload is longer than they allow.
    """
    if len(payload) > options.max_payload:
        raise options.MISUSE(f"a payload of {len(payload)} bytes is longer than {options.max_payload}")
    header = bytes((options.local_address, options.remote_address)) + len(payload).to_bytes(2, "little")
    body = header + payload + crc16(payload).to_bytes(CRC_BYTES, "little")
    return _FLAG + body.replace(b"\x7d", b"\x7d\x5d").replace(b"\x7e", b"\x7d\x5e")


def longest_frame(options: FlaggedOptions) -> int:
    """The size of the longest frame, in bytes: everything behind the flag escaped."""
    return 1 + 2 * (_HEADER_BYTES + options.max_payload + CRC_BYTES)


class DropReason(enum.Enum):
    """Why bytes did not become a message."""

    NOISE = "no flag"
    CUT_SHORT = "a flag within the frame"
    NOT_FOR_US = "another destination address"
    BAD_LENGTH = "length beyond the limit"
    BAD_CRC = "wrong CRC"
    BAD_BODY = "sound frame, senseless message"


COUNTER_OF_DROP = MappingProxyType(
    {
        DropReason.NOISE: "noise",
        DropReason.CUT_SHORT: "cut_short",
        DropReason.NOT_FOR_US: "not_for_us",
        DropReason.BAD_LENGTH: "bad_lengths",
        DropReason.BAD_CRC: "bad_crcs",
        DropReason.BAD_BODY: "bad_bodies",
    }
)
"""The counter of each reason, as protocols on such frames call it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """A sound frame.

    Attributes:
        raw: as it stood on the wire.
        source: the address of its sender.
        payload: what it carries, unescaped.
    """

    raw: bytes
    source: int
    payload: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class Dropped:
    """Bytes that belong to no sound frame."""

    reason: DropReason
    data: bytes


class FrameReader:
    """Finds frames in a stream.

    Args:
        options: limits and addresses.
    """

    def __init__(self, options: FlaggedOptions) -> None:
        self._options = options
        self._raw = bytearray()
        self._body = bytearray()
        self._wanted = 0  # bytes of the body when it is looked at next; 0 outside of a frame
        self._escaped = False
        self._found: list[Frame | Dropped] = []

    @property
    def held(self) -> int:
        """Bytes of an unfinished frame or of noise that are kept; bounded."""
        return len(self._raw)

    def receive(self, data: bytes, now_ns: int = 0) -> list[Frame | Dropped]:
        """Takes bytes; returns what they complete, in order. The time plays no part. Raises nothing."""
        del now_ns
        first, *others = data.split(_FLAG)
        self._take(first)
        for piece in others:
            self._give_up()
            self._raw += _FLAG
            self._wanted = _ADDRESS_BYTES
            self._take(piece)
        found, self._found = self._found, []
        return found

    def reset(self) -> list[Frame | Dropped]:
        """The line is gone: gives up what is unfinished, and returns it."""
        self._give_up()
        found, self._found = self._found, []
        return found

    def _take(self, piece: bytes) -> None:
        """Takes bytes without a flag, as far as each look needs them."""
        at = 0
        while self._wanted and at < len(piece):
            some = piece[at : at + self._wanted - len(self._body)]
            at += len(some)
            self._raw += some
            self._unescape(some)
            if len(self._body) == self._wanted:
                self._look()
        self._noise(piece[at:])

    def _unescape(self, some: bytes) -> None:
        if not self._escaped and _ESCAPE not in some:
            self._body += some
            return
        for byte in some:
            if self._escaped:
                self._body.append(byte ^ _TURNED)
                self._escaped = False
            elif byte == _ESCAPE:
                self._escaped = True
            else:
                self._body.append(byte)

    def _look(self) -> None:
        """Judges the frame as far as it has come: its address, its length, all of it."""
        body = self._body
        if self._wanted == _ADDRESS_BYTES:
            self._wanted = _HEADER_BYTES
            if body[1] != self._options.local_address:
                self._end(DropReason.NOT_FOR_US)
            return
        length = int.from_bytes(body[_ADDRESS_BYTES:_HEADER_BYTES], "little")
        whole = _HEADER_BYTES + length + CRC_BYTES
        if length > self._options.max_payload:
            self._end(DropReason.BAD_LENGTH)
        elif self._wanted < whole:
            self._wanted = whole
        else:
            self._finish(bytes(body[_HEADER_BYTES : _HEADER_BYTES + length]))

    def _finish(self, payload: bytes) -> None:
        if crc16(payload) != int.from_bytes(self._body[-CRC_BYTES:], "little"):
            self._end(DropReason.BAD_CRC)
            return
        self._found.append(Frame(raw=bytes(self._raw), source=self._body[0], payload=payload))
        self._begin_anew()

    def _noise(self, data: bytes) -> None:
        self._raw += data
        while not self._wanted and len(self._raw) >= NOISE_RUN:
            self._found.append(Dropped(reason=DropReason.NOISE, data=bytes(self._raw[:NOISE_RUN])))
            del self._raw[:NOISE_RUN]

    def _give_up(self) -> None:
        """Reports what stands there and is no frame."""
        if self._raw:
            self._end(DropReason.CUT_SHORT if self._wanted and len(self._raw) > 1 else DropReason.NOISE)

    def _end(self, reason: DropReason) -> None:
        self._found.append(Dropped(reason=reason, data=bytes(self._raw)))
        self._begin_anew()

    def _begin_anew(self) -> None:
        self._raw.clear()
        self._body.clear()
        self._wanted = 0
        self._escaped = False


def frame_regions(
    raw: bytes, options: FlaggedOptions, decode: Callable[[bytes], object], senseless: type[Exception], name: str
) -> list[Region]:
    """The parts of a sound frame as it stands on the wire, where an escaped byte takes two.

    Args:
        raw: the frame.
        options: limits and addresses.
        decode: reads the payload, for `protocols.common.layout.Body`.
        senseless: what it raises.
        name: of the first byte of the payload.
    """
    frame = next(iter(FrameReader(options).receive(raw)))
    if not isinstance(frame, Frame):
        return laid_out(raw, [("unread", len(raw))])
    widths, at = [], 0
    while at < len(raw):
        widths.append(2 if raw[at] == _ESCAPE else 1)
        at += widths[-1]
    middle = Body(frame.payload, decode, senseless).sizes(name)
    parts, byte = [], 0
    for part, count in [("flag", 1), ("source", 1), ("remote", 1), ("length", 2), *middle, ("CRC", CRC_BYTES)]:
        parts.append((part, sum(widths[byte : byte + count])))
        byte += count
    return laid_out(raw, parts)
