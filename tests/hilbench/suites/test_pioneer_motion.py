"""The suite of motion on the virtual benches: it passes, it is as long as it says, and equal runs are equal."""

from __future__ import annotations

import math

import pytest

from hilbench.bench_provider import make_provider
from hilbench.check import CheckOptions, Verdict, list_cases, run_suites
from hilbench.exit_codes import ExitCode
from protocols.p2os.motion_clauses import MOTION_CLAUSES

NEEDS_A_SCENE = {"M13", "M14", "M15", "M16", "M17", "M21", "M22"}
MOST_BENCH_TIME_S = 200


def check(bench, select="", seed=0, act=run_suites):
    options = CheckOptions(bench=bench, suites=("pioneer-motion",), select=select, seed=seed)
    provider = make_provider(options)
    try:
        return act(options, provider)
    finally:
        provider.close()


def causes(report):
    return {case.id: case.cause for case in report.cases if case.cause}


@pytest.fixture(scope="module")
def on_bullet():
    return check("pioneer")


@pytest.fixture(scope="module")
def on_the_plane():
    return check("pioneer-plane")


@pytest.mark.needs_bullet
class TestOnBullet:
    def test_every_clause_passes(self, on_bullet):
        assert causes(on_bullet) == {}
        assert on_bullet.exit_code == ExitCode.OK
        assert {clause.id for clause in on_bullet.clauses} == {clause.id for clause in MOTION_CLAUSES}
        assert {clause.verdict for clause in on_bullet.clauses} == {Verdict.PASS}

    def test_it_takes_as_long_as_it_says(self, on_bullet, require_declared_times):
        assert on_bullet.bench_time_s <= MOST_BENCH_TIME_S
        require_declared_times(on_bullet, check("pioneer", act=list_cases))

    def test_every_clause_records_figures(self, on_bullet):
        for clause in on_bullet.clauses:
            cases = [case for case in on_bullet.cases if clause.id in case.clause_ids]
            figures = [measure for case in cases for measure in case.measures if "came after" not in measure.name]
            assert figures, clause.id
            assert all(math.isfinite(measure.value) for measure in figures)

    def test_equal_runs_have_equal_hashes(self, on_bullet):
        again = check("pioneer", select="M05 or M13 or M16")
        hashes = {case.id: case.case_hash for case in on_bullet.cases}
        assert len(again.cases) == 3
        assert {case.id: case.case_hash for case in again.cases}.items() <= hashes.items()

    def test_another_seed_is_another_room_and_no_other_verdict(self, on_bullet):
        other = check("pioneer", select="M16", seed=7)
        assert causes(other) == {}
        (case,) = other.cases
        assert case.case_hash not in {one.case_hash for one in on_bullet.cases}


class TestOnThePlane:
    def test_what_needs_no_scene_passes(self, on_the_plane):
        passed = {clause.id for clause in on_the_plane.clauses if clause.verdict is Verdict.PASS}
        assert passed == {clause.id for clause in MOTION_CLAUSES} - NEEDS_A_SCENE
        assert on_the_plane.exit_code == ExitCode.OK

    def test_the_rest_is_not_applicable(self, on_the_plane):
        left_out = {clause.id for clause in on_the_plane.clauses if clause.verdict is Verdict.NOT_APPLICABLE}
        assert left_out == NEEDS_A_SCENE
        missing = {case.clause_ids[0]: set(case.missing) for case in on_the_plane.cases if case.missing}
        assert all("scene" in names for names in missing.values())
