"""The standard server information packet (SIP), which the server sends every 100 ms of a session.

All fields are the raw ones of the wire; `units.py` turns them into millimetres and degrees for a given robot.
(Pioneer 2 Operations Manual, server information packets; AriaCoda ArRobot.cpp, processMotorPacket; Player sip.cc.)
"""

from __future__ import annotations

from dataclasses import dataclass
from struct import Struct, error
from typing import ClassVar

from protocols.p2os.errors import LocalProtocolError, RemoteProtocolError
from protocols.p2os.fields import FieldReader, FieldWriter

__all__ = ["LateSipFields", "Sip", "SonarReading"]

_FRONT = Struct("<BHHhhhBBBhHBB")
_READING = Struct("<BH")
_BACK = Struct("<HBBB")


@dataclass(frozen=True, slots=True, kw_only=True)
class SonarReading:
    """One new sonar reading.

    Attributes:
        number: the disc, from 0 (POLLING counts from 1).
        range_raw: 0..65535, in units of the robot's RangeConvFactor; see `units.sonar_range_mm`.
    """

    number: int
    range_raw: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Sip:
    """One SIP, type 32 hex when the robot stands and 33 hex when it moves.

    Attributes:
        moving: the status byte: the robot moves.
        x_raw: 0..65535, position in units of DistConvFactor; 15 bits count, it wraps.
        y_raw: as `x_raw`.
        th_raw: heading, -2048..2047 for a turn, + counter-clockwise.
        left_raw: speed of the left wheel, mm/s on a Pioneer 2 (VelConvFactor 1).
        right_raw: speed of the right wheel, as above.
        battery_dv: battery voltage in 0.1 V, 0..255.
        stall_rear: byte 15: bit 0 left wheel stalled, bits 1-5 rear bumper segments (1 pressed).
        stall_front: byte 16: bit 0 right wheel stalled, bits 1-5 front bumper segments (7 of them on AROS).
        control_raw: the heading asked for, in units of `th_raw`.
        flags: bit 0 motors enabled, bit 1 sonar on; ARCOS has more, see the properties.
        compass_raw: 0..255, in units of 2 degrees; 0 where there is none.
        sonars: the new readings since the last SIP.
        timer: the word behind the readings: on P2OS low byte the selected analog port, high byte the gripper.
        analog: 0..255 for 0..5 V at the selected analog port.
        digin: the digital inputs, one bit each.
        digout: the digital outputs, one bit each.
        tail: what late firmware appends; `late_fields` reads it. Empty on a Pioneer 2-DX.
    """

    STOPPED: ClassVar[int] = 0x32
    MOVING: ClassVar[int] = 0x33
    WIDE_TYPES: ClassVar[frozenset[int]] = frozenset((0x30, 0x31, 0x34))
    """Further status bytes that the Player, ROS and ESP32 clients take for a SIP; odd ones count as moving."""

    moving: bool = False
    x_raw: int = 0
    y_raw: int = 0
    th_raw: int = 0
    left_raw: int = 0
    right_raw: int = 0
    battery_dv: int = 0
    stall_rear: int = 0
    stall_front: int = 0
    control_raw: int = 0
    flags: int = 0
    compass_raw: int = 0
    sonars: tuple[SonarReading, ...] = ()
    timer: int = 0x0005
    analog: int = 0
    digin: int = 0
    digout: int = 0
    tail: bytes = b""

    def encode(self) -> bytes:
        """The body of the packet.

        Raises:
            LocalProtocolError: a field does not fit its place.
        """
        status = self.MOVING if self.moving else self.STOPPED
        front = (
            *(status, self.x_raw, self.y_raw, self.th_raw, self.left_raw, self.right_raw, self.battery_dv),
            *(self.stall_rear, self.stall_front, self.control_raw, self.flags, self.compass_raw, len(self.sonars)),
        )
        try:
            parts = [_FRONT.pack(*front)]
            parts += [_READING.pack(reading.number, reading.range_raw) for reading in self.sonars]
            parts.append(_BACK.pack(self.timer, self.analog, self.digin, self.digout))
        except error as problem:
            raise LocalProtocolError(f"{self} does not fit a SIP: {problem}") from None
        return b"".join(parts) + self.tail

    @classmethod
    def decode(cls, body: bytes) -> Sip:
        """Reads the body of a SIP of type 30 to 34 hex.

        Raises:
            RemoteProtocolError: it ends too early for its sonar count.
        """
        try:
            status, x, y, th, left, right, battery, rear, front, control, flags, compass, n = _FRONT.unpack_from(body)
            back = _FRONT.size + n * _READING.size
            timer, analog, digin, digout = _BACK.unpack_from(body, back)
        except error:
            raise RemoteProtocolError(f"a SIP of {len(body)} bytes is too short for its sonar count") from None
        readings = _READING.iter_unpack(body[_FRONT.size : back])
        return cls(
            moving=bool(status & 1),
            x_raw=x,
            y_raw=y,
            th_raw=th,
            left_raw=left,
            right_raw=right,
            battery_dv=battery,
            stall_rear=rear,
            stall_front=front,
            control_raw=control,
            flags=flags,
            compass_raw=compass,
            sonars=tuple(SonarReading(number=number, range_raw=distance) for number, distance in readings),
            timer=timer,
            analog=analog,
            digin=digin,
            digout=digout,
            tail=body[back + _BACK.size :],
        )

    @property
    def left_stall(self) -> bool:
        """The left wheel is stalled: byte 15, bit 0 (the TCM2 manual alone says the other byte)."""
        return bool(self.stall_rear & 1)

    @property
    def right_stall(self) -> bool:
        """The right wheel is stalled: byte 16, bit 0."""
        return bool(self.stall_front & 1)

    @property
    def rear_bumpers(self) -> int:
        """Rear bumper mask, bit 0 = segment 1. Meaningless on a robot without bumpers: see `units.bumpers`."""
        return self.stall_rear >> 1

    @property
    def front_bumpers(self) -> int:
        """Front bumper mask, bit 0 = segment 1. Meaningless on a robot without bumpers: see `units.bumpers`."""
        return self.stall_front >> 1

    @property
    def motors_enabled(self) -> bool:
        """Flag bit 0."""
        return bool(self.flags & 0x0001)

    @property
    def sonar_enabled(self) -> bool:
        """Flag bit 1, and on ARCOS any of bits 1-4, one for each array (AriaCoda ArRobot.cpp)."""
        return bool(self.flags & 0x001E)

    @property
    def stop_button(self) -> bool:
        """Flag bit 5, ARCOS only."""
        return bool(self.flags & 0x0020)

    @property
    def analog_port(self) -> int:
        """The selected analog port, as P2OS sends it: the low byte (the capture of a real Pioneer 2-DX has 05 00)."""
        return self.timer & 0xFF

    @property
    def gripper_state(self) -> int:
        """The gripper bits, as P2OS sends them: the high byte. ARCOS swaps both bytes; see `Dialect`."""
        return self.timer >> 8


