"""The suite vehicle-host: our simulator's side passes in every profile; a faulty one, and a foreign one, is judged."""

from __future__ import annotations

import re
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from hilbench.bench_provider import make_provider
from hilbench.check import CheckOptions, Verdict, list_cases, run_suites
from hilbench.config import open_bench
from hilbench.journal import Journal
from hilbench.options import TargetChoice
from hilbench.shared import Shared
from hilbench.vehicle.provider import VehicleProvider
from protocols.carla import AckermannCommand, Commanded, CommandLimits, ManualCommand, Mode, Signs
from protocols.carla.clauses import HOST_CLAUSES
from targets.robots.car_host import BEHAVIOURS, DEFECTS, CarHost
from tests.mutants.car_host import FAULTY_HOSTS

ROW = re.compile(r"^\| `(?P<name>[\w-]+)` \| [^|]+ \| (?P<clauses>VS[^|]+) \|$", re.MULTILINE)
PAGE = (Path(__file__).parents[3] / "docs" / "vehicle.md").read_text(encoding="utf-8")
FOUND = {row["name"]: tuple(row["clauses"].split(", ")) for row in ROW.finditer(PAGE)}
FOREIGN = """
import sys
import serial
port = serial.Serial(sys.argv[1], 921600, timeout=0.05)
while True:
    port.write(bytes.fromhex("23410000000042000000004300000000440000000024" + sys.argv[2]))
    port.read(4096)
"""

OPTIONS = CheckOptions(bench="vehicle-model", suites=("vehicle-host",))


@pytest.fixture(scope="module")
def report():
    return run_suites(OPTIONS, make_provider(OPTIONS))


def test_each_clause_is_cited_by_one_function_in_each_of_its_profiles():
    planned = list_cases(OPTIONS, make_provider(OPTIONS))
    cited = [(case.clauses[0].id, case.setup.program) for case in planned]
    assert sorted(cited) == sorted((clause.id, profile) for clause in HOST_CLAUSES for profile in clause.profiles)
    functions = {(case.clauses[0].id, case.id.partition("[")[0]) for case in planned}
    assert len(functions) == len(HOST_CLAUSES) >= 40


def test_the_simulator_s_side_passes_in_every_profile(report):
    assert {case.id: case.cause for case in report.cases if case.verdict is not Verdict.PASS} == {}
    assert report.exit_code == 0


def test_every_edge_of_its_table_is_taken(report):
    (coverage,) = (table for table in report.observed.coverage if table.peer == "simulator's side")
    assert coverage.edges_missed == ()


def test_the_page_names_each_defect():
    assert FOUND.keys() == DEFECTS.keys()


def judged(make, select):
    """What the suite makes of such hosts, by clause."""
    shared = Shared(bench_file=open_bench("vehicle-model"), timeout_scale=1.0, journal=Journal())
    report = run_suites(replace(OPTIONS, select=select), VehicleProvider(shared, make_host=make))
    return {case.clause_ids[0]: case.verdict for case in report.cases}


def with_defect(name):
    def make(settings, power_on_ns):
        return CarHost(replace(settings, defects=(name,)), power_on_ns=power_on_ns)

    return make


@pytest.mark.parametrize("name", DEFECTS)
def test_a_faulty_one_is_found(name):
    """By each clause that the page names for it."""
    found = judged(with_defect(name), f"[hardened] and ({' or '.join(FOUND[name])})")
    assert found == dict.fromkeys(FOUND[name], Verdict.FAIL)


def test_torn_frames_and_waiting_are_told_apart():
    """H3 is found without the waiting, and the waiting with a reader that tears nothing."""
    torn, waiting = FOUND["H3"], FOUND["H5"]
    assert judged(with_defect("H3"), f"[hardened] and ({' or '.join(waiting)})") == dict.fromkeys(waiting, Verdict.PASS)
    assert judged(with_defect("H5"), f"[hardened] and ({' or '.join(torn)})") == dict.fromkeys(torn, Verdict.PASS)


def test_each_hazard_is_missed_where_it_is_gone():
    """A hardened host where the published one is expected: no clause that describes a hazard passes."""
    hazards = [clause.id for clause in HOST_CLAUSES if "hardened" not in clause.profiles]

    def make(settings, power_on_ns):
        return CarHost(settings, power_on_ns=power_on_ns, behaviour=BEHAVIOURS["hardened"])

    assert judged(make, f"[v0] and ({' or '.join(hazards)})") == dict.fromkeys(hazards, Verdict.FAIL)


class Hasty(CarHost):
    def _tell(self, command, **about):
        if isinstance(command, AckermannCommand):
            command = replace(command, speed_m_s=command.speed_m_s + 1)
        super()._tell(command, **about)


class Swapped(CarHost):
    def _tell(self, command, **about):
        if isinstance(command, ManualCommand):
            command = replace(command, throttle=command.brake, brake=command.throttle)
        super()._tell(command, **about)


class Fearless(CarHost):
    def _tell(self, command, **about):
        if command != AckermannCommand():
            super()._tell(command, **about)


class Lenient(CarHost):
    """Takes mode 7 for 1."""

    _before = b""

    def receive(self, data, now_ns):
        before, self._before = self._before, data
        return super().receive(b"\x01" if (before, data) == (b"M", b"\x07") else data, now_ns)


class Pedantic(CarHost):
    """Takes a frame only with the NUL behind it."""

    _held = b""

    def receive(self, data, now_ns):
        held, self._held = self._held, b"$" if data == b"$" else b""
        return super().receive(b"" if self._held else (held if data == b"\0" else b"") + data, now_ns)


