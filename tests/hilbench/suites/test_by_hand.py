"""Clauses that need a hand on the target, judged at a port because somebody there is asked: in bench time."""

from __future__ import annotations

import contextlib
import json
from functools import partial

import pytest

from hilbench.bench.operator import Operator
from hilbench.bench.shared import Shared
from hilbench.benchfile.reader import open_bench
from hilbench.check import CheckOptions, Verdict, run_suites
from hilbench.check.report import matrix
from hilbench.journal import Journal
from hilbench.systems.rover.hands import OperatorHands
from hilbench.systems.rover.system import ROVER
from hilbench.systems.vehicle.system import VEHICLE
from measure.mutants import rover as rovers
from measure.mutants.beside import BesideRover, BesideVehicle
from measure.mutants.in_bench_time import ForeignRoverInBenchTime, ForeignVehicleInBenchTime
from measure.mutants.vehicle.tables import all_mutants as all_vehicles
from protocols.carla.clauses import BOARD_CLAUSES as VEHICLE_CLAUSES
from protocols.pkt import Position
from protocols.pkt.clauses import BOARD_CLAUSES as ROVER_CLAUSES
from targets.robots.rover import RoverRobot, RoverSettings
from targets.robots.vehicle_interface import VehicleInterface, VehicleSettings
from tests.each import each


def check(person, select, *, strict=False, journal=None):
    """Check what stands beside somebody, of whom it is asked what the clauses need."""
    bench, suite, profile, system, foreign = PLACES[type(person)]
    options = CheckOptions(bench=bench, suites=(suite,), select=f"[{profile}] and ({select})", strict=strict)
    operator = Operator(system.hand_requests, [person])
    journal = Journal(journal, {}) if journal else Journal()
    shared = Shared(bench_file=open_bench(bench), timeout_scale=1.0, journal=journal, operator=operator)
    provider = foreign(shared, person.put)
    try:
        return run_suites(options, provider)
    finally:
        provider.close()


PLACES = {
    BesideRover: ("rover-model", "pkt-board", "documented", ROVER, ForeignRoverInBenchTime),
    BesideVehicle: ("vehicle-model", "vehicle-board", "hardened", VEHICLE, ForeignVehicleInBenchTime),
}


def right_rover():
    return RoverRobot(RoverSettings())


def right_vehicle():
    return VehicleInterface(VehicleSettings())


def test_a_place_is_asked_for_to_the_metre():
    """A thousandth of a degree moves it by up to 55 m: half of what is allowed."""

    class Asked:
        def ask(self, *words):
            self.words = words
            return "yes"

    assert OperatorHands(asked := Asked()).stands_at(Position(latitude_deg=-34.61749, longitude_deg=-58.36851))
    assert asked.words == ("position", "-34.61749", "-58.36851")


OF_THE_ROVER = {one.id for one in ROVER_CLAUSES if one.by_hand and "documented" in one.profiles}
OF_THE_VEHICLE = {one.id for one in VEHICLE_CLAUSES if one.by_hand and "hardened" in one.profiles}


ROVER_FAULTS = {
    "P02D": "no-0x81",
    "P11D": "no-resync",
    "P26": "no-periodic-reports",
    "P38D": "pid-offsets",
    "P40D": "gps-order",
    "P42D": "quat-wxyz",
    "P43D": "first-rpm-1",
    "P44D": "led-shared",
    "P45D": "pid-windup",
    "P46D": "pid-no-reset",
    "P62": "setpoints-outlive-the-link",
    "P63": "setpoint-flags-ignored",
    "P78": "accepted-from-1",
    "P89": "field-mirrored",
    "P90": "stale-byte-84",
    "P91": "position-stays",
    "P92": "temperature-in-fahrenheit",
}
VEHICLE_FAULTS = {
    "VB03": "ping-2s",
    "VB08": "starts-off",
    "VB09": "deaf-switch",
    "VB10": "press-ends-emergency",
    "VB15": "zero-off",
    "VB17": "joystick-at-half",
    "VB18": "joystick-at-half",
    "VB42H": "agent-by-commands",
    "VB43": "hasty-lamps",
    "VB54": "no-red",
}
"""By clause a fault that it has to find."""


FEW = {"P02D", "P43D", "P62", "VB09", "VB54"}
SELECTED = pytest.mark.parametrize(
    "chosen",
    [
        pytest.param(FEW, id="few", marks=pytest.mark.slow("each of them takes as long as a person does")),
        pytest.param(
            {*ROVER_FAULTS, *VEHICLE_FAULTS} - FEW,
            id="others",
            marks=pytest.mark.exhaustive("the gate has five of them"),
        ),
    ],
)


def test_there_is_a_fault_for_each_clause_by_hand():
    assert (ROVER_FAULTS.keys(), VEHICLE_FAULTS.keys()) == (OF_THE_ROVER, OF_THE_VEHICLE)


