"""Bytes that wait until the receiver looks for them; see `PollOptions`.

The looks are at whole multiples of their period from the epoch, so the result depends on when bytes came and not on how
they were cut. A byte that comes at the very time of a look waits for the next one.
"""

from __future__ import annotations

from protocols.pkt.framing import NOISE_RUN, Dropped, DropReason
from protocols.pkt.options import PollOptions

__all__ = ["PollQueue"]

_NS_PER_S = 1_000_000_000
_UNLUCKY = 11
"""EAGAIN in newlib, which the number of bytes read is compared with (application.cpp, `read_telecommands`)."""


class PollQueue:
    """The receive buffer in front of a polled decoder.

    Args:
        options: see `PollOptions`.
        epoch_ns: the time of the first look, in ns of bench time.
    """

    def __init__(self, options: PollOptions, epoch_ns: int = 0) -> None:
        self._options = options
        self._epoch_ns = epoch_ns
        self._waiting = bytearray()
        self._lost = bytearray()
        self._look_ns: int | None = None

    @property
    def held(self) -> int:
        """How many bytes wait."""
        return len(self._waiting)

    def next_deadline_ns(self) -> int | None:
        """When the next look takes bytes, in ns of bench time; None when none wait."""
        return self._look_ns

    def put(self, data: bytes, now_ns: int) -> None:
        """Takes bytes that came at `now_ns`, as many as there is room for."""
        room = self._options.buffer_bytes - len(self._waiting)
        self._waiting += data[:room]
        self._lost += data[room : room + NOISE_RUN - len(self._lost)]
        if self._waiting and self._look_ns is None:
            self._look_ns = self._look_after(now_ns)

    def take(self) -> tuple[bytes, list[Dropped]]:
        """What the look that is due yields, and what was lost: of the bytes without room the first `NOISE_RUN`."""
        dropped = [Dropped(reason=DropReason.OVERRUN, data=bytes(self._lost))] if self._lost else []
        self._lost.clear()
        taken = bytes(self._waiting[: self._options.bytes_each])
        del self._waiting[: len(taken)]
        looked_ns, self._look_ns = self._look_ns, None
        if self._waiting and looked_ns is not None:
            self._look_ns = self._look_after(looked_ns)
        if self._options.lose_eleven and len(taken) == _UNLUCKY:
            return b"", [*dropped, Dropped(reason=DropReason.POLL_OF_ELEVEN, data=taken)]
        return taken, dropped

    def _look_after(self, now_ns: int) -> int:
        """The first look behind this time; rates that do not divide a second are rounded down, never accumulated."""
        if now_ns < self._epoch_ns:
            return self._epoch_ns
        number = (now_ns - self._epoch_ns) * self._options.hz // _NS_PER_S
        while (look_ns := self._epoch_ns + number * _NS_PER_S // self._options.hz) <= now_ns:
            number += 1
        return look_ns
