"""The rover's ride, and what the cases of several files require of it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pytest

from hilbench.check import Violation, near
from hilbench.mcu.board_case import BoardCase
from hilbench.suites._rover_law import STEP_S, Driven, wheel_course
from hilbench.suites._rover_motion import FEED_S, NAMES, Ride, numbers_in
from protocols.pkt import ImuReport

__all__ = [
    "LAW_RPM",
    "LOOK_S",
    "TURNS_RPM",
    "TWITCHES_RPM",
    "course_rpm",
    "next_imu",
    "require_law",
    "require_speeds",
    "require_status",
    "ride",
]

LAW_RPM = 4.0
"""How far a speed may be from the law. The bench puts pulses of 5 ms on steps of 4.2 ms. A choice."""

LOOK_S = 0.2
"""Over which speeds are mean ones: ten periods of the pulses."""

TURNS_RPM, TWITCHES_RPM = 40.0, 5.0
"""A wheel that is faster turns, one that is slower stands: pulses that are too short move it a little. Choices."""


@pytest.fixture
def ride(bench: BoardCase) -> Ride:
    """The rover, power just on, with a watch on what it does."""
    return Ride(bench)


def course_rpm(driven: Driven, duration_s: float) -> float:
    """Return the mean speed of the last ten periods of a course."""
    course = list(wheel_course(driven, duration_s))
    last = course[-round(LOOK_S / STEP_S) :]
    return sum(last) / len(last) * 60 / math.tau


def require_speeds(ride: Ride, wanted_rpm: Sequence[float], tolerance_rpm: float, what: str) -> None:
    """Require the mean speeds of all wheels over the last ten periods."""
    for name, found_rpm, rpm in zip(NAMES, ride.rpm(LOOK_S), wanted_rpm, strict=True):
        near(found_rpm, rpm, tolerance_rpm, unit="rpm", what=f"{name} wheel {what}")


def require_law(ride: Ride, throttles: Sequence[float], duration_s: float, **others: float) -> None:
    """Drive at one throttle after the other, and hold the wheels' speeds against the law, from where they were."""
    start_rpm = 0.0
    for throttle in throttles:
        ride.drive(throttle, throttle, duration_s)
        wanted_rpm = course_rpm(Driven(throttle=throttle, start_rpm=start_rpm, **others), duration_s)
        require_speeds(ride, [wanted_rpm] * 4, LAW_RPM, f"{duration_s:g} s after throttle {throttle:g}")
        start_rpm = min(ride.rpm(LOOK_S))


def next_imu(ride: Ride) -> tuple[int, ImuReport]:
    """Wait for the next 0x82, and keep the link up; return it with the time of its first byte."""
    mark = ride.rover.mark()
    for _ in range(3):
        ride.go(FEED_S)
        if found := ride.rover.peer.since(mark, ImuReport):
            return found[0][0].start_ns, numbers_in(found[0][1])
    raise Violation("no 0x82 within 1.2 s", ride.rover.peer.evidence(mark))


def require_status(ride: Ride, wanted: int) -> None:
    """Require the STATUS byte."""
    status = ride.status()
    if status != wanted:
        raise Violation(f"STATUS is {status:#04x}, required {wanted:#04x}", ride.rover.peer.evidence())
