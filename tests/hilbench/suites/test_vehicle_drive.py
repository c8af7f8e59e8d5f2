"""The drives of `vehicle-drive` on the behavioural board: a right one passes, each wrong one is found by its clause."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from hilbench.bench import Bench
from hilbench.bench.devices import LinesActor
from hilbench.benchfile.bench_model import World
from hilbench.check import Violation
from hilbench.check.cases import spec_of
from hilbench.check.catalogue import find_clause
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.mcu.bare_vehicle import BareVehicle
from hilbench.suites import vehicle_drive
from hilbench.suites._vehicle_drive import Drive, DriveBench
from hilbench.systems.vehicle.drive_clauses import CLAUSES
from hilbench.systems.vehicle.hands import ModelHands
from measure.mutants.vehicle.driven import DRIVEN
from protocols.carla import VECTORS, Axis, Mode, decode_command
from targets.robots import car_host
from targets.robots.vehicle_interface import SIMULATOR_LINE, STACK_LINE, VehicleInterface, VehicleSettings
from targets.robots.vehicle_interface.board import behaviour_of

pytestmark = pytest.mark.needs_physics

CASES = {name: one for name, one in vars(vehicle_drive).items() if spec_of(one) is not None}


@pytest.fixture
def make():
    """A drive through a behavioural board with these defects."""

    def make(*defects, kind=VehicleInterface, mutant=None, **options):
        bench = Bench(Scheduler(), Journal())
        line = Line(baud=921_600)
        links = {name: MemoryLink(bench.scheduler, line, name=name) for name in (SIMULATOR_LINE, STACK_LINE)}
        there = BareVehicle(bench, World(scene="test-track", vehicle="car", step_hz=240), seed=0)
        behaviour = behaviour_of(VehicleSettings(defects=defects))
        behaviour = replace(behaviour, board=replace(behaviour.board, **options))
        board = kind(VehicleSettings(), behaviour=behaviour) if mutant is None else mutant.make(VehicleSettings())
        actor = LinesActor(bench, board, {name: link.b for name, link in links.items()}, name="board")
        return Drive(
            DriveBench(
                bench=bench,
                simulator=links[SIMULATOR_LINE].a,
                stack=links[STACK_LINE].a,
                body=there.body,
                runner=there.runner,
                hands=ModelHands(bench, board, actor),
            )
        )

    return make


def begin_a_lap(drive):
    """The first straight and half of a curve."""
    drive.start()
    vehicle_drive.require_driven(drive, 110.0)


WHOLE_LAP = "test_a_lap"
BEGINNING = "the_beginning_of_a_lap"
DRIVES = {**CASES, BEGINNING: begin_a_lap}
IN_GATE = {"test_hand_over_by_press", "test_simulator_lost"}
"""What a right board does in the gate; each mode is in one of them."""

FAULTY = [
    # what is wrong, which drive finds it, by which clause, how
    ("V1", "test_by_joystick", "VD03", "a frame of mode 0 tells the car AckermannCommand"),
    ({"x_axis": Axis(least=1057, zero=30000)}, "test_hand_over_by_press", "VD04", "the stick at rest"),
    ("H7", "test_stack_lost", "VD06", "speed 1.3 s after the last command"),
    ({"status_deadline_s": 0.15}, "test_simulator_lost", "VD08", "last status to EMERGENCY"),
    ("one-miss", "test_emergency_stop", "VD10", "the car stands 3 s after power-on"),
    ("no-factor", BEGINNING, "VD11", "tyre angle on the lap"),
]
MORE_FAULTY = [
    ({"steering_factor": -1.2}, BEGINNING, "VD01", "farthest off the middle line|touched something"),
    ({"steering_factor": -1.2}, WHOLE_LAP, "VD01", "farthest off the middle line|touched something"),
    ("axes-swapped", "test_by_joystick", "VD03", "acceleration at half of the stick's way"),
    (
        {"command_deadline_s": 0.15},
        "test_stack_lost",
        "VD06",
        "the mode is not MANUAL|way from the last command",
    ),
    ("no-factor", WHOLE_LAP, "VD11", "tyre angle on the lap"),
]
another = pytest.mark.exhaustive("another faulty board of its clause is in the gate")


@pytest.mark.parametrize(
    "name",
    [
        name if name in IN_GATE else pytest.param(name, marks=pytest.mark.exhaustive("the gate has two other drives"))
        for name in DRIVES
        if name != WHOLE_LAP
    ],
)
def test_the_hardened_board_drives(make, name):
    DRIVES[name](make())


@pytest.mark.exhaustive("the gate has the beginning of the lap")
def test_the_hardened_board_drives_a_whole_lap(make):
    DRIVES[WHOLE_LAP](make())


@pytest.mark.parametrize(
    ("wrong", "name", "clause", "cause"),
    [*FAULTY, *(pytest.param(*row, marks=another) for row in MORE_FAULTY)],
    ids=str,
)
def test_a_wrong_board_is_found(make, wrong, name, clause, cause):
    with pytest.raises(Violation, match=cause) as found:
        DRIVES[name](make(wrong) if isinstance(wrong, str) else make(**wrong))
    assert found.value.clause in ("", clause)


class StrayEmergency(VehicleInterface):
    """Puts a frame of EMERGENCY in the place of each hundredth of AUTOWARE; the car hardly notices."""

    _frames = 0

    def _from_simulator(self, events, now_ns):
        sent = super()._from_simulator(events, now_ns)
        return [(line, self._changed(data) if line == SIMULATOR_LINE else data) for line, data in sent]

    def _changed(self, data):
        self._frames += decode_command(data).mode == Mode.AUTOWARE
        return data if self._frames % 100 else VECTORS["F3"].data


def test_one_stray_emergency_is_found(make):
    drive = make(kind=StrayEmergency)
    drive.start()
    drive.go(5.0)
    with pytest.raises(Violation, match=r"1 times the mode is not 1: at .* a frame of mode 0") as found:
        vehicle_drive.require_mode(drive, 0.0, Mode.AUTOWARE, "VD01")
    assert found.value.clause == "VD01"


@another
def test_reports_with_other_signs_are_found(make):
    drive = make()
    drive.car.simulator.host.behaviour = car_host.behaviour_of("hardened", (), "original")
    drive.start()
    assert drive.until(lambda: abs(drive.now.turn_rad_s) > 0.1, 20.0)
    drive.go(0.2)
    with pytest.raises(Violation, match=r"(turn_rad_s|lateral_speed_m_s) is reported as") as found:
        for report_s, report in drive.reports:
            vehicle_drive.require_true(drive, report_s, report)
    assert found.value.clause == "VD02"


FOUND_BY = {
    "VD05": ("test_hand_over_by_press", "acceleration after the hand-over"),
    "VD07": ("test_stack_lost", "times the mode is not 4"),
    "VD09": ("test_simulator_lost", "the mode is not MANUAL"),
}


@pytest.mark.parametrize("mutant", [one for one in DRIVEN if one.about != ("VD02",)], ids=lambda one: one.id)
def test_a_faulty_board_is_found(make, mutant):
    (clause,) = mutant.about
    name, cause = FOUND_BY[clause]
    with pytest.raises(Violation, match=cause) as found:
        CASES[name](make(mutant=mutant))
    assert found.value.clause == clause


def test_reports_with_exchanged_fields_are_found(make):
    """By VD02, as soon as the car turns; on a straight both figures are 0."""
    (mutant,) = (one for one in DRIVEN if one.about == ("VD02",))
    drive = make(mutant=mutant)
    drive.start()
    assert drive.until(lambda: abs(drive.now.turn_rad_s) > 0.1, 20.0)
    drive.go(0.2)
    with pytest.raises(Violation, match=r"(turn_rad_s|lateral_speed_m_s) is reported as") as found:
        for report_s, report in drive.reports:
            vehicle_drive.require_true(drive, report_s, report)
    assert found.value.clause == "VD02"


def test_the_page_names_the_faulty_boards():
    page = (Path(__file__).parents[3] / "docs" / "vehicle-drive.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `([\w-]+)` \| ([^|]+) \| (VD\d\d) \|$", page, re.MULTILINE)
    assert rows == [(one.id, one.what, *one.about) for one in DRIVEN]


def test_a_stop_is_no_emergency(make):
    """The driving stack is lost: a command of mode 1 stops the car, its tyres straight."""
    drive = make()
    drive.start()
    drive.stack.stop_driving()
    with pytest.raises(Violation, match="no emergency within 1 s"):
        drive.emergency(1.0)


def test_every_clause_has_a_faulty_board():
    found = {"VD01"} | {clause for _, _, clause, _ in FAULTY} | {clause for one in DRIVEN for clause in one.about}
    assert found == {clause.id for clause in CLAUSES}


def test_every_clause_has_a_case_and_every_case_its_clauses():
    cited = [clause for one in CASES.values() for clause in spec_of(one).clause_ids]
    assert set(cited) == {clause.id for clause in CLAUSES}
    assert all(find_clause(clause) is not None for clause in cited)


def test_bench_times_are_said():
    assert all(spec_of(one).bench_time_s > 0 for one in CASES.values())
