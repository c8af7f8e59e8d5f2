"""Dead reckoning: exact on arcs, quantised by ticks, wrong only by what the settings say."""

from __future__ import annotations

import dataclasses
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from targets.robots.pioneer.odometry import Odometer
from targets.robots.pioneer.settings import RobotSettings
from tests.each import each

PERFECT = RobotSettings(encoder_ticks_per_turn=100_000_000)
STEP_NS = 4_166_666


def angles(left_mm: float, right_mm: float, robot: RobotSettings = PERFECT) -> tuple[float, float]:
    per_mm = math.tau / robot.mm_per_turn
    return left_mm * per_mm, right_mm * per_mm


@given(left=st.floats(-3000, 3000), right=st.floats(-3000, 3000), steps=st.integers(1, 50))
@settings(deadline=None)
def test_an_arc_is_exact_in_any_number_of_steps(left: float, right: float, steps: int) -> None:
    odometer = Odometer(PERFECT, (0.0, 0.0), seed=1)
    for k in range(1, steps + 1):
        odometer.update(angles(left * k / steps, right * k / steps), k * STEP_NS)
    turn = (right - left) / 2 / PERFECT.half_track_mm
    forward = (left + right) / 2
    radius = forward / turn if turn else math.inf
    x = radius * math.sin(turn) if turn else forward
    y = radius * (1 - math.cos(turn)) if turn else 0.0
    assert odometer.pose.x_mm == pytest.approx(x, abs=0.01)
    assert odometer.pose.y_mm == pytest.approx(y, abs=0.01)
    assert odometer.pose.heading_deg == pytest.approx(math.degrees(turn), abs=1e-3)


def test_ticks_are_cumulative_and_quantised() -> None:
    robot = RobotSettings()
    odometer = Odometer(robot, (1.0, -2.0), seed=1)
    odometer.update((1.0 + math.tau, -2.0 - 2 * math.tau), STEP_NS)
    assert odometer.ticks == (39_400, -78_800)
    odometer.set_origin()
    assert odometer.ticks == (39_400, -78_800)
    tick_mm = robot.mm_per_turn / 39_400
    odometer.update((1.0 + math.tau * (1 + 0.4 / 39_400), -2.0 - 2 * math.tau), 2 * STEP_NS)
    assert odometer.travel.left_mm == pytest.approx(39_400 * tick_mm)


def test_origin_moves_the_pose_but_not_the_wheels() -> None:
    odometer = Odometer(PERFECT, (0.0, 0.0), seed=1)
    odometer.update(angles(100.0, 300.0), STEP_NS)
    odometer.set_origin()
    assert odometer.pose.x_mm == odometer.pose.y_mm == odometer.pose.heading_deg == 0.0
    odometer.update(angles(200.0, 400.0), 2 * STEP_NS)
    assert odometer.pose.x_mm == pytest.approx(100.0, abs=1e-3)
    assert odometer.pose.y_mm == pytest.approx(0.0, abs=1e-3)


def test_speeds_are_the_mean_over_the_window() -> None:
    odometer = Odometer(PERFECT, (0.0, 0.0), seed=1)
    assert odometer.wheel_speeds_mm_s() == (0.0, 0.0)
    for k in range(200):
        t_ms = k * 4
        odometer.update(angles(0.2 * t_ms, -0.1 * t_ms), t_ms * 1_000_000)
    assert odometer.wheel_speeds_mm_s() == pytest.approx((200.0, -100.0), abs=0.01)
    for k in range(200, 215):
        odometer.update(angles(0.2 * 796, -0.1 * 796), k * 4_000_000)
    assert odometer.wheel_speeds_mm_s() == (0.0, 0.0)


@each(
    ("changes", "x", "heading"),
    [
        ({"left_wheel_error": 0.01, "right_wheel_error": 0.01}, 1010.0, 0.0),
        ({"left_wheel_error": -0.01}, 995.0, math.degrees(10 / 2 / PERFECT.half_track_mm)),
    ],
)
def test_wheel_errors(changes: dict[str, float], x: float, heading: float) -> None:
    robot = dataclasses.replace(PERFECT, **changes)
    odometer = Odometer(robot, (0.0, 0.0), seed=1)
    odometer.update(angles(1000.0, 1000.0), STEP_NS)
    assert odometer.pose.x_mm == pytest.approx(x, abs=0.2)
    assert odometer.pose.heading_deg == pytest.approx(heading, abs=1e-3)


def test_track_error_scales_the_turn() -> None:
    odometer = Odometer(dataclasses.replace(PERFECT, track_error=0.05), (0.0, 0.0), seed=1)
    odometer.update(angles(-100.0, 100.0), STEP_NS)
    assert math.radians(odometer.pose.heading_deg) == pytest.approx(100 / PERFECT.half_track_mm / 1.05, rel=1e-5)


def slipped_mm(steps: int, seed: int) -> float:
    odometer = Odometer(dataclasses.replace(PERFECT, slip_noise_mm_per_sqrt_m=2.0), (0.0, 0.0), seed=seed)
    for k in range(1, steps + 1):
        odometer.update(angles(1000.0 * k / steps, 1000.0 * k / steps), k * STEP_NS)
    return odometer.travel.left_mm - 1000.0


def test_slip_is_seeded_and_as_large_as_stated() -> None:
    assert slipped_mm(10, seed=7) == slipped_mm(10, seed=7)
    assert slipped_mm(10, seed=7) != slipped_mm(10, seed=8)
    for steps in (1, 50):
        errors = [slipped_mm(steps, seed) for seed in range(300)]
        deviation = math.sqrt(sum(e * e for e in errors) / len(errors))
        assert deviation == pytest.approx(2.0, rel=0.2)
