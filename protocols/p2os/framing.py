"""Frames: header, count, body, checksum; and the reader that finds them in any stream of bytes.

A frame is `FA FB count body checksum`. The count is what follows it: the body and the two checksum bytes. The checksum
is the only big-endian item of the protocol. There is no byte stuffing, so `FA FB` may stand inside a body: a frame that
turns out to be bad is searched again from the byte after its header, and good frames behind it or inside it are found.
(Pioneer 2 Operations Manual, client-server chapter; sliding window as in the Player p2os driver, packet.cc. ARIA's
receiver differs: it loses a frame when a stray `FA` stands right before its header.)

What the reader promises:

- every byte received is reported exactly once, in order, in a `Frame` or in a `Dropped`;
- the results depend on the bytes and the times only, never on how the bytes were cut into pieces;
- between calls it keeps at most one unfinished frame or `NOISE_RUN` bytes of noise;
- the work is linear in the bytes received (a byte can be checksummed again only by the frames that could hold it, of
  which there are at most a third of the longest count).
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from struct import Struct

from protocols.p2os.errors import LocalProtocolError

__all__ = [
    "HEADER",
    "MAX_COUNT",
    "MAX_COUNT_AUX",
    "MAX_COUNT_STRICT",
    "MAX_COUNT_TOLERANT",
    "NOISE_RUN",
    "DropReason",
    "Dropped",
    "Frame",
    "FrameReader",
    "checksum",
    "encode_frame",
]

HEADER = b"\xfa\xfb"
MIN_COUNT = 3
"""The smallest count: a body of one byte and the checksum."""
MAX_COUNT_STRICT = 200
"""The largest count of a client frame (Pioneer 2 Operations Manual)."""
MAX_COUNT_TOLERANT = 207
"""The largest count that AMRISim's receiver, ClientPacketReceiver.cpp, takes without complaint."""
MAX_COUNT_AUX = 203
"""The largest count this family has a use for: GETAUX asks for up to 200 bytes (Pioneer 2 Operations Manual)."""
MAX_COUNT = 255
"""The largest count that a count byte can say. No manual limits the packets of a server; ARIA takes any of them."""
NOISE_RUN = 256
"""Noise is reported in runs of at most this many bytes."""

