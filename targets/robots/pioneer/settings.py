"""What is burnt into a robot's FLASH, and what is bolted on: every value with its unit and where it comes from.

A source names a public document or program. "assumed" marks a physical value nobody published, "choice" a decision of
this model; both are listed in reports and neither changes a verdict by itself.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from types import MappingProxyType
from typing import Any, Literal

from protocols.p2os.options import WATCHDOG_S, WrongOrder
from protocols.p2os.robots import ROBOTS, RobotParameters, find_robot
from targets.robots.pioneer.hostbaud import RATES

PORTS = 5
"""Analog input ports of the user I/O connector, numbered 1 to 5 (Pioneer 2 Operations Manual, ADSEL)."""

_P2_MANUAL = "Pioneer 2 / PeopleBot Operations Manual, client-server chapter"
_ARIA = "reedhedges/AriaCoda params/p2dx.p"
_CONFIG = "typical CONFIG of a P2OS robot; assumed"
_SIMULATOR = "reedhedges/AMRISim EmulatePioneer.cc"


def _setting(default: Any, unit: str, source: str) -> Any:
    return field(default=default, metadata={"unit": unit, "source": source})


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotSettings:
    """The robot. The defaults are those of a Pioneer 2-DX; `describe` lists each value with unit and source.

    Raises:
        ValueError: A value makes no robot: a text that its packet cannot carry, a rate or size that is not positive, a
            number outside `RANGES`. The message begins with the name of the setting.
    """

    # who it is
    name: str = _setting("hilbench", "", "choice; clients keep 19 characters")
    robot_class: str = _setting("Pioneer", "", _P2_MANUAL)
    subclass: str = _setting("p2dx", "", _ARIA)
    serial: str = _setting("VIRTUAL001", "", "choice; ARIA takes the serial SIM for a simulator")

    # units on the wire
    distance_unit_mm: float = _setting(0.84, "mm per X/Y unit", _ARIA)
    range_unit_mm: float = _setting(0.268, "mm per sonar unit", _ARIA)
    speed_unit_mm_s: float = _setting(1.0, "mm/s per speed unit", _ARIA)
    vel2_unit_mm_s: float = _setting(20.0, "mm/s per VEL2 unit", _ARIA)
    heading_units_per_turn: int = _setting(4096, "units per turn", _P2_MANUAL)

    # mechanics as the controller believes them
    wheel_diameter_mm: float = _setting(165.0, "mm", "Pioneer 2 Operations Manual, specifications")
    half_track_mm: float = _setting(1 / 0.0056, "mm", f"{_ARIA}: 1 / DiffConvFactor")
    encoder_ticks_per_turn: int = _setting(39_400, "ticks per wheel turn", "assumed: 500 lines x 4 x gear 19.7")

    # how wrong those beliefs are; zero is a perfect robot
    left_wheel_error: float = _setting(0.0, "fraction of the left wheel's size", "choice")
    right_wheel_error: float = _setting(0.0, "fraction of the right wheel's size", "choice")
    track_error: float = _setting(0.0, "fraction of the track", "choice")
    slip_noise_mm_per_sqrt_m: float = _setting(0.0, "mm of deviation per wheel after 1 m", "choice")

    # motion: hard tops, session limits, profile
    translation_top_mm_s: float = _setting(1600.0, "mm/s", "usual figure for a P2-DX; assumed")
    rotation_top_deg_s: float = _setting(360.0, "deg/s", _CONFIG)
    translation_acceleration_top_mm_s2: float = _setting(2000.0, "mm/s2", _CONFIG)
    rotation_acceleration_top_deg_s2: float = _setting(300.0, "deg/s2", _CONFIG)
    translation_max_mm_s: float = _setting(600.0, "mm/s", _CONFIG)
    rotation_max_deg_s: float = _setting(100.0, "deg/s", _CONFIG)
    translation_acceleration_mm_s2: float = _setting(300.0, "mm/s2", _SIMULATOR)
    translation_deceleration_mm_s2: float = _setting(300.0, "mm/s2", _SIMULATOR)
    rotation_acceleration_deg_s2: float = _setting(100.0, "deg/s2", _SIMULATOR)
    rotation_deceleration_deg_s2: float = _setting(100.0, "deg/s2", _SIMULATOR)
    emergency_deceleration_mm_s2: float = _setting(5000.0, "mm/s2", "assumed: E_STOP is 'not subject to deceleration'")
    emergency_deceleration_deg_s2: float = _setting(1600.0, "deg/s2", "assumed: the same at the wheel rim")
    pid_gains: tuple[int, int, int, int, int, int] = _setting(
        (40, 20, 0, 40, 30, 0), "RotKP RotKV RotKI TransKP TransKV TransKI", f"{_CONFIG}; reported, not used"
    )
    encoder_ticks_per_half_turn: int = _setting(16_570, "RevCount", f"{_CONFIG}; reported, not used")
    aux1_baud: int = _setting(0, "code of a rate, 0 for 9600", f"{_CONFIG}; reported, not used")
    motor_packets: int = _setting(0, "P2MPACS", f"{_CONFIG}; reported, not used")
    joystick_mm_s: int = _setting(500, "mm/s", f"{_CONFIG}; reported, not used")
    joystick_deg_s: int = _setting(100, "deg/s", f"{_CONFIG}; reported, not used")
    has_move: bool = _setting(True, "", "reedhedges/AriaCoda params: a Pioneer 1 has no MOVE")
    servo_gain_per_s: float = _setting(5.0, "1/s", "choice: gain from position error to speed")
    servo_window_mm: float = _setting(50.0, "mm", "choice: a larger error restarts the profile where the robot is")
    servo_window_deg: float = _setting(10.0, "deg", "choice: as above")
    servo_correction_mm_s: float = _setting(30.0, "mm/s", "choice: most speed the servo adds to the profile")
    servo_correction_deg_s: float = _setting(10.0, "deg/s", "choice: as above")

    # stall monitor
    pwm_max: int = _setting(500, "PWM counts", _CONFIG)
    stall_pwm: int = _setting(200, "PWM counts", f"{_CONFIG}: StallVal")
    stall_wait_ms: int = _setting(200, "ms", f"{_CONFIG}: StallCount")
    stall_average_ms: int = _setting(500, "ms", "Pioneer 2/3 H8 Operations Manual, StallVal and StallCount")
    stall_speed_mm_s: float = _setting(100.0, "mm/s", "Pioneer 2/3 H8 Operations Manual, StallVal and StallCount")

    # timing
    sip_cycle_ms: int = _setting(100, "ms", f"{_P2_MANUAL}; 50 is the documented alternative")
    watchdog_ms: int = _setting(round(WATCHDOG_S * 1000), "ms", _P2_MANUAL)
    watchdog_stops: bool = _setting(True, "", f"{_P2_MANUAL}; false as {_SIMULATOR}, which only warns")
    sonar_cycle_ms: int = _setting(40, "ms", _P2_MANUAL)
    speed_window_ms: int = _setting(50, "ms", "choice: wheel speeds are averaged over this long")
    host_baud_trial_ms: int = _setting(500, "ms", "Pioneer 2/3 H8 Operations Manual, HOSTBAUD")
    host_baud: int = _setting(9600, "bit/s", _P2_MANUAL)

    # the line, where robots and simulators differ
    wrong_order: Literal["refuse", "adopt", "reecho", "restart", "ignore"] = _setting(
        "refuse", "", "choice: what a SYNC out of order is answered with; adopt, reecho, restart as AMRISim's builds"
    )
    max_count: Literal[200, 207, 249] = _setting(
        200, "bytes", f"{_P2_MANUAL}; 207 AMRISim, 249 Pioneer 2/3 H8 Operations Manual"
    )
    handshake_limit_s: float | None = _setting(
        None, "s", f"{_P2_MANUAL}: none; 10 as {_SIMULATOR}, after which a handshake is forgotten"
    )
    raw_tty: bool = _setting(
        True, "", "reedhedges/AriaCoda src/ArRobot.cpp comDataN: TTY strings without a length byte are taken too"
    )

    # battery
    battery_dv: int = _setting(130, "0.1 V", _SIMULATOR)
    low_battery_dv: int = _setting(110, "0.1 V", _CONFIG)

    # bumpers
    bumpers_fitted: bool = _setting(True, "", "choice: ARIA's p2dx.p says not fitted, with 5 + 5 nominal segments")
    front_bumper_segments: int = _setting(5, "segments", _ARIA)
    rear_bumper_segments: int = _setting(5, "segments", _ARIA)
    bump_stall_only_toward: bool = _setting(False, "", "Pioneer 3 Operations Manual, BUMPSTALL; off on a Pioneer 2")

    # sonar
    sonar_discs: tuple[int, ...] = _setting(tuple(range(8)), "0-based", "a P2-DX normally carries the front array only")
    sonar_no_echo_mm: float = _setting(
        8576.0, "mm", "qemu-gazebo-sim/p2os-arduino test_sip.cpp: raw 32000 from a P2-DX"
    )

    # user I/O and accessories
    digital_in: int = _setting(0xFF, "bits", _SIMULATOR)
    digital_out: int = _setting(0xFF, "bits", _SIMULATOR)
    analog: tuple[int, int, int, int, int] = _setting((512,) * PORTS, "10-bit counts of 5 V, ports 1 to 5", "choice")
    gripper_fitted: bool = _setting(False, "", "choice: an option of the robot")
    tcm2_fitted: bool = _setting(False, "", "choice: an option of the robot")
    gyro_fitted: bool = _setting(False, "", "choice: an option of later robots")
    joystick_fitted: bool = _setting(False, "", "choice: an option of the robot")
    aux_loop_back: bool = _setting(False, "", "choice: a wire from Tx to Rx of each AUX port")
    answers_battery_info: bool = _setting(False, "", "choice: P2OS knows no BATTERYINFO")

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if item.name in _TEXTS:
                _check_text(item.name, value)
            if item.name in _CHOICES and value not in _CHOICES[item.name]:
                raise ValueError(f"{item.name} must be one of {_listed(_CHOICES[item.name])}, not {value!r}")
            for number in value if isinstance(value, tuple) else (value,):
                if isinstance(number, int | float):
                    _check_number(item.name, number)
        robot = find_robot(self.subclass)
        if robot is None:
            raise ValueError(f"subclass must be one of {_listed(tuple(ROBOTS))}, not {self.subclass!r}")
        discs = tuple(number for number, pose in enumerate(robot.sonars) if pose is not None)
        if missing := set(self.sonar_discs).difference(discs):
            raise ValueError(f"sonar_discs must be of {_listed(discs)} on a {self.subclass}, not {min(missing)}")

    @property
    def mm_per_turn(self) -> float:
        """Distance of one wheel turn as the controller believes it, mm."""
        return math.pi * self.wheel_diameter_mm

    @property
    def believed_half_track_mm(self) -> float:
        """Half the distance between the wheels as the controller believes it, mm."""
        return self.half_track_mm * (1 + self.track_error)


_POSITIVE = ("_mm", "_ms", "_mm_s", "_deg_s", "_mm_s2", "_deg_s2", "_per_turn", "_per_s", "_deg", "_max")
"""Name endings of the settings that only make sense above zero: sizes, durations, rates."""

_TEXTS = ("name", "robot_class", "subclass", "serial")
_TEXT_LENGTH = 19
"""Clients keep so many characters of an identification string (Player p2os.cc); the serial is held to the same."""

_CHOICES: Mapping[str, tuple[object, ...]] = MappingProxyType(
    {
        "host_baud": RATES,
        "wrong_order": tuple(policy.name.lower() for policy in WrongOrder),
        "max_count": (200, 207, 249),
    }
)

_BYTE, _WORD, _FRACTION = (0, 0xFF), (0, 0xFFFF), (-0.5, 0.5)

RANGES: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        # one byte of the SIP or of the configuration packet
        **dict.fromkeys(("battery_dv", "digital_in", "digital_out", "sip_cycle_ms"), _BYTE),
        "aux1_baud": (0, len(RATES) - 1),
        "motor_packets": _BYTE,
        # two bytes of the configuration packet
        **dict.fromkeys(("rotation_top_deg_s", "translation_top_mm_s", "rotation_max_deg_s"), _WORD),
        **dict.fromkeys(("translation_max_mm_s", "translation_acceleration_top_mm_s2"), _WORD),
        **dict.fromkeys(("rotation_acceleration_top_deg_s2", "translation_acceleration_mm_s2"), _WORD),
        **dict.fromkeys(("translation_deceleration_mm_s2", "rotation_acceleration_deg_s2"), _WORD),
        **dict.fromkeys(("rotation_deceleration_deg_s2", "pid_gains", "encoder_ticks_per_half_turn"), _WORD),
        **dict.fromkeys(("joystick_mm_s", "joystick_deg_s", "pwm_max", "stall_pwm", "stall_wait_ms"), _WORD),
        **dict.fromkeys(("watchdog_ms", "low_battery_dv"), _WORD),
        # half a turn is a signed word of the SIP
        "heading_units_per_turn": (2, 0x10000),
        # seven bits of a stall byte, beside the stall itself
        **dict.fromkeys(("front_bumper_segments", "rear_bumper_segments"), (0, 7)),
        # four arrays of eight
        "sonar_discs": (0, 31),
        # ten bits of the I/O packet
        "analog": (0, 1023),
        # more than half of a wheel or a track is no error of it
        **dict.fromkeys(("left_wheel_error", "right_wheel_error", "track_error"), _FRACTION),
        "slip_noise_mm_per_sqrt_m": (0, 1000),
        "handshake_limit_s": (0.001, 3600),
    }
)
"""Least and greatest value of the settings that a field of a packet carries, or that make no sense outside."""


def _check_text(name: str, text: str) -> None:
    if len(text) > _TEXT_LENGTH or "\0" in text or not text.isascii():
        raise ValueError(f"{name} must have at most {_TEXT_LENGTH} ASCII characters and no NUL, not {text[:40]!r}")


def _check_number(name: str, number: float) -> None:
    if name.endswith(_POSITIVE) and not number > 0:
        raise ValueError(f"{name} must be positive, not {number!r}")
    least, greatest = RANGES.get(name, (-math.inf, math.inf))
    if not (least <= number <= greatest and math.isfinite(number)):
        bounds = f"between {least} and {greatest}" if name in RANGES else "finite"
        raise ValueError(f"{name} must be {bounds}, not {number!r}")


def _listed(values: tuple[object, ...]) -> str:
    return ", ".join(map(str, values))


def settings_for(subclass: str) -> RobotSettings:
    """Settings of another robot of the family: wire units, track, sonar, bumpers and tops from its parameter table.

    Wheels, encoders and everything the tables do not hold stay those of a Pioneer 2-DX.

    Args:
        subclass: As in the identification, for example "p3at", or "p2dx/variant".

    Raises:
        ValueError: No table has this robot.
    """
    robot = find_robot(subclass)
    if robot is None:
        raise ValueError(f"{subclass!r} is none of {', '.join(ROBOTS)}")
    standard = RobotSettings()
    return RobotSettings(
        subclass=robot.subclass,
        distance_unit_mm=robot.distance_unit_mm,
        range_unit_mm=robot.range_unit_mm,
        speed_unit_mm_s=robot.speed_unit_mm_s,
        vel2_unit_mm_s=robot.vel2_unit_mm_s,
        heading_units_per_turn=robot.units_per_turn,
        half_track_mm=1 / robot.turn_rad_per_mm,
        has_move=robot.has_move,
        translation_top_mm_s=min(standard.translation_top_mm_s, float(robot.max_speed_mm_s)),
        translation_max_mm_s=min(standard.translation_max_mm_s, float(robot.max_speed_mm_s)),
        rotation_top_deg_s=min(standard.rotation_top_deg_s, float(robot.max_turn_deg_s)),
        sonar_discs=_fitted_discs(robot),
        sonar_no_echo_mm=standard.sonar_no_echo_mm if robot.range_unit_mm < 1 else _LATE_NO_ECHO_MM,
        bumpers_fitted=robot.subclass == "p2dx" or bool(robot.front_bumpers or robot.rear_bumpers),
        front_bumper_segments=robot.front_bumpers or standard.front_bumper_segments,
        rear_bumper_segments=robot.rear_bumpers or standard.rear_bumper_segments,
    )


_LATE_NO_ECHO_MM = 5000.0
"""Range without an echo of robots that report mm: what ARIA takes for "nothing seen" (assumed)."""


def _fitted_discs(robot: RobotParameters) -> tuple[int, ...]:
    """All discs of the table, except that a P2-DX normally carries the front array only."""
    discs = tuple(number for number, pose in enumerate(robot.sonars) if pose is not None)
    return discs[:8] if robot.subclass == "p2dx" else discs


@dataclass(frozen=True, slots=True, kw_only=True)
class Described:
    """One setting for a report: its name, value, unit and source."""

    name: str
    value: object
    unit: str
    source: str


def describe(settings: RobotSettings) -> tuple[Described, ...]:
    """List every setting with unit and source, in the order of the class."""
    return tuple(
        Described(name=f.name, value=getattr(settings, f.name), unit=f.metadata["unit"], source=f.metadata["source"])
        for f in fields(settings)
    )
