"""``python -m measure.car_figures``: the car's model against formulas, as the table of ``docs/vehicle-car.md``.

``--picture`` draws the test track into ``docs/images/test-track.svg``.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from hilbench.suites._clearance import outline_m
from worlds import find_scene, find_vehicle
from worlds.above import Sheet, top_view
from worlds.car_commands import CarCommand, CommandMode
from worlds.car_dynamics import CarDynamics
from worlds.car_parameters import DEFAULTS as P
from worlds.motion import PlanarPose, PlanarVelocity

DOCS = Path(__file__).parents[1] / "docs"
PICTURE = DOCS / "images" / "test-track.svg"
HZ = 240
SHEET = Sheet(title="The scene test-track from above", px_per_m=5, bar_m=10, note="outline: the car at its start")


class Row(NamedTuple):
    """One figure: what was done, what was looked at, what the formula says and what came."""

    case: str
    what: str
    expected: float
    found: float

    @property
    def cells(self) -> tuple[str, ...]:
        """As the table shows it."""
        error = (self.found / self.expected - 1) * 100
        shown = "0.000" if abs(error) < 5e-4 else f"{error:+.3f}"
        return self.case, self.what, f"{self.expected:.4f}", f"{self.found:.4f}", shown


def rows() -> Iterator[Row]:
    """Every figure of the table."""
    yield from _circles()
    yield from _speeding_up()
    yield from _stopping()


def table() -> str:
    """Return the table as Markdown."""
    lines = [("Case", "What", "Formula", "Model", "Error, %"), ("---",) * 5, *(row.cells for row in rows())]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def picture() -> str:
    """Return the test track from above as SVG."""
    return top_view(find_scene("test-track"), {}, [outline_m(find_vehicle("car"))], SHEET)


def _car(speed_m_s: float, command: CarCommand) -> CarDynamics:
    car = CarDynamics()
    car.adopt(PlanarPose(0.0, 0.0, 0.0), PlanarVelocity(speed_m_s, 0.0, 0.0))
    car.layer.command = command
    return car


def _ackermann(speed_m_s: float, *, steering_rad: float = 0.0, accel: float = 0.0, jerk: float = 0.0) -> CarCommand:
    return CarCommand(
        mode=CommandMode.ACKERMANN,
        speed_m_s=speed_m_s,
        steering_rad=steering_rad,
        accel_m_s2=accel,
        jerk_m_s3=jerk,
    )


def _run(car: CarDynamics, seconds: float) -> None:
    for _ in range(round(seconds * HZ)):
        car.advance(1 / HZ)


def _circles() -> Iterator[Row]:
    difference = P.com_ahead_m / P.front_stiffness_n_rad - P.front_arm_m / P.rear_stiffness_n_rad
    understeer = P.mass_kg / P.wheelbase_m * difference
    for speed, degrees in ((5.0, 2.0), (10.0, 2.0), (10.0, 5.0), (20.0, 2.0)):
        angle = math.radians(degrees)
        car = _car(speed, _ackermann(speed, steering_rad=angle))
        _run(car, 15.0)
        case, way = f"{speed:g} m/s, tyres at {degrees:g}°", math.hypot(speed, car.lat_speed_m_s)
        radius = (P.wheelbase_m + understeer * speed**2) / angle
        yield Row(case, "radius, m: linear bicycle", radius, way / car.yaw_rate_rad_s)
        yield Row(case, "the same: kinematic", P.wheelbase_m / math.tan(angle), way / car.yaw_rate_rad_s)
    angle = math.radians(20)
    car = _car(0.9, _ackermann(0.9, steering_rad=angle))
    _run(car, 15.0)
    yield Row(
        "0.9 m/s, tyres at 20°", "radius, m: kinematic", P.wheelbase_m / math.tan(angle), 0.9 / car.yaw_rate_rad_s
    )


def _speeding_up() -> Iterator[Row]:
    speed = 8.3
    for accel, jerk in ((1.0, 0.0), (2.5, 0.0), (1.5, 1.0), (2.0, 2.5), (3.0, 0.7)):
        car, steps = _car(0.0, _ackermann(speed, accel=accel, jerk=jerk)), 0
        greatest, steepest, before = 0.0, 0.0, 0.0
        while car.lon_speed_m_s < speed - 1e-3:
            _run(car, 1 / HZ)
            steps += 1
            greatest = max(greatest, car.lon_accel_m_s2)
            steepest = max(steepest, abs(car.lon_accel_m_s2 - before) * HZ)
            before = car.lon_accel_m_s2
        case = f"to {speed:g} m/s within {accel:g} m/s²" + (f" and {jerk:g} m/s³" if jerk else "")
        yield Row(case, "time, s", _time_s(speed - 1e-3, speed, accel, jerk), steps / HZ)
        if not jerk or accel * accel / jerk < speed:
            yield Row(case, "greatest acceleration, m/s²", accel, greatest)
        if jerk:
            yield Row(case, "greatest jerk, m/s³", jerk, steepest)


def _time_s(reached: float, speed: float, accel: float, jerk: float) -> float:
    """When the fastest profile without overshoot reaches a speed just below its end."""
    if not jerk:
        return reached / accel
    whole = speed / accel + accel / jerk if accel * accel / jerk < speed else 2 * math.sqrt(speed / jerk)
    return whole - math.sqrt(2 * (speed - reached) / jerk)


def _stopping() -> Iterator[Row]:
    for speed in (1.0, 5.0, 10.0, 15.0):
        car = _car(speed, _ackermann(0.0, accel=1.0, jerk=1.0))
        _run(car, 3.0)
        yield Row(f"speed 0 commanded at {speed:g} m/s", "way, m", speed**2 / 2 / P.max_decel_m_s2, car.pose.x_m)
    rolling, drag = (
        9.81 * P.rolling_resistance,
        P.air_density_kg_m3 * P.drag_coefficient * P.drag_area_m2 / 2 / P.mass_kg,
    )
    car = _car(20.0, CarCommand(brake=1.0))
    _run(car, 3.0)
    way = math.log1p(drag * 400 / (P.max_decel_m_s2 + rolling)) / 2 / drag
    yield Row("whole brake at 20 m/s", "way, m", way, car.pose.x_m)
    car = _car(20.0, CarCommand())
    _run(car, 60.0)
    rate, start = math.sqrt(rolling * drag), math.atan(20 * math.sqrt(drag / rolling))
    yield Row(
        "60 s of coasting from 20 m/s",
        "speed, m/s",
        math.sqrt(rolling / drag) * math.tan(start - 60 * rate),
        car.lon_speed_m_s,
    )


def main(words: Sequence[str]) -> int:
    """Print the table, or draw the picture."""
    parser = argparse.ArgumentParser(prog="python -m measure.car_figures", description=__doc__)
    parser.add_argument("--picture", action="store_true", help="draw the test track instead")
    if parser.parse_args(words).picture:
        PICTURE.write_text(picture(), encoding="utf-8")
    else:
        sys.stdout.write(table())
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
