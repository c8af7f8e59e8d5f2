"""What the cases of `p2os_server` require again and again, and how exactly a robot is held to what it was told."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from itertools import pairwise

from hilbench.check import Inconclusive, Untimely, Violation, at_most, near
from hilbench.clock import NS_PER_S
from hilbench.suites._session import (
    CYCLE_S,
    SIP_WITHIN_S,
    Seen,
    Session,
    Slope,
    medians_mm_s,
    poses,
    turn_rate_deg_s,
)
from hilbench.systems.pioneer.peer import Peer
from protocols.p2os import ServerPacket, Sip, SyncEcho

SPEED_MM_S = 5.0
"""Tolerance of a wheel speed; clause S22 has it, the others take it over."""

RAMP_MM_S2 = 300
"""Set by cases that ask for a speed and not how it is reached: a robot's own ramp may take longer than they wait."""

SLOPE = 0.2
"""Tolerance of an acceleration, as a share: a servo under load trails its ramp; who ignores SETA is farther off."""

TURN_RATE = 0.2
"""Tolerance of a rate of turn, as a share. No clause has a figure; the track of a real robot is known to some per cent,
and a wrong unit is farther off."""

SETTLED = 12 / 4096
"""Tolerance of a heading, as a share of a turn; clause S28 has it: 12 of 4096 units, about 1 degree."""

STANDING_UNITS = 1
"""How much a coordinate of a standing robot may flicker."""

STREAM = 3
"""So many packets in six SIP cycles are a stream: half of what one in each cycle makes."""


def require_reply(peer: Peer, kind: type[ServerPacket], expected: bytes, mark: int) -> None:
    """Require a packet of a kind since ``mark``, in time and byte for byte as expected."""
    peer.expect(kind, mark=mark, what=expected.hex(" ").upper())
    raw = peer.since(mark, kind)[0][0].raw
    if raw != expected:
        raise Violation(f"{raw.hex(' ').upper()} came, required {expected.hex(' ').upper()}", peer.evidence(mark))


def require_echo(peer: Peer, sync: bytes, stimulus: bytes = b"") -> None:
    """Send ``stimulus`` or the SYNC itself, and require the SYNC's echo."""
    mark = peer.mark()
    peer.write(stimulus or sync)
    require_reply(peer, SyncEcho, sync, mark)


def require_sips_begin(peer: Peer, opening: bytes) -> None:
    """Go through the handshake, open with these bytes, and require the SIPs to begin in time."""
    peer.handshake()
    mark, sent_ns = peer.mark(), peer.bench.now_ns
    peer.write(opening)
    peer.expect(Sip, SIP_WITHIN_S, what="SIP after OPEN")
    begun_s = (peer.since(mark, Sip)[0][0].start_ns - sent_ns) / NS_PER_S
    at_most(begun_s, 0.2, unit="s", what="first SIP after OPEN", uncertainty=peer.uncertainty_s(sent_ns))
    peer.expect(Sip, SIP_WITHIN_S, what="second SIP after OPEN")


def require_plain_sip(one: Seen) -> None:
    """Require the SIP of a standing robot, of the length that its sonar readings make."""
    count, readings = one.raw[2], one.raw[22]
    line = one.raw.hex(" ").upper()
    if one.raw[3] != Sip.STOPPED:
        raise Violation(f"type {one.raw[3]:02X} of a standing robot, not 32", [line])
    if count != 27 + 3 * readings:
        raise Violation(f"count {count} with {readings} sonar readings, not {27 + 3 * readings}", [line])


def require_rate(starts_ns: Sequence[int], doubts_s: Sequence[float], session: Session) -> None:
    """Require SIPs, of which these are the times, every 100 or 50 ms.

    Args:
        starts_ns: when the first byte of each came, at least two.
        doubts_s: how far off each interval may be.
        session: where they came.
    """
    spans_s = [(b - a) / NS_PER_S for a, b in pairwise(starts_ns)]
    cycle_s = CYCLE_S if statistics.median(spans_s) > 0.75 * CYCLE_S else CYCLE_S / 2
    span_s, doubt_s = max(zip(spans_s, doubts_s, strict=True), key=lambda pair: abs(pair[0] - cycle_s) + pair[1])
    try:
        near(
            span_s * 1000,
            cycle_s * 1000,
            10,
            unit="ms",
            what="interval of SIPs farthest off",
            uncertainty=doubt_s * 1000,
        )
    except Violation as violation:
        if session.peer.bench.scheduler.locked and all_caught_up(starts_ns, round(cycle_s * NS_PER_S)):
            raise Inconclusive(f"{violation}; the next ones made up for it, as when a host is busy") from violation
        raise


def require_flow(starts_ns: Sequence[int], session: Session) -> None:
    """Require that the SIPs have not dried up: the last one is on its way, or was only just there."""
    if len(starts_ns) < 2 or session.now_ns - starts_ns[-1] > DRY_S * NS_PER_S:
        raise Untimely(f"the SIPs stopped after {len(starts_ns)}", session.peer.evidence())


DRY_S = 2.5 * CYCLE_S
"""Longest time since the first byte of the last whole SIP: one cycle, and another that a slow line still carries."""


