"""The suite pkt-board: the right rover passes in every profile, and every clause has a rover that fails it."""

from __future__ import annotations

import contextlib
from contextlib import closing
from dataclasses import replace
from types import SimpleNamespace
from unittest.mock import patch

import pytest

from hilbench.bench import Bench
from hilbench.bench.devices import DeviceActor
from hilbench.bench.shared import Shared
from hilbench.benchfile.reader import open_bench
from hilbench.check import CheckOptions, Verdict, list_cases, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.journal import Journal
from hilbench.judging.uncertainty import OfTimes
from hilbench.links import Line, PtyDoor
from hilbench.suites._rover import EVER_LATER, Rover
from hilbench.terminal.options import TargetChoice
from measure.mutants.defects_page import killers
from measure.mutants.each_its_own import judge, one_for_each
from measure.mutants.in_bench_time import ForeignRoverInBenchTime
from measure.mutants.late import BLAMED, AtPort, late_benches
from measure.mutants.rover import BY_HAND, all_mutants, fault, on_the_page, run
from protocols.pkt import MotionReport
from protocols.pkt.clauses import BOARD_CLAUSES
from targets.robots.rover import DEFECTS, RoverRobot, RoverSettings
from tests.share import few

OPTIONS = CheckOptions(bench="rover-model", suites=("pkt-board",))
FOUND = on_the_page()


@pytest.fixture(scope="module")
def planned():
    return list_cases(OPTIONS, make_provider(OPTIONS))


@pytest.fixture(scope="module")
def report():
    return run(None, "documented")


def test_each_clause_is_cited_by_one_function_in_each_of_its_profiles(planned):
    cited = [(case.clauses[0].id, case.setup.program) for case in planned]
    assert sorted(cited) == sorted((clause.id, profile) for clause in BOARD_CLAUSES for profile in clause.profiles)
    functions = {(case.clauses[0].id, case.id.partition("[")[0]) for case in planned}
    assert len(functions) == len(BOARD_CLAUSES) >= 60


@pytest.mark.slow("all that is asked of a rover as documented, once; three minutes of bench time")
def test_the_rover_passes(report):
    assert {case.id: case.cause for case in report.cases if case.verdict is not Verdict.PASS} == {}
    assert report.exit_code == 0
    assert {case.clause_ids[0] for case in report.cases} == {
        clause.id for clause in BOARD_CLAUSES if "documented" in clause.profiles
    }


@pytest.mark.exhaustive("the published profiles, which say as much again; the gate has the documented one")
def test_the_rover_passes_in_every_profile():
    report = run(None)
    assert {case.id: case.cause for case in report.cases if case.verdict is not Verdict.PASS} == {}
    assert report.exit_code == 0


@pytest.mark.exhaustive("four minutes of bench time; the gate has what the seed draws")
def test_the_rover_passes_with_each_member_of_its_sequences():
    try_members = Rover.try_members
    with patch.object(Rover, "try_members", lambda *args, budget: try_members(*args, budget=10 * budget * budget)):
        report = run(None, "P81 or P82")
    assert {case.id: case.cause for case in report.cases if case.verdict is not Verdict.PASS} == {}
    assert all(one.tried == one.members for case in report.cases for one in case.families)


def test_two_runs_are_the_same(report):
    assert run(None, "P26").run_hash == run(None, "P26").run_hash
    again = {case.id: case.case_hash for case in run(None, "P30 and documented").cases}
    assert again.items() <= {case.id: case.case_hash for case in report.cases}.items()


SOONER = {"P40D": "gps-order", "P89": "quaternion-long"}
"""Which fault a clause finds at once that takes a minute of bench time for another."""


def one_fault_for_each_clause():
    mutants, clause_ids = {mutant.id: mutant for mutant in all_mutants()}, [clause.id for clause in BOARD_CLAUSES]
    chosen = dict(one_for_each(clause_ids, FOUND)) | SOONER
    return [fault(mutants[name], clause_id) for clause_id, name in chosen.items()]


@pytest.mark.slow("each clause of the rover and a fault that it has to find")
def test_each_clause_finds_a_faulty_rover():
    verdicts = judge(OPTIONS, make_provider(OPTIONS), one_fault_for_each_clause(), until_found=True)
    assert verdicts.not_found == {}
    assert verdicts.found_by == {clause.id for clause in BOARD_CLAUSES}


