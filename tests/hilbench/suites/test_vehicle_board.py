"""The suite vehicle-board: the right board passes in every profile."""

from __future__ import annotations

import pytest

from hilbench.bench_provider import make_provider
from hilbench.check import CheckOptions, Verdict, list_cases, run_suites
from protocols.carla.clauses import BOARD_CLAUSES

OPTIONS = CheckOptions(bench="vehicle-model", suites=("vehicle-board",))


@pytest.fixture(scope="module")
def report():
    return run_suites(OPTIONS, make_provider(OPTIONS))


def test_each_clause_is_cited_by_one_function_in_each_of_its_profiles():
    planned = list_cases(OPTIONS, make_provider(OPTIONS))
    cited = [(case.clauses[0].id, case.setup.program) for case in planned]
    assert sorted(cited) == sorted((clause.id, profile) for clause in BOARD_CLAUSES for profile in clause.profiles)
    functions = {(case.clauses[0].id, case.id.partition("[")[0]) for case in planned}
    assert len(functions) == len(BOARD_CLAUSES) >= 60


def test_the_board_passes_in_every_profile(report):
    assert {case.id: case.cause for case in report.cases if case.verdict is not Verdict.PASS} == {}
    assert report.exit_code == 0


def test_every_edge_of_the_control_task_is_taken(report):
    covered = {coverage.peer: coverage for coverage in report.observed.coverage}
    assert covered["control task"].edges_missed == ()
    assert covered["modes of the board"].states_missed == ()
