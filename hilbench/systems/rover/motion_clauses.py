"""The catalogue of how a rover drives and what it knows of that: R01 to R27."""

from __future__ import annotations

from hilbench.check.catalogue import Clause
from hilbench.judging.verdicts import Level

__all__ = ["CLAUSES"]

_NOTEBOOKS = "nhorro/ceai2020 intro_se, notebooks of the bench tests"
_MANUAL = "nhorro/ceai2020 rover_firmware/doc/index.md"
_CONFIG = "nhorro/ceai2020 rover_firmware/config.h"
_G0 = "nhorro/rover-firmware application.cpp"
_KIT = "TT motor 1:48, as sold; ST data sheet L298; docs/rover-vehicle.md"
_FLOOR = "docs/rover-vehicle.md, on the floor"
_MPU = "PS-MPU-9250A-01"
_NEO = "NEO-6 data sheet GPS.G6-HW-09005"
_TOLERANCE = "tolerance: choice"
_CHOICE = "choice: no source says"


def _clause(number: int, title: str, text: str, *sources: str, level: Level = "must", needs: str = "wheels") -> Clause:
    return Clause(
        id=f"R{number:02}",
        suite="rover-motion",
        level=level,
        title=title,
        text=text,
        source="; ".join(sources),
        needs=frozenset({"boards", "server", "torque", *needs.split()}),
    )


