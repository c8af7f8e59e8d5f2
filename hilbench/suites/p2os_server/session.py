"""PULSE, CLOSE, and a session after another."""

from __future__ import annotations

import pytest

from hilbench.check import Violation, at_most, case
from hilbench.clock import NS_PER_S
from hilbench.suites._requirements import require_echo, require_fresh, require_moving
from hilbench.suites._session import CYCLE_S, Session
from hilbench.suites.p2os_server._syncs import SYNC0, SYNC2
from hilbench.systems.pioneer.peer import Peer
from protocols.p2os import CommandNumber

_C = CommandNumber


@case("S39", bench_time_s=0.9)
def test_pulse_has_no_answer(peer: Peer) -> None:
    session = Session(peer)
    mark = peer.mark()
    session.write(SYNC0)
    seen = session.watch(0.7)
    if any(got.raw[3] == SYNC0[3] for got in peer.received[mark:]):
        raise Violation("PULSE was echoed like a SYNC0", peer.evidence(mark))
    if len(seen) < 0.5 / CYCLE_S:
        raise Violation("PULSE has ended the stream of SIPs", peer.evidence(mark))
    session.leave()


@case("S40", bench_time_s=0.9)
def test_close_ends_the_session(peer: Peer) -> None:
    session = Session(peer)
    mark, sent_ns = peer.mark(), session.now_ns
    session.write(SYNC2)
    peer.run(0.7)
    last_ns = max((got.at_ns for got in peer.received[mark:]), default=sent_ns)
    going_on = session.now_ns - last_ns < 2 * CYCLE_S * NS_PER_S
    at_most(
        (last_ns - sent_ns) / NS_PER_S,
        0.2,
        unit="s",
        what="end of the last packet after CLOSE" + ", and more may follow: the check stopped looking" * going_on,
        uncertainty=session.uncertainty_s(sent_ns),
    )
    require_echo(peer, SYNC0)


@case("S41", bench_time_s=2.3)
@pytest.mark.parametrize("argument", [1, None], ids=["argument", "bare"])
def test_a_new_session_begins_at_rest(peer: Peer, argument: int | None) -> None:
    """Comes back as soon as a robot can have braked with 300 mm/s², the default ramp. Floor: 1 m ahead."""
    session = Session(peer, motors=True)
    session.send(_C.VEL, 200)
    session.watch_alive(1.0)
    require_moving(session.next(), session)
    session.send(_C.CLOSE, argument)
    peer.run(200 / DEFAULT_RAMP_MM_S2)
    require_fresh(Session(peer).first, peer)


DEFAULT_RAMP_MM_S2 = 300
"""Deceleration of a Pioneer whose client has set none (AMRISim, EmulatePioneer.cc). CLOSE may brake harder."""