_OVERHEAD = 3
_BYTES_OF_COUNT = 256
_WORDS = tuple(Struct(f">{n}H") for n in range(_BYTES_OF_COUNT // 2))


def checksum(body: bytes) -> int:
    """The checksum of a body: big-endian words added modulo 65536, a last odd byte XORed into the low byte.

    Source: Pioneer 2 Operations Manual, client-server chapter; AriaCoda ArRobotPacket.cpp.
    """
    words, odd = divmod(len(body), 2)
    if words >= len(_WORDS):
        return _long_checksum(body)
    total: int = sum(_WORDS[words].unpack_from(body)) & 0xFFFF
    return total ^ body[-1] if odd else total


def _long_checksum(body: bytes) -> int:
    """The same sum for a body longer than any frame can hold."""
    even = len(body) & ~1
    total = ((sum(body[0:even:2]) << 8) + sum(body[1:even:2])) & 0xFFFF
    return total ^ body[-1] if len(body) & 1 else total


def encode_frame(body: bytes, *, max_count: int = MAX_COUNT_STRICT) -> bytes:
    """The whole frame around a body.

    Args:
        body: what the frame carries; its first byte is the command number or the packet type.
        max_count: the largest count byte allowed, 3 to 255.

    Raises:
        LocalProtocolError: the body is empty, or too long for `max_count`.
    """
    count = len(body) + 2
    if not MIN_COUNT <= count <= max_count:
        raise LocalProtocolError(f"a body of {len(body)} bytes makes a count of {count}, not {MIN_COUNT}..{max_count}")
    return b"".join((HEADER, bytes((count,)), body, checksum(body).to_bytes(2, "big")))


class DropReason(enum.Enum):
    """Why bytes did not become a message."""

    NOISE = "no header"
    BAD_COUNT = "count out of range"
    BAD_CHECKSUM = "wrong checksum"
    TIMED_OUT = "unfinished frame abandoned"
    BAD_BODY = "sound frame, senseless body"


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """A sound frame as it stood on the wire."""

    raw: bytes

    @property
    def body(self) -> bytes:
        """What the frame carries, without header, count and checksum."""
        return self.raw[3:-2]


@dataclass(frozen=True, slots=True, kw_only=True)
class Dropped:
    """Bytes that belong to no sound frame."""

    reason: DropReason
    data: bytes


class FrameReader:
    """Finds the frames in a stream of bytes.

    Args:
        max_count: the largest count byte taken for a frame: 200 by the manual, 207 to be as tolerant as AMRISim.
        timeout_ns: an unfinished frame is given up when no byte came for this long, in ns; None waits for ever.
            Without it a damaged count can hide what follows until that many bytes have come. No source gives a
            figure; see `ServerOptions.frame_timeout_s`.
    """

    __slots__ = ("_deadline_ns", "_held", "_max_count", "_need", "_timeout_ns")

    def __init__(self, *, max_count: int = MAX_COUNT_STRICT, timeout_ns: int | None = None) -> None:
        if not MIN_COUNT <= max_count < _BYTES_OF_COUNT:
            raise LocalProtocolError(f"max_count {max_count} is not {MIN_COUNT}..255")
        self._max_count = max_count
        self._timeout_ns = timeout_ns
        self._held = b""
        self._need = 0  # bytes held before which looking at them again is in vain
        self._deadline_ns: int | None = None

    @property
    def held(self) -> int:
        """How many bytes wait for more, in bytes; never more than the longest frame or `NOISE_RUN`."""
        return len(self._held)

    def next_deadline_ns(self) -> int | None:
        """When the bytes held are given up, in ns of bench time; None when none are held or no timeout is set."""
        return self._deadline_ns

    def receive(self, data: bytes, now_ns: int) -> list[Frame | Dropped]:
        """Takes the bytes that came at `now_ns`, in ns of bench time, and returns what they complete."""
        found = self.expire(now_ns)
        if data:
            self._held += data
            if len(self._held) >= self._need:
                self._held = self._scan(self._held, found)
            self._deadline_ns = now_ns + self._timeout_ns if self._held and self._timeout_ns is not None else None
        return found

    def expire(self, now_ns: int) -> list[Frame | Dropped]:
        """Gives up the bytes held if their time is over; sound frames inside them are still found."""
        found: list[Frame | Dropped] = []
        if self._deadline_ns is not None and now_ns >= self._deadline_ns:
            self._abandon(found)
        return found

    def reset(self) -> list[Frame | Dropped]:
        """Gives up the bytes held at once: the line went down."""
        found: list[Frame | Dropped] = []
        self._abandon(found)
        return found

    def _abandon(self, found: list[Frame | Dropped]) -> None:
        """Ends every unfinished frame, one header at a time, until nothing is held."""
        data = self._held
        while data:
            start = _header_start(data, 0, len(data))
            if start:
                found.append(Dropped(reason=DropReason.NOISE, data=data[:start]))
            end = _header_start(data, start + 1, len(data))
            if end > start:
                found.append(Dropped(reason=DropReason.TIMED_OUT, data=data[start:end]))
            data = self._scan(data[end:], found)
        self._held = b""
        self._need = 0
        self._deadline_ns = None

    def _scan(self, data: bytes, found: list[Frame | Dropped]) -> bytes:
        """Reports all that `data` decides and returns the undecided rest."""
        at, size = 0, len(data)
        self._need = 0
        while True:
            start = data.find(HEADER, at)
            if start < 0:
                return _hold_noise(data, at, found)
            if start > at:
                _report_noise(data, at, start, found)
            if start + _OVERHEAD > size:
                return data[start:]
            count = data[start + 2]
            if not MIN_COUNT <= count <= self._max_count:
                # A count of FA may itself begin the next header, so it is not dropped with this one.
                at = start + (2 if count == HEADER[0] else 3)
                found.append(Dropped(reason=DropReason.BAD_COUNT, data=data[start:at]))
                continue
            at = start + _OVERHEAD + count
            if at > size:
                self._need = at - start
                return data[start:]
            if checksum(data[start + _OVERHEAD : at - 2]) == data[at - 2] << 8 | data[at - 1]:
                found.append(Frame(raw=data[start:at]))
                continue
            at = _header_start(data, start + 2, at)
            found.append(Dropped(reason=DropReason.BAD_CHECKSUM, data=data[start:at]))


def _header_start(data: bytes, at: int, end: int) -> int:
    """Where the next header, or its first byte as the very last, stands in `data[at:end]`; `end` if nowhere."""
    start = data.find(HEADER, at, end)
    if start >= 0:
        return start
    return end - 1 if end > at and data[end - 1] == HEADER[0] else end


def _report_noise(data: bytes, start: int, end: int, found: list[Frame | Dropped]) -> None:
    """Reports `data[start:end]` as noise, in runs."""
    found.extend(
        Dropped(reason=DropReason.NOISE, data=data[at : min(at + NOISE_RUN, end)])
        for at in range(start, end, NOISE_RUN)
    )


def _hold_noise(data: bytes, at: int, found: list[Frame | Dropped]) -> bytes:
    """Reports the full runs of noise that reach to the end of the data, and returns what is not yet a full run."""
    runs_end = at + (_header_start(data, at, len(data)) - at) // NOISE_RUN * NOISE_RUN
    _report_noise(data, at, runs_end, found)
    return data[runs_end:]
