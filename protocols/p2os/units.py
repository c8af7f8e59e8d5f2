"""Raw fields to physical units and back, for a given robot, and a pose that does not jump where a counter wraps."""

from __future__ import annotations

import math
from dataclasses import dataclass

from protocols.p2os.options import CompassRule, Dialect
from protocols.p2os.robots import RobotParameters
from protocols.p2os.sip import Sip

__all__ = [
    "NO_ECHO_RAW",
    "Pose",
    "PoseTracker",
    "SipReading",
    "analog_v",
    "battery_v",
    "bumpers",
    "compass_deg",
    "distance_raw",
    "heading_raw",
    "is_no_echo",
    "read_sip",
    "sonar_range_mm",
    "sonar_range_raw",
    "timer_bytes",
    "wheel_speed_mm_s",
    "wheel_speed_raw",
]

POSITION_MASK = 0x7FFF
"""Fifteen bits of x and y count; the counter wraps at 32768, of some firmware at 65536 (AriaCoda ArRobot.cpp)."""

NO_ECHO_RAW = 32_000
"""What a sonar of a real Pioneer 2-DX reports when nothing comes back: 8576 mm (a capture in p2os-arduino)."""

_ARIA_ANGLE_RAD = 0.00153
_FULL_SCALE_V = 5.0


def _centred(value: int, modulus: int) -> int:
    """The number congruent to `value` in -modulus/2 .. modulus/2 - 1."""
    half = modulus // 2
    return (value + half) % modulus - half


def _angle_unit_rad(robot: RobotParameters, dialect: Dialect) -> float:
    return _ARIA_ANGLE_RAD if dialect.aria_angle else robot.angle_unit_rad


def distance_raw(mm: float, robot: RobotParameters) -> int:
    """A position in mm as the 15-bit counter of a SIP, rounded to the nearest unit."""
    return round(mm / robot.distance_unit_mm) & POSITION_MASK


def heading_raw(rad: float, robot: RobotParameters) -> int:
    """A heading in rad as a SIP has it: half a turn is -2048..2047 on a Pioneer 2."""
    return _centred(round(rad * robot.units_per_turn / (2 * math.pi)), robot.units_per_turn)


def wheel_speed_raw(mm_s: float, robot: RobotParameters) -> int:
    """A wheel speed in mm/s in units of a SIP, within sixteen bits."""
    return max(-0x8000, min(0x7FFF, round(mm_s / robot.speed_unit_mm_s)))


def wheel_speed_mm_s(raw: int, robot: RobotParameters) -> float:
    """A wheel speed of a SIP in mm/s."""
    return raw * robot.speed_unit_mm_s


def sonar_range_raw(mm: float | None, robot: RobotParameters) -> int:
    """A sonar range in mm, None for no echo, in units of a SIP."""
    return NO_ECHO_RAW if mm is None else max(0, min(0xFFFF, round(mm / robot.range_unit_mm)))


def sonar_range_mm(raw: int, robot: RobotParameters) -> float:
    """A sonar range of a SIP in mm; for no echo what the robot sends for it, 8576 mm on a Pioneer 2-DX."""
    return raw * robot.range_unit_mm


def is_no_echo(raw: int) -> bool:
    """The sonar heard nothing."""
    return raw >= NO_ECHO_RAW


def battery_v(sip: Sip) -> float:
    """The battery voltage in V."""
    return sip.battery_dv / 10


def analog_v(sip: Sip) -> float:
    """The voltage at the selected analog port, 0..5 V."""
    return sip.analog * _FULL_SCALE_V / 0xFF


def timer_bytes(sip: Sip, dialect: Dialect = Dialect()) -> tuple[int, int]:  # noqa: B008 - frozen
    """The (analog port, gripper bits) of the word behind the sonar readings."""
    low, high = sip.timer & 0xFF, sip.timer >> 8
    return (high, low) if dialect.gripper_first else (low, high)


def compass_deg(raw: int, rule: CompassRule = CompassRule.ARIA) -> int | None:
    """The compass byte in degrees; None for no reading, which only the Player rule knows."""
    if rule is CompassRule.ARIA:
        return 2 * raw
    return None if raw in (0, 181, 255) else 2 * (raw - 1)


