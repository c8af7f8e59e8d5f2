"""Headings, ways, limits, ramps and the origin."""

from __future__ import annotations

import math

import pytest

from hilbench.check import Inconclusive, NotApplicable, Violation, at_least, at_most, case, near
from hilbench.suites._requirements import SPEED_MM_S, STANDING_UNITS, require_heading, require_slope
from hilbench.suites._session import Session, poses
from hilbench.systems.pioneer.peer import Peer
from protocols.p2os import CommandNumber

_C = CommandNumber

MOVE = 0.01
"""Tolerance of MOVE, as a share; clause S30 has it."""


@case("S28", bench_time_s=5.7)
def test_heading_is_taken_and_held(peer: Peer) -> None:
    """Turns on the spot."""
    session = Session(peer, motors=True)
    session.set_ramps(turn=100)
    session.send(_C.SETO)
    for heading_deg in (90, -90):
        session.send(_C.HEAD, heading_deg)
        require_heading(session, heading_deg)
    session.leave()


@case("S29", bench_time_s=3.1)
def test_heading_changes_are_relative(peer: Peer) -> None:
    """DCHEAD is sent in the middle of a turn, where the setpoint and the heading differ. Turns on the spot."""
    session = Session(peer, motors=True)
    session.set_ramps(turn=100)
    session.send(_C.SETO)
    session.send(_C.DHEAD, -45)
    require_heading(session, -45)
    session.send(_C.DHEAD, -45)
    session.watch_alive(0.3)
    session.send(_C.DCHEAD, 30)
    require_heading(session, -60)
    session.leave()


@case("S91", bench_time_s=9.6)
def test_the_setpoint_is_the_heading_asked_for(peer: Peer) -> None:
    """While it turns, and when it has. Turns on the spot."""
    session = Session(peer, motors=True)
    session.set_ramps(turn=100)
    rest = session.next_after(session.send(_C.SETO))
    turn, setpoint = session.robot.units_per_turn, 0.0
    found: list[tuple[str, float, int]] = []
    for number, argument_deg in TURNS:
        start = {_C.HEAD: 0.0, _C.DHEAD: rest.sip.th_raw, _C.DCHEAD: setpoint}[number]
        setpoint = start + argument_deg * turn / 360
        turning = session.next_after(session.send(number, argument_deg))
        session.watch_alive(0.5)
        rest = session.wait_at_rest(8.0)
        found += [(f"{number.name} {argument_deg}", setpoint, one.sip.control_raw) for one in (turning, rest)]
    session.leave()
    if not any(units for _, _, units in found):
        raise NotApplicable("the robot says no heading setpoint: its bytes are always 0")
    for what, wanted, units in found:
        off = math.remainder(units - wanted, turn)
        near(wanted + off, wanted, SETPOINT_UNITS, unit="units", what=f"setpoint of {what}")


TURNS = (
    (_C.HEAD, 45),
    (_C.DHEAD, -90),
    (_C.DCHEAD, 30),
    (_C.HEAD, -30),
    (_C.DHEAD, 40),
    (_C.DCHEAD, -20),
)
"""Commands and their arguments, one behind the other."""

SETPOINT_UNITS = 2
"""An angle in degrees, and what is rounded of it. That of DHEAD begins where the robot rests, a little off its goal."""


@case("S30", bench_time_s=4.4)
def test_move_goes_its_way(peer: Peer) -> None:
    """Floor: 1.1 m ahead."""
    session = Session(peer, motors=True)
    require_move(session)
    session.send(_C.SETO)
    first = session.next()
    session.send(_C.MOVE, 1000)
    session.watch_alive(0.5)
    last = session.wait_at_rest(12.0)
    gone_mm = poses([first, last], session.robot)[-1].x_mm - poses([first], session.robot)[0].x_mm
    near(gone_mm, 1000, 1000 * MOVE, unit="mm", what="way of MOVE 1000 along X")
    session.leave()


def require_move(session: Session) -> None:
    """End the case for a robot whose firmware has no MOVE by ARIA's parameters (HasMoveCommand)."""
    if not session.robot.has_move:
        session.leave()
        raise NotApplicable(f"a {session.robot.subclass} has no MOVE")


@case("S31", bench_time_s=11.0)
def test_the_speed_limit_holds(peer: Peer) -> None:
    """Floor: 1.1 m ahead."""
    session = Session(peer, motors=True)
    require_move(session)
    session.send(_C.SETV, 100)
    session.send(_C.MOVE, 1000)
    mark = peer.mark()
    session.watch_alive(0.5)
    session.wait_at_rest(15.0)
    seen = session.seen(mark)
    fastest = max(max(abs(s.left_mm_s), abs(s.right_mm_s)) for s in seen)
    at_most(fastest, 100 + SPEED_MM_S, unit="mm/s", what="fastest wheel speed under SETV 100")
    at_least(fastest, 50, unit="mm/s", what="fastest wheel speed, to have something to judge")
    session.leave()


@case("S32", bench_time_s=2.5)
def test_acceleration_can_be_set(peer: Peer) -> None:
    """Floor: 0.7 m ahead."""
    session = Session(peer, motors=True)
    session.send(_C.SETV, 500)
    session.set_ramps(up=1000, down=1000)
    for start, end in ((0, 500), (500, 0)):
        before = session.next()
        session.send(_C.VEL, end)
        require_slope([before, *session.watch_alive(1.0)], start, end, (end - start) * 2, session)
    session.leave()


@case("S33", bench_time_s=2.5)
@pytest.mark.parametrize(
    "frame",
    [
        pytest.param(bytes.fromhex("FAFB03070007"), id="bare"),
        pytest.param(bytes.fromhex("FAFB04073B073B"), id="type-only"),
    ],
)
def test_origin_is_set(peer: Peer, frame: bytes) -> None:
    """Drives an arc first, so that all three are away from 0. Floor: 0.4 m ahead and to the left."""
    session = Session(peer, motors=True)
    session.send(_C.VEL, 200)
    session.send(_C.RVEL, 50)
    session.watch_alive(1.0)
    session.send(_C.STOP)
    session.wait_at_rest(5.0)
    before = session.next()
    if 0 in (before.sip.x_raw, before.sip.y_raw, before.sip.th_raw):
        raise Inconclusive("a coordinate is 0 before SETO, although the robot drove an arc", peer.evidence())
    after = session.next_after(session.write(frame)).sip
    off = [signed15(after.x_raw), signed15(after.y_raw), after.th_raw]
    if max(map(abs, off)) > STANDING_UNITS:
        raise Violation(f"X, Y, Th are {off} in the SIP after SETO", peer.evidence())
    session.leave()


def signed15(raw: int) -> int:
    """A coordinate as a signed number of 15 bits, and of 16 where the server has so many."""
    return raw - 0x10000 if raw >= 0xC000 else raw - 0x8000 if raw >= 0x4000 else raw
