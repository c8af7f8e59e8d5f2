"""Does a program find its way between obstacles? The dodger drives a Pioneer in seeded rooms, in each of three ways.

Its pins straight to the wheels; its pins over the P2OS adapter, the same image; and a program that speaks P2OS itself.
Rooms come from the seed of the case, so that each case has its own. Besides the free drives there are scenes in which
one thing is looked at: one obstacle before one sensor, one wall to turn away from, and the same inputs twice.
"""

from __future__ import annotations

import math

import pytest

from hilbench.check import CaseSetup, Inconclusive, Violation, at_most, case
from hilbench.clock import NS_PER_S
from hilbench.mcu.board_case import BoardCase
from hilbench.suites._bluepill import MOTORS, obstacles, place_before
from hilbench.suites._dodge import AHEAD, FORWARD, LONGEST_BLIND_S, TURN, Drive, Sessions, longest_overlap_s
from hilbench.suites._replay import Inputs, Outputs

FREE_S = 180.0
"""Three minutes (bachelor-thesis, section 5.4)."""

ROOMS = (1, 2)
"""Rooms for each way; there are more in the campaign."""

PINS = CaseSetup(program="dodge")
ADAPTER = CaseSetup(variant="robot", program="dodge")
P2OS = CaseSetup(variant="p2os", program="dodge-p2os")
ALONE = CaseSetup(variant="bare", program="dodge")

SETTLE_S = 0.2
RANGE_M = 0.35
"""From a sensor to the post before it: within the threshold of 0.5 m of the simulated sensor."""

WALL_X_M = 1.0
"""Where the robot begins before the wall, which is 2 m ahead of the origin."""

TURN_AWAY_S = 8.0
"""To drive 0.3 m, turn by up to 180 degrees at 60 degrees a second and drive on, and as much again."""

SEES_S = TURN_AWAY_S / 2

DRIVING_S = 4.0
"""Until a session is open and the robot drives."""

STRAIGHT, BACK_M = (4, 5), 0.08
"""Discs 10 degrees off the way: they see the post so much farther back already, and for 1 s, if the robot drives on.
The rays of 3 and 6 leave it in less than the half second that D06 allows."""

RESET_S = 4.0
"""After it the board is reset: a session is open by then, the robot drives, and the wall is more than 1 m away."""

DRIVES_M_S = 0.1
STANDS_M_S = 0.02
LONGEST_ADRIFT_S = 3.0
AFTER_RESET_S = 20.0

REPLAY_S = 60.0
LEAST_CHANGES = 20
"""Fewer edges of outputs would say little about them."""

STARTED_NS = NS_PER_S
"""The first codes are on the motor wires by then; what changes them later is what comes in."""


def _drive_freely(bench: BoardCase) -> None:
    drive = Drive(bench)
    bench.board.run(FREE_S)
    drive.require_alive()
    drive.require_no_contact()
    drive.require_ends()
    drive.require_sight()
    drive.require_way()


@case("G13", "D01", "D02", "D03", "D04", bench_time_s=FREE_S, setup=PINS)
@pytest.mark.parametrize("room", ROOMS)
def test_straight_on_wheels(bench: BoardCase, room: int) -> None:
    _drive_freely(bench)


@case("G13", "D01", "D02", "D03", "D04", bench_time_s=FREE_S, setup=ADAPTER)
@pytest.mark.parametrize("room", ROOMS)
def test_over_the_adapter(bench: BoardCase, room: int) -> None:
    _drive_freely(bench)


@case("G13", "D01", "D02", "D04", "D06", bench_time_s=FREE_S, setup=P2OS)
@pytest.mark.parametrize("room", ROOMS)
def test_by_p2os(bench: BoardCase, room: int) -> None:
    drive = Drive(bench, commands=True)
    bench.board.run(FREE_S)
    drive.require_alive()
    drive.require_no_contact()
    drive.require_ends()
    drive.require_sight_over_p2os()
    drive.require_way()


@case("D03", bench_time_s=0.5, setup=PINS, scene="post")
@pytest.mark.parametrize("sensor", AHEAD)
def test_each_sensor_ahead_is_looked_at(bench: BoardCase, sensor: int) -> None:
    drive = Drive(bench)
    bench.board.run(SETTLE_S)
    place_before(bench, sensor, RANGE_M)
    seen = bench.board.run_until(lambda: obstacles(bench.board) == [sensor], SETTLE_S)
    if not seen:
        raise Inconclusive(f"DD{sensor} is not high alone, but {obstacles(bench.board)}")
    bench.board.run(2 * LONGEST_BLIND_S)
    if not any(spell.motion == FORWARD for spell in drive.spells()):
        raise Violation("the program does not drive where nothing is near")
    what = f"time that DD{sensor} is high alone and both codes forward"
    at_most(longest_overlap_s(drive.high(sensor), drive.spells()), LONGEST_BLIND_S, unit="s", what=what)