@SELECTED
def test_what_is_right_passes_with_somebody_beside_it(chosen):
    for person, clauses in (
        (BesideRover(right_rover), OF_THE_ROVER & chosen),
        (BesideVehicle(right_vehicle()), OF_THE_VEHICLE & chosen),
    ):
        report = check(person, " or ".join(clauses))
        assert {case.id: case.cause for case in report.cases if case.verdict is not Verdict.PASS} == {}
        assert {clause.id for clause in report.clauses} == clauses
        assert {clause.id for clause in report.clauses if clause.by_own_report} == clauses & {"P62"}
        assert report.exit_code == 0


@SELECTED
def test_what_is_wrong_is_found_with_somebody_beside_it(chosen):
    of_rovers = {mutant.id: mutant for mutant in rovers.all_mutants()}
    of_vehicles = {mutant.id: mutant for mutant in all_vehicles()}
    found = {}
    for clause_id in OF_THE_ROVER & chosen:
        mutant = of_rovers[ROVER_FAULTS[clause_id]]
        with contextlib.ExitStack() as stack:
            for make in mutant.patches:
                stack.enter_context(make())
            report = check(BesideRover(partial(mutant.make, RoverSettings())), clause_id)
        found[clause_id] = report.clauses[0].verdict
    for clause_id in OF_THE_VEHICLE & chosen:
        board = of_vehicles[VEHICLE_FAULTS[clause_id]].make(VehicleSettings())
        found[clause_id] = check(BesideVehicle(board), clause_id).clauses[0].verdict
    assert found == dict.fromkeys(chosen, Verdict.FAIL)


@each("person, select, asked", [
    (BesideRover(right_rover), "P26 or P02D", [
        ("led",), ("led",), ("hold-wheels",), ("last", "release-wheels"), ("close",),
    ]),
    (BesideRover(right_rover), "P26 or P46D", [
        ("hold-wheels",), ("release-wheels",), ("hold-wheels",), ("last", "release-wheels"), ("close",),
    ]),
    (BesideVehicle(right_vehicle()), "VB08 or VB09", [
        ("hold-joystick", "back"), ("light",), ("release-joystick",), ("press",), ("close",),
    ]),
])  # fmt: skip
def test_what_was_asked_for_is_taken_back_before_the_next_case(person, select, asked):
    assert check(person, select).exit_code == 0
    assert person.asked == asked


@pytest.mark.exhaustive("twenty seconds without an agent; the gate has other clauses by hand")
def test_a_board_that_was_started_without_an_agent_is_started_once_more():
    person = BesideVehicle(right_vehicle())
    assert check(person, "VB03 or VB09").exit_code == 0
    reset = [("hold-reset",), ("release-reset",)]
    assert [one for one in person.asked if "reset" in one[0]] == reset * 2


def test_what_the_operator_cannot_do_is_not_shown():
    for strict, code in ((False, 0), (True, 4)):
        person = BesideRover(right_rover, "hold-wheels")
        report = check(person, "P02D or P26 or P63", strict=strict)
        causes = {clause.id: (clause.verdict, clause.cause) for clause in report.clauses}
        text = "the operator cannot: hold all four wheels, so that none turns"
        assert causes == {
            "P02D": (Verdict.PASS, ""),
            "P26": (Verdict.NOT_APPLICABLE, text),
            "P63": (Verdict.NOT_APPLICABLE, text),
        }
        assert report.exit_code == code
        assert report.exit_meaning.endswith("2 must clauses not shown here: P26, P63")


def test_without_an_operator_the_same_clauses_are_not_shown_or_by_report():
    options = CheckOptions(bench="rover-model", suites=("pkt-board",), select="documented and (P26 or P63)")
    shared = Shared(bench_file=open_bench("rover-model"), timeout_scale=1.0, journal=Journal())
    provider = ForeignRoverInBenchTime(shared, BesideRover(right_rover).put)
    found = {clause.id: (clause.verdict, clause.by_own_report) for clause in run_suites(options, provider).clauses}
    assert found == {"P26": (Verdict.NOT_APPLICABLE, ()), "P63": (Verdict.PASS, ("wheels",))}


def test_requests_and_answers_are_in_journal_report_and_evidence(tmp_path):
    class Blind(BesideRover):
        def led(self, _bench):
            return "dark"

    PLACES[Blind] = PLACES[BesideRover]
    report = check(Blind(right_rover), "P02D", journal=tmp_path / "run.jsonl")
    assert report.cases[0].asked == ("is the test LED lit?: dark",) * 2
    assert report.clauses[0].verdict is Verdict.FAIL
    assert "asked of the operator: is the test LED lit?: dark" in report.clauses[0].evidence
    assert "operator: asked 2 times in 1 case\n" in matrix.render(report, colours=False, width=None)
    events = [json.loads(line) for line in (tmp_path / "run.jsonl").read_text().splitlines()]
    of_operator = [
        (one["kind"], one["request"], one.get("answer")) for one in events if one.get("source") == "operator"
    ]
    assert of_operator == [("asked", "led", None), ("answered", "led", "dark")] * 2
