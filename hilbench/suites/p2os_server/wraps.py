"""Position and heading where their counters wrap."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

from hilbench.check import Inconclusive, Violation, at_most, case
from hilbench.clock import NS_PER_S
from hilbench.suites._session import CYCLE_S, Seen, Session, poses
from hilbench.systems.pioneer.peer import Peer
from protocols.p2os import CommandNumber, Pose

_C = CommandNumber

STEP_MM = 100.0
"""Clients of the Player family throw away a step between two SIPs that is longer (Player p2os driver, sip.cc)."""


def drive_until(session: Session, mark: int, there: Callable[[Pose], bool], within_s: float) -> list[Seen]:
    """Keep the robot going until its pose, followed from the first SIP since ``mark``, is there; return the SIPs."""
    end_ns = session.now_ns + round(within_s * NS_PER_S)
    while session.now_ns < end_ns:
        session.watch_alive(0.5)
        seen = session.seen(mark)
        if session.peer.dropped:
            raise Inconclusive("bytes were lost, so a step may be two; S18 judges checksums", session.peer.evidence())
        if there(poses(seen, session.robot)[-1]):
            return seen
    raise Violation(f"the robot does not get there within {within_s:.0f} s", session.peer.evidence())


@case("S52", bench_time_s=50.3)
def test_position_wraps_without_a_jump(peer: Peer) -> None:
    """At 900 mm/s a step stays below the limit; a slower robot goes as fast as ARIA lets it.

    Floor: 41 m ahead, or 15 bits of the robot's units; or jack it up.
    """
    session = Session(peer, motors=True)
    speed_mm_s = min(900, session.robot.max_speed_mm_s)
    session.send(_C.SETO)
    session.next()
    mark = peer.mark()
    session.next()
    session.send(_C.SETV, speed_mm_s)
    session.send(_C.VEL, speed_mm_s)
    way_mm = max(40_000.0, 0x8000 * session.robot.distance_unit_mm + 1000)
    seen = drive_until(session, mark, lambda pose: pose.x_mm > way_mm, within_s=1.5 * way_mm / speed_mm_s)
    session.send(_C.STOP)
    session.wait_at_rest(10.0)
    steps_mm = [max(abs(b.x_mm - a.x_mm), abs(b.y_mm - a.y_mm)) for a, b in pairwise(poses(seen, session.robot))]
    late_mm = speed_mm_s * session.uncertainty_s(seen[0].start_ns)
    at_most(max(steps_mm), STEP_MM, unit="mm", what="longest step between two SIPs", uncertainty=late_mm)
    wrapped = any(a.sip.x_raw - b.sip.x_raw > 0x4000 for a, b in pairwise(seen))
    sixteen_bits = max(s.sip.x_raw for s in seen) > 0x7FFF
    assert wrapped or sixteen_bits, f"X never wrapped on {way_mm / 1000:g} m"
    session.leave()


@case("S53", bench_time_s=14.4)
def test_heading_wraps_at_half_a_turn(peer: Peer) -> None:
    """Turns on the spot."""
    session = Session(peer, motors=True)
    session.set_ramps(turn=200)
    session.send(_C.SETRV, TURN_DEG_S)
    session.next()
    mark = peer.mark()
    session.send(_C.RVEL, TURN_DEG_S)
    turns = 5
    seen = drive_until(session, mark, lambda pose: pose.heading_deg > (turns + 0.5) * 360, within_s=30.0)
    session.send(_C.STOP)
    half = session.robot.units_per_turn // 2
    least, most = min(s.sip.th_raw for s in seen), max(s.sip.th_raw for s in seen)
    assert -half <= least <= most < half, f"Th goes from {least} to {most}, beyond {-half} to {half - 1}"
    steps_deg = [b.heading_deg - a.heading_deg for a, b in pairwise(poses(seen, session.robot))]
    late_deg = TURN_DEG_S * session.uncertainty_s(seen[0].start_ns)
    most_deg = 1.25 * TURN_DEG_S * CYCLE_S
    at_most(max(map(abs, steps_deg)), most_deg, unit="deg", what="greatest step of the heading", uncertainty=late_deg)
    wraps = sum(a.sip.th_raw - b.sip.th_raw > half for a, b in pairwise(seen))
    assert wraps >= turns, f"Th wrapped {wraps} times in {turns} turns"
    session.leave()


TURN_DEG_S = 150
