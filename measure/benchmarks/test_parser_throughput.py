"""Throughput of the frame reader beside a plain loop over the bytes.

The ratio is printed; nothing is asserted on time.
"""

from __future__ import annotations

import random

import pytest

from measure.benchmarks.throughput import STREAM_BYTES, compare, cut
from protocols.p2os import FrameReader, Sip, SonarReading, encode_packet
from protocols.p2os.framing import Frame


class PlainReader:
    """What one writes first: a state machine fed byte by byte. It does not look again into a bad frame."""

    def __init__(self):
        self.frames = []
        self._state = 0
        self._count = 0
        self._body = []

    def receive(self, data):
        for byte in data:
            if self._state == 0:
                self._state = 1 if byte == 0xFA else 0
            elif self._state == 1:
                self._state = 2 if byte == 0xFB else (1 if byte == 0xFA else 0)
            elif self._state == 2:
                self._count = byte
                self._body = []
                self._state = 3 if 3 <= byte <= 200 else 0
            else:
                self._body.append(byte)
                if len(self._body) == self._count:
                    self._finish()

    def _finish(self):
        total = 0
        body = self._body[:-2]
        for at in range(0, len(body) - 1, 2):
            total = (total + (body[at] << 8 | body[at + 1])) & 0xFFFF
        if len(body) & 1:
            total ^= body[-1]
        if total == self._body[-2] << 8 | self._body[-1]:
            self.frames.append(bytes(body))
        self._state = 0


def sip_stream():
    """SIPs as a robot sends them, three readings each."""
    chance = random.Random(1)
    data = bytearray()
    while len(data) < STREAM_BYTES:
        readings = tuple(SonarReading(number=n, range_raw=chance.randrange(20_000)) for n in range(3))
        data += encode_packet(Sip(moving=True, x_raw=chance.randrange(32768), sonars=readings))
    return bytes(data)


def noisy_stream():
    """The same with a tenth of the bytes in noise between the frames."""
    chance = random.Random(2)
    data = bytearray()
    while len(data) < STREAM_BYTES:
        data += encode_packet(Sip(x_raw=chance.randrange(32768))) + chance.randbytes(chance.randrange(7))
    return bytes(data)


@pytest.mark.parametrize("stream", [sip_stream, noisy_stream])
@pytest.mark.parametrize("size", [4096, 39, 1])
def test_throughput(stream, size, say):
    parts = cut(stream(), size)
    figures = compare(FrameReader, Frame, PlainReader, parts)
    say(f"{stream.__name__}, chunks of {size}: {figures}")
