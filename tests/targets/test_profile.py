"""The trapezoid: limits kept, targets hit exactly, re-planning without a jump."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from targets.robots.pioneer.profile import Limits, Plan, plan_distance, plan_speed
from tests.share import examples

speeds = st.floats(-2000, 2000)
distances = st.floats(-40_000, 40_000)
limits = st.builds(Limits, speed=st.floats(1, 2000), acceleration=st.floats(5, 2000), deceleration=st.floats(5, 2000))
LIMITS = Limits(speed=600.0, acceleration=300.0, deceleration=200.0)


def instants(plan: Plan, count: int = 60) -> list[float]:
    return [plan.duration_s * k / count for k in range(count + 1)]


def simpson(plan: Plan, a: float, b: float) -> float:
    """Integral of the speed; exact inside a phase, where the speed is linear."""
    return (plan.at(a)[1] + 4 * plan.at((a + b) / 2)[1] + plan.at(b)[1]) * (b - a) / 6


@given(speed=speeds, target=speeds, limits=limits)
@settings(deadline=None)
def test_speed_plan_arrives_and_keeps_its_rates(speed: float, target: float, limits: Limits) -> None:
    plan = plan_speed(speed, target, limits)
    assert plan.final_speed == pytest.approx(max(-limits.speed, min(limits.speed, target)))
    for phase in plan.phases:
        rising = abs(phase.speed_after(phase.duration_s)) > abs(phase.speed)
        assert abs(phase.acceleration) == (limits.acceleration if rising else limits.deceleration)
    clipped = plan.final_speed
    same_direction = speed * clipped >= 0
    grows = same_direction and abs(clipped) >= abs(speed)
    if grows:
        expected = abs(clipped - speed) / limits.acceleration
    elif same_direction:
        expected = abs(clipped - speed) / limits.deceleration
    else:
        expected = abs(speed) / limits.deceleration + abs(clipped) / limits.acceleration
    assert plan.duration_s == pytest.approx(expected, abs=1e-9)


@given(speed=speeds, distance=distances, limits=limits)
@settings(deadline=None)
def test_distance_plan_lands_exactly_at_rest(speed: float, distance: float, limits: Limits) -> None:
    plan = plan_distance(speed, distance, limits)
    covered = math.fsum(phase.travelled(phase.duration_s) for phase in plan.phases)
    assert covered == pytest.approx(distance, abs=1e-6, rel=1e-9)
    assert plan.at(plan.duration_s + 1) == (distance, 0.0)
    if plan.phases:
        last = plan.phases[-1]
        assert last.speed_after(last.duration_s) == pytest.approx(0.0, abs=1e-6)


@given(speed=speeds, distance=distances, limits=limits)
@settings(deadline=None)
def test_distance_plan_is_continuous_and_within_limits(speed: float, distance: float, limits: Limits) -> None:
    plan = plan_distance(speed, distance, limits)
    assert all(phase.duration_s >= 0 for phase in plan.phases)
    expected = speed
    for phase in plan.phases:
        assert phase.speed == pytest.approx(expected, abs=1e-6)
        expected = phase.speed_after(phase.duration_s)
        assert abs(phase.acceleration) in (0.0, limits.acceleration, limits.deceleration)
        growing = abs(expected) > abs(phase.speed)
        assert abs(phase.acceleration) == (limits.acceleration if growing else abs(phase.acceleration))
    top = max(limits.speed, abs(speed))
    assert all(abs(plan.at(t)[1]) <= top * (1 + 1e-9) for t in instants(plan))


@given(speed=speeds, distance=distances, limits=limits)
@settings(max_examples=examples(50))
def test_a_plan_covers_the_integral_of_its_speed(speed: float, distance: float, limits: Limits) -> None:
    plan = plan_distance(speed, distance, limits)
    ends = [0.0]
    for phase in plan.phases:
        ends.append(ends[-1] + phase.duration_s)
    for start, end in pairwise(ends):
        # the speed at the very end of a phase belongs to the next one, which is the same speed
        assert plan.at(end)[0] - plan.at(start)[0] == pytest.approx(simpson(plan, start, end), rel=1e-6, abs=1e-4)


def test_known_trapezoid() -> None:
    plan = plan_distance(0.0, 3000.0, LIMITS)
    ramp_up, cruise, ramp_down = (phase.duration_s for phase in plan.phases)
    assert (ramp_up, ramp_down) == (2.0, 3.0)
    assert cruise == pytest.approx((3000 - 600 - 900) / 600)
    assert plan.at(1.0) == (150.0, 300.0)


def test_known_triangle() -> None:
    plan = plan_distance(0.0, 100.0, Limits(speed=600.0, acceleration=100.0, deceleration=100.0))
    assert [phase.duration_s for phase in plan.phases] == pytest.approx([1.0, 1.0])
    assert plan.at(1.0) == (pytest.approx(50.0), pytest.approx(100.0))


def test_too_fast_to_stop_overshoots_and_comes_back() -> None:
    plan = plan_distance(600.0, 100.0, LIMITS)
    farthest = max(plan.at(t)[0] for t in instants(plan, 1000))
    assert farthest == pytest.approx(600.0**2 / 400, rel=1e-3)
    assert plan.at(plan.duration_s) == (100.0, 0.0)


def test_reversing_brakes_first() -> None:
    plan = plan_speed(200.0, -300.0, LIMITS)
    assert [(p.duration_s, p.acceleration) for p in plan.phases] == [(1.0, -200.0), (1.0, -300.0)]


def test_nothing_to_do_is_no_phase() -> None:
    assert plan_speed(100.0, 100.0, LIMITS).phases == ()
    assert plan_distance(0.0, 0.0, LIMITS).duration_s == 0.0
