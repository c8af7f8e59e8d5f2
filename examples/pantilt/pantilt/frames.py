"""Frames of the servo bus: a5, the servo's id, a length, as many bytes of payload, the inverted sum of all but a5."""

import struct
from collections import namedtuple
from enum import Enum

from protocols.common.framing import Frame

SYNC = 0xA5
LONGEST = 8  # bytes of payload
GAP_NS = 20_000_000  # a longer pause ends a frame
IDS = {"pan": 1, "tilt": 2}
Reason = Enum("Reason", {"SYNC": "no beginning of a frame", "LENGTH": "length out of range", "SUM": "wrong checksum"})

Goal = namedtuple("Goal", "servo angle_cdeg")  # host: go to an angle, in 0.01 degrees
Read = namedtuple("Read", "servo")  # host: asks for position and load
Torque = namedtuple("Torque", "servo on")  # host: hold with torque, or let go
Status = namedtuple("Status", "servo angle_cdeg load_percent torque tripped")  # servo; tripped: by its watchdog
Refused = namedtuple("Refused", "servo why")  # servo: does not do it
LAYOUTS = {0x01: (Goal, "<h"), 0x02: (Read, "<"), 0x03: (Torque, "<?"), 0x81: (Status, "<hb??"), 0xFF: (Refused, "<B")}
Why = Enum("Why", {"SENSELESS": 1, "OUT_OF_RANGE": 2, "TORQUE_OFF": 3})


class FrameError(ValueError):
    """A payload makes no sense."""


def encode(message, options=None):
    """Return the frame of a message."""
    number = next(number for number, (kind, _) in LAYOUTS.items() if isinstance(message, kind))
    return frame(message.servo, bytes([number]) + struct.pack(LAYOUTS[number][1], *message[1:]))


def decode(found):
    """Return the message of a sound frame, or raise FrameError."""
    servo, payload = found.raw[1], found.payload
    kind, layout = LAYOUTS.get(payload[0], (None, "<"))
    if kind is None or len(payload) != 1 + struct.calcsize(layout):
        raise FrameError(f"no message: {payload.hex(' ').upper()}")
    return kind(servo, *struct.unpack_from(layout, payload, 1))


def frame(servo, payload):
    """Return a sound frame around 1 to LONGEST bytes."""
    body = bytes([servo, len(payload)]) + payload
    return bytes([SYNC]) + body + bytes([~sum(body) & 0xFF])


def look(held):
    """Say what bytes begin with: a frame, no frame and why, or None while that is not known."""
    if held[0] != SYNC:
        return Reason.SYNC
    if len(held) > 2 and not 1 <= held[2] <= LONGEST:
        return Reason.LENGTH
    if len(held) < 4 or len(held) < held[2] + 4:
        return None
    raw = held[: held[2] + 4]
    return Frame(raw, raw[3:-1]) if frame(raw[1], raw[3:-1]) == raw else Reason.SUM
