"""Ways, speeds and accelerations straight on."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from hilbench.check import Violation, case, near, record_measure, within
from hilbench.suites._mechanics import slope, stopping_way, trapezoid_time_s
from hilbench.suites._session import Session
from hilbench.suites._truth import Sample, Truth
from hilbench.suites.pioneer_motion._judged import (
    SPEED,
    TURN_DEG,
    WAY,
    WAY_MM,
    cruise,
    mean_turn_deg_s,
    session,
    stop_from,
    truth,
)
from protocols.p2os import CommandNumber

__all__ = ["session", "truth"]

_C = CommandNumber

RAMP = 0.03
"""Tolerance of an acceleration, as a share: a servo pulls along a reference that the wheels trail when they set off."""


def mean_speed_mm_s(samples: Sequence[Sample]) -> float:
    """Return the mean speed from way and time, + forward."""
    return samples[-1].seen_from(samples[0])[0] / samples[-1].after_s(samples[0].at_ns)


@case("M01", bench_time_s=6.7)
def test_move_arrives(session: Session, truth: Truth) -> None:
    speed, ramp = 400, 400
    session.set_ramps(up=ramp, down=ramp)
    session.send(_C.SETV, speed)
    for way in (1000, -500):
        start = truth.now
        begun_ns = session.send(_C.MOVE, way)
        end = truth.wait_still(10.0)
        ahead, left = end.seen_from(start)
        near(ahead, way, WAY * abs(way) + WAY_MM, unit="mm", what=f"way of MOVE {way}")
        near(left, 0, WAY * abs(way) + WAY_MM, unit="mm", what=f"stray to the left in MOVE {way}")
        near(end.heading_deg - start.heading_deg, 0, TURN_DEG, unit="deg", what=f"change of heading in MOVE {way}")
        late_s = end.after_s(begun_ns) - trapezoid_time_s(abs(way), speed, ramp)
        record_measure(f"time of MOVE {way} beyond the trapezoid's", late_s, "s")
    session.leave()


@case("M02", bench_time_s=2.8)
@pytest.mark.parametrize("speed", [300, -200])
def test_velocity_is_true(session: Session, truth: Truth, speed: int) -> None:
    session.set_ramps(up=600)
    session.send(_C.VEL, speed)
    samples = cruise(session, truth, 1.0, 1.5)
    near(mean_speed_mm_s(samples), speed, SPEED * abs(speed), unit="mm/s", what=f"true speed at VEL {speed}")
    near(mean_turn_deg_s(samples), 0, TURN_DEG, unit="deg/s", what=f"true rate of turn at VEL {speed}")
    session.leave()


@case("M03", bench_time_s=1.6)
@pytest.mark.parametrize("acceleration", [200, 600])
def test_acceleration_is_seta(session: Session, truth: Truth, acceleration: int) -> None:
    speed = 300
    session.set_ramps(up=acceleration)
    arrived_ns = session.send(_C.VEL, speed)
    session.peer.run_alive(speed / acceleration + 0.3)
    ramp = [sample for sample in truth.since(arrived_ns) if 0.1 * speed < sample.speed_mm_s < 0.9 * speed]
    if len(ramp) < 10:  # at 240 Hz the steepest ramp here has 96
        raise Violation(f"the speed does not rise to {speed} mm/s along a ramp", [str(sample) for sample in ramp])
    rise = slope([sample.after_s(arrived_ns) for sample in ramp], [sample.speed_mm_s for sample in ramp])
    near(rise, acceleration, RAMP * acceleration, unit="mm/s2", what=f"true acceleration at SETA {acceleration}")
    session.leave()


@case("M04", bench_time_s=3.0)
@pytest.mark.parametrize("deceleration", [300, 600])
def test_stopping_way(session: Session, truth: Truth, deceleration: int) -> None:
    """The robot goes on at its speed until its next control step; so much longer the way may be."""
    speed = 500
    session.set_ramps(up=600, down=deceleration)
    way, rest = stop_from(speed, session, truth, _C.STOP)
    low = stopping_way(speed, deceleration)
    high = low + speed * truth.step_s
    slack = WAY * low + WAY_MM
    doubt = speed * session.uncertainty_s(rest.at_ns)
    what = f"way of STOP from {speed} mm/s at SETA -{deceleration}"
    within(way, low - slack, high + slack, unit="mm", what=what, uncertainty=doubt)
    session.leave()
