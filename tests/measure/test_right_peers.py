"""Robots and boards that were written without the project are right: no clause accuses them."""

from __future__ import annotations

from functools import partial

import pytest

from hilbench.suites._vehicle import Vehicle
from measure.right_peers import at_port, pioneer_robot, rover_board
from measure.right_peers.__main__ import RIGHT, Run, checked_in_memory, is_good, missing, table
from measure.right_peers.pioneer_robot import STEP_S, PioneerRobot
from measure.right_peers.rover_board import RoverBoard, Side
from measure.right_peers.vehicle_board import MANUAL, VehicleBoard
from tests.each import each

SOME = [
    ("script-p2os", "S03 or S22 or S36 or S82"),
    ("script-pkt", "P03 or P19 or P24D or P64"),
    ("script-carla", "VB01 or VB07 or VB12"),
]


@pytest.mark.parametrize(("name", "some"), SOME, ids=[name for name, _ in SOME])
def test_some_clauses_do_not(name, some):
    verdicts, accused = checked_in_memory(RIGHT[name], seed=0, also=some)
    assert accused == {}
    assert verdicts["pass"] >= 3


def test_a_slow_loop_of_control_is_right(monkeypatch):
    """No document says how often a board controls its speeds."""
    monkeypatch.setattr(rover_board, "STEP_S", 0.1)
    verdicts, accused = checked_in_memory(RIGHT["script-pkt"], seed=0, also="P88")
    assert accused == {}
    assert verdicts["pass"] == 1


def test_a_robot_that_is_kept_slow_is_right(monkeypatch):
    """Whose FLASH has a SETV of 250 mm/s, and 30 degrees/s."""
    monkeypatch.setattr(pioneer_robot, "DEFAULTS", pioneer_robot.DEFAULTS | {"setv": 250, "setrv": 30})
    verdicts, accused = checked_in_memory(RIGHT["script-p2os"], seed=0, also="S22 or S32")
    assert accused == {}
    assert verdicts["pass"] == 2


class Trailing(PioneerRobot):
    """Its servo trails the ramp by 60 ms."""

    _served = 0.0

    def _go(self):
        self._served += (self._speed - self._served) * STEP_S / 0.06
        self._as_served(super()._go)

    def _sip(self):
        return self._as_served(super()._sip)

    def _as_served(self, do):
        planned, self._speed = self._speed, self._served
        try:
            return do()
        finally:
            self._speed = planned


def test_a_robot_whose_servo_trails_its_ramp_is_right(monkeypatch):
    monkeypatch.setitem(at_port.PEERS, "p2os", lambda now_s: at_port.OneLine(Trailing(now_s)))
    verdicts, accused = checked_in_memory(RIGHT["script-p2os"], seed=0, also="S36")
    assert accused == {}
    assert verdicts["pass"] == 1


class QuickToStop(RoverBoard):
    """Its wheels stop at once, and every other 0x83 comes 50 ms later: still four in a second."""

    def __init__(self, now_s):
        super().__init__(now_s)
        for side in self._sides:
            side.step = partial(self._step, side)

    def _step(self, side):
        Side.step(side)
        side.rpm *= side.throttle != 0

    def _report_83(self):
        self._next[0x83] += 0.05 if 0.2 < self._next[0x83] % 0.5 < 0.3 else -0.05
        return super()._report_83()


def test_a_board_whose_wheels_stop_at_once_is_right(monkeypatch):
    monkeypatch.setitem(at_port.PEERS, "pkt", lambda now_s: at_port.OneLine(QuickToStop(now_s)))
    verdicts, accused = checked_in_memory(RIGHT["script-pkt"], seed=0, also="P30 or P83")
    assert accused == {}
    assert verdicts["pass"] == 2


class HeldJoystick(VehicleBoard):
    """In MANUAL somebody drives."""

    def _drive(self, figures, mode):
        super()._drive((-0.3, 0.0, 0.7, 0.0, 0.0) if mode == MANUAL else figures, mode)


def test_a_board_is_right_whose_last_status_came_before_the_frames_that_are_looked_at(monkeypatch):
    """Statuses stop right behind a frame: the first of the ten that none follows is then the first of all."""
    manual = Vehicle.manual

    def behind_a_frame(vehicle, **options):
        mark = manual(vehicle, **options)
        vehicle.bench.run_until(lambda: vehicle.mark() > mark, 1.0)
        return vehicle.mark()

    monkeypatch.setattr(Vehicle, "manual", behind_a_frame)
    verdicts, accused = checked_in_memory(RIGHT["script-carla"], seed=0, also="VB21")
    assert accused == {}
    assert verdicts["pass"] == 1


def test_a_board_whose_joystick_is_held_is_right(monkeypatch):
    monkeypatch.setitem(at_port.PEERS, "carla", HeldJoystick)
    verdicts, accused = checked_in_memory(RIGHT["script-carla"], seed=0, also="VB41H")
    assert accused == {}
    assert verdicts["pass"] == 1


@pytest.mark.exhaustive("every clause that a port can judge: some seconds each; the gate has the sorts")
@pytest.mark.parametrize("name", [name for name, _ in SOME])
def test_no_clause_does(name):
    verdicts, accused = checked_in_memory(RIGHT[name], seed=1)
    assert accused == {}
    assert verdicts["pass"] >= 37


def run(where, verdicts, accused=None):
    return Run(commit="c", peer="script-pkt", where=where, seed=3, verdicts=verdicts, accused=accused or {})


GOOD = run("memory", {"pass": 99, "not-applicable": 7})
DOUBT = run("busy", {"pass": 99, "inconclusive": 1}, {"P05": "late"})
MUCH_DOUBT = run("busy", {"pass": 97, "inconclusive": 3}, {"P05": "late"})
BAD = run("pty", {"fail": 1}, {"P01": "silent"})


def test_what_was_run_is_not_run_again():
    left = [seed for _, _, seed in missing([GOOD], ["script-pkt"], ["memory"])]
    assert sorted([*left, 3]) == list(range(90))


@each(
    ("runs", "is_right"),
    [([GOOD], True), ([GOOD, DOUBT], True), ([GOOD, DOUBT, MUCH_DOUBT], False), ([GOOD, BAD], False)],
)
def test_one_failure_is_too_much_and_so_is_doubt_in_two_of_a_hundred(runs, is_right):
    assert is_good(runs) is is_right


def test_who_is_accused_of_what_is_said():
    said = table([GOOD, BAD])
    assert "| script-pkt | memory | 1 | 99 | 0 | 0 |" in said
    assert "script-pkt, pty, seed 3: P01: silent" in said
