"""What the rover says of its sensors while somebody has it in his hands, beside what he knows of the place."""

from __future__ import annotations

import math

from hilbench.check import Inconclusive, Violation, near
from hilbench.suites._rover import Rover, on_rover
from hilbench.suites.pkt_board._turn import Told, disagreement
from hilbench.suites.pkt_board.sensed import NEXT_WITHIN_S
from hilbench.suites.pkt_board.sensors import LENGTH, MPU_READ, require_there
from hilbench.systems.rover.hands import TURNS
from protocols.pkt import GpsReport, ImuReport

REPORTS = 9
"""Of a turn: once there and back, 8 s, at one report a second."""

LATE_S = 0.2
"""How far off the time between two reports may be for the rates to be held against it. A choice: a fifth of it."""

COLDER_C, WARMER_C = 30.0, 10.0
"""How much colder than the sensor the air may be, and how much warmer. Choices: a chip beside a voltage regulator, or
one that was just brought in."""


@on_rover("P89", lasts_s=62.0)
def test_one_turn(rover: Rover) -> None:
    """A hand may shake, or be quicker than it was asked for; so what does not agree is looked at again."""
    for _ in range(2):
        why = disagreement([_turned(rover, way) for way in TURNS])
        if not why:
            return
    raise Violation(why, rover.peer.evidence())


def _turned(rover: Rover, way: str) -> Told:
    """Have the rover turned; return what 0x82 tells of it."""
    rover.hands.turn(way)
    rover.next(ImuReport, NEXT_WITHIN_S)
    mark, begun_ns = rover.mark(), rover.peer.bench.now_ns
    for _ in range(REPORTS):
        rover.next(ImuReport, NEXT_WITHIN_S)
    told = [(got.start_ns, report) for got, report in rover.peer.since(mark, ImuReport)]
    rover.hands.put_down()
    if rover.peer.uncertainty_s(begun_ns) > LATE_S:
        raise Inconclusive("the bench was too late to say how far the rover turned from one 0x82 to the next")
    for _, report in told:
        _require_read(report)
        if not any(report.quaternion) or not any(report.acceleration):
            raise Inconclusive("0x82 has zeros for attitude or acceleration")
        near(math.hypot(*report.quaternion), 1.0, LENGTH, unit="", what="length of the quaternion in 0x82")
    return told


def _require_read(report: ImuReport) -> None:
    if not report.validity & MPU_READ:
        raise Inconclusive(f"byte 1 of 0x82 is {report.validity}: the inertial sensor was not read")


def _second_position(rover: Rover) -> GpsReport:
    """Return the second 0x84 from now on: the first one may have been made before."""
    rover.next(GpsReport, NEXT_WITHIN_S)
    return rover.next(GpsReport, NEXT_WITHIN_S)


@on_rover("P90", lasts_s=5.0)
def test_the_fix(rover: Rover) -> None:
    rover.hands.cover_sky(True)
    without = _second_position(rover).validity
    rover.hands.cover_sky(False)
    having = _second_position(rover).validity
    if without or not having:
        text = f"byte 1 of 0x84 is {without} without a fix and {having} with one"
        raise Violation(text, rover.peer.evidence())


@on_rover("P91", lasts_s=5.0)
def test_the_position_moves(rover: Rover) -> None:
    rover.hands.carry()
    require_there(rover, _second_position(rover))


@on_rover("P92", lasts_s=2.5)
def test_the_temperature(rover: Rover) -> None:
    rover.next(ImuReport, NEXT_WITHIN_S)
    report = rover.next(ImuReport, NEXT_WITHIN_S)
    _require_read(report)
    shown_c = report.temperature_c
    if not rover.hands.air_is_between(shown_c - COLDER_C, shown_c + WARMER_C):
        raise Violation(f"0x82 has {shown_c:g} C, and the air is not near that", rover.peer.evidence())
