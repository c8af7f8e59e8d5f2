"""A wall that stalls the wheels and touches the bumpers."""

from __future__ import annotations

import pytest

from hilbench.check import Violation, case, near, record_measure
from hilbench.clock import NS_PER_S
from hilbench.suites._session import Session
from hilbench.suites._truth import Truth
from hilbench.suites._wall import WALL_MM, drive_into_wall, face_wall, require_no_stall, require_stall, segments_touched
from hilbench.suites.pioneer_motion._judged import session, truth
from protocols.p2os import CommandNumber
from worlds.vehicles.pioneer_2dx import DEFAULTS
from worlds.world import World

__all__ = ["session", "truth"]

_C = CommandNumber

GIVE_WAY_MM = 5.0
"""How much a robot may give way at a wall, and be off that sets off from one: what is stiff gives a few tenths of a
millimetre in the physics, and wheels that push may slip. A choice."""


@case("M13", bench_time_s=5.3, scene="wall")
def test_wall_stalls_the_wheels(session: Session, truth: Truth, world: World) -> None:
    """Puts the robot a little before the wall, drives at it and goes on pushing."""
    face_wall(world, truth, 0)
    touched_ns = drive_into_wall(session, truth, world, 200)
    require_stall(session, touched_ns)
    session.peer.run_alive(3.0)
    pushed_mm = [sample.x_mm - (WALL_MM - DEFAULTS.length_front_m * 1000) for sample in truth.since(touched_ns)]
    what = "distance of the bumper from the wall while the robot pushes"
    near(max(pushed_mm, key=abs), 0, GIVE_WAY_MM, unit="mm", what=what)
    session.leave()


@case("M14", bench_time_s=7.2, scene="wall")
def test_stall_ends(session: Session, truth: Truth, world: World) -> None:
    """Puts the robot a little before the wall and drives at it; then back, and at it again but not as far."""
    face_wall(world, truth, 0)
    touched_ns = drive_into_wall(session, truth, world, 200)
    require_stall(session, touched_ns)
    for way in (-300, 150):
        start = truth.now
        session.send(_C.MOVE, way)
        end = truth.wait_still(6.0)
        near(end.seen_from(start)[0], way, GIVE_WAY_MM, unit="mm", what=f"way of MOVE {way} after the stall")
        mark = session.peer.mark()
        session.peer.run_alive(0.4)
        require_no_stall(session, mark, "away from the wall")
    session.leave()


@case("M21", bench_time_s=2.5, scene="wall")
@pytest.mark.parametrize("bearing_deg", [0, 30, -30, 180, 150])
def test_bumper_reports_its_segment(session: Session, truth: Truth, world: World, bearing_deg: int) -> None:
    """Puts the robot before the wall so that one segment is parallel to it, and drives at it.

    Five segments of 30 degrees each, counted from the robot's left to its right in front and behind; this count is this
    robot's, for the public manuals name the bits but not the side they begin at.
    """
    face_wall(world, truth, bearing_deg)
    mark = session.peer.mark()
    touched_ns = drive_into_wall(session, truth, world, 150 if abs(bearing_deg) < 90 else -150)
    early = [s for s in session.seen(mark) if s.sip.front_bumpers or s.sip.rear_bumpers]
    if early:
        raise Violation("a bumper is reported before anything is touched", [early[0].raw.hex(" ").upper()])
    report = session.next_after(touched_ns + round(2 * truth.step_s * NS_PER_S))
    record_measure("time from the contact to the SIP that has to report it", report.after_s(touched_ns), "s")
    reported, expected = (report.sip.front_bumpers, report.sip.rear_bumpers), segments_touched(bearing_deg)
    if reported != expected:
        raise Violation(
            f"front bumpers {reported[0]:05b} and rear bumpers {reported[1]:05b} are reported,"
            f" {expected[0]:05b} and {expected[1]:05b} touch the wall (segment 1 is the last digit)",
            session.peer.evidence(),
        )
    session.leave()