SEEDS = [(0.1, 0), (0.03, 2), (0.05, 5), (0.1, 2), (0.1, 6), (0.2, 1)]
OF_TIME = {"P01", "P12", "P21", "P23D", "P65", "P77"}
"""What is about times, or a pace, that 100 ms blur."""


@pytest.mark.parametrize("select", few(["P03 and documented", "P27 and documented"], 1, "the gate has one such clause"))
def test_a_bench_that_gets_later_faster_than_time_passes_ends_a_case(select):
    def uncertainty_s(bench, since_ns):
        return OfTimes(0.01 + 2 * (bench.now_ns - since_ns) / 1e9)

    options = replace(OPTIONS, select=select)
    with patch.object(Bench, "uncertainty_s", uncertainty_s):
        cases = run_suites(options, make_provider(options)).cases
    assert {(case.verdict, case.cause) for case in cases} == {(Verdict.INCONCLUSIVE, EVER_LATER)}


BY_CHANCE = {"P45", "P46"}
"""Of a rover that loses what comes together by eleven bytes (P25), and so a frame now and then, whoever is late."""


@pytest.mark.exhaustive("each fault once more; the gate has what P2OS's clients show on a late bench")
def test_on_a_late_bench_the_other_clauses_find_it_too():
    with late_benches(0.1):
        verdicts = judge(OPTIONS, make_provider(OPTIONS), one_fault_for_each_clause())
    assert verdicts.open_clauses - BY_CHANCE == OF_TIME


@pytest.mark.exhaustive("each profile; the gate has what P2OS's clients show on a late bench")
@pytest.mark.parametrize(("late_s", "seed"), SEEDS)
def test_on_a_late_bench_no_right_rover_is_accused(late_s, seed):
    options = replace(OPTIONS, select="not [g2]")  # see `BY_CHANCE`
    with late_benches(late_s, seed):
        cases = run_suites(options, AtPort(make_provider(options))).cases
    assert {case.id: case.cause for case in cases if case.verdict in BLAMED} == {}


def test_the_page_names_each_faulty_rover():
    assert FOUND.keys() == {*DEFECTS, *(mutant.id for mutant in BY_HAND)}


def test_each_published_defect_is_found_by_a_promise():
    documented = {clause.id for clause in BOARD_CLAUSES if "documented" in clause.profiles}
    assert len(DEFECTS) >= 15
    for name in DEFECTS:
        assert set(FOUND[name]) & documented


@pytest.mark.exhaustive("each faulty rover against all clauses; the gate has one for each clause")
def test_the_page_is_up_to_date():
    assert {mutant.id: killers(run(mutant)) for mutant in all_mutants()} == FOUND


def put_a_rover(bench, port):
    DeviceActor(bench, RoverRobot(RoverSettings()), port, name="rover")


def test_of_a_rover_at_a_port_is_judged_what_can_be_seen_on_the_line():
    shared = Shared(bench_file=open_bench("rover-model"), timeout_scale=1.0, journal=Journal())
    options = replace(OPTIONS, select="P01 or P04D or P05 or P14 or P16D or P22D or P28D")
    verdicts = {
        case.id: case.verdict for case in run_suites(options, ForeignRoverInBenchTime(shared, put_a_rover)).cases
    }
    assert len(verdicts) > 7
    for name, verdict in verdicts.items():
        assert verdict is (Verdict.PASS if name.endswith("[documented]") else Verdict.NOT_APPLICABLE), name


def at_a_port(select, rover):
    """Run clauses against a rover of which only the line is seen; `rover` makes it."""

    def put(bench, port):
        DeviceActor(bench, rover(), port, name="rover")

    shared = Shared(bench_file=open_bench("rover-model"), timeout_scale=1.0, journal=Journal())
    return run_suites(replace(OPTIONS, select=f"documented and ({select})"), ForeignRoverInBenchTime(shared, put))


def test_wheels_that_run_out_slowly_are_right():
    assert at_a_port("P83", lambda: RoverRobot(RoverSettings(wheel_lag_s=0.5))).exit_code == 0


