"""On the floor: straight on, and turning."""

from __future__ import annotations

import math

from hilbench.check import at_least, at_most, near, within
from hilbench.clock import NS_PER_S
from hilbench.suites._rover_law import CARRIED_KG_M2, Driven
from hilbench.suites._rover_motion import Ride, ideal_turn_deg_s, on_bench
from hilbench.suites.rover_motion._judged import LOOK_S, TURNS_RPM, course_rpm, ride
from worlds.vehicles.rover_4wd import DEFAULTS

__all__ = ["ride"]

SPEED, DRIFT, DRIFT_DEG = 0.03, 0.01, 1.0
"""Tolerance of the speed, drift a way, drift of the heading. Choices."""

RATIO = (0.42, 0.62)
"""Of four dragged wheels to two that roll: 0.60 with friction that is the same in all directions, as in MuJoCo, and
0.50 in PyBullet, which weighs sliding along and across a wheel differently (docs/rover-vehicle.md)."""

STANDS_DEG_S = 2.0
"""What turns more slowly does not turn. A choice."""


@on_bench("R10", lasts_s=2.2, scene="hard-floor")
def test_straight_on(ride: Ride) -> None:
    ride.go(0.1)
    start = ride.now
    ride.drive(0.5, 0.5, 2.0)
    before = ride.before(LOOK_S)
    speed_m_s = ride.now.seen_from(before)[0] / ((ride.now.at_ns - before.at_ns) / NS_PER_S)
    rpm = course_rpm(Driven(throttle=0.5, inertia_kg_m2=CARRIED_KG_M2), 2.0)
    law_m_s = rpm * math.tau / 60 * DEFAULTS.wheel_radius_m
    near(speed_m_s, law_m_s, SPEED * law_m_s, unit="m/s", what="speed over ground 2 s after throttle 0.5")
    ahead_m, left_m = ride.now.seen_from(start)
    at_most(abs(left_m), DRIFT * ahead_m, unit="m", what=f"drift to the side on {ahead_m:.2f} m")
    at_most(abs(ride.now.yaw_deg - start.yaw_deg), DRIFT_DEG, unit="deg", what="drift of the heading")


def turn_ratio(ride: Ride, over_s: float = 0.5) -> tuple[float, float]:
    """Return how fast the rover turned lately, in deg/s, + to the left, and its share of what two wheels would make."""
    before = ride.before(over_s)
    turn_deg_s = (ride.now.yaw_deg - before.yaw_deg) / ((ride.now.at_ns - before.at_ns) / NS_PER_S)
    return turn_deg_s, turn_deg_s / ideal_turn_deg_s(ride.now.rpm_since(before))


@on_bench("R11", lasts_s=3.6, scene="hard-floor")
def test_turning_on_the_spot(ride: Ride) -> None:
    for throttle, for_s, way in ((0.8, 1.5, "left"), (-0.8, 2.0, "right")):
        ride.drive(-throttle, throttle, for_s)
        turn_deg_s, ratio = turn_ratio(ride)
        at_least(turn_deg_s * math.copysign(1, throttle), 60.0, unit="deg/s", what=f"rate of turn to the {way}")
        within(ratio, *RATIO, unit="of two wheels", what=f"rate of turn to the {way}")


@on_bench("R12", lasts_s=2.7, scene="carpet")
def test_turning_on_a_carpet(ride: Ride) -> None:
    ride.drive(-0.8, 0.8, 0.8)
    turn_deg_s, _ = turn_ratio(ride, 0.3)
    at_most(abs(turn_deg_s), STANDS_DEG_S, unit="deg/s", what="rate of turn at throttles -0.8 and 0.8")
    ride.drive(-1.0, 1.0, 1.8)
    within(turn_ratio(ride)[0], 10.0, 60.0, unit="deg/s", what="rate of turn at throttles -1 and 1")


@on_bench("R13", lasts_s=1.3, scene="hard-floor")
def test_unequal_throttles(ride: Ride) -> None:
    ride.drive(0.4, 0.7, 1.2)
    at_least(min(ride.rpm(LOOK_S)), TURNS_RPM, unit="rpm", what="slowest wheel at throttles 0.4 and 0.7")
    at_most(abs(ride.now.yaw_deg), DRIFT_DEG, unit="deg", what="turn at throttles 0.4 and 0.7")
