"""The two ways from the pins to a robot, what each needs of the bench, and tolerances."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TypeVar

from hilbench.check import CaseSetup, Violation, case
from hilbench.mcu.board_case import BoardBench
from hilbench.suites._bluepill import obstacles, place_before, take_away
from hilbench.suites._truth import Sample

FunctionT = TypeVar("FunctionT", bound=Callable[..., object])

Settings = Mapping[str, Mapping[str, object]]

SPEED = 0.05
"""Tolerance of a speed, as a share; the thesis compares speeds by eye, so the figure is a choice."""

STOP_S = 1.0
"""How soon the robot has to stand after code 0."""

DRIFT_DEG = 3.0
"""How much its heading may drift in a leg on a flat floor."""

UNIT = 1.0
"""Tolerance of the tables: one mm/s, mrad/s or deg/s."""

SECTOR_DEG = 45.0

SECTOR_TOLERANCE_DEG = 1.0

LOOP_S = 0.010
"""The programs look at their pins every 10 ms."""

PUBLISH_S = 0.100
"""The original reads the motor wires every 100 ms (stm32-qemu vl.c)."""

ON_RAMP = 0.2
"""Tolerance of the speed on a ramp, as a share. A choice."""

MOVES_MM_S = 5.0
"""A robot that is faster has begun to move. A choice."""

_MOTORS = {"part 'motor_left'", "part 'motor_right'"}

_SENSORS = {f"part 'switch_{number}'" for number in range(1, 9)}

_ENCODERS = {"part 'encoder_left'", "part 'encoder_right'"}

_SONAR_S = 8 * 0.040
"""A round of the eight discs at the front: one every 40 ms (Pioneer 2 Operations Manual)."""

SONAR_LATE_S = _SONAR_S + 0.100 + 0.100
"""Until a reading is at the pins: a whole round, the cycle of the SIP, and its bytes at 9600 baud."""


def on_wheels(
    *clause_ids: str,
    program: str,
    lasts_s: float,
    scene: str = "empty",
    settings: Settings | None = None,
    needs: Iterable[str] = (),
) -> Callable[[FunctionT], FunctionT]:
    """Declare a case with the pins straight on wheels and sensors."""
    setup = CaseSetup(program=program, settings=settings or {})
    wanted = {*_MOTORS, *_SENSORS, *_ENCODERS, "rays", *needs}
    return case(*clause_ids, bench_time_s=lasts_s, needs=wanted, scene=scene, setup=setup)


def on_adapter(
    *clause_ids: str, program: str, lasts_s: float, scene: str = "empty", needs: Iterable[str] = (), **settings: object
) -> Callable[[FunctionT], FunctionT]:
    """Declare a case with the pins on the adapter; what is named beside is set on it."""
    setup = CaseSetup(variant="robot", program=program, settings={"adapter": settings} if settings else {})
    wanted = {"part 'adapter'", "rays", *needs}
    return case(*clause_ids, bench_time_s=lasts_s, needs=wanted, scene=scene, setup=setup)


def on_nothing(*clause_ids: str, program: str, lasts_s: float) -> Callable[[FunctionT], FunctionT]:
    """Declare a case with motors on the pins and nothing else."""
    setup = CaseSetup(variant="bare", program=program)
    return case(*clause_ids, bench_time_s=lasts_s, needs=_MOTORS, setup=setup)


def required(holds: bool, message: str, lines: Iterable[object] = ()) -> None:
    """Require something of the target."""
    if not holds:
        raise Violation(message, [str(line) for line in lines])


WORDS = (0, 3, -4, 0)


def mean_mm_s(samples: Sequence[Sample]) -> float:
    """Return the mean speed from way and time, + forward."""
    return samples[-1].seen_from(samples[0])[0] / samples[-1].after_s(samples[0].at_ns)


def mean_mrad_s(samples: Sequence[Sample]) -> float:
    """Return the mean rate of turn from angle and time, + counter-clockwise."""
    turned_deg = samples[-1].heading_deg - samples[0].heading_deg
    return math.radians(turned_deg) * 1000 / samples[-1].after_s(samples[0].at_ns)


POST_M = 0.4
"""Where the post is before a sensor: within the threshold of either way, and in the cone of no other disc."""


def look_at_post(bench: BoardBench, sensor: int, settle_s: float) -> list[int]:
    """Put the post before a sensor, and return the distance wires that are high then; take it away again."""
    place_before(bench, sensor, POST_M)
    bench.board.run(settle_s)
    high = obstacles(bench.board)
    take_away(bench)
    bench.board.run(settle_s)
    left = obstacles(bench.board)
    required(not left, f"the obstacle before sensor {sensor} is gone, and DD{left} still high")
    return high


def pulse(bench: BoardBench, pin: str, high_s: float) -> None:
    """Drive a pin high for a time, then low."""
    bench.board.pin(pin).drive(True)
    bench.board.run(high_s)
    bench.board.pin(pin).drive(False)
