"""STOP, E_STOP, and the watchdog that stops a robot to which nobody speaks."""

from __future__ import annotations

from itertools import pairwise

from hilbench.check import Inconclusive, Untimely, Violation, at_least, at_most, case
from hilbench.suites._requirements import SLOPE, SPEED_MM_S, require_flow, require_moving, require_slope, require_speeds
from hilbench.suites._session import CYCLE_S, Seen, Session
from hilbench.systems.pioneer.peer import Peer
from protocols.p2os import CommandNumber

_C = CommandNumber

STOP_SEEN_S = 0.25
"""How much later than at the wheels a stop may show in a SIP: one cycle, the span a speed is averaged over, and the
servo's last millimetres."""


# --- stopping


@case("S34", bench_time_s=3.6)
def test_stop_brakes_and_keeps_the_motors_on(peer: Peer) -> None:
    """Floor: 0.7 m ahead."""
    session = Session(peer, motors=True)
    session.set_ramps(up=400, down=200)
    session.send(_C.VEL, 300)
    session.watch_alive(1.2)
    before = session.next()
    at_least(before.speed_mm_s, 200, unit="mm/s", what="speed before STOP, to have something to judge")
    session.send(_C.STOP)
    ramp = session.watch_alive(1.5 + STOP_SEEN_S)
    require_slope([before, *ramp], before.speed_mm_s, 0, -200, session)
    at_rest = session.wait_at_rest(2.0)
    if not at_rest.sip.motors_enabled:
        raise Violation("STOP has switched the motors off", peer.evidence())
    session.leave()


def stop_time_s(session: Session, command: int) -> tuple[float, float]:
    """Drive at 400 mm/s, stop with ``command``; return after how long a SIP shows rest, and its uncertainty."""
    session.send(_C.VEL, 400)
    session.watch_alive(1.4)
    sent_ns = session.now_ns
    require_moving(session.next(), session)
    arrived_ns = session.send(command)
    while not (seen := session.next()).at_rest:
        if seen.after_s(arrived_ns) > 4.0:
            raise Violation(f"the robot does not stop within 4 s of command {command}", session.peer.evidence())
        session.send(_C.PULSE)
    return seen.after_s(arrived_ns), session.uncertainty_s(sent_ns)


@case("S35", bench_time_s=5.7)
def test_emergency_stop_is_harder_than_stop(peer: Peer) -> None:
    """With a slow deceleration set, which must not apply. Floor: 1.5 m ahead."""
    session = Session(peer, motors=True)
    session.set_ramps(up=400, down=200)
    stop_s, doubt_s = stop_time_s(session, _C.STOP)
    emergency_s, more_doubt_s = stop_time_s(session, _C.E_STOP)
    at_least(
        stop_s / emergency_s,
        SEVERAL,
        unit="times",
        what="time of STOP against that of E_STOP",
        uncertainty=(doubt_s + more_doubt_s * stop_s / emergency_s) / emergency_s,
    )
    session.leave()


SEVERAL = 3.0
"""What "several times faster" is taken for."""


# --- the watchdog


def drive_into_silence(session: Session) -> tuple[int, list[Seen]]:
    """Send VEL 200 and nothing more for 3.3 s; return when VEL had arrived, and the SIPs."""
    session.set_ramps(up=300, down=300)
    arrived_ns = session.send(_C.VEL, 200)
    return arrived_ns, session.watch(SILENT_S)


SILENT_S = 3.3

STOPPED_S = 2.0 + 200 / (300 * (1 - SLOPE)) + STOP_SEEN_S
"""How soon a SIP shows at rest a robot that was told 200 mm/s, and then nothing: its servo may trail the ramp."""


@case("S36", bench_time_s=3.6)
def test_silence_stops_the_robot(peer: Peer) -> None:
    """Floor: 0.6 m ahead, and 1 m more for a robot that fails."""
    session = Session(peer, motors=True)
    since_ns = session.now_ns
    arrived_ns, seen = drive_into_silence(session)
    doubt_s = session.uncertainty_s(since_ns)
    require_flow([s.start_ns for s in seen], session)
    widest_s = max(b.after_s(a.start_ns) for a, b in pairwise(seen))
    at_most(widest_s, 1.5 * CYCLE_S, unit="s", what="longest pause between SIPs", uncertainty=doubt_s)
    if all(s.at_rest for s in seen):
        raise Inconclusive("the robot never moved, so nothing can be seen of its watchdog", peer.evidence())
    if not seen[-1].at_rest:
        text = f"the robot still moves after {SILENT_S:g} s of silence"
        raise Untimely(text, peer.evidence(), spare_s=SILENT_S - STOPPED_S)
    last_moving = max(i for i, s in enumerate(seen) if not s.at_rest)
    at_most(
        seen[last_moving + 1].after_s(arrived_ns),
        STOPPED_S,
        unit="s",
        what="at rest after the last command",
        uncertainty=doubt_s,
    )
    session.leave()


@case("S37", bench_time_s=5.1)
def test_the_next_packet_revives_the_robot(peer: Peer) -> None:
    """Floor: 1 m ahead, and 1 m more for a robot that fails."""
    session = Session(peer, motors=True)
    _, seen = drive_into_silence(session)
    if not seen[-1].at_rest:
        raise Inconclusive("the robot has not stopped, so it cannot be revived; see S36", peer.evidence())
    session.send(_C.PULSE)
    session.watch_alive(1.0)
    require_speeds(session, 200, 200)
    session.leave()


@case("S38", bench_time_s=4.9)
def test_any_packet_feeds_the_watchdog(peer: Peer) -> None:
    """With ramps on which even a short stop would show in several SIPs. Floor: 1 m ahead."""
    session = Session(peer, motors=True)
    since_ns = session.now_ns
    session.set_ramps(up=200, down=1000)
    session.send(_C.VEL, 200)
    seen = session.watch(1.9)
    for silence_s in (1.9, 0.8):
        session.send(_C.SONAR, 1)
        seen += session.watch(silence_s)
    driving = [s for s in seen if s.after_s(since_ns) > 1.0 + STOP_SEEN_S]
    slowest = min(s.speed_mm_s for s in driving)
    if slowest < 200 - 2 * SPEED_MM_S and 1.9 + session.uncertainty_s(since_ns) >= 2.0:
        raise Inconclusive("the host was late: more than 2 s may have passed without a packet", peer.evidence())
    at_least(slowest, 200 - 2 * SPEED_MM_S, unit="mm/s", what="slowest while fed every 1.9 s")
    session.leave()
