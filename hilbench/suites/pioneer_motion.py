"""Does the robot do in the world what the protocol says? Each case drives it over the line and judges what it did.

The commands are those of P2OS; the truth is the world's own pose and velocity, at every step of the physics; what is
required follows from formulas and from the exact geometry of the scene. So a wrong scale, a swapped sign or a late
watchdog shows even where the robot's own reports are consistent with themselves.

Only a virtual robot has a truth to look at. Each case begins with a fresh one in the middle of its scene.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterator, Sequence

import pytest

from hilbench.cases import VirtualCase
from hilbench.check import Violation, at_most, case, near, record_measure, within
from hilbench.clock import NS_PER_S
from hilbench.peer import Peer
from hilbench.suites._echoes import require_echoes
from hilbench.suites._mechanics import arc_end, circle_radius, slope, stopping_way, trapezoid_time_s, turn_radius
from hilbench.suites._session import Session, poses
from hilbench.suites._truth import Sample, Truth
from hilbench.suites._wall import (
    WALL_MM,
    drive_into_wall,
    face_wall,
    require_no_stall,
    require_stall,
    segments_touched,
)
from protocols.p2os import CommandNumber, pack_bytes
from worlds.scenes.builtin import RAMP_FOOT_M, RAMP_LENGTH_M, RAMP_SLOPE_RAD
from worlds.vehicles.pioneer_2dx import DEFAULTS
from worlds.world import World

_C = CommandNumber

# --- how exactly a robot is held to what it was told
#
# At 240 steps per second the physics rolls a metre to 0.1 mm and turns 90 degrees to 0.02, when speeds change along
# ramps. What a robot may be off beyond that is its control loop: it learns of a command at its next step, and its servo
# lands within some tenths of a millimetre.

WAY = 0.002
"""Tolerance of a way, as a share: ten times what the physics is off, a tenth of what a client would notice."""

WAY_MM = 1.0
"""Tolerance of where a way ends, for the servo's last millimetre; about one distance unit of a SIP (0.84 mm)."""

TURN_DEG = 0.25
"""Tolerance of where a turn ends; about three heading units of a SIP (0.088 degrees)."""

SPEED = 0.005
"""Tolerance of a steady speed or rate of turn, as a share."""

RAMP = 0.03
"""Tolerance of an acceleration, as a share: a servo pulls along a reference that the wheels trail when they set off."""

RADIUS = 0.005
"""Tolerance of the radius of a circle, as a share: that of a steady speed and a steady rate of turn at worst."""

LIMIT = 0.01
"""How far, as a share, a speed may be above its limit for a moment: a servo swings over when a ramp ends."""

MOTIONLESS_MM = 1.0
MOTIONLESS_DEG = 0.1
"""A robot has not moved when it is no farther off than this: about one unit of a SIP."""

GIVE_WAY_MM = 5.0
"""How much a robot may give way at a wall, and be off that sets off from one: what is stiff gives a few tenths of a
millimetre in the physics, and wheels that push may slip. A choice."""

REACTION_S = 0.02
"""How late the end of a motion may be beyond its formula: the robot notices a command, or its absence, at its next
step, and its servo takes some steps more for the last tenths of a millimetre."""


@pytest.fixture
def truth(bench: VirtualCase, peer: Peer) -> Iterator[Truth]:
    """Where the robot really was, from now on."""
    watched = Truth(bench.bench, bench.world, peer)
    yield watched
    watched.close()


@pytest.fixture
def session(peer: Peer, truth: Truth) -> Session:
    """A session with the motors on."""
    return Session(peer, motors=True)


# --- straight on


def cruise(session: Session, truth: Truth, settle_s: float, measure_s: float) -> list[Sample]:
    """Let the robot settle, then return the samples of some time."""
    session.peer.run_alive(settle_s)
    start_ns = session.now_ns
    session.peer.run_alive(measure_s)
    return truth.since(start_ns)


