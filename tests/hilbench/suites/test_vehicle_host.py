"""The suite vehicle-host: our simulator's side passes in every profile; a faulty one, and a foreign one, is judged."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from hilbench.bench.client_under_test import EXEC_CAPABILITIES
from hilbench.bench.locked_providers import ExecProvider
from hilbench.bench.shared import Shared
from hilbench.benchfile.reader import open_bench
from hilbench.check import CheckOptions, Verdict, list_cases, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.journal import Journal
from hilbench.systems.vehicle.provider import VehicleProvider, foreign_simulator
from hilbench.terminal.options import TargetChoice
from measure.mutants.car_host import FAULTY_HOSTS
from measure.mutants.each_its_own import Fault, judge
from measure.mutants.in_bench_time import ForeignClientInBenchTime, saying
from measure.mutants.late import BLAMED, AtPort, late_benches
from protocols.carla import AckermannCommand, Commanded, CommandLimits, ManualCommand, Mode, Signs
from protocols.carla.clauses import HOST_CLAUSES
from targets.robots.car_host import BEHAVIOURS, DEFECTS, CarHost
from tests.each import each

ROW = re.compile(r"^\| `(?P<name>[\w-]+)` \| [^|]+ \| (?P<clauses>VS[^|]+) \|$", re.MULTILINE)
PAGE = (Path(__file__).parents[3] / "docs" / "vehicle.md").read_text(encoding="utf-8")
FOUND = {row["name"]: tuple(row["clauses"].split(", ")) for row in ROW.finditer(PAGE)}
STATUS = bytes.fromhex("23410000000042000000004300000000440000000024")

OPTIONS = CheckOptions(bench="vehicle-model", suites=("vehicle-host",))


LONG = "VS20 or (VS25 and not [hardened])"


@pytest.fixture(scope="module")
def report():
    options = replace(OPTIONS, select=f"not ({LONG})")
    return run_suites(options, make_provider(options))


def test_each_clause_is_cited_by_one_function_in_each_of_its_profiles():
    planned = list_cases(OPTIONS, make_provider(OPTIONS))
    cited = [(case.clauses[0].id, case.setup.program) for case in planned]
    assert sorted(cited) == sorted((clause.id, profile) for clause in HOST_CLAUSES for profile in clause.profiles)
    functions = {(case.clauses[0].id, case.id.partition("[")[0]) for case in planned}
    assert len(functions) == len(HOST_CLAUSES) >= 40


@pytest.mark.slow("all that is asked of the simulator's side, once; two and a half minutes of bench time")
def test_the_simulator_s_side_passes_in_every_profile(report):
    assert {case.id: case.cause for case in report.cases if case.verdict is not Verdict.PASS} == {}
    assert report.exit_code == 0


@pytest.mark.exhaustive("ten seconds of processor time; the gate has what finds a fault in them")
def test_the_published_ones_pass_the_long_cases():
    options = replace(OPTIONS, select=LONG)
    report = run_suites(options, make_provider(options))
    assert {case.verdict for case in report.cases} == {Verdict.PASS}
    assert len(report.cases) == 5


def test_every_edge_of_its_table_is_taken(report):
    (coverage,) = (table for table in report.observed.coverage if table.peer == "simulator's side")
    assert coverage.edges_missed == ()


def test_the_page_names_each_defect():
    assert FOUND.keys() == DEFECTS.keys()


def shared_bench():
    return Shared(bench_file=open_bench("vehicle-model"), timeout_scale=1.0, journal=Journal())


def judged(make, select):
    """What the suite makes of such hosts, by clause."""
    report = run_suites(replace(OPTIONS, select=select), VehicleProvider(shared_bench(), make_host=make))
    return {case.clause_ids[0]: case.verdict for case in report.cases}


def with_defect(name):
    def make(settings, power_on_ns):
        return CarHost(replace(settings, defects=(name,)), power_on_ns=power_on_ns)

    return make


def fault(name, make, clause, select="[hardened]"):
    """A host as something that a clause has to find."""
    open_case = VehicleProvider(shared_bench(), make_host=make).open_case
    return Fault(name=name, clause_id=clause, select=select, open_case=open_case)


def test_torn_frames_and_waiting_are_told_apart():
    """H3 is found without the waiting, and the waiting with a reader that tears nothing."""
    torn, waiting = FOUND["H3"], FOUND["H5"]
    assert judged(with_defect("H3"), f"[hardened] and ({' or '.join(waiting)})") == dict.fromkeys(waiting, Verdict.PASS)
    assert judged(with_defect("H5"), f"[hardened] and ({' or '.join(torn)})") == dict.fromkeys(torn, Verdict.PASS)


class Illegible(CarHost):
    """Says B where the A of a status stands."""

    def advance(self, now_ns):
        return super().advance(now_ns).replace(b"#A", b"#B")


def test_statuses_that_cannot_be_read_are_no_defect_of_ours():
    def illegible(settings, power_on_ns):
        return Illegible(settings, power_on_ns=power_on_ns)

    options = replace(OPTIONS, select="[hardened] and VS21H")
    report = run_suites(options, VehicleProvider(shared_bench(), make_host=illegible))
    (case,) = report.cases
    assert (case.verdict, case.cause.partition(";")[0]) == (
        Verdict.FAIL,
        "0 statuses came while the board was silent for 2 s",
    )


def as_hardened(settings, power_on_ns):
    """A hardened host where the published one is expected: no clause that describes a hazard passes."""
    return CarHost(settings, power_on_ns=power_on_ns, behaviour=BEHAVIOURS["hardened"])


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


def of_kind(kind):
    def make(settings, power_on_ns):
        return kind(settings, power_on_ns=power_on_ns)

    return make


def named_faults():
    faults = [fault(name, with_defect(name), clause) for name, clauses in FOUND.items() for clause in clauses]
    for kind, clauses in (*OTHERS, *FAULTY_HOSTS):
        faults += [fault(kind.__name__, of_kind(kind), clause) for clause in clauses]
    hazards = [clause.id for clause in HOST_CLAUSES if "hardened" not in clause.profiles]
    faults += [fault("hardened", as_hardened, clause, "[v0]") for clause in hazards]
    return faults


OF_TIME = {"VS20", "VS28", "VS28H"}
"""What is about times that 100 ms blur: a rate to 2 in 1200, and what comes 3 ms apart."""


@pytest.mark.exhaustive("each fault once more; the gate has what P2OS's clients show on a late bench")
def test_on_a_late_bench_the_other_clauses_find_it_too():
    with late_benches(0.1):
        verdicts = judge(OPTIONS, make_provider(OPTIONS), named_faults())
    assert verdicts.open_clauses == OF_TIME


@pytest.mark.exhaustive("each profile; the gate has what P2OS's clients show on a late bench")
def test_on_a_late_bench_no_right_simulator_is_accused():
    with late_benches(0.1):
        cases = run_suites(OPTIONS, AtPort(make_provider(OPTIONS))).cases
    assert {case.id: case.cause for case in cases if case.verdict in BLAMED} == {}


@pytest.mark.slow("each clause of the simulator's side and a fault that it has to find")
def test_each_clause_finds_a_fault_that_is_named_for_it():
    one_of_each = {fault.clause_id: fault for fault in reversed(named_faults())}
    verdicts = judge(OPTIONS, make_provider(OPTIONS), one_of_each.values())
    assert verdicts.not_found == {}
    assert verdicts.found_by == {clause.id for clause in HOST_CLAUSES}


@pytest.mark.exhaustive("each fault that is named for a clause; the gate has one of each clause")
def test_each_clause_finds_each_fault_that_is_named_for_it():
    verdicts = judge(OPTIONS, make_provider(OPTIONS), named_faults())
    assert verdicts.not_found == {}
    assert verdicts.found_by == {clause.id for clause in HOST_CLAUSES}


def test_board_and_simulator_s_side_on_the_emulated_bench():
    assert len(on_the_emulated_bench("VS01 and [hardened]")) == 1


@pytest.mark.exhaustive("more clauses, and each image; the gate has the hardened one and a short case")
@pytest.mark.parametrize("select", ["VS01 and not [hardened]", "VS18"])
def test_each_board_and_simulator_s_side_on_the_emulated_bench(select):
    """Each with its own image; a simulator's side that does not pause is found there, too."""
    assert len(on_the_emulated_bench(select)) == (3 if select == "VS18" else 2)


def on_the_emulated_bench(select):
    """Return cases that pass."""
    options = CheckOptions(bench="vehicle", suites=("vehicle-host",), select=select)
    cases = run_suites(options, make_provider(options)).cases
    assert {case.id: case.cause for case in cases if case.verdict is not Verdict.PASS} == {}
    return cases


@each(("behind", "expected"), [(b"", Verdict.PASS), (b"\0", Verdict.FAIL)])
def test_a_foreign_one_is_judged_by_its_statuses(behind, expected):
    shared = shared_bench()
    provider = ForeignClientInBenchTime(shared, foreign_simulator(shared), saying(STATUS + behind, 0.05))
    cases = run_suites(replace(OPTIONS, select="[hardened] and (VS13 or VS14)"), provider).cases
    assert {case.clause_ids[0]: case.verdict for case in cases} == {"VS13": expected, "VS14": Verdict.NOT_APPLICABLE}


def test_a_program_is_a_foreign_one():
    provider = make_provider(replace(OPTIONS, targets=(TargetChoice(spec="exec:bridge {pty}"),)))
    assert isinstance(provider, ExecProvider)
    assert provider.capabilities == {"CARLA", "simulator", "program 'hardened'", *EXEC_CAPABILITIES}
