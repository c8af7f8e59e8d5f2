"""One axis: the reference is exact for any step, the servo lands and never runs away."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from targets.robots.pioneer.axis import HALT, Axis, PositionGoal, Servo, SpeedGoal
from targets.robots.pioneer.profile import Limits
from tests.each import each
from tests.share import examples

LIMITS = Limits(speed=600.0, acceleration=300.0, deceleration=300.0)
SERVO = Servo(gain_per_s=5.0, window=50.0, correction=30.0)


def drive(axis: Axis, position: float, steps: list[float], gain: float = 1.0) -> tuple[float, float]:
    """Run the axis on a plant that does `gain` times what it is told; return the position and the top speed."""
    fastest = 0.0
    for dt_s in steps:
        speed = axis.step(dt_s, position)
        fastest = max(fastest, abs(speed))
        position += gain * speed * dt_s
    return position, fastest


@given(
    target=st.floats(-5000, 5000),
    cut_at=st.integers(0, 400),
    second=st.floats(-5000, 5000),
    dt_s=st.sampled_from([0.001, 1 / 240, 0.01, 0.05]),
)
@settings(max_examples=examples(60))
def test_lands_exactly_even_when_replanned_midway(target: float, cut_at: int, second: float, dt_s: float) -> None:
    axis = Axis(SERVO, LIMITS)
    axis.pursue(PositionGoal(position=target), LIMITS)
    position, fastest = drive(axis, 0.0, [dt_s] * cut_at)
    axis.pursue(PositionGoal(position=second), LIMITS)
    position, later = drive(axis, position, [dt_s] * int(45 / dt_s / 1.5))
    assert position == pytest.approx(second, abs=1e-6)
    assert max(fastest, later) <= LIMITS.speed + 1e-6


@given(steps=st.lists(st.floats(0.0005, 0.1), min_size=1, max_size=200))
@settings(deadline=None)
def test_position_does_not_depend_on_the_steps(steps: list[float]) -> None:
    fine, coarse = Axis(SERVO, LIMITS), Axis(SERVO, LIMITS)
    for axis in (fine, coarse):
        axis.pursue(SpeedGoal(speed=500.0), LIMITS)
    position, _ = drive(fine, 0.0, steps)
    once, _ = drive(coarse, 0.0, [sum(steps)])
    assert position == pytest.approx(once, rel=1e-9, abs=1e-9)


@each("gain", [0.9, 1.1])
def test_a_plant_that_does_too_little_or_too_much_is_corrected_without_oscillation(gain: float) -> None:
    axis = Axis(SERVO, LIMITS)
    axis.pursue(PositionGoal(position=1000.0), LIMITS)
    position, trace = 0.0, []
    for _ in range(240 * 12):
        position += gain * axis.step(1 / 240, position) / 240
        trace.append(position)
    assert trace[-1] == pytest.approx(1000.0, abs=0.1)
    assert max(trace) < 1010.0
    settling = trace[240 * 6 :]
    crossings = sum((a - 1000) * (b - 1000) < 0 for a, b in pairwise(settling))
    assert crossings <= 1


def test_a_blocked_axis_does_not_save_up_speed() -> None:
    axis = Axis(SERVO, LIMITS)
    axis.pursue(SpeedGoal(speed=200.0), LIMITS)
    for _ in range(2400):
        axis.step(1 / 240, 0.0)
    assert abs(axis.reference[0]) <= SERVO.window + 200 / 240
    assert axis.step(1 / 240, 0.0) <= 200.0 + SERVO.correction + 1e-6


def test_hold_keeps_the_goal_and_release_resumes_it() -> None:
    axis = Axis(SERVO, LIMITS)
    axis.pursue(SpeedGoal(speed=200.0), LIMITS)
    position, _ = drive(axis, 0.0, [0.01] * 200)
    axis.hold(LIMITS)
    position, _ = drive(axis, position, [0.01] * 200)
    assert axis.reference[1] == 0.0
    axis.release()
    drive(axis, position, [0.01] * 200)
    assert axis.reference[1] == 200.0


def test_drop_forgets_the_goal() -> None:
    axis = Axis(SERVO, LIMITS)
    axis.pursue(PositionGoal(position=1000.0), LIMITS)
    axis.drop((12.0, 0.0), LIMITS)
    assert axis.reference == (12.0, 0.0)
    assert axis.setpoint == 12.0


def test_halt_does_not_creep_back_after_sliding_too_far() -> None:
    axis = Axis(SERVO, LIMITS)
    axis.pursue(SpeedGoal(speed=500.0), LIMITS)
    position, _ = drive(axis, 0.0, [0.01] * 300)
    axis.pursue(HALT, Limits(speed=600.0, acceleration=5000.0, deceleration=5000.0))
    axis.step(0.2, position)
    assert axis.step(0.01, position + 40.0) == 0.0
    axis.keep_place()
    assert axis.step(0.01, position + 35.0) > 0.0


def test_drop_brakes_within_its_own_limits_whatever_was_pursued_before() -> None:
    axis = Axis(SERVO, LIMITS)
    axis.pursue(SpeedGoal(speed=0.0), Limits(speed=600.0, acceleration=10.0, deceleration=10.0))
    axis.drop((0.0, 300.0), Limits(speed=600.0, acceleration=10.0, deceleration=100.0))
    drive(axis, 0.0, [0.01] * 100)
    assert axis.reference[1] == pytest.approx(200.0)


@each("sign", [1, -1])
def test_the_direction_is_known_before_the_axis_moves_and_gone_when_it_rests(sign: int) -> None:
    axis = Axis(SERVO, LIMITS)
    assert axis.direction == 0
    axis.pursue(PositionGoal(position=sign * 100.0), LIMITS)
    assert axis.direction * sign > 0
    drive(axis, 0.0, [0.01] * 400)
    assert axis.direction == 0
    axis.pursue(SpeedGoal(speed=-sign * 100.0), LIMITS)
    assert axis.direction * sign < 0
    axis.hold(LIMITS)
    assert axis.direction == 0