def mean_speed_mm_s(samples: Sequence[Sample]) -> float:
    """Return the mean speed from way and time, + forward."""
    return samples[-1].seen_from(samples[0])[0] / samples[-1].after_s(samples[0].at_ns)


def mean_turn_deg_s(samples: Sequence[Sample]) -> float:
    """Return the mean rate of turn from angle and time, + counter-clockwise."""
    return (samples[-1].heading_deg - samples[0].heading_deg) / samples[-1].after_s(samples[0].at_ns)


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


def stop_from(speed: int, session: Session, truth: Truth, command: int) -> tuple[float, Sample]:
    """Drive at a speed, give a stopping command, and return the way from its arrival to rest, and where that was."""
    session.send(_C.VEL, speed)
    cruise(session, truth, speed / 600 + 0.2, 0.1)
    arrived_ns = session.send(command)
    rest = truth.wait_still(10.0)
    return rest.seen_from(truth.at(arrived_ns))[0], rest


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


# --- turning


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


# --- arcs


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


# --- limits


@case("M10", bench_time_s=6.5)
def test_setv_is_not_exceeded(session: Session, truth: Truth) -> None:
    """Way, speed and wheels in turn; so that it means something, each has to come near the limit."""
    limit = 150
    session.set_ramps(up=600, down=600)
    session.send(_C.SETV, limit)
    for number, argument in ((_C.MOVE, 400), (_C.VEL, -500), (_C.VEL2, pack_bytes(25, 25))):
        start_ns = session.send(number, argument)
        session.peer.run_alive(1.5)
        session.send(_C.STOP)
        truth.wait_still(2.0)
        fastest = max(abs(sample.speed_mm_s) for sample in truth.since(start_ns))
        within(fastest, limit * 0.95, limit * (1 + LIMIT), unit="mm/s", what=f"top speed of {number.name} {argument}")
    session.leave()


@case("M11", bench_time_s=6.7)
def test_setrv_is_not_exceeded(session: Session, truth: Truth) -> None:
    """Angle, rate and wheels in turn; so that it means something, each has to come near the limit."""
    limit = 40
    session.set_ramps(up=600, down=600)
    session.send(_C.SETRV, limit)
    for number, argument in ((_C.DHEAD, -60), (_C.RVEL, 100), (_C.VEL2, pack_bytes(10, -10))):
        start_ns = session.send(number, argument)
        session.peer.run_alive(1.5)
        session.send(_C.STOP)
        truth.wait_still(2.0)
        fastest = max(abs(sample.turn_deg_s) for sample in truth.since(start_ns))
        high = limit * (1 + LIMIT)
        within(fastest, limit * 0.95, high, unit="deg/s", what=f"top rate of turn of {number.name} {argument}")
    session.leave()


# --- stopping


@case("M12", bench_time_s=4.1)
def test_watchdog_stops_in_the_world(session: Session, truth: Truth) -> None:
    """The last packet is the PULSE after which nothing is sent."""
    speed, ramp = 300, 600
    session.set_ramps(up=ramp, down=ramp)
    session.send(_C.VEL, speed)
    cruise(session, truth, 0.8, 0.2)
    silent_ns = session.send(_C.PULSE)
    rest = truth.wait_still(WATCHDOG_S + speed / ramp + 2.0, feed=False)
    doubt_s = session.uncertainty_s(silent_ns)
    at_most(
        rest.after_s(silent_ns),
        WATCHDOG_S + speed / ramp + REACTION_S,
        unit="s",
        what="time from the last packet to rest",
        uncertainty=doubt_s,
    )
    way = rest.seen_from(truth.at(silent_ns))[0]
    high = (speed * WATCHDOG_S + stopping_way(speed, ramp)) * (1 + SPEED) + speed * truth.step_s
    at_most(way, high, unit="mm", what="way since the last packet", uncertainty=speed * doubt_s)
    session.leave()


WATCHDOG_S = 2.0
"""How long a robot that hears nothing drives on (Pioneer 2 Operations Manual, watchdog)."""


