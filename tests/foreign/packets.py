"""P2OS packets as foreign programs see them. Nothing here comes from the package `protocols`: that is what is tested.

Source of the format: Pioneer 2 Operations Manual, client-server chapter. How each program looks for a packet:
AriaCoda src/ArRobotPacketReceiver.cpp; Player server/drivers/mixed/p2os/packet.cc; allenh1/p2os
p2os_driver/src/packet.cpp.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

PULSE = SYNC0 = 0
OPEN = SYNC1 = 1
CLOSE = SYNC2 = 2
ENABLE, SETA, SETV, SETO, MOVE, SETRV, VEL, HEAD = 4, 5, 6, 7, 8, 10, 11, 12
CONFIG, RVEL, SETRA, SONAR, STOP, VEL2 = 18, 21, 23, 28, 29, 32
TTY2, GETAUX, BATTERYINFO = 42, 43, 62
STOPPED, MOVING, CONFIG_REPLY = 0x32, 0x33, 0x20


def checksum(body):
    """Big-endian 16-bit words added up, a last odd byte exclusive-ored."""
    total = 0
    for index in range(0, len(body) - 1, 2):
        total = (total + (body[index] << 8 | body[index + 1])) & 0xFFFF
    return total ^ body[-1] if len(body) % 2 else total


def frame(number, argument=None):
    """A command: without argument, with an integer (sign and magnitude), or with raw bytes from the type byte on."""
    body = bytes((number,))
    if isinstance(argument, bytes):
        body += argument
    elif argument is not None:
        body += struct.pack("<BH", 0x3B if argument >= 0 else 0x1B, abs(argument))
    return b"\xfa\xfb" + bytes((len(body) + 2,)) + body + struct.pack(">H", checksum(body))


class AriaReceiver:
    """Takes an FA, then wants an FB at once; a second FA is not taken for the start of a header."""

    def take(self, buffer):
        """Return the body of the first good packet in `buffer`, None if there is none yet; what was used is removed."""
        while len(buffer) >= 3:
            if buffer[0] != 0xFA:
                del buffer[0]
                continue
            if buffer[1] != 0xFB:
                del buffer[:2]
                continue
            count = buffer[2]
            if len(buffer) < 3 + count:
                return None
            body, received = bytes(buffer[3 : 1 + count]), bytes(buffer[1 + count : 3 + count])
            del buffer[: 3 + count]
            if count >= 3 and received == struct.pack(">H", checksum(body)):
                return body
        return None


class PlayerReceiver:
    """Slides a window of two bytes over the input until it holds a header."""

    def take(self, buffer):
        while True:
            start = buffer.find(b"\xfa\xfb")
            if start < 0:
                del buffer[:-1]
                return None
            del buffer[:start]
            if len(buffer) < 3 or len(buffer) < 3 + buffer[2]:
                return None
            count = buffer[2]
            body, received = bytes(buffer[3 : 1 + count]), bytes(buffer[1 + count : 3 + count])
            del buffer[: 3 + count]
            if body and self.accepts(checksum(body), *received):
                return body

    def accepts(self, computed, high, low):
        return computed == high << 8 | low


class RosReceiver(PlayerReceiver):
    """Its comparison has a misplaced parenthesis: any low byte but 0 passes; with 0 half of the right ones do not."""

    def accepts(self, computed, high, low):
        signed = computed - 0x10000 if computed >= 0x8000 else computed
        return low != 0 or signed == high << 8


@dataclass(frozen=True, slots=True, kw_only=True)
class Sip:
    """The fields of a standard information packet that the programs use."""

    moving: bool
    x_raw: int
    y_raw: int
    th_raw: int
    left_mm_s: int
    right_mm_s: int
    battery_dv: int
    motors: bool
    sonar: bool
    ranges_raw: dict[int, int]

    @classmethod
    def parse(cls, body):
        x, y, th, left, right, battery, _, _, _, flags, _, count = struct.unpack_from("<HHhhhBBBhHBB", body, 1)
        ranges = dict(struct.unpack_from("<BH", body, 20 + 3 * index) for index in range(count))
        assert len(body) == 25 + 3 * count, "a P2-DX has no tail"
        return cls(
            moving=body[0] == MOVING,
            x_raw=x,
            y_raw=y,
            th_raw=th,
            left_mm_s=left,
            right_mm_s=right,
            battery_dv=battery,
            motors=bool(flags & 1),
            sonar=bool(flags & 2),
            ranges_raw=ranges,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Config:
    """The limits that ARIA takes from a CONFIG packet."""

    subclass: str
    rotation_max: int
    translation_max: int
    rotation_accelerations: tuple[int, int]
    translation_accelerations: tuple[int, int]

    @classmethod
    def parse(cls, body):
        _, subclass, _, rest = body[1:].split(b"\0", 3)
        numbers = struct.unpack_from("<BHHHHH", rest)
        assert numbers[1]
        assert numbers[2], "a top speed of 0 leaves ARIA unable to drive"
        rest = rest[11:].split(b"\0", 1)[1]
        fields = struct.unpack_from("<BBBHHBHHHBHHHHHHHHHHHHH", rest)
        return cls(
            subclass=subclass.decode(),
            rotation_max=fields[14],
            translation_max=fields[15],
            rotation_accelerations=fields[16:18],
            translation_accelerations=fields[21:23],
        )


def identification(body):
    """Name, class and subclass out of the answer to SYNC2."""
    return tuple(part.decode() for part in body[1:].split(b"\0")[:3])


def wrapped(step, modulus):
    """The shortest step between two readings of a counter that wraps at `modulus`."""
    return (step + modulus // 2) % modulus - modulus // 2
