"""The robot's connector on a Blue Pill: which wire is where, what codes mean, and how a case gets hold of both ends.

Everything that a case expects is computed here, from the published formulas, and not asked of the parts under test.
Pins: bachelor-thesis, Table 3, and the schematic of the adapter board. Arithmetic: pioneer_2DX-Interface
code-esp32_d1, bluepill_comm.cpp and utils.cpp.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TypeVar

from hilbench.check import Violation
from hilbench.mcu.board_case import BoardBench
from hilbench.mcu.under_test import BoardUnderTest
from hilbench.suites._board_watch import Watch
from protocols.p2os import robot_parameters

ValueT = TypeVar("ValueT")

__all__ = [
    "CODES",
    "CONNECT",
    "DISTANCES",
    "LEFT_ENCODER",
    "LEFT_MOTOR",
    "MM_S_PER_CODE",
    "MOTORS",
    "RESET",
    "RIGHT_ENCODER",
    "RIGHT_MOTOR",
    "adapter_speed_mm_s",
    "adapter_turn_deg_s",
    "adapter_turn_mrad_s",
    "bits",
    "connect",
    "drive_codes",
    "face_wall",
    "last",
    "levels",
    "obstacles",
    "place_before",
    "place_in_cell",
    "runs",
    "show",
    "signed",
    "take_away",
    "wheel_turn_mrad_s",
    "word",
]

LEFT_MOTOR = ("PB7", "PB6", "PB5")
"""comm1, comm2, comm3; comm3 is the sign."""

RIGHT_MOTOR = ("PA1", "PA2", "PA3")
MOTORS = (*LEFT_MOTOR, *RIGHT_MOTOR)

DISTANCES = ("PA4", "PA5", "PA6", "PA7", "PB0", "PB1", "PB10", "PB11")
"""DD1 to DD8."""

LEFT_ENCODER = ("PB4", "PB3", "PA15")
"""s1, s2, s3; s1 is bit 0."""

RIGHT_ENCODER = ("PC13", "PC14", "PC15")
CONNECT = "PB12"
RESET = "PB13"

CODES = range(-4, 4)

TRACK_MM = 2 / 0.0056
"""Distance between the wheels: 2 / DiffConvFactor (AriaCoda params/p2dx.p)."""

MM_S_PER_CODE = 62.5
"""Speed of a rim for each code: 1000 mm/s over 16 codes of two wheels."""

OUT_OF_SIGHT_M = (0.0, 0.0)
"""Where nothing is near in the scenes ``post`` and ``cell``, whose middle is 3 m ahead of it."""

OBSTACLE_X_M = 3.0


# --- words


def signed(raw: int) -> int:
    """Return the code of a word 0..7: two's complement of three bits."""
    return raw - 8 if raw >= 4 else raw


def bits(number: int) -> tuple[bool, bool, bool]:
    """Return the levels of comm1 to comm3, or s1 to s3, for a code or number; the first wire is bit 0."""
    return bool(number & 1), bool(number & 2), bool(number & 4)


def levels(board: BoardUnderTest, pins: Iterable[str]) -> tuple[bool, ...]:
    """Return the levels of pins; one that floats reads low."""
    return tuple(board.pin(pin).level is True for pin in pins)


def word(board: BoardUnderTest, pins: Iterable[str]) -> int:
    """Return the number on wires, the first of which is bit 0."""
    return sum(level << place for place, level in enumerate(levels(board, pins)))


def obstacles(board: BoardUnderTest) -> list[int]:
    """Return the numbers of the distance wires that are high."""
    return [number for number, high in enumerate(levels(board, DISTANCES), 1) if high]


# --- what codes mean


def _c_divide(dividend: int, divisor: int) -> int:
    return math.trunc(dividend / divisor)


def adapter_speed_mm_s(left: int, right: int) -> int:
    """Return the speed that the adapter asks for: the sum of the codes scaled to -500..500, and halved."""
    return _c_divide(-500 + _c_divide((left + right + 8) * 1000, 16), 2)


def adapter_turn_mrad_s(left: int, right: int) -> int:
    """Return its rate of turn, + counter-clockwise: the difference scaled to -340..340, and halved."""
    return _c_divide(-340 + _c_divide((right - left + 8) * 680, 16), 2)