def test_of_a_right_rover_at_a_port_a_lost_link_is_shown_by_its_own_report():
    report = at_a_port("P24D or P62 or P63 or P76 or P80", lambda: RoverRobot(RoverSettings()))
    assert {clause.id: clause.by_own_report for clause in report.clauses} == {
        "P24D": ("duty",),
        "P62": ("duty", "wheels"),
        "P63": ("wheels",),
        "P76": ("duty",),
        "P80": ("duty",),
    }
    assert {case.cause for case in report.cases if case.verdict is not Verdict.NOT_APPLICABLE} == {""}
    shown = "5 must clauses shown by the target's own report alone: P24D, P62, P63, P76, P80"
    assert (report.exit_code, report.exit_meaning) == (0, f"all checks passed; {shown}")


@pytest.mark.parametrize(
    ("name", "clause_id"),
    [
        ("no-link-timeout", "P24D"),
        ("noise-counts-as-life", "P80"),
        ("lost-once", "P76"),
        ("setpoints-outlive-the-link", "P62"),
        *(
            pytest.param(*row, marks=pytest.mark.exhaustive("another fault of a clause of which the gate has one"))
            for row in (
                ("stops-late", "P24D"),
                ("stops-a-little-late", "P24D"),
                ("stops-one-pair", "P24D"),
                ("motors-come-back", "P24D"),
                ("requests-do-not-count-as-life", "P24D"),
                ("speed-control-outlives-the-link", "P62"),
            )
        ),
    ],
)
def test_of_a_rover_at_a_port_what_is_wrong_when_the_link_is_lost_is_found_by_its_own_report(name, clause_id):
    mutant = next(one for one in all_mutants() if one.id == name)
    with contextlib.ExitStack() as stack:
        for make in mutant.patches:
            stack.enter_context(make())
        report = at_a_port(clause_id, lambda: mutant.make(RoverSettings()))
    assert [clause.verdict for clause in report.clauses] == [Verdict.FAIL]
    assert report.exit_code == 1


def test_a_rover_that_does_not_show_its_throttles_shows_nothing_of_a_lost_link():
    class Mute(RoverRobot):
        def _report(self, report):
            said = super()._report(report)
            return replace(said, throttles=(0.0, 0.0)) if isinstance(said, MotionReport) else said

    report = at_a_port("P24D or P76 or P80", lambda: Mute(RoverSettings()))
    assert {clause.id: clause.verdict for clause in report.clauses} == {
        "P24D": Verdict.INCONCLUSIVE,
        "P76": Verdict.INCONCLUSIVE,
        "P80": Verdict.INCONCLUSIVE,
    }


def test_a_rover_as_published_is_judged_at_a_port_as_it_is_on_the_model():
    shared = Shared(bench_file=open_bench("rover-model"), timeout_scale=1.0, journal=Journal())

    def capabilities(profile):
        provider = ForeignRoverInBenchTime(shared, put_a_rover)
        with patch.object(type(provider), "_profile", profile):
            return provider.capabilities

    def planned(profile):
        provider = SimpleNamespace(capabilities=capabilities(profile), close=lambda: None)
        options = replace(OPTIONS, select=f"{profile} and (P24 or P24D or P28 or P62)")
        return {case.clause_ids[0]: (case.missing, case.by_own_report) for case in list_cases(options, provider)}

    assert planned("g2") == {"P24": ((), ()), "P28": ((), ("duty",))}
    assert planned("g0") == {"P24D": (("duty",), ())}  # it sends no 0x83


@pytest.mark.real_time("a rover behind a pseudo-terminal and pyserial; where the host is late, nothing is concluded")
def test_a_rover_behind_a_pty(tmp_path):
    target = TargetChoice(spec=f"serial:{tmp_path / 'rover'}@115200")
    options = replace(OPTIONS, targets=(target,), select="P01 and documented")
    provider = make_provider(options)
    with closing(PtyDoor(provider._scheduler, str(tmp_path / "rover"), Line(baud=115200), any_baud=True)) as door:
        put_a_rover(provider._bench, door)
        report = run_suites(options, provider)
        provider.close()
    assert [case.verdict for case in report.cases] in ([Verdict.PASS], [Verdict.INCONCLUSIVE])
