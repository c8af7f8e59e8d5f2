"""The measurement: frames into a client that takes lines for frames, and what of them comes out."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice

from protocols.pkt import Frame, FrameReader, LineReader, encode_frame, hides_newline

__all__ = ["Loss", "by_formula", "lost_by_lines", "lost_by_newline"]

_TOGETHER = 256


@dataclass(frozen=True, slots=True)
class Loss:
    """What was lost of so many frames."""

    lost: int
    of: int

    @property
    def share(self) -> float:
        """0 to 1."""
        return self.lost / self.of

    @property
    def uncertainty(self) -> float:
        """Two standard deviations of a share that is measured on so many frames."""
        return 2 * math.sqrt(max(self.share * (1 - self.share), 1 / self.of) / self.of)


def by_formula(size: int) -> float:
    """The share of random payloads of so many bytes that have a newline in themselves or in their CRC."""
    return 1 - (255 / 256) ** (size + 2)


def lost_by_lines(payloads: Iterator[bytes], count: int) -> tuple[Loss, Loss]:
    """What a client loses that takes lines for frames, and one that goes by the length, of so many frames."""
    by_line, by_length = LineReader(), FrameReader()
    shown_by_line = shown_by_length = 0
    left = count
    while left:
        frames = [encode_frame(payload) for payload in islice(payloads, min(left, _TOGETHER))]
        data = b"".join(frames)
        sent = set(frames)
        shown_by_line += sum(isinstance(item, Frame) and item.raw in sent for item in by_line.receive(data, 0))
        shown_by_length += sum(isinstance(item, Frame) for item in by_length.receive(data, 0))
        left -= len(frames)
    return Loss(count - shown_by_line, count), Loss(count - shown_by_length, count)


def lost_by_newline(payloads: Iterator[bytes], count: int) -> Loss:
    """What a receiver loses that ends a frame without a length byte at its first newline."""
    return Loss(sum(map(hides_newline, islice(payloads, count))), count)