def all_caught_up(starts_ns: Sequence[int], cycle_ns: int) -> bool:
    """Say whether every interval out of band is made up for by its neighbours: the SIPs are back on their grid.

    So it looks when the host that serves, or ours, was busy: SIPs come late and then closer together. A SIP left out,
    or a clock that drifts, is never made up for.
    """
    return all(
        any(
            abs(starts_ns[after] - starts_ns[before] - (after - before) * cycle_ns) <= _BAND_NS
            for before in range(max(0, i - _CATCH_UP), i + 1)
            for after in range(i + 1, min(len(starts_ns), i + 2 + _CATCH_UP))
            if after - before > 1
        )
        for i in range(len(starts_ns) - 1)
        if abs(starts_ns[i + 1] - starts_ns[i] - cycle_ns) > _BAND_NS
    )


_BAND_NS = 10_000_000

_CATCH_UP = 5
"""Within how many SIPs before or after, half a second, lateness must be made up for. A choice."""


def require_standing(seen: Sequence[Seen], session: Session, why: str) -> None:
    """Require that a robot stands all the time: type, wheel speeds and X."""
    if not all(s.at_rest for s in seen):
        raise Violation(f"the robot moves: {why}", session.peer.evidence())
    followed = poses(seen, session.robot)
    moved = max(abs(pose.x_mm - followed[0].x_mm) for pose in followed)
    if moved > STANDING_UNITS * session.robot.distance_unit_mm:
        raise Violation(f"X changes by {moved:.1f} mm: {why}", session.peer.evidence())


def require_moving(seen: Seen, session: Session) -> None:
    """Require that a SIP shows motion."""
    if seen.at_rest:
        raise Violation("the robot does not move", session.peer.evidence())


def require_fresh(first: Seen, peer: Peer) -> None:
    """Require of the first SIP of a new session that nothing of the old one goes on."""
    if first.sip.motors_enabled:
        raise Violation("the motors are still on in a new session", peer.evidence())
    if not first.at_rest:
        raise Violation("the robot still moves in a new session", peer.evidence())


def require_speeds(session: Session, left_mm_s: float, right_mm_s: float) -> list[Seen]:
    """Watch for half a second; require both wheel speeds."""
    seen = session.watch_alive(0.5)
    left, right = medians_mm_s(seen)
    near(left, left_mm_s, SPEED_MM_S, unit="mm/s", what="left wheel")
    near(right, right_mm_s, SPEED_MM_S, unit="mm/s", what="right wheel")
    if not all(s.sip.moving for s in seen):
        raise Violation("the type of a moving robot's SIP is not 33", session.peer.evidence())
    return seen


def require_slope(
    ramp: Sequence[Seen], start_mm_s: float, end_mm_s: float, rate_mm_s2: float, session: Session
) -> None:
    """Require the slope of a ramp, which the SIPs show from before its beginning to behind its end."""
    slope = Slope(ramp, start_mm_s, end_mm_s, session.uncertainty_s(ramp[0].start_ns))
    near(
        slope.mm_s2,
        rate_mm_s2,
        SLOPE * abs(rate_mm_s2),
        unit="mm/s²",
        what=f"slope from {start_mm_s:g} to {end_mm_s:g} mm/s",
        uncertainty=slope.uncertainty_mm_s2,
    )


def require_turn_rate(seen: Sequence[Seen], rate_deg_s: float, session: Session) -> None:
    """Require the mean rate at which the heading changes."""
    left, right = medians_mm_s(seen)
    near(
        turn_rate_deg_s(seen, session.robot),
        rate_deg_s,
        TURN_RATE * abs(rate_deg_s),
        unit="deg/s",
        what=f"wheels at {left:.0f} and {right:.0f} mm/s, rate of turn by the heading",
        uncertainty=abs(rate_deg_s) * 2 * session.uncertainty_s(seen[0].start_ns) / seen[-1].after_s(seen[0].start_ns),
    )


def require_heading(session: Session, expected_deg: float) -> None:
    """Wait until the robot is at rest; require its heading."""
    session.watch_alive(0.5)
    at_rest = session.wait_at_rest(8.0)
    off = math.remainder(at_rest.sip.th_raw / session.robot.units_per_turn - expected_deg / 360, 1.0)
    units = session.robot.units_per_turn
    at_most(abs(off) * units, SETTLED * units, unit="units", what=f"heading, off {expected_deg:g} degrees")


def require_fifteen_bits(seen: Sequence[Seen], peer: Peer) -> None:
    """Require that no coordinate needs a sixteenth bit."""
    largest = max(max(s.sip.x_raw, s.sip.y_raw) for s in seen)
    if largest > 0x7FFF:
        raise Violation(f"a coordinate is {largest}, where the counter has 15 bits", peer.evidence())


def require_request(peer: Peer, number: int, kind: type[ServerPacket]) -> None:
    """Require one packet for argument 1, a stream for 2, and none after 0."""
    session = Session(peer)
    counts = {}
    for argument in (1, 2, 0):
        session.send(number, argument)
        # what is under way when the stream is ended may still come
        peer.run(2 * CYCLE_S if argument == 0 else 0)
        mark = peer.mark()
        peer.run(0.6)
        counts[argument] = len(peer.since(mark, kind))
    assert counts[1] == 1, f"{counts[1]} {kind.__name__} for the argument 1, which asks for one"
    assert counts[2] >= STREAM, f"{counts[2]} {kind.__name__} in 0.6 s for the argument 2, which asks for a stream"
    if counts[0]:
        raise Untimely(f"{counts[0]} {kind.__name__} after the argument 0, which ends the stream", spare_s=CYCLE_S)
    session.leave()
