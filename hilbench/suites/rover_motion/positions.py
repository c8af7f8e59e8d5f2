"""Positions of the GPS receiver, and how it fails."""

from __future__ import annotations

import math

from hilbench.check import Violation, at_least, at_most
from hilbench.clock import NS_PER_MS, NS_PER_S
from hilbench.suites._rover_motion import Ride, metres_off, numbers_in, on_bench
from hilbench.suites.rover_motion._judged import require_status, ride
from protocols.pkt import GpsReport, Position, position
from protocols.pkt.codes import StatusFlag

__all__ = ["ride"]

CEP_M = 2.5
"""Half of the errors are smaller (NEO-6 data sheet GPS.G6-HW-09005, table 2); three times as much is rare: 0.2 %."""

PLACE_M = 0.7
"""Half of a float's last place at 58 degrees is 0.2 m, and 0x84 may be a step older than the truth. A choice."""

EPOCH_LATE_NS = 300 * NS_PER_MS
"""From the moment of a solution until the board has read it, at least: its sentences come at 9600 baud."""


def fixes(ride: Ride, mark: int) -> list[tuple[int, Position]]:
    """Return the positions of the 0x84 since a mark that say they are known, each with the time of its first byte."""
    found = ride.rover.peer.since(mark, GpsReport)
    return [(got.start_ns, position(numbers_in(report), ride.dialect)) for got, report in found if report.validity]


def last_position(ride: Ride, mark: int = 0) -> GpsReport:
    """Return the newest 0x84 since a mark."""
    found = ride.rover.peer.since(mark, GpsReport)
    if not found:
        raise Violation("no 0x84 came", ride.rover.peer.evidence(mark))
    return numbers_in(found[-1][1])


def off_m(ride: Ride, at_ns: int, place: Position) -> float:
    """Return how far a reported position is from where the rover was at the receiver's last full second before."""
    epoch_ns = (at_ns - EPOCH_LATE_NS) // NS_PER_S * NS_PER_S
    return math.dist(metres_off(ride.origin, place), ride.east_north_m(ride.at(epoch_ns)))


@on_bench("R18", lasts_s=3.2, scene="hard-floor")
def test_accuracy_of_the_position(ride: Ride) -> None:
    ride.go(3.1)
    found = fixes(ride, 0)
    if not found:
        raise Violation("no 0x84 with a known position within 3.1 s of a hot start", ride.rover.peer.evidence())
    for at_ns, place in found:
        at_most(off_m(ride, at_ns, place), 3 * CEP_M, unit="m", what="error of the position")


@on_bench("R19", lasts_s=8.3, scene="hard-floor", settings={"gps": {"accuracy_m": 0.0, "noise_m": 0.0}})
def test_positions_along_a_way(ride: Ride) -> None:
    ride.drive(1.0, 1.0, 8.2)
    found = fixes(ride, 0)
    at_least(len(found), 5, unit="positions", what="known positions in 8 s from a hot start")
    for at_ns, place in found:
        at_most(off_m(ride, at_ns, place), PLACE_M, unit="m", what="error of the position on the way")
    (_, first), *_, (_, last) = found
    way_m = math.dist(metres_off(ride.origin, first), metres_off(ride.origin, last))
    at_least(way_m, 2.0, unit="m", what="way between the first position and the last")


@on_bench("R20", lasts_s=6.4, scene="stand")
def test_without_a_fix(ride: Ride) -> None:
    ride.go(3.2)
    mark = ride.rover.mark()
    known = fixes(ride, 0)
    if not known:
        raise Violation("no 0x84 with a known position within 3.2 s of a hot start", ride.rover.peer.evidence())
    ride.open_sky(0.0)
    ride.go(3.1)
    report = last_position(ride, mark)
    if report.validity:
        raise Violation("0x84 knows a position, and the receiver sees no sky", ride.rover.peer.evidence())
    off = math.dist(metres_off(ride.origin, position(report, ride.dialect)), metres_off(ride.origin, known[-1][1]))
    at_most(off, 3 * CEP_M, unit="m", what="position in 0x84 beside the last known one")
    require_status(ride, 0)


@on_bench("R21", lasts_s=3.9, settings={"gps": {"baud": 4800}})
def test_receiver_that_is_not_understood(ride: Ride) -> None:
    require_status(ride, 0)
    ride.go(3.8)
    require_status(ride, StatusFlag.GPS_FAIL)
    if last_position(ride).validity:
        raise Violation("0x84 says that the position is known", ride.rover.peer.evidence())
