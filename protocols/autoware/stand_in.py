"""Frames of the stand-in link, and the reader that finds them in any stream of bytes.

    7E  source  remote  length low  length high  payload  CRC low  CRC high

The frame is that of the serial stream of Micro XRCE-DDS (eProsima/Micro-XRCE-DDS-Client,
src/c/profile/transport/stream_framing/stream_framing_protocol.c), so that an agent can take over the line; the payload
is ours (`payload.py`). Behind the flag, each 7E and 7D is sent as 7D and the byte with bit 5 turned over: addresses,
length and CRC as well. So a flag always begins a frame, and a receiver that lost its place finds it at the next one.
Length and CRC are those of the payload before escaping.

As in the original's reader: a flag within a frame begins another one, also behind a 7D; a 7D is undone whatever
follows it; a frame for another address or longer than the limit is passed over up to the next flag. Ours is that each
of these is reported, and that every byte received is reported exactly once, however the stream was cut.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass

from protocols.autoware.crc import CRC_BYTES, crc16
from protocols.autoware.errors import LocalProtocolError
from protocols.autoware.options import FramingOptions

__all__ = [
    "ESCAPE",
    "FLAG",
    "NOISE_RUN",
    "DropReason",
    "Dropped",
    "Frame",
    "FrameReader",
    "encode_frame",
    "longest_frame",
]

FLAG = 0x7E
ESCAPE = 0x7D
TURNED = 0x20
"""What an escaped byte is xored with."""
NOISE_RUN = 256
"""Noise is reported in runs of at most this many bytes."""

_HEADER_BYTES = 4
_DEFAULTS = FramingOptions()


def _escaped(data: bytes) -> bytes:
    escape = bytes((ESCAPE,))
    return data.replace(escape, bytes((ESCAPE, ESCAPE ^ TURNED))).replace(
        bytes((FLAG,)), bytes((ESCAPE, FLAG ^ TURNED))
    )


def encode_frame(payload: bytes, options: FramingOptions = _DEFAULTS) -> bytes:
    """The whole frame around a payload.

    Raises:
        LocalProtocolError: the payload is empty, or longer than the options allow.
    """
    if not 1 <= len(payload) <= options.max_payload:
        raise LocalProtocolError(f"a payload of {len(payload)} bytes is not 1..{options.max_payload}")
    header = bytes((options.local_address, options.remote_address)) + len(payload).to_bytes(2, "little")
    return bytes((FLAG,)) + _escaped(header + payload + crc16(payload).to_bytes(CRC_BYTES, "little"))


def longest_frame(options: FramingOptions = _DEFAULTS) -> int:
    """The size of the longest frame, in bytes: everything behind the flag escaped."""
    return 1 + 2 * (_HEADER_BYTES + options.max_payload + CRC_BYTES)


class DropReason(enum.Enum):
    """Why bytes did not become a message."""

    NOISE = "no flag"
    CUT_SHORT = "a flag within the frame"
    NOT_FOR_US = "another remote address"
    BAD_LENGTH = "length beyond the limit"
    BAD_CRC = "wrong CRC"
    BAD_BODY = "sound frame, senseless payload"


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

    def __init__(self, options: FramingOptions = _DEFAULTS) -> None:
        self._options = options
        self._raw = bytearray()
        self._body = bytearray()
        self._in_frame = False
        self._escape = False
        self._found: list[Frame | Dropped] = []

    @property
    def held(self) -> int:
        """Bytes of an unfinished frame or of noise that are kept; bounded."""
        return len(self._raw)

    def receive(self, data: bytes, now_ns: int = 0) -> list[Frame | Dropped]:
        """Takes bytes; returns what they complete, in order. The time plays no part. Raises nothing."""
        del now_ns
        for byte in data:
            if byte == FLAG:
                self._flag()
            elif self._in_frame:
                self._take(byte)
            else:
                self._noise(byte)
        found, self._found = self._found, []
        return found

    def reset(self) -> list[Dropped]:
        """The line is gone: gives up what is unfinished, and returns it."""
        self._give_up()
        self._in_frame = False
        dropped = [item for item in self._found if isinstance(item, Dropped)]
        self._found.clear()
        return dropped

    def _flag(self) -> None:
        self._give_up()
        self._in_frame = True
        self._raw.append(FLAG)

    def _give_up(self) -> None:
        """Reports what stands there and is no frame."""
        if self._raw:
            self._end(DropReason.CUT_SHORT if self._in_frame and len(self._raw) > 1 else DropReason.NOISE)

    def _noise(self, byte: int) -> None:
        self._raw.append(byte)
        if len(self._raw) == NOISE_RUN:
            self._end(DropReason.NOISE)

    def _take(self, byte: int) -> None:
        self._raw.append(byte)
        if self._escape:
            byte ^= TURNED
            self._escape = False
        elif byte == ESCAPE:
            self._escape = True
            return
        self._body.append(byte)
        if len(self._body) >= 2:
            self._judge()

    def _judge(self) -> None:
        """Looks at the frame as far as it has come."""
        body = self._body
        if body[1] != self._options.local_address:
            self._end(DropReason.NOT_FOR_US)
        elif len(body) >= _HEADER_BYTES:
            length = int.from_bytes(body[2:_HEADER_BYTES], "little")
            end = _HEADER_BYTES + length
            if length > self._options.max_payload:
                self._end(DropReason.BAD_LENGTH)
            elif len(body) == end + CRC_BYTES:
                self._finish(bytes(body[_HEADER_BYTES:end]), int.from_bytes(body[end:], "little"))

    def _finish(self, payload: bytes, crc: int) -> None:
        if crc != crc16(payload):
            self._end(DropReason.BAD_CRC)
            return
        self._found.append(Frame(raw=bytes(self._raw), source=self._body[0], payload=payload))
        self._begin_anew()

    def _end(self, reason: DropReason) -> None:
        self._found.append(Dropped(reason=reason, data=bytes(self._raw)))
        self._begin_anew()

    def _begin_anew(self) -> None:
        self._raw.clear()
        self._body.clear()
        self._in_frame = False
        self._escape = False