def adapter_turn_deg_s(left: int, right: int) -> int:
    """Return what it tells the robot of that."""
    return round(math.degrees(adapter_turn_mrad_s(left, right) / 1000))


def wheel_turn_mrad_s(left: int, right: int) -> float:
    """Return the rate of turn of two wheels at these codes, + counter-clockwise."""
    return (right - left) * MM_S_PER_CODE / TRACK_MM * 1000


# --- driving the wires by hand, where the program leaves them alone


def drive_codes(board: BoardUnderTest, left: int, right: int) -> None:
    """Drive the motor wires from outside."""
    for pin, level in zip(MOTORS, (*bits(left), *bits(right)), strict=True):
        board.pin(pin).drive(level)


def connect(bench: BoardBench, watch: Watch, connected: type[object]) -> int:
    """Raise p2dx_con until the adapter has its session, and return when that was, in ns.

    Args:
        bench: with an adapter.
        watch: of the bench.
        connected: the event of the adapter that tells.
    """
    bench.board.pin(CONNECT).drive(True)
    if not bench.board.run_until(lambda: bool(watch.reported(connected)), 4.0):
        raise Violation("the adapter has no session with the robot 4 s after p2dx_con went high")
    return watch.reported(connected)[-1].at_ns


# --- what the sensors see


def place_before(bench: BoardBench, sensor: int, range_m: float, back_m: float = 0.0) -> None:
    """Put the robot so that its sensor has the middle of the scene's post straight before it.

    Args:
        bench: with the scene ``post``.
        sensor: 1 to 8, from the left.
        range_m: from the sensor to the middle of the post.
        back_m: how much farther back the robot is put.
    """
    x_m, y_m, turn_rad = disc(sensor)
    ahead_m = OBSTACLE_X_M - x_m - range_m * math.cos(turn_rad) - back_m
    bench.world.place(ahead_m, -y_m - range_m * math.sin(turn_rad), 0.0)


def place_in_cell(bench: BoardBench) -> None:
    """Put the robot into the scene ``cell``."""
    bench.world.place(OBSTACLE_X_M, 0.0, 0.0)


def take_away(bench: BoardBench) -> None:
    """Put the robot where it sees nothing near in the scenes ``post`` and ``cell``."""
    bench.world.place(*OUT_OF_SIGHT_M, 0.0)


def face_wall(bench: BoardBench, sensor: int, range_m: float, wall_m: float) -> None:
    """Put the robot so that its sensor looks at a wall squarely.

    Args:
        bench: with a wall across the way, whose face is ``wall_m`` ahead of the origin.
        sensor: 1 to 8.
        range_m: from the sensor to the wall.
        wall_m: see above.
    """
    x_m, y_m, turn_rad = disc(sensor)
    ahead_m = x_m * math.cos(turn_rad) + y_m * math.sin(turn_rad)
    bench.world.place(wall_m - range_m - ahead_m, 0.0, -turn_rad)


def disc(sensor: int) -> tuple[float, float, float]:
    """Return where a sensor sits on the robot: x and y in metres, direction in rad (AriaCoda params/p2dx.p)."""
    pose = robot_parameters("p2dx").sonars[sensor - 1]
    if pose is None:
        raise KeyError(sensor)
    return pose.x_mm / 1000, pose.y_mm / 1000, pose.th_rad


def show(bench: BoardBench, part: str, values: Mapping[str, float]) -> None:
    """Show a part other quantities than the world's, until the next step of the physics or for good.

    The chip then gets a millisecond to see what the part makes of them.
    """
    bench.emulated.surroundings.parts.show(part, values)
    bench.board.run(0.001)


def runs(values: Sequence[ValueT]) -> list[ValueT]:
    """Return a sequence without the repetitions of a value."""
    return [value for place, value in enumerate(values) if place == 0 or value != values[place - 1]]


def last(things: Sequence[ValueT], what: str) -> ValueT:
    """Return the last of some things that there have to be; `what` is missing otherwise."""
    if not things:
        raise Violation(f"{what} is missing")
    return things[-1]
