"""The suite of motion on the virtual benches: it passes, it is as long as it says, and equal runs are equal."""

from __future__ import annotations

import math

import pytest

from hilbench.check import CheckOptions, Verdict, list_cases, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.exit_codes import ExitCode
from protocols.p2os.motion_clauses import MOTION_CLAUSES

NEEDS_A_SCENE = {"M13", "M14", "M15", "M16", "M17", "M21", "M22"}
WITH_FULL_PHYSICS = NEEDS_A_SCENE | {"M19"}  # which takes less time on the plane
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
def in_scenes():
    return check("pioneer", select=" or ".join(WITH_FULL_PHYSICS))


@pytest.fixture(scope="module")
def on_the_plane():
    return check("pioneer-plane")


@pytest.mark.slow("all that is asked of the motion of a robot, once; two minutes of bench time")
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


@pytest.mark.needs_physics
def test_in_a_scene_it_passes(on_the_plane):
    report = check("pioneer", select="M13 or M19")
    assert causes(report) == {}
    assert {clause.id: clause.verdict for clause in report.clauses} == dict.fromkeys(("M13", "M19"), Verdict.PASS)
    again = check("pioneer-plane", select="M05").cases
    assert {case.case_hash for case in again} <= {case.case_hash for case in on_the_plane.cases}


@pytest.mark.needs_physics
@pytest.mark.exhaustive("eight clauses with full physics; the gate has two, and in test_mutants a mutant of each")
class TestInScenes:
    def test_what_needs_a_scene_passes(self, in_scenes):
        assert causes(in_scenes) == {}
        assert in_scenes.exit_code == ExitCode.OK
        assert {clause.id for clause in in_scenes.clauses} == WITH_FULL_PHYSICS

    def test_it_takes_as_long_as_it_says(self, in_scenes, on_the_plane, require_declared_times):
        clauses = [*in_scenes.clauses, *(one for one in on_the_plane.clauses if one.id not in WITH_FULL_PHYSICS)]
        declared = check("pioneer", act=list_cases)
        require_declared_times(clauses, declared)
        assert sum(case.bench_time_s for case in declared) <= MOST_BENCH_TIME_S

    def test_every_clause_records_figures(self, in_scenes, on_the_plane):
        figures = {}
        for case in (*in_scenes.cases, *on_the_plane.cases):
            of_case = [measure for measure in case.measures if "came after" not in measure.name]
            assert all(math.isfinite(measure.value) for measure in of_case)
            figures.setdefault(case.clause_ids[0], []).extend(of_case)
        assert all(figures.values()), figures
        assert figures.keys() == {clause.id for clause in MOTION_CLAUSES}

    def test_equal_runs_have_equal_hashes(self, in_scenes, on_the_plane):
        hashes = {case.id: case.case_hash for case in (*on_the_plane.cases, *in_scenes.cases)}
        again = [*check("pioneer", select="M19").cases, *check("pioneer-plane", select="M05").cases]
        assert len(again) == 2
        assert {case.id: case.case_hash for case in again}.items() <= hashes.items()

    def test_another_seed_is_another_room_and_no_other_verdict(self, in_scenes):
        other = check("pioneer", select="M16", seed=7)
        assert causes(other) == {}
        (case,) = other.cases
        assert case.case_hash not in {one.case_hash for one in in_scenes.cases}


@pytest.mark.needs_physics
@pytest.mark.exhaustive("on PyBullet throughout; the gate has it on the plane, and in scenes what needs one")
def test_every_clause_passes_with_full_physics(require_declared_times):
    report = check("pioneer")
    assert causes(report) == {}
    assert {clause.verdict for clause in report.clauses} == {Verdict.PASS}
    assert {clause.id for clause in report.clauses} == {clause.id for clause in MOTION_CLAUSES}
    require_declared_times(report.clauses, check("pioneer", act=list_cases))
