"""The suite of the dodger: the right program passes, the broken ones fail where they are broken."""

from __future__ import annotations

import pytest

from hilbench.bench_provider import make_provider
from hilbench.check import CheckOptions, Verdict, list_cases, run_suites
from hilbench.check.suites import SHIPPED_FOLDER
from hilbench.exit_codes import ExitCode
from hilbench.options import TargetChoice
from hilbench.suites._dodge_clauses import CLAUSES
from targets.firmware import image_path

pytestmark = pytest.mark.needs_bullet

SHORT = "each_sensor or wall"
FREE = "straight_on_wheels[1]"


def check(image="", select="", seed=0, act=run_suites):
    targets = (TargetChoice(name="brain.dodge", spec=f"bluepill:{image_path(image)}"),) if image else ()
    options = CheckOptions(bench="bluepill", suites=("bluepill-dodge",), select=select, seed=seed, targets=targets)
    provider = make_provider(options)
    try:
        return act(options, provider)
    finally:
        provider.close()


def failed(report):
    return {case.id.partition("/")[2]: case.cause for case in report.cases if case.verdict is not Verdict.PASS}


def test_what_it_looks_at_alone_passes():
    report = check(select=SHORT)
    assert failed(report) == {}
    assert report.exit_code == ExitCode.OK


def test_a_program_that_ignores_sensor_4_is_found_by_the_obstacle_before_it():
    report = check("broken-blind-4", SHORT)
    assert report.exit_code == ExitCode.VIOLATION
    assert list(failed(report)) == ["each_sensor_ahead_is_looked_at[4]"]
    assert "time that DD4 is high alone and both codes forward" in failed(report)["each_sensor_ahead_is_looked_at[4]"]


def test_a_program_that_never_leaves_a_turn_is_found_before_a_wall():
    report = check("broken-stuck-turn", SHORT)
    assert report.exit_code == ExitCode.VIOLATION
    assert list(failed(report)) == ["a_wall_is_turned_away_from"]
    assert "does not drive on within 8 s before a wall" in failed(report)["a_wall_is_turned_away_from"]


def test_a_robot_in_session_is_caught_again_after_a_reset_of_the_board():
    report = check(select="adrift")
    assert failed(report) == {}
    assert {clause.id for clause in report.clauses if clause.verdict is Verdict.PASS} == {"D07"}


@pytest.mark.parametrize("image", ["bad-lockup", "bad-iwdg-loop"])
def test_a_program_that_crashes_is_found_at_once(image):
    report = check(image, "straight_on_wheels")
    assert report.exit_code == ExitCode.VIOLATION
    verdicts = {clause.id: clause.verdict for clause in report.clauses}
    assert verdicts.pop("D04") is Verdict.FAIL
    assert set(verdicts.values()) == {Verdict.INCONCLUSIVE}


def test_every_clause_has_a_case_and_bench_times_are_said():
    cases = check(act=list_cases)
    cited = {clause.id for case in cases for clause in case.clauses}
    assert cited == {"G13", *(clause.id for clause in CLAUSES)}
    assert len({case.seed for case in cases}) == len(cases)
    assert (SHIPPED_FOLDER / "bluepill_dodge.py").is_file()


@pytest.mark.exhaustive("takes too long")
def test_every_clause_passes_and_equal_runs_are_equal():
    report = check()
    assert failed(report) == {}
    one = next(case for case in report.cases if case.id.endswith("each_sensor_ahead_is_looked_at[4]"))
    (again,) = check(select="each_sensor_ahead_is_looked_at[4]").cases
    assert again.case_hash == one.case_hash != ""


@pytest.mark.exhaustive("takes too long")
def test_the_right_program_passes_in_a_free_drive():
    assert failed(check(select=FREE)) == {}


@pytest.mark.parametrize(
    ("image", "clause"),
    [
        pytest.param("broken-blind-4", "D03", id="blind-4", marks=pytest.mark.exhaustive("takes too long")),
        pytest.param("broken-stuck-turn", "D02", id="stuck-turn", marks=pytest.mark.exhaustive("takes too long")),
    ],
)
def test_broken_programs_are_found_in_free_drives_too(image, clause):
    report = check(image, FREE)
    assert report.exit_code == ExitCode.VIOLATION
    assert {found.id for found in report.clauses if found.verdict is Verdict.FAIL} == {clause}
