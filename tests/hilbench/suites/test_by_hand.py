"""Clauses that need a hand on the target, judged at a port because somebody there is asked: in bench time."""

from __future__ import annotations

import contextlib
import json
from functools import partial
from itertools import pairwise

import pytest

from hilbench.bench.devices import DeviceActor, LinesActor
from hilbench.bench.operator import CANNOT, DONE, Operator
from hilbench.bench.shared import Shared
from hilbench.benchfile.reader import open_bench
from hilbench.check import CheckOptions, Verdict, run_suites
from hilbench.check.report import matrix
from hilbench.journal import Journal
from hilbench.systems.rover.system import ROVER
from hilbench.systems.vehicle.system import VEHICLE
from measure.mutants import rover as rovers
from measure.mutants.in_bench_time import ForeignRoverInBenchTime, ForeignVehicleInBenchTime
from measure.mutants.vehicle.tables import all_mutants as all_vehicles
from protocols.carla import X_AXIS, Y_AXIS
from protocols.carla.clauses import BOARD_CLAUSES as VEHICLE_CLAUSES
from protocols.pkt.clauses import BOARD_CLAUSES as ROVER_CLAUSES
from targets.robots.rover import RoverRobot, RoverSettings
from targets.robots.vehicle_interface import VehicleInterface, VehicleSettings
from tests.each import each

TAKES_S = 3.0
"""How long somebody takes for whatever he is asked for: much longer than any deadline of the protocols."""


class Person:
    """Does what he is asked for at the target, in his own time.

    Attributes:
        asked: the names and words of the requests.
        cannot: the names of those that he refuses.
    """

    def __init__(self, *cannot):
        self.asked, self.cannot = [], cannot

    def answer(self, bench, asked):
        self.asked.append((asked.name, *asked.words))
        bench.run_for(TAKES_S / 2)
        if asked.name in self.cannot:
            return CANNOT
        said = getattr(self, asked.name.replace("-", "_"))(bench, *asked.words)
        bench.run_for(TAKES_S / 2)
        return said or DONE

    def last(self, asked):
        self.asked.append(("last", asked.name))

    def close(self):
        self.asked.append(("close",))


class BesideRover(Person):
    """And is the board, which may be held in reset.

    Args:
        make: makes the rover, which counts time from when it is switched on.
    """

    def __init__(self, make, *cannot):
        super().__init__(*cannot)
        self.make, self.robot, self.on_ns, self.actor = make, make(), 0, None

    def put(self, bench, port):
        self.actor = DeviceActor(bench, self, port, name="rover")

    def led(self, _bench):
        return "lit" if self.robot.lit else "dark"

    def hold_wheels(self, _bench):
        self.robot.plant.force(0.0)

    def release_wheels(self, _bench):
        self.robot.plant.force(None)

    def hold_reset(self, _bench):
        self.robot = None

    def release_reset(self, bench):
        self.robot, self.on_ns = self.make(), bench.now_ns
        self.actor.transmit(b"")

    def receive(self, data, now_ns):
        return self.robot.receive(data, now_ns - self.on_ns) if self.robot else b""

    def advance(self, now_ns):
        return self.robot.advance(now_ns - self.on_ns) if self.robot else b""

    def next_deadline_ns(self):
        return self.robot.next_deadline_ns() + self.on_ns if self.robot else None

    def take_events(self):
        return self.robot.take_events() if self.robot else ()


class BesideVehicle(Person):
    """Args: board: what stands at the ports."""

    def __init__(self, board, *cannot):
        super().__init__(*cannot)
        self.board, self.actor = board, None

    def put(self, bench, ports):
        self.actor = LinesActor(bench, self.board, ports, name="board")

    def press(self, bench):
        self.actor.transmit(self.board.press(bench.now_ns))

    def hold_joystick(self, bench, place):
        """A hand does not get quite to the end, and not straight."""
        x = {"right": 60_000, "left": 2000}.get(place.partition("to the ")[2].partition(" ")[0], X_AXIS.zero + 700)
        y = 1900 if "back" in place else Y_AXIS.zero
        self.actor.transmit(self.board.set_joystick(x, y, bench.now_ns))

    def release_joystick(self, bench):
        self.actor.transmit(self.board.set_joystick(X_AXIS.zero + 200, Y_AXIS.zero - 200, bench.now_ns))

    def light(self, _bench):
        return self.board.light or "none"

    def indicators(self, bench):
        seen = []
        for _ in range(150):
            bench.run_for(0.02)
            seen.append(self.board.lit_lamps(bench.now_ns))
        left, right = (sum(now > before for before, now in pairwise(side)) for side in zip(*seen, strict=True))
        if not {left, right} <= {0, *range(3, 7)}:
            return "otherwise"
        return {(True, False): "left", (False, True): "right", (True, True): "both"}.get((left > 0, right > 0), "none")


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


OF_THE_ROVER = {one.id for one in ROVER_CLAUSES if one.by_hand and "documented" in one.profiles}
OF_THE_VEHICLE = {one.id for one in VEHICLE_CLAUSES if one.by_hand and "hardened" in one.profiles}


ROVER_FAULTS = {
    "P02D": "no-0x81",
    "P11D": "no-resync",
    "P26": "no-periodic-reports",
    "P38D": "pid-offsets",
    "P43D": "first-rpm-1",
    "P44D": "led-shared",
    "P45D": "pid-windup",
    "P46D": "pid-no-reset",
    "P62": "setpoints-outlive-the-link",
    "P63": "setpoint-flags-ignored",
    "P78": "accepted-from-1",
}
VEHICLE_FAULTS = {
    "VB08": "starts-off",
    "VB09": "deaf-switch",
    "VB10": "press-ends-emergency",
    "VB15": "zero-off",
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
