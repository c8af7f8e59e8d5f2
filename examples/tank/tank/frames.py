"""Frames of the tank bus: a length byte, as many bytes of payload, the CRC-16 of both with its low byte first."""

import struct
from binascii import crc_hqx
from collections import namedtuple
from enum import Enum

from protocols.common.checksum import Checksum
from protocols.common.framing import Frame

LONGEST, GAP_NS = 8, 20_000_000  # bytes of payload; a longer pause ends a frame
CHECKSUM = Checksum(value=crc_hqx, begin=0xFFFF, first=0, stop=-2, at=-2, size=2, order="little")  # CRC-16/IBM-3740
Reason = Enum("Reason", {"LENGTH": "length out of range", "CRC": "wrong CRC"})

Read = namedtuple("Read", "")  # host: asks for the level
SetValve = namedtuple("SetValve", "percent")  # host: opens the valve by 0 to 100 %
Level = namedtuple("Level", "level_mm percent tripped")  # node: the answer; tripped: the watchdog has shut the valve
Refused = namedtuple("Refused", "command")  # node: does not carry out a command, by its first byte
LAYOUTS = {0x01: (Read, "<"), 0x02: (SetValve, "<B"), 0x81: (Level, "<HB?"), 0xFF: (Refused, "<B")}


class FrameError(ValueError):
    """A payload makes no sense."""


def encode(message, options=None):
    """Return the frame of a message."""
    number = next(number for number, (kind, _) in LAYOUTS.items() if isinstance(message, kind))
    return frame(bytes([number]) + struct.pack(LAYOUTS[number][1], *message))


def decode(payload):
    """Return the message of a payload, or raise FrameError."""
    kind, layout = LAYOUTS.get(payload[0], (None, "<"))
    if kind is None or len(payload) != 1 + struct.calcsize(layout):
        raise FrameError(f"no message: {payload.hex(' ').upper()}")
    return kind(*struct.unpack_from(layout, payload, 1))


def frame(payload):
    """Return a sound frame around 1 to LONGEST bytes."""
    return CHECKSUM.mended(bytes([len(payload)]) + payload + bytes(2))


def look(held):
    """Say what bytes begin with: a frame, no frame and why, or None while that is not known."""
    if not 1 <= held[0] <= LONGEST:
        return Reason.LENGTH
    raw = held[: held[0] + 3]
    if len(raw) < held[0] + 3:
        return None
    return Frame(raw, raw[1:-2]) if frame(raw[1:-2]) == raw else Reason.CRC
