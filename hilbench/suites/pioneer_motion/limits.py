"""Top speeds that are not exceeded."""

from __future__ import annotations

from hilbench.check import case, within
from hilbench.suites._session import Session
from hilbench.suites._truth import Truth
from hilbench.suites.pioneer_motion._judged import session, truth
from protocols.p2os import CommandNumber, pack_bytes

__all__ = ["session", "truth"]

_C = CommandNumber

LIMIT = 0.01
"""How far, as a share, a speed may be above its limit for a moment: a servo swings over when a ramp ends."""


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