@case("D06", bench_time_s=DRIVING_S + 1.2, setup=P2OS, scene="post")
@pytest.mark.parametrize("sensor", STRAIGHT)
def test_each_disc_ahead_is_looked_at_over_p2os(bench: BoardCase, sensor: int) -> None:
    drive = Drive(bench, commands=True)
    bench.board.run(DRIVING_S)
    if drive.spells()[-1].motion != FORWARD:
        raise Violation("the program does not drive where nothing is near")
    place_before(bench, sensor, RANGE_M - BACK_M, BACK_M)
    bench.board.run(1.2)
    if not drive.near():
        raise Inconclusive(f"nothing is near before disc {sensor}")
    drive.require_sight_over_p2os()


@case("D02", bench_time_s=TURN_AWAY_S, setup=PINS, scene="wall")
def test_a_wall_is_turned_away_from(bench: BoardCase) -> None:
    bench.world.place(WALL_X_M, 0.0, 0.0)
    drive = Drive(bench)

    def turned_away() -> bool:
        motions = [spell.motion for spell in drive.spells()]
        return TURN in motions and FORWARD in motions[motions.index(TURN) :]

    begin_s = bench.board.now_s
    sees = bench.board.run_until(drive.sees, SEES_S)
    if not sees and any(spell.motion == FORWARD for spell in drive.spells()):
        raise Inconclusive(f"none of DD3 to DD6 goes high within {SEES_S:g} s of driving towards a wall")
    if not bench.board.run_until(turned_away, TURN_AWAY_S - (bench.board.now_s - begin_s)):
        motions = ", ".join(f"{spell.motion} for {spell.length_s:.2f} s" for spell in drive.spells())
        raise Violation(f"it does not drive on within {TURN_AWAY_S:g} s before a wall: {motions}")
    drive.require_ends(TURN_AWAY_S)


@case("D07", bench_time_s=RESET_S + AFTER_RESET_S, setup=P2OS, scene="wall")
def test_a_reset_within_a_session_leaves_no_robot_adrift(bench: BoardCase) -> None:
    def speed_m_s() -> float:
        return math.hypot(*bench.world.velocity().linear_m_s[:2])

    drive = Drive(bench, commands=True)
    bench.board.run(RESET_S)
    if speed_m_s() < DRIVES_M_S:
        raise Inconclusive(f"the robot does not drive after {RESET_S:g} s, but moves at {speed_m_s():.3f} m/s")
    bench.board.reset()
    sessions = Sessions(bench)
    begin_s = bench.board.now_s
    caught = bench.board.run_until(lambda: speed_m_s() < STANDS_M_S or sessions.opened > 0, LONGEST_ADRIFT_S)
    if not drive.resets:
        raise Inconclusive("the board is not reset")
    if not caught:
        speed = f"{speed_m_s():.3f} m/s, in the session from before"
        raise Violation(f"{LONGEST_ADRIFT_S:g} s after a reset of the board the robot drives on at {speed}")
    bench.board.run(AFTER_RESET_S - (bench.board.now_s - begin_s))
    drive.require_untouched("D07")
    if drive.clearance.least_m == math.inf:
        raise Inconclusive("nothing is near enough to be touched")


@case("D05", bench_time_s=2 * REPLAY_S, setup=CaseSetup(program="dodge"), needs=ALONE.needs)
def test_the_same_inputs_give_the_same_outputs(bench: BoardCase) -> None:
    inputs, outputs = Inputs(bench), Outputs(bench)
    bench.board.run(REPLAY_S)
    alone = bench.open_other(ALONE)
    again = Outputs(alone)
    inputs.give(alone)
    alone.board.run(REPLAY_S)
    if len(outputs.edges) < LEAST_CHANGES or not inputs.edges:
        raise Inconclusive(f"{len(outputs.edges)} edges of outputs are too few to compare")
    outputs.require_same(again)
    if not any(edge.pin in MOTORS and edge.ns > STARTED_NS for edge in outputs.edges):
        raise Inconclusive(f"the motor wires do not change after {STARTED_NS / NS_PER_S:g} s, whatever comes in")
