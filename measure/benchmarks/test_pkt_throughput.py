"""Throughput of the PKT! frame reader beside a plain loop over the bytes, and beside its CRC alone.

The ratios are printed, with the CRC that is in use; nothing is asserted on time.
"""

from __future__ import annotations

import random

import pytest

from measure.benchmarks.throughput import STREAM_BYTES, compare, cut, rate
from protocols.pkt import Frame, FrameReader, ImuReport, MotionReport, crc16, encode_frame, encode_report


class PlainReader:
    """What one writes first, and what the firmware does: a state machine fed byte by byte."""

    def __init__(self):
        self.frames = []
        self._state = 0
        self._length = 0
        self._payload = []
        self._crc = 0

    def receive(self, data):
        for byte in data:
            if self._state < 4:
                self._state = self._state + 1 if byte == b"PKT!"[self._state] else 0
            elif self._state == 4:
                self._length, self._payload = byte, []
                self._state = 5 if 1 <= byte <= 96 else 0
            elif self._state == 5:
                self._payload.append(byte)
                if len(self._payload) == self._length:
                    self._state = 6
            elif self._state == 6:
                self._crc = byte << 8
                self._state = 7
            elif self._state == 7:
                self._state = 8 if self._crc | byte == crc16(bytes(self._payload)) else 0
            else:
                if byte == 0x0A:
                    self.frames.append(bytes(self._payload))
                self._state = 0


def telemetry():
    """Reports as a rover sends them: four of motion for one of the IMU."""
    chance = random.Random(1)
    data = bytearray()
    while len(data) < STREAM_BYTES:
        for _ in range(4):
            ticks = tuple(chance.randrange(100_000) for _ in range(4))
            data += encode_frame(encode_report(MotionReport(ticks=ticks)))
        data += encode_frame(encode_report(ImuReport(acceleration=(chance.random(), 0.0, 1.0))))
    return bytes(data)


def noisy_telemetry():
    """The same with noise between the frames."""
    chance = random.Random(2)
    data = bytearray()
    while len(data) < STREAM_BYTES:
        data += encode_frame(encode_report(MotionReport())) + chance.randbytes(chance.randrange(7))
    return bytes(data)


def only_crc(payloads):
    return sum(crc16(payload) < 0x10000 for payload in payloads)


@pytest.mark.parametrize("stream", [telemetry, noisy_telemetry])
@pytest.mark.parametrize("size", [4096, 32, 1])
def test_throughput(stream, size, say):
    parts = cut(stream(), size)
    figures = compare(FrameReader, Frame, PlainReader, parts)
    payloads = [item.payload for item in FrameReader().receive(b"".join(parts), 0) if isinstance(item, Frame)]
    crc, _ = rate(only_crc, payloads)
    say(f"{stream.__name__}, chunks of {size}: {figures}; CRC alone {crc:.1f} MB/s of payload")