# name, size in bytes, signed
_LATE = (
    ("battery_dv", 2, False),
    ("charge_state", 1, False),
    ("rotation_ddeg_s", 2, True),
    ("fault_flags", 2, False),
    ("lateral_mm_s", 2, True),
    ("temperature_c", 1, True),
    ("charge_percent", 1, True),
    ("time_us", 4, False),
    ("flags3", 4, False),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class LateSipFields:
    """What late firmware appends to a SIP; an item that the packet does not reach is None.

    Source: AriaCoda ArRobot.cpp, processMotorPacket, which reads each item only while bytes remain.

    Attributes:
        battery_dv: battery voltage in 0.1 V, beyond what the SIP's one byte can hold.
        charge_state: state of the charger.
        rotation_ddeg_s: rotation rate in 0.1 degree/s.
        fault_flags: fault bits.
        lateral_mm_s: lateral speed in mm/s.
        temperature_c: degrees Celsius.
        charge_percent: state of charge in per cent.
        time_us: a counter of microseconds.
        flags3: further flags.
    """

    battery_dv: int | None = None
    charge_state: int | None = None
    rotation_ddeg_s: int | None = None
    fault_flags: int | None = None
    lateral_mm_s: int | None = None
    temperature_c: int | None = None
    charge_percent: int | None = None
    time_us: int | None = None
    flags3: int | None = None

    def encode(self) -> bytes:
        """The tail of a SIP, up to the first item that is None.

        Raises:
            LocalProtocolError: an item does not fit its place.
        """
        writer = FieldWriter(0)
        for name, size, signed in _LATE:
            value = getattr(self, name)
            if value is None:
                break
            (writer.signed if signed else writer.unsigned)(name, value, size)
        return writer.body[1:]

    @classmethod
    def decode(cls, tail: bytes) -> LateSipFields:
        """Reads a tail of any length; what it does not hold whole is None."""
        reader = FieldReader(tail, 0)
        values: dict[str, int] = {}
        for name, size, signed in _LATE:
            if reader.left < size:
                break
            values[name] = (reader.signed if signed else reader.unsigned)(size)
        return cls(**values)
