"""The suite vehicle-board: the right board passes in every profile, and every clause has a board that fails it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hilbench.check import CheckOptions, Verdict, list_cases, run_suites
from hilbench.check.bench_provider import make_provider
from measure.mutants.defects_page import killers
from measure.mutants.each_its_own import judge, one_for_each
from measure.mutants.late import BLAMED, AtPort, late_benches
from measure.mutants.vehicle.page import PAGE
from measure.mutants.vehicle.published import CURES
from measure.mutants.vehicle.runs import fault, run
from measure.mutants.vehicle.tables import BY_HAND, all_mutants
from protocols.carla.clauses import BOARD_CLAUSES
from targets.robots.vehicle_interface import DEFECTS

OPTIONS = CheckOptions(bench="vehicle-model", suites=("vehicle-board",))
FOUND = PAGE.said()


@pytest.fixture(scope="module")
def report():
    return run_suites(OPTIONS, make_provider(OPTIONS))


def test_each_clause_is_cited_by_one_function_in_each_of_its_profiles():
    planned = list_cases(OPTIONS, make_provider(OPTIONS))
    cited = [(case.clauses[0].id, case.setup.program) for case in planned]
    assert sorted(cited) == sorted((clause.id, profile) for clause in BOARD_CLAUSES for profile in clause.profiles)
    functions = {(case.clauses[0].id, case.id.partition("[")[0]) for case in planned}
    assert len(functions) == len(BOARD_CLAUSES) >= 60


def long_clauses():
    """The clauses of the hardened board whose case goes on for more than five seconds of bench time."""
    hardened = replace(OPTIONS, select="[hardened]")
    cases = list_cases(hardened, make_provider(hardened))
    return {case.clause_ids[0] for case in cases if case.bench_time_s > 5.0}


@pytest.mark.slow("most of what is asked of the hardened board, once; two minutes of bench time")
def test_the_hardened_board_passes_what_is_short():
    options = replace(OPTIONS, select=f"[hardened] and not ({' or '.join(long_clauses())})")
    report = run_suites(options, make_provider(options))
    assert {case.id: case.cause for case in report.cases if case.verdict is not Verdict.PASS} == {}
    assert report.exit_code == 0
    hardened = {clause.id for clause in BOARD_CLAUSES if "hardened" in clause.profiles}
    assert {case.clause_ids[0] for case in report.cases} == hardened - long_clauses()


@pytest.mark.exhaustive("all cases of all profiles; the gate has those of the hardened board that take five seconds")
def test_the_board_passes_in_every_profile(report):
    assert {case.id: case.cause for case in report.cases if case.verdict is not Verdict.PASS} == {}
    assert report.exit_code == 0


@pytest.mark.exhaustive("all profiles together, which take long; the unit tests of the protocol go through its table")
def test_every_edge_of_the_control_task_is_taken(report):
    covered = {coverage.peer: coverage for coverage in report.observed.coverage}
    assert covered["control task"].edges_missed == ()
    assert covered["modes of the board"].states_missed == ()


def one_fault_for_each_clause():
    mutants, clause_ids = {mutant.id: mutant for mutant in all_mutants()}, [clause.id for clause in BOARD_CLAUSES]
    return [fault(mutants[name], clause_id) for clause_id, name in one_for_each(clause_ids, FOUND)]


@pytest.mark.slow("each clause of the board and a fault that it has to find")
def test_each_clause_finds_a_faulty_board():
    verdicts = judge(OPTIONS, make_provider(OPTIONS), one_fault_for_each_clause())
    assert verdicts.not_found == {}
    assert verdicts.found_by == {clause.id for clause in BOARD_CLAUSES}


OF_TIME = {"VB05", "VB05H", "VB06", "VB08", "VB14", "VB30H", "VB40", "VB40H", "VB44", "VB45", "VB57", "VB57H", "VB64"}
"""What is about times that 100 ms blur: which of the frames that come 100 ms apart has which cause."""


@pytest.mark.exhaustive("each fault once more; the gate has what P2OS's clients show on a late bench")
def test_on_a_late_bench_the_other_clauses_find_it_too():
    with late_benches(0.1):
        verdicts = judge(OPTIONS, make_provider(OPTIONS), one_fault_for_each_clause())
    assert verdicts.open_clauses == OF_TIME


@pytest.mark.exhaustive("each profile; the gate has what P2OS's clients show on a late bench")
@pytest.mark.parametrize(("late_s", "seed"), [(0.03, 1), (0.1, 0), (0.1, 2), (0.2, 1), (0.4, 2)])
def test_on_a_late_bench_no_right_board_is_accused(late_s, seed):
    with late_benches(late_s, seed):
        cases = run_suites(OPTIONS, AtPort(make_provider(OPTIONS))).cases
    assert {case.id: case.cause for case in cases if case.verdict in BLAMED} == {}


def test_the_page_names_each_faulty_board():
    assert FOUND.keys() == {*DEFECTS, *(mutant.id for mutant in (*CURES, *BY_HAND))}


def test_each_published_defect_is_found_by_what_is_asked_instead():
    asked = {clause.id for clause in BOARD_CLAUSES if "hardened" in clause.profiles}
    assert len(DEFECTS) >= 12
    for name in DEFECTS:
        assert set(FOUND[name]) & asked


@pytest.mark.exhaustive("each faulty board against all clauses; the gate has one for each clause")
def test_the_page_is_up_to_date():
    assert {mutant.id: killers(run(mutant)) for mutant in all_mutants()} == FOUND
