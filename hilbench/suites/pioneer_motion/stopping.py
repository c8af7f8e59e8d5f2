"""What ends a motion, how soon, and what does not begin one."""

from __future__ import annotations

import math

from hilbench.check import at_most, case, record_measure
from hilbench.suites._mechanics import stopping_way
from hilbench.suites._session import Session
from hilbench.suites._truth import Sample, Truth
from hilbench.suites.pioneer_motion._judged import SPEED, WAY_MM, cruise, session, stop_from, truth
from hilbench.systems.pioneer.peer import Peer
from protocols.p2os import CommandNumber, pack_bytes

__all__ = ["session", "truth"]

_C = CommandNumber

MOTIONLESS_MM = 1.0
MOTIONLESS_DEG = 0.1
"""A robot has not moved when it is no farther off than this: about one unit of a SIP."""

REACTION_S = 0.02
"""How late the end of a motion may be beyond its formula: the robot notices a command, or its absence, at its next
step, and its servo takes some steps more for the last tenths of a millimetre."""


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
