"""What the adapter tells of itself."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = [
    "AdapterEvent",
    "AdapterHeld",
    "AdapterStarted",
    "BytesDropped",
    "CodesRead",
    "ConnectionPin",
    "DistanceBits",
    "EncoderWords",
    "RobotConnectFailed",
    "RobotConnected",
    "RobotLeft",
    "RobotLost",
    "SafeStopped",
    "SpeedSent",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class AdapterStarted:
    """It has begun to run, in mode ``bluepill`` or ``gamepad``, because of ``power`` or its ``reset line``."""

    mode: str
    cause: str


@dataclass(frozen=True, slots=True, kw_only=True)
class AdapterHeld:
    """Its reset line is high: it does nothing, drives nothing and has forgotten everything."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ConnectionPin:
    """p2dx_con is seen to be high or low, and acted on; the echo follows."""

    connected: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotConnected:
    """The robot has opened a session; what it said it was."""

    name: str
    robot_class: str
    subclass: str


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotConnectFailed:
    """No session came about."""

    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotLost:
    """The session is gone."""

    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotLeft:
    """The adapter has taken leave of the robot."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BytesDropped:
    """Bytes from the robot that were no message: how many, and why."""

    count: int
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class CodesRead:
    """Other motor codes (-4..3) than before were read, and what they mean."""

    left: int
    right: int
    speed_m_s: float
    turn_rad_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedSent:
    """VEL and RVEL went to the robot."""

    speed_mm_s: int
    turn_deg_s: int


@dataclass(frozen=True, slots=True, kw_only=True)
class SafeStopped:
    """Nothing moved on the pins for too long: the robot is told to stop until something does."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DistanceBits:
    """Other levels than before on the distance wires; bit 0 is DD1."""

    bits: int


@dataclass(frozen=True, slots=True, kw_only=True)
class EncoderWords:
    """Other numbers than before on the encoder wires, 0..7."""

    left: int
    right: int


AdapterEvent = (
    AdapterStarted
    | AdapterHeld
    | ConnectionPin
    | RobotConnected
    | RobotConnectFailed
    | RobotLost
    | RobotLeft
    | BytesDropped
    | CodesRead
    | SpeedSent
    | SafeStopped
    | DistanceBits
    | EncoderWords
)
