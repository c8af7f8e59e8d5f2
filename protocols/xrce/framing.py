"""How messages stand on a line: in serial frames (`protocols.common.flagged`), or over TCP behind their length.

The specification (OMG DDS-XRCE 1.0, Annex C.1.1.6) wants the CRC of RFC 1662 over addresses, length and payload in a
serial frame; what clients and agents in use have instead is CRC-16/ARC over the payload alone. Over TCP there are 16
bits of length before each message, low byte first, and nothing else (Micro-XRCE-DDS-Client,
src/c/profile/transport/ip/tcp/tcp_transport.c).
"""

from __future__ import annotations

from collections.abc import Iterable

from protocols.common import flagged
from protocols.common.flagged import NOISE_RUN, Dropped, DropReason, Frame
from protocols.xrce.codes import COOKIE, SubmessageId
from protocols.xrce.errors import RemoteProtocolError
from protocols.xrce.message import decode_header
from protocols.xrce.options import Framing, FramingOptions

__all__ = [
    "NOISE_RUN",
    "DropReason",
    "Dropped",
    "Frame",
    "FrameReader",
    "LengthReader",
    "LineReader",
    "encode_frame",
    "longest_frame",
]

_DEFAULTS = FramingOptions()
_LENGTH_BYTES = 2
_SUBHEADER_BYTES = 4
_RESULT_BYTES = 2


class FrameReader(flagged.FrameReader):
    """Finds serial frames in a stream."""

    def __init__(self, options: FramingOptions = _DEFAULTS) -> None:
        super().__init__(options)


def encode_frame(payload: bytes, options: FramingOptions = _DEFAULTS) -> bytes:
    """The whole frame around a payload; a serial one where the framing is not known yet.

    Raises:
        LocalProtocolError: the payload is longer than the options allow.
    """
    if options.framing is not Framing.LENGTH:
        return flagged.encode_frame(payload, options)
    if len(payload) > options.max_payload:
        raise options.MISUSE(f"a payload of {len(payload)} bytes is longer than {options.max_payload}")
    return len(payload).to_bytes(_LENGTH_BYTES, "little") + payload


def longest_frame(options: FramingOptions = _DEFAULTS) -> int:
    """The size of the longest frame, in bytes."""
    return flagged.longest_frame(options)


class LengthReader:
    """Finds messages behind their lengths; after one that is too long nothing is found any more, until a reset."""

    def __init__(self, options: FramingOptions = _DEFAULTS) -> None:
        self._most = options.max_payload
        self._bytes = bytearray()
        self._lost = False

    @property
    def held(self) -> int:
        """Bytes of an unfinished message; bounded."""
        return len(self._bytes)

    def receive(self, data: bytes) -> list[Frame | Dropped]:
        """Takes bytes; returns what they complete, in order. Raises nothing."""
        self._bytes += data
        found: list[Frame | Dropped] = []
        at = 0
        while not self._lost and len(self._bytes) >= at + _LENGTH_BYTES:
            length = int.from_bytes(self._bytes[at : at + _LENGTH_BYTES], "little")
            end = at + _LENGTH_BYTES + length
            self._lost = length > self._most
            if self._lost or len(self._bytes) < end:
                break
            raw = bytes(self._bytes[at:end])
            found.append(Frame(raw=raw, source=0, payload=raw[_LENGTH_BYTES:]))
            at = end
        del self._bytes[:at]
        if self._lost and self._bytes:
            found += self._given_up(DropReason.BAD_LENGTH)
        return found

    def reset(self) -> list[Frame | Dropped]:
        """The line is gone: gives up what is unfinished, and returns it."""
        self._lost = False
        return self._given_up(DropReason.CUT_SHORT)

    def _given_up(self, reason: DropReason) -> list[Frame | Dropped]:
        data = bytes(self._bytes)
        self._bytes.clear()
        return [Dropped(reason=reason, data=data)] if data else []


class LineReader(flagged.FrameReader):
    """Finds frames in the framing of the options; where that may be either, that of the first to end.

    A line begins with lengths if the first of them leads to a message that begins a session or pings, or to the answer
    to that. Until that is known, what a serial line would have had to drop is not reported.

    Args:
        options: framing, limits and addresses.

    Attributes:
        framing: that of the line, as far as it is known.
    """

    def __init__(self, options: FramingOptions) -> None:
        super().__init__(options)
        self._line_options = options
        self._lengths = LengthReader(options)
        self._doubtful: list[Frame | Dropped] = []
        self.framing = options.framing

    @property
    def held(self) -> int:
        """Bytes of what is unfinished, or of noise; bounded."""
        serial = 0 if self.framing is Framing.LENGTH else super().held
        return serial + self._lengths.held + sum(len(one.data) for one in self._doubtful if isinstance(one, Dropped))

    def receive(self, data: bytes, now_ns: int = 0) -> list[Frame | Dropped]:
        """Takes bytes; returns what they complete, in order. Raises nothing."""
        match self.framing:
            case Framing.SERIAL:
                return super().receive(data, now_ns)
            case Framing.LENGTH:
                return self._lengths.receive(data)
        self._doubtful += super().receive(data, now_ns)
        found = self._lengths.receive(data)
        serial_end = _first_end(self._doubtful)
        if serial_end is None and not found:
            return []
        length_end = _first_end(one for one in found[:1] if isinstance(one, Frame) and _begins(one.payload))
        if length_end is not None and (serial_end is None or length_end < serial_end):
            self._doubtful = found
            return self._is(Framing.LENGTH)
        return self._is(Framing.SERIAL)

    def reset(self) -> list[Frame | Dropped]:
        """The line is gone: gives up what is unfinished, and returns it; the next one may be of the other framing."""
        found = self._lengths.reset() if self.framing is Framing.LENGTH else self._doubtful + super().reset()
        options = self._line_options
        super().__init__(options)
        self._lengths, self._doubtful, self.framing = LengthReader(options), [], options.framing
        return found

    def _is(self, framing: Framing) -> list[Frame | Dropped]:
        self.framing = framing
        if framing is Framing.SERIAL:
            self._lengths = LengthReader(self._line_options)
        found, self._doubtful = self._doubtful, []
        return found


def _first_end(found: Iterable[Frame | Dropped]) -> int | None:
    """Where the first frame of a line ends, in bytes from its beginning; None if there is none."""
    end = 0
    for one in found:
        if isinstance(one, Frame):
            return end + len(one.raw)
        end += len(one.data)
    return None


def _begins(message: bytes) -> bool:
    """A message begins as the first ones of either end do: it begins a session, or is a ping."""
    try:
        _, body = decode_header(message)
    except RemoteProtocolError:
        return False
    payload = body[_SUBHEADER_BYTES:]
    match body[0] if payload else None:
        case SubmessageId.CREATE_CLIENT:
            return payload.startswith(COOKIE)
        case SubmessageId.STATUS_AGENT:
            return payload[_RESULT_BYTES:].startswith(COOKIE)
        case SubmessageId.GET_INFO | SubmessageId.INFO:
            return True
    return False