@case("M19", bench_time_s=3.1)
def test_enable_0_ends_the_motion(session: Session, truth: Truth) -> None:
    """Whether it brakes or lets go: a robot that needs longer than STOP does has not stopped but rolls on."""
    speed, ramp = 400, 300
    session.set_ramps(up=800, down=ramp)
    session.send(_C.VEL, speed)
    cruise(session, truth, 0.8, 0.2)
    arrived_ns = session.send(_C.ENABLE, 0)
    rest = truth.wait_still(5.0)
    doubt_s = session.uncertainty_s(arrived_ns)
    high_s = speed / ramp + REACTION_S
    at_most(rest.after_s(arrived_ns), high_s, unit="s", what="time from ENABLE 0 to rest", uncertainty=doubt_s)
    way, high = rest.seen_from(truth.at(arrived_ns))[0], stopping_way(speed, ramp) + WAY_MM
    at_most(way, high, unit="mm", what="way from ENABLE 0 to rest", uncertainty=speed * doubt_s)
    assert not session.next().sip.motors_enabled, "the SIP says that the motors are on"
    session.send(_C.VEL, speed)
    session.peer.run_alive(0.7)
    require_motionless(rest, truth, "VEL after ENABLE 0")


@case("M20", bench_time_s=5.1)
def test_emergency_stop_is_shorter(session: Session, truth: Truth) -> None:
    """At most half the way, for there must be a difference that is no accident."""
    speed = 500
    session.set_ramps(up=600, down=300)
    stop, _ = stop_from(speed, session, truth, _C.STOP)
    emergency, rest = stop_from(speed, session, truth, _C.E_STOP)
    record_measure(f"way of STOP from {speed} mm/s", stop, "mm")
    doubt = speed * session.uncertainty_s(rest.at_ns)
    at_most(emergency, stop / 2, unit="mm", what=f"way of E_STOP from {speed} mm/s", uncertainty=doubt)
    session.leave()


@case("M24", bench_time_s=3.2)
def test_no_motion_with_motors_off(peer: Peer, truth: Truth) -> None:
    session = Session(peer)
    start = truth.now
    for number, argument in (
        (_C.VEL, 300),
        (_C.MOVE, 500),
        (_C.RVEL, 60),
        (_C.HEAD, 90),
        (_C.DHEAD, -45),
        (_C.VEL2, pack_bytes(20, 10)),
    ):
        session.send(number, argument)
        peer.run(0.5)
        require_motionless(start, truth, f"{number.name} {argument}")
    session.leave()


def require_motionless(start: Sample, truth: Truth, what: str) -> None:
    """Require that the robot is where it was, and looks where it looked."""
    moved = math.dist(truth.now.point_mm, start.point_mm)
    at_most(moved, MOTIONLESS_MM, unit="mm", what=f"way after {what}")
    turned = abs(truth.now.heading_deg - start.heading_deg)
    at_most(turned, MOTIONLESS_DEG, unit="deg", what=f"turn after {what}")


# --- odometry


@case("M18", bench_time_s=16.0)
def test_odometry_agrees_with_the_truth(session: Session, truth: Truth) -> None:
    """A square of half a metre, compared at its four corners."""
    session.set_ramps(up=600, down=600, turn=200)
    start = truth.now
    mark = origin(session)
    for corner in (1, 2, 3, 4):
        session.send(_C.MOVE, 500)
        truth.wait_still(5.0)
        session.send(_C.DHEAD, 90)
        end = truth.wait_still(5.0)
        session.next()
        said = poses(session.seen(mark), session.robot)[-1]
        ahead, left = end.seen_from(start)
        near(said.x_mm, ahead, ODOMETRY_MM, unit="mm", what=f"x of the SIP at corner {corner}")
        near(said.y_mm, left, ODOMETRY_MM, unit="mm", what=f"y of the SIP at corner {corner}")
        turned = end.heading_deg - start.heading_deg
        near(said.heading_deg, turned, TURN_DEG, unit="deg", what=f"heading of the SIP at corner {corner}")
    session.leave()


