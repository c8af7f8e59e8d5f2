"""Turns on the spot, and arcs."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pytest

from hilbench.check import at_most, case, near
from hilbench.suites._mechanics import arc_end, circle_radius, turn_radius
from hilbench.suites._session import Session
from hilbench.suites._truth import Sample, Truth
from hilbench.suites.pioneer_motion._judged import SPEED, TURN_DEG, WAY_MM, cruise, mean_turn_deg_s, session, truth
from protocols.p2os import CommandNumber, pack_bytes

__all__ = ["session", "truth"]

_C = CommandNumber

RADIUS = 0.005
"""Tolerance of the radius of a circle, as a share: that of a steady speed and a steady rate of turn at worst."""


@case("M05", bench_time_s=4.7)
def test_head_is_a_true_heading(session: Session, truth: Truth) -> None:
    """HEAD 90 twice: the second time the robot is there already."""
    start = truth.now
    for heading in (90, 90, 30):
        session.send(_C.HEAD, heading)
        end = truth.wait_still(6.0)
        near(end.heading_deg - start.heading_deg, heading, TURN_DEG, unit="deg", what=f"true heading of HEAD {heading}")
        require_place(start, end)
    session.leave()


@case("M06", bench_time_s=3.6)
def test_dhead_is_relative(session: Session, truth: Truth) -> None:
    for number in (1, 2):
        start = truth.now
        session.send(_C.DHEAD, -45)
        end = truth.wait_still(6.0)
        what = f"true turn of DHEAD -45, number {number}"
        near(end.heading_deg - start.heading_deg, -45, TURN_DEG, unit="deg", what=what)
        require_place(start, end)
    session.leave()


def require_place(start: Sample, end: Sample) -> None:
    """Require that the robot turned on the spot."""
    at_most(math.dist(start.point_mm, end.point_mm), PLACE_MM, unit="mm", what="stray of the middle in a turn")


PLACE_MM = 3.0
"""How far the middle between the wheels may stray when the robot turns on the spot. A choice."""


@case("M07", bench_time_s=2.4)
@pytest.mark.parametrize("rate", [30, -50])
def test_rotation_is_true(session: Session, truth: Truth, rate: int) -> None:
    session.send(_C.RVEL, rate)
    samples = cruise(session, truth, 0.9, 1.2)
    near(mean_turn_deg_s(samples), rate, SPEED * abs(rate), unit="deg/s", what=f"true rate of turn at RVEL {rate}")
    session.leave()


def require_arc(samples: Sequence[Sample], speed: float, rate: float) -> None:
    """Require the circle that speed and rate of turn make, and on it the way and the pose they lead to."""
    radius = turn_radius(speed, rate)
    measured = circle_radius([sample.point_mm for sample in samples])
    near(measured, radius, RADIUS * radius, unit="mm", what=f"radius at {speed:g} mm/s and {rate:.4g} deg/s")
    first, last = samples[0], samples[-1]
    near(mean_turn_deg_s(samples), rate, SPEED * abs(rate), unit="deg/s", what="true rate of turn on the arc")
    expected = arc_end(speed, rate, last.after_s(first.at_ns))
    miss = math.dist(last.seen_from(first), expected)
    arc_mm = abs(speed) * last.after_s(first.at_ns)
    at_most(miss, SPEED * arc_mm + WAY_MM, unit="mm", what=f"distance from where an arc of {arc_mm:.0f} mm ends")


@case("M08", bench_time_s=5.0)
@pytest.mark.parametrize(("speed", "rate"), [(300, 45), (-200, 60)])
def test_arc_of_velocity_and_rotation(session: Session, truth: Truth, speed: int, rate: int) -> None:
    session.set_ramps(up=600)
    session.send(_C.VEL, speed)
    session.send(_C.RVEL, rate)
    require_arc(cruise(session, truth, 1.2, 3.5), speed, rate)
    session.leave()


@case("M09", bench_time_s=5.0)
@pytest.mark.parametrize(("left", "right"), [(200, 400), (300, -100)])
def test_arc_of_wheel_speeds(session: Session, truth: Truth, left: int, right: int) -> None:
    """The robot's table has what half the wheels' difference makes of it in rad/s (DiffConvFactor)."""
    session.set_ramps(up=600)
    unit = session.robot.vel2_unit_mm_s
    session.send(_C.VEL2, pack_bytes(round(left / unit), round(right / unit)))
    rate = math.degrees((right - left) / 2 * session.robot.turn_rad_per_mm)
    require_arc(cruise(session, truth, 1.2, 3.5), (left + right) / 2, rate)
    session.leave()
