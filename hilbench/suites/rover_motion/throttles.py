"""Throttles to wheels that hang in the air."""

from __future__ import annotations

from hilbench.check import at_least, at_most, near, within
from hilbench.suites._rover_law import Driven, settled_rpm
from hilbench.suites._rover_motion import LEFT, NAMES, RIGHT, Ride, on_bench
from hilbench.suites.rover_motion._judged import (
    LAW_RPM,
    LOOK_S,
    TURNS_RPM,
    TWITCHES_RPM,
    course_rpm,
    require_law,
    require_speeds,
    ride,
)

__all__ = ["ride"]

SAME_RPM = 1.0
"""How far apart wheels may be that are driven alike. A choice."""

ORIGINAL_RPM = {0.39: (142.0, 145.0), 0.35: (133.0, 133.0), 0.30: (115.0, 120.0), 0.25: (95.0, 100.0)}
"""Throttle and speeds of the original's wheels in the air (nhorro/ceai2020 intro_se, notebooks)."""

ORIGINAL_OFF_RPM = 4.0
"""What is read from plots, of wheels that scatter, on cells of which nobody knows how full they were. A choice."""


@on_bench("R01", lasts_s=4.9)
def test_throttle_to_speed(ride: Ride) -> None:
    require_law(ride, (0.3, 0.5, 1.0, 0.4), 1.2)


@on_bench("R02", lasts_s=5.3)
def test_as_the_original_in_the_air(ride: Ride) -> None:
    ride.drive(0.5, 0.5, 0.8)
    for throttle, (low_rpm, high_rpm) in ORIGINAL_RPM.items():
        ride.drive(throttle, throttle, 1.1)
        for name, rpm in zip(NAMES, ride.rpm(LOOK_S), strict=True):
            what = f"{name} wheel at throttle {throttle:g}"
            within(rpm, low_rpm - ORIGINAL_OFF_RPM, high_rpm + ORIGINAL_OFF_RPM, unit="rpm", what=what)


@on_bench("R03", lasts_s=5.2)
def test_breakaway(ride: Ride) -> None:
    """A wheel that is pulsed just below twitches a little."""
    for throttle, for_s, turns in ((0.21, 0.6, False), (0.26, 1.5, True), (0.21, 1.2, True), (0.17, 1.8, False)):
        ride.drive(throttle, throttle, for_s)
        for name, rpm in zip(NAMES, ride.rpm(LOOK_S), strict=True):
            what = f"{name} wheel {for_s:g} s after throttle {throttle:g}"
            if turns:
                at_least(rpm, TURNS_RPM, unit="rpm", what=what)
            else:
                at_most(rpm, TWITCHES_RPM, unit="rpm", what=what)


@on_bench("R04", lasts_s=2.5)
def test_both_directions(ride: Ride) -> None:
    ride.drive(-0.4, -0.4, 1.2)
    rpm = course_rpm(Driven(throttle=0.4), 1.2)
    require_speeds(ride, [-rpm] * 4, LAW_RPM, "1.2 s after throttle -0.4")
    ride.drive(0.4, -0.4, 1.2)
    left, right, *_ = ride.rpm(LOOK_S)
    require_speeds(ride, [left, right] * 2, SAME_RPM, "beside the other of its side")
    at_least(left, rpm / 2, unit="rpm", what="left wheels after throttle 0.4, 1.2 s after -0.4")
    near(right, -settled_rpm(Driven(throttle=0.4)), LAW_RPM, unit="rpm", what="right wheels after throttle -0.4")


@on_bench("R05", lasts_s=1.6)
def test_flags(ride: Ride) -> None:
    for flags, signs in ((1, (1, 0)), (2, (1, -1)), (0, (1, -1))):
        ride.drive(0.5 * (flags == 1), -0.5 * (flags == 2), 0.5, flags=flags)
        for side, wheels, sign in zip(("left", "right"), (LEFT, RIGHT), signs, strict=True):
            for wheel in wheels:
                rpm = ride.rpm(0.1)[wheel]
                what = f"{NAMES[wheel]} wheel after a command with flags {flags}"
                if sign:
                    at_least(rpm * sign, TURNS_RPM, unit="rpm", what=f"{what}, {side} {'+' if sign > 0 else '-'}")
                else:
                    at_most(abs(rpm), TWITCHES_RPM, unit="rpm", what=what)
