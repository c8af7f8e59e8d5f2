"""Velocities: of the robot, its rotation, and each wheel."""

from __future__ import annotations

import statistics
from itertools import pairwise

import pytest

from hilbench.check import Violation, at_most, case, near
from hilbench.suites._requirements import (
    RAMP_MM_S2,
    SPEED_MM_S,
    STANDING_UNITS,
    require_fifteen_bits,
    require_slope,
    require_speeds,
    require_turn_rate,
)
from hilbench.suites._session import Session, medians_mm_s, poses, turned_deg
from hilbench.systems.pioneer.peer import Peer
from protocols.p2os import CommandNumber

_C = CommandNumber

STRAIGHT_DEG = 2.0
"""How much the heading may stray on a straight run of half a metre: two wheels never pull alike."""


@case("S22", bench_time_s=2.2)
def test_velocity_is_reached_along_the_ramp(peer: Peer) -> None:
    """Floor: 0.6 m ahead."""
    session = Session(peer, motors=True)
    session.set_ramps(up=200, down=400)
    before = session.next()
    session.send(_C.VEL, 200)
    ramp = session.watch_alive(1.3)
    seen = require_speeds(session, 200, 200)
    require_slope([before, *ramp], 0, 200, 200, session)
    at_most(
        abs(turned_deg([before, *ramp, *seen], session.robot)),
        STRAIGHT_DEG,
        unit="deg",
        what="change of heading on a straight run",
    )
    session.leave()


@case("S23", bench_time_s=1.9)
def test_negative_velocity_drives_backwards(peer: Peer) -> None:
    """SETO first, so that X has to go below 0. Floor: 0.4 m behind."""
    session = Session(peer, motors=True)
    session.set_ramps(up=RAMP_MM_S2, down=RAMP_MM_S2)
    session.send(_C.SETO)
    first = session.next()
    session.write(bytes.fromhex("FAFB060B1BC800D31B"))
    ramp = session.watch_alive(1.0)
    seen = [first, *ramp, *require_speeds(session, -200, -200)]
    steps = [b.x_mm - a.x_mm for a, b in pairwise(poses(seen, session.robot))]
    if not sum(steps) < 0 or max(steps) > STANDING_UNITS * session.robot.distance_unit_mm:
        text = f"X goes by {sum(steps):.0f} mm, and by {max(steps):.0f} mm between two SIPs, while both wheels go back"
        raise Violation(text, peer.evidence())
    require_fifteen_bits(seen, peer)
    session.leave()


@case("S24", bench_time_s=2.9)
def test_rotation_velocity_turns_both_ways(peer: Peer) -> None:
    """Turns on the spot."""
    session = Session(peer, motors=True)
    session.set_ramps(turn=100)
    for rate in (30, -30):
        session.send(_C.RVEL, rate)
        session.watch_alive(0.8)
        seen = session.watch_alive(0.5)
        left, right = medians_mm_s(seen)
        assert (right - left) * rate > 0, f"RVEL {rate}: the left wheel goes {left:g}, the right one {right:g} mm/s"
        require_turn_rate(seen, rate, session)
    session.leave()


@case("S25", bench_time_s=1.9)
def test_translation_and_rotation_go_together(peer: Peer) -> None:
    """Floor: 0.5 m ahead and to the left."""
    session = Session(peer, motors=True)
    session.set_ramps(up=RAMP_MM_S2, down=RAMP_MM_S2, turn=100)
    session.send(_C.VEL, 100)
    session.watch_alive(0.5)
    session.send(_C.RVEL, 20)
    session.watch_alive(0.6)
    seen = session.watch_alive(0.5)
    middle = statistics.median(s.speed_mm_s for s in seen)
    near(middle, 100, SPEED_MM_S, unit="mm/s", what="mean of the wheel speeds")
    require_turn_rate(seen, 20, session)
    session.leave()


@case("S26", bench_time_s=3.6)
def test_each_wheel_takes_its_speed(peer: Peer) -> None:
    """As Player packs it, and then backwards as ARIA does. Floor: 0.5 m ahead and to the left."""
    session = Session(peer, motors=True)
    session.set_ramps(up=RAMP_MM_S2, down=RAMP_MM_S2)
    for frame, left, right in (("FAFB06203B0A052A40", 5, 10), ("FAFB06201B0504251F", -5, -5)):
        session.write(bytes.fromhex(frame))
        session.watch_alive(1.0 if left > 0 else 1.3)
        require_speeds(session, left * session.robot.vel2_unit_mm_s, right * session.robot.vel2_unit_mm_s)
    session.leave()


@case("S27", bench_time_s=1.6)
@pytest.mark.parametrize(
    "frame",
    [
        pytest.param(bytes.fromhex("FAFB06201B0504251F"), id="aria"),
        pytest.param(bytes.fromhex("FAFB06203BFBFB1C36"), id="player"),
    ],
)
def test_negative_wheel_speeds_of_both_senders(peer: Peer, frame: bytes) -> None:
    """Floor: 0.2 m behind."""
    session = Session(peer, motors=True)
    session.set_ramps(up=RAMP_MM_S2, down=RAMP_MM_S2)
    session.write(frame)
    session.watch_alive(0.8)
    require_speeds(session, -5 * session.robot.vel2_unit_mm_s, -5 * session.robot.vel2_unit_mm_s)
    session.leave()
