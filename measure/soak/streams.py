"""Bytes without end to send, which whoever receives them can tell from all others."""

from __future__ import annotations

import random

LARGEST = 64 * 1024
"""A piece has so many bytes at most."""


class Stream:
    """It repeats after a prime number of bytes, which no size of a piece divides.

    Attributes:
        sent: bytes that were taken from it to be sent.
        received: bytes that came.
        different: how many of those were others.
    """

    PERIOD = 1_000_003

    def __init__(self, seed):
        block = random.Random(seed).randbytes(self.PERIOD)
        self._block = block + block[:LARGEST]
        self.sent = self.received = self.different = 0

    def coming(self, count):
        """The next bytes to send; `sent` says how far it is."""
        at = self.sent % self.PERIOD
        return self._block[at : at + count]

    def take(self, data):
        for start in range(0, len(data), LARGEST):
            piece = data[start : start + LARGEST]
            at = self.received % self.PERIOD
            said = self._block[at : at + len(piece)]
            if piece != said:
                self.different += sum(one != other for one, other in zip(piece, said, strict=True))
            self.received += len(piece)