CLAUSES = (
    _clause(
        1,
        "Throttle to speed",
        "With the wheels in the air, each wheel has the speed that the figures of motor, driver and battery make of "
        "the throttle, 4 rpm more or less, 1.2 s after a command, while it speeds up and when it has settled.",
        f"{_MANUAL}, 0x03: duty is the throttle",
        _KIT,
        _TOLERANCE,
    ),
    _clause(
        2,
        "As the original in the air",
        "Coming from faster, wheels in the air turn at 142 to 145, 133, 115 to 120 and 95 to 100 rpm at throttles of "
        "0.39, 0.35, 0.30 and 0.25, 4 rpm more or less.",
        _NOTEBOOKS,
        _TOLERANCE,
        level="should",
    ),
    _clause(
        3,
        "Breakaway",
        "Wheels in the air that stand do not turn at a throttle of 0.21 and turn at 0.26; those that turn go on at "
        "0.21 and stop at 0.17.",
        f"{_NOTEBOOKS}: about 0.23 upwards, 0.19 to 0.20 downwards",
        _TOLERANCE,
    ),
    _clause(
        4,
        "Both directions",
        "A negative throttle turns the wheels backward, as fast as the positive one turns them forward; the sides may "
        "turn against each other.",
        f"{_MANUAL}, 0x03",
        _TOLERANCE,
    ),
    _clause(
        5,
        "One side alone",
        "Flag bit 0 is for the left wheels, bit 1 for the right ones; a side whose bit is 0 goes on as it was.",
        f"{_MANUAL}, 0x03",
    ),
    _clause(
        6,
        "The gains at power-up",
        "At a set point of 120 rpm, given while they turn, the wheels settle where 0.01 of the throttle for each "
        "missing rpm, and the little that has been summed, is the throttle that makes that speed, 7 rpm more or less; "
        "0x83 shows such throttles and speeds, within 0.05 of the throttle.",
        f"{_CONFIG}: kp 0.01, kd 0.0001, ki 0.0001",
        _KIT,
        _TOLERANCE,
    ),
    _clause(
        7,
        "Speed control settles in the air",
        "With gains from RESET_PID that fit the motors, 0.003, 0 and 0.006, the wheels are within 3 rpm of set points "
        "of 30, 60 and 120 rpm after 2.4 s, and stay within a band of 6 rpm.",
        f"{_MANUAL}, 0x04 and 0x05",
        "gains, time and tolerance: choice",
    ),
    _clause(
        8,
        "Speed control settles on the floor",
        "The same on a hard floor, backward, at 60 and 120 rpm after 3.5 s.",
        f"{_MANUAL}, 0x04 and 0x05",
        "gains, time and tolerance: choice",
    ),
    _clause(
        9,
        "Tachometers",
        "Each wheel's count in 0x83 is its angle in slots of its disc of 20, one more or less, whichever way it "
        "turned; its speed is true within 4 %.",
        f"{_MANUAL}, tachometers and 0x83",
        _TOLERANCE,
    ),
    _clause(
        10,
        "Straight on",
        "At a throttle of 0.5 on both sides the rover has, 2 s later, the speed over ground of its wheels by their "
        "figures within 3 %, has drifted by less than 1 % of its way, and turned by less than 1 degree.",
        _KIT,
        _FLOOR,
        _TOLERANCE,
    ),
    _clause(
        11,
        "Turning on the spot",
        "On a hard floor throttles of -0.8 and 0.8 turn the rover to the left and their opposites to the right, at "
        "0.42 to 0.62 of the rate of two wheels on one axle: all four are dragged sideways.",
        _FLOOR,
        _TOLERANCE,
    ),
    _clause(
        12,
        "Turning on a carpet",
        "On a carpet the same throttles do not turn the rover, and whole ones turn it at 10 to 60 degrees/s: dragging "
        "the wheels takes twice as much.",
        _FLOOR,
        _TOLERANCE,
    ),
    _clause(
        13,
        "Unequal throttles of one sign",
        "On a hard floor throttles of 0.4 and 0.7 drive the rover straight on: the difference is less than it takes "
        "to drag the wheels, and the model's tyres do not give way. On a real floor the way would bend a little.",
        _FLOOR,
        level="should",
    ),
    _clause(
        14,
        "The inertial sensor at rest",
        "0x82 of a rover at rest has 9.81 m/s^2 upwards and none to the sides, no rate, 25 degrees C and the earth's "
        "field, each within the tolerance of the sensor, and both validity bits.",
        f"{_MANUAL}, 0x82: m/s^2, deg/s",
        f"{_MPU} sections 3.1 to 3.3",
        needs="imu",
    ),
    _clause(
        15,
        "The gyroscope",
        "In a turn on the spot the rate about z in 0x82 is the true one, + to the left, within the scale's 3 % and 3 "
        "deg/s; the others are none.",
        f"{_MANUAL}, 0x82",
        f"{_MPU} section 3.1",
        _TOLERANCE,
        needs="wheels imu",
    ),
    _clause(
        16,
        "Attitude on a ramp",
        "Standing on a slope of 8 degrees, the attitude in 0x82, scalar last, has a nose that is 8 degrees up, 6 more "
        "or less, and no roll; the acceleration has 1.37 m/s^2 forward, none to the side, and 9.71 upward, each "
        "within 90 mg.",
        f"{_MANUAL}, 0x82",
        f"{_MPU} section 3.2: 60 mg are 3.4 degrees",
        _TOLERANCE,
        needs="imu",
    ),
    _clause(
        17,
        "Heading after a turn",
        "After a turn on the spot of more than 60 degrees and two seconds of rest the heading in 0x82 is the true one "
        "within 12 degrees; the field has 173 mG towards north and 148 mG upward, within 40 mG, along x, y and z of "
        "the rover.",
        f"{_MANUAL}, 0x82",
        _TOLERANCE,
        needs="wheels imu",
    ),
    _clause(
        18,
        "Accuracy of the position",
        "Three seconds after a hot start 0x84 has a position, latitude first, within three times the receiver's "
        "accuracy of 2.5 m.",
        f"{_MANUAL}, 0x84",
        f"{_NEO} table 2",
        needs="gps",
    ),
    _clause(
        19,
        "Positions along a way",
        "With a receiver that errs no more than its last digit, each position that 0x84 has of a rover on its way is "
        "where it was at the full second before, within 0.7 m.",
        f"{_MANUAL}, 0x84: degrees as float32",
        _TOLERANCE,
        needs="wheels gps",
    ),
    _clause(
        20,
        "Without a fix",
        "When the receiver no longer sees the sky, byte 1 of 0x84 is 0 within three seconds, and the position the "
        "last one known; STATUS stays 0, as the receiver speaks.",
        f"{_MANUAL}, 0x84: reserved byte",
        _CHOICE,
        needs="gps",
    ),
    _clause(
        21,
        "A receiver that is not understood",
        "Where nothing that comes from the receiver makes sense, GPS_FAIL is set in STATUS after 3.8 s, and byte 1 of "
        "0x84 is 0.",
        f"{_G0}: STATUS bit 0x02",
        f"time: {_CHOICE}",
        needs="gps",
    ),
    _clause(
        22,
        "The sensor's bus breaks on the way",
        "When SDA is stuck, or the inertial sensor no longer answers, AHRS_FAIL is set in STATUS within 0.5 s and "
        "0x82 is not valid; commands drive the wheels as before. When it is mended, the bit goes within 2.6 s.",
        f"{_G0}: STATUS bit 0x01",
        f"times: {_CHOICE}",
        needs="wheels imu",
    ),
    _clause(
        23,
        "Lost link",
        "The motors of a rover on its way get their last pulse 0.9 to 1.03 s after the last frame, whether throttles "
        "or set points drive it, and its wheels stand; requests do not bring them back, the next command does.",
        f"{_CONFIG}: HEARTBEAT_TIMEOUT_IN_MS",
        f"{_G0} handle_connection_lost",
        _TOLERANCE,
    ),
    _clause(
        24,
        "A stalled wheel",
        "When a hand holds a wheel, 0x83 has 0 rpm for it within 1.31 s, while the others turn on; it counts and "
        "shows a speed again when it is let go.",
        f"{_MANUAL}, tachometers: 0 after a second without a slot, median of three, 4 Hz",
    ),
    _clause(
        25,
        "A wall",
        "At a throttle of 0.35 the rover drives up to a wall and its wheels stand there; 0x83 has 0 rpm for all of "
        "them and still the throttle.",
        _FLOOR,
        _TOLERANCE,
    ),
    _clause(
        26,
        "An empty battery",
        "With cells that have a tenth of their charge left, full throttle turns the wheels as their voltage of 6.96 V "
        "makes it, 4 rpm more or less, and by a tenth slower than full ones at least.",
        "assumed: the common course of a cell's voltage",
        _KIT,
        _TOLERANCE,
    ),
    _clause(
        27,
        "The axes of the inertial sensor",
        "With a sensor that is mounted on its side, or on its nose, 0x82 has gravity and a turn on the spot to the "
        "left along the axis that then points up, + y or - x, and nothing along the others.",
        f"{_MANUAL}, 0x82: x, y, z of the sensor",
        f"{_MPU} sections 3.1 and 3.2, 9.1",
        _TOLERANCE,
        needs="wheels imu",
    ),
)
"""All clauses, in the order of their ids."""