class Eager(CarHost):
    def report(self, *what, now_ns):
        return b"".join(super(Eager, self).report("velocity", "steering", now_ns=now_ns) for _ in what)


class Restless(CarHost):
    def report_by_hand(self):
        """Goes on by itself."""


class Deafened(CarHost):
    """Hears nothing after half a million bytes."""

    _heard = 0

    def receive(self, data, now_ns):
        self._heard += len(data)
        return super().receive(data if self._heard < 500_000 else b"", now_ns)


class HalfClamped(CarHost):
    """Keeps steer below 1, and lets it go below -1."""

    def _take(self, events, now_ns):
        return super()._take([self._loose(event) for event in events], now_ns)

    def _loose(self, event):
        if isinstance(event, Commanded) and event.frame.mode == Mode.MANUAL and event.frame.steering < 0:
            return replace(event, command=replace(event.command, steer=event.frame.steering))
        return event


class LooksAtSpeeds(CarHost):
    """Looks for the impossible in the speed alone."""

    def __init__(self, settings, *, power_on_ns):
        right, any_ = BEHAVIOURS["hardened"], 1e31
        limits = CommandLimits(steering_rad=any_, steering_rate_rad_s=any_, acceleration_m_s2=any_, jerk_m_s3=any_)
        wrong = replace(right, line=replace(right.line, limits=limits))
        super().__init__(settings, power_on_ns=power_on_ns, behaviour=wrong)


class Mirrored(CarHost):
    def __init__(self, settings, *, power_on_ns):
        signs = Signs(lateral=-1.0, heading_rate=-1.0, steering=-1.0)
        right = BEHAVIOURS["hardened"]
        wrong = replace(right, host=replace(right.host, signs=signs))
        super().__init__(settings, power_on_ns=power_on_ns, behaviour=wrong)


class SteersToTheRight(CarHost):
    """Takes CARLA's steer to be positive to the left."""

    def __init__(self, settings, *, power_on_ns):
        right = BEHAVIOURS["hardened"]
        wrong = replace(right, host=replace(right.host, signs=Signs(steer_rad=1.0292)))
        super().__init__(settings, power_on_ns=power_on_ns, behaviour=wrong)


class OneWheel(CarHost):
    """Takes the largest angle of one wheel for that of the car."""

    def __init__(self, settings, *, power_on_ns):
        right = BEHAVIOURS["hardened"]
        wrong = replace(right, host=replace(right.host, signs=Signs(steer_rad=-1.2216)))
        super().__init__(settings, power_on_ns=power_on_ns, behaviour=wrong)


class Slow(CarHost):
    def __init__(self, settings, *, power_on_ns):
        super().__init__(replace(settings, status_hz=19.9), power_on_ns=power_on_ns)


OTHERS = (
    (Hasty, ("VS01", "VS05")),
    (Swapped, ("VS02",)),
    (Fearless, ("VS03",)),
    (Lenient, ("VS04",)),
    (Pedantic, ("VS05",)),
    (Eager, ("VS14", "VS15")),
    (Mirrored, ("VS14", "VS16")),
    (SteersToTheRight, ("VS16",)),
    (OneWheel, ("VS16",)),
    (Restless, ("VS18", "VS19")),
    (HalfClamped, ("VS24H",)),
    (LooksAtSpeeds, ("VS27H",)),
    (Slow, ("VS20",)),
    (Deafened, ("VS25",)),
)


@pytest.mark.parametrize(("kind", "clauses"), [*OTHERS, *FAULTY_HOSTS])
def test_another_faulty_one_is_found(kind, clauses):
    def make(settings, power_on_ns):
        return kind(settings, power_on_ns=power_on_ns)

    assert judged(make, f"[hardened] and ({' or '.join(clauses)})") == dict.fromkeys(clauses, Verdict.FAIL)


def test_each_clause_finds_something():
    hardened = {clause.id for clause in HOST_CLAUSES if "hardened" in clause.profiles}
    found = {clause for clauses in FOUND.values() for clause in clauses} | {one for _, some in OTHERS for one in some}
    assert hardened - found == set()


def test_board_and_simulator_s_side_on_the_emulated_bench():
    """Each with its own image; a simulator's side that does not pause is found there, too."""
    options = CheckOptions(bench="vehicle", suites=("vehicle-host",), select="VS01 or VS18")
    cases = run_suites(options, make_provider(options)).cases
    assert {case.id: case.cause for case in cases if case.verdict is not Verdict.PASS} == {}
    assert sorted({case.clause_ids[0] for case in cases}) == ["VS01", "VS18"]
    assert len(cases) == 6


@pytest.mark.parametrize(
    ("behind", "expected"),
    [("", {Verdict.PASS}), ("00", {Verdict.FAIL, Verdict.INCONCLUSIVE})],  # inconclusive on a host that was late
)
def test_a_foreign_one_is_judged_by_its_statuses(tmp_path, behind, expected):
    program = tmp_path / "bridge.py"
    program.write_text(FOREIGN)
    target = TargetChoice(spec=f"exec:{sys.executable} {program} {{pty}} '{behind}'")
    options = replace(OPTIONS, targets=(target,), select="[hardened] and (VS13 or VS14)")
    cases = run_suites(options, make_provider(options)).cases
    verdicts = {case.clause_ids[0]: case.verdict for case in cases}
    assert verdicts.pop("VS13") in expected
    assert verdicts == {"VS14": Verdict.NOT_APPLICABLE}