ODOMETRY_MM = 4.0
"""Tolerance of the position after up to 2 m and four right angles: WAY of 2 m, which is also about what TURN_DEG makes
of a metre."""


def origin(session: Session) -> int:
    """Make the pose 0, 0, 0; return the mark of the first SIP that has it."""
    arrived_ns = session.send(_C.SETO)
    session.next_after(arrived_ns)
    return session.peer.mark() - 1


@case("M23", bench_time_s=10.3)
def test_heading_over_two_turns(session: Session, truth: Truth) -> None:
    """All the way round twice and a bit, so that the heading of the SIPs wraps twice; then at rest once more."""
    rate = 90
    start = truth.now
    mark = origin(session)
    session.send(_C.RVEL, rate)
    truth.wait_until(lambda: truth.now.heading_deg - start.heading_deg > 740, 15.0, "no two turns")
    session.send(_C.STOP)
    end = truth.wait_still(3.0)
    session.next()
    seen = session.seen(mark)
    followed = poses(seen, session.robot)
    errors = [
        pose.heading_deg - (truth.at(sip.start_ns).heading_deg - start.heading_deg)
        for pose, sip in zip(followed, seen, strict=True)
    ]
    # A SIP on its way is as old as its first byte is long, and what it says as old as the robot's last step.
    age_s = 10 / (session.peer.port.baud or 9600) + truth.step_s
    doubt = rate * session.uncertainty_s(seen[0].start_ns)
    worst = max(errors, key=abs)
    near(worst, 0, TURN_DEG + rate * age_s, unit="deg", what="heading of a SIP less the true one", uncertainty=doubt)
    turned = end.heading_deg - start.heading_deg
    near(followed[-1].heading_deg, turned, TURN_DEG, unit="deg", what="heading of the SIP at rest after two turns")
    session.leave()


# --- contacts


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
    told = session.next_after(touched_ns + round(2 * truth.step_s * NS_PER_S))
    record_measure("time from the contact to the SIP that has to report it", told.after_s(touched_ns), "s")
    reported, expected = (told.sip.front_bumpers, told.sip.rear_bumpers), segments_touched(bearing_deg)
    if reported != expected:
        raise Violation(
            f"front bumpers {reported[0]:05b} and rear bumpers {reported[1]:05b} are reported,"
            f" {expected[0]:05b} and {expected[1]:05b} touch the wall (segment 1 is the last digit)",
            session.peer.evidence(),
        )
    session.leave()


# --- echoes


def look_around(session: Session, truth: Truth, world: World, legs: Sequence[tuple[int, int]]) -> None:
    """Look where the robot is, then after each leg: a heading in degrees, and a way in mm."""
    session.set_ramps(up=600, down=600, turn=200)
    require_echoes(session, world, "at the start")
    for heading, way in legs:
        session.send(_C.HEAD, heading)
        truth.wait_still(5.0)
        session.send(_C.MOVE, way)
        truth.wait_still(5.0)
        require_echoes(session, world, f"after HEAD {heading} and MOVE {way}")
    session.leave()


@case("M15", bench_time_s=9.7, scene="wall")
def test_sonars_before_a_wall(session: Session, truth: Truth, world: World) -> None:
    look_around(session, truth, world, [(20, 600), (-40, 300)])


@case("M16", bench_time_s=17.1, scene="room-with-boxes")
def test_sonars_in_a_room(session: Session, truth: Truth, world: World) -> None:
    """The room keeps 1.5 m around its middle free."""
    look_around(session, truth, world, [(50, 700), (170, 700), (-70, 700)])


@case("M17", bench_time_s=10.7, scene="corridor")
def test_sonars_in_a_corridor(session: Session, truth: Truth, world: World) -> None:
    look_around(session, truth, world, [(15, 800), (-60, 600)])


# --- uphill


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
