"""Up a ramp."""

from __future__ import annotations

import math
import statistics

from hilbench.check import case, near
from hilbench.suites._session import Session
from hilbench.suites._truth import Truth
from hilbench.suites.pioneer_motion._judged import SPEED, WAY, WAY_MM, session, truth
from protocols.p2os import CommandNumber
from worlds.scenes.builtin import RAMP_FOOT_M, RAMP_LENGTH_M, RAMP_SLOPE_RAD

__all__ = ["session", "truth"]

_C = CommandNumber


@case("M22", bench_time_s=8.7, scene="ramp")
def test_robot_climbs_a_ramp(session: Session, truth: Truth) -> None:
    """Measured where wheels and caster are on the slope."""
    speed = 500
    session.set_ramps(up=600)
    session.send(_C.VEL, speed)
    begin_mm, end_mm = RAMP_FOOT_M * 1000 + 500, (RAMP_FOOT_M + RAMP_LENGTH_M * math.cos(RAMP_SLOPE_RAD)) * 1000 - 500
    first = truth.wait_until(lambda: truth.now.x_mm > begin_mm, 10.0, "the robot does not get onto the slope")
    last = truth.wait_until(lambda: truth.now.x_mm > end_mm, 15.0, "the robot does not get up the slope")
    way = math.hypot(math.dist(last.point_mm, first.point_mm), last.z_mm - first.z_mm)
    near(way / last.after_s(first.at_ns), speed, SPEED * speed, unit="mm/s", what="true speed up the slope")
    climbed = math.tan(RAMP_SLOPE_RAD) * (last.x_mm - first.x_mm)
    near(last.z_mm - first.z_mm, climbed, WAY * way + WAY_MM, unit="mm", what="height gained on the slope")
    pitch = statistics.fmean(sample.pitch_deg for sample in truth.since(first.at_ns))
    near(pitch, -math.degrees(RAMP_SLOPE_RAD), 0.5, unit="deg", what="pitch on the slope")
    session.leave()