def bumpers(sip: Sip, robot: RobotParameters) -> tuple[int, int]:
    """The (front, rear) masks of pressed bumper segments, bit 0 for segment 1.

    A robot without a ring has 0, whatever the packet says: a real Pioneer 2-DX without bumpers sends all bits set
    (p2os-arduino, captured).
    """
    front = sip.front_bumpers & ((1 << robot.front_bumpers) - 1)
    return front, sip.rear_bumpers & ((1 << robot.rear_bumpers) - 1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Pose:
    """A pose by odometry: mm and rad in the frame of the start; the heading is not wrapped."""

    x_mm: float = 0.0
    y_mm: float = 0.0
    heading_rad: float = 0.0

    @property
    def heading_deg(self) -> float:
        """The heading in degrees, not wrapped."""
        return math.degrees(self.heading_rad)


class PoseTracker:
    """Follows the counters of one SIP after the other, so that x, y and heading run on where the counters wrap.

    A step is taken for the shortest one modulo 32768 units (a wrap at 65536 is then no step either) and modulo a turn.
    The first SIP after the start or `reset` gives the pose itself, with x and y read as signed 15-bit numbers.

    Args:
        robot: whose units the SIPs have.
        dialect: of which the angle matters here.
    """

    __slots__ = ("_angle_rad", "_last", "_robot", "_th", "_x", "_y")

    def __init__(self, robot: RobotParameters, dialect: Dialect = Dialect()) -> None:  # noqa: B008 - frozen
        self._robot = robot
        self._angle_rad = _angle_unit_rad(robot, dialect)
        self.reset()

    def reset(self) -> None:
        """Forgets everything: the next SIP is a first one. Call it after SETO."""
        self._last: Sip | None = None
        self._x = self._y = self._th = 0

    def update(self, sip: Sip) -> Pose:
        """Takes the next SIP and returns the pose it brings."""
        x, y, th = (0, 0, 0) if self._last is None else (self._last.x_raw, self._last.y_raw, self._last.th_raw)
        self._x += _centred(sip.x_raw - x, POSITION_MASK + 1)
        self._y += _centred(sip.y_raw - y, POSITION_MASK + 1)
        self._th += _centred(sip.th_raw - th, self._robot.units_per_turn)
        self._last = sip
        return self.pose

    @property
    def pose(self) -> Pose:
        """The pose of the last SIP."""
        unit = self._robot.distance_unit_mm
        return Pose(x_mm=self._x * unit, y_mm=self._y * unit, heading_rad=self._th * self._angle_rad)


@dataclass(frozen=True, slots=True, kw_only=True)
class SipReading:
    """A SIP in physical units.

    Attributes:
        moving: the robot moves.
        left_mm_s: speed of the left wheel.
        right_mm_s: speed of the right wheel.
        battery_v: in V.
        left_stall: the left wheel is stalled.
        right_stall: the right wheel is stalled.
        front_bumpers: mask of pressed segments, 0 on a robot without.
        rear_bumpers: as above.
        motors_enabled: the motors have power.
        sonar_enabled: the sonar fires.
        heading_error_rad: heading asked for less heading.
        compass_deg: None for no reading.
        sonars_mm: range by disc number, of the new readings only.
        no_echo: the discs among them that heard nothing.
        analog_port: the selected port.
        analog_v: its voltage.
        gripper_state: see `GripperPacket.state`.
        digin: digital inputs, one bit each.
        digout: digital outputs, one bit each.
    """

    moving: bool
    left_mm_s: float
    right_mm_s: float
    battery_v: float
    left_stall: bool
    right_stall: bool
    front_bumpers: int
    rear_bumpers: int
    motors_enabled: bool
    sonar_enabled: bool
    heading_error_rad: float
    compass_deg: int | None
    sonars_mm: dict[int, float]
    no_echo: frozenset[int]
    analog_port: int
    analog_v: float
    gripper_state: int
    digin: int
    digout: int


def read_sip(sip: Sip, robot: RobotParameters, dialect: Dialect = Dialect()) -> SipReading:  # noqa: B008 - frozen
    """Reads all of a SIP but the pose, for which see `PoseTracker`."""
    front, rear = bumpers(sip, robot)
    port, gripper = timer_bytes(sip, dialect)
    error_raw = _centred(sip.control_raw - sip.th_raw, robot.units_per_turn)
    return SipReading(
        moving=sip.moving,
        left_mm_s=wheel_speed_mm_s(sip.left_raw, robot),
        right_mm_s=wheel_speed_mm_s(sip.right_raw, robot),
        battery_v=battery_v(sip),
        left_stall=sip.left_stall,
        right_stall=sip.right_stall,
        front_bumpers=front,
        rear_bumpers=rear,
        motors_enabled=sip.motors_enabled,
        sonar_enabled=sip.sonar_enabled,
        heading_error_rad=error_raw * _angle_unit_rad(robot, dialect),
        compass_deg=compass_deg(sip.compass_raw, dialect.compass),
        sonars_mm={reading.number: sonar_range_mm(reading.range_raw, robot) for reading in sip.sonars},
        no_echo=frozenset(reading.number for reading in sip.sonars if is_no_echo(reading.range_raw)),
        analog_port=port,
        analog_v=analog_v(sip),
        gripper_state=gripper,
        digin=sip.digin,
        digout=sip.digout,
    )
