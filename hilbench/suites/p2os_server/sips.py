"""The stream of SIPs, and how a session begins."""

from __future__ import annotations

import math
from itertools import pairwise

from hilbench.check import Inconclusive, Violation, at_most, case, within
from hilbench.clock import NS_PER_S
from hilbench.suites._requirements import STANDING_UNITS, require_plain_sip, require_rate, require_standing
from hilbench.suites._session import Session
from hilbench.systems.pioneer.peer import Peer
from protocols.p2os import CommandNumber, battery_v

_C = CommandNumber


@case("S18", bench_time_s=10.3)
def test_sips_come_at_their_rate(peer: Peer) -> None:
    """Listens and says nothing. The robot stands, so the watchdog may run out."""
    session = Session(peer)
    mark, dropped = peer.mark(), len(peer.dropped)
    session.next()
    end_ns = session.now_ns + 10 * NS_PER_S
    seen, doubts_s = session.seen(mark), list[float]()
    while session.now_ns < end_ns:
        session.next()
        last, seen = seen[-1], session.seen(mark)
        doubts_s += [session.uncertainty_s(last.start_ns)] * (len(seen) - 1 - len(doubts_s))
    if len(peer.dropped) > dropped:
        raise Violation("bytes came that are no sound packet", peer.evidence(mark))
    for one in seen:
        require_plain_sip(one)
    require_rate([s.start_ns for s in seen], doubts_s, session)
    session.leave()


@case("S19", bench_time_s=0.2)
def test_a_session_begins_with_motors_off_and_sonar_on(peer: Peer) -> None:
    flags = Session(peer).first.sip.flags
    assert not flags & 1, f"flags {flags:04X}: the motors are on"
    assert flags & 2, f"flags {flags:04X}: the sonar is off"


@case("S80", bench_time_s=2.3)
def test_the_battery_is_one_that_a_robot_can_have(peer: Peer) -> None:
    """Listens and says nothing. The robot stands, so the watchdog may run out."""
    session = Session(peer)
    found_v = [battery_v(seen.sip) for seen in (session.first, *session.watch(2.0))]
    low_v, high_v = OTHER_BATTERY_V if session.robot.subclass in OTHER_BATTERY else LEAD_12_V
    for volts in (min(found_v), max(found_v)):
        within(volts, low_v, high_v, unit="V", what="battery")
    steps_v = [round(abs(after - before), 1) for before, after in pairwise(found_v)]
    at_most(max(steps_v), STEP_V, unit="V", what="greatest step of the battery from SIP to SIP")
    session.leave()


LEAD_12_V = 9.0, 16.0
"""A lead battery of 12 V: servers shut down below about 11 V, and a charger goes up to 14.7 V (Pioneer 2/3 H8 manual).
How far beyond these is a choice."""

OTHER_BATTERY, OTHER_BATTERY_V = frozenset({"powerbot"}), (0.1, 25.5)
"""A PowerBot has 24 V: while it is charged the byte is at its end."""

STEP_V = 1.0
"""Of a battery that drives nothing. A choice: ten units of the byte."""


@case("S90", bench_time_s=1.2)
def test_a_standing_robot_says_so_in_every_field(peer: Peer) -> None:
    """Listens and says nothing."""
    session = Session(peer)
    turn = session.robot.units_per_turn
    wraps_at = {"x_raw": COORDINATES, "y_raw": COORDINATES, "th_raw": turn, "control_raw": turn}
    first, *rest = (session.first, *session.watch(1.0))
    for one in (first, *rest):
        sip, line = one.sip, [one.raw.hex(" ").upper()]
        if sip.left_stall or sip.right_stall:
            raise Violation("a stall is reported, and the motors are off", line)
        if not one.at_rest:
            raise Violation("the robot moves, and the motors are off", line)
        for name, wrap in wraps_at.items():  # the counters may flicker by one, over their wrap, too
            before, now = getattr(first.sip, name), getattr(sip, name)
            if abs(math.remainder(now - before, wrap)) > STANDING_UNITS:
                raise Violation(f"{name} was {before} and is {now}", line)
    session.leave()


COORDINATES = 0x8000
"""At which x and y wrap."""


@case("S20", bench_time_s=1.2)
def test_velocity_with_motors_off_moves_nothing(peer: Peer) -> None:
    session = Session(peer)
    session.send(_C.VEL, 200)
    require_standing(session.watch(1.0), session, "the motors are off")
    session.leave()


@case("S21", bench_time_s=0.4)
def test_enable_switches_the_motors_on(peer: Peer) -> None:
    session = Session(peer)
    arrived_ns = session.send(_C.ENABLE, 1)
    flags = [session.next_after(arrived_ns).sip.flags for _ in range(2)]
    assert flags[1] & 1, f"the motors are off in the second SIP after ENABLE 1 (flags {flags[1]:04X})"
    session.leave()


@case("S81", bench_time_s=0.6)
def test_enable_0_switches_the_motors_off(peer: Peer) -> None:
    session = Session(peer)
    for argument in (1, 0):
        arrived_ns = session.send(_C.ENABLE, argument)
        flags = [session.next_after(arrived_ns).sip.flags for _ in range(2)]
        if argument and not flags[1] & 1:
            raise Inconclusive("the motors are not on after ENABLE 1")
    assert not flags[1] & 1, f"the motors are on in the second SIP after ENABLE 0 (flags {flags[1]:04X})"
    session.leave()
