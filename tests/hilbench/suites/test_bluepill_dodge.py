"""The suite of the dodger: the right program passes, the broken ones fail where they are broken."""

from __future__ import annotations

import pytest

from hilbench.benchfile.suites import SHIPPED_FOLDER
from hilbench.check import CheckOptions, Verdict, list_cases, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.exit_codes import ExitCode
from hilbench.systems.bluepill.dodge_clauses import CLAUSES
from hilbench.terminal.options import TargetChoice
from targets.firmware import image_path

pytestmark = pytest.mark.needs_physics

SHORT = "each_sensor or wall"
FREE = "straight_on_wheels[1]"

FOUND = {"D02", "D03", "D04", "D06"}
"""D06 by sonars that see nothing, in `test_no_effect`."""
FIND_NOTHING = {"G13", "D01", "D05", "D07"}
"""What takes minutes of free driving to violate, or no program here does: for these we have no mistake."""


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


def found_by(report):
    """The clauses that a broken program violates."""
    assert report.exit_code == ExitCode.VIOLATION
    return {clause.id for clause in report.clauses if clause.verdict is Verdict.FAIL}


def test_what_it_looks_at_alone_passes():
    report = check(select=SHORT)
    assert failed(report) == {}
    assert report.exit_code == ExitCode.OK


def test_a_program_that_ignores_sensor_4_is_found_by_the_obstacle_before_it():
    report = check("broken-blind-4", "each_sensor")
    assert found_by(report) == {"D03"}
    assert list(failed(report)) == ["each_sensor_ahead_is_looked_at[4]"]
    assert "time that DD4 is high alone and both codes forward" in failed(report)["each_sensor_ahead_is_looked_at[4]"]


def test_a_program_that_never_leaves_a_turn_is_found_before_a_wall():
    report = check("broken-stuck-turn", "wall")
    assert found_by(report) == {"D02"}
    assert "does not drive on within 8 s before a wall" in failed(report)["a_wall_is_turned_away_from"]


@pytest.mark.exhaustive("a robot drives for 24 s of bench time; the gate has G22, a reset with an adapter and a robot")
def test_a_robot_in_session_is_caught_again_after_a_reset_of_the_board():
    report = check(select="adrift")
    assert failed(report) == {}
    assert {clause.id for clause in report.clauses if clause.verdict is Verdict.PASS} == {"D07"}


@pytest.mark.parametrize("image", ["bad-lockup", "bad-iwdg-loop"])
def test_a_program_that_crashes_is_found_at_once(image):
    report = check(image, FREE)
    assert found_by(report) == {"D04"}
    assert {clause.verdict for clause in report.clauses if clause.id != "D04"} == {Verdict.INCONCLUSIVE}


def test_every_clause_finds_a_broken_program_or_is_listed_as_finding_nothing():
    assert {"G13", *(clause.id for clause in CLAUSES)} == FOUND | FIND_NOTHING


def test_every_clause_has_a_case_and_bench_times_are_said():
    cases = check(act=list_cases)
    cited = {clause.id for case in cases for clause in case.clauses}
    assert cited == {"G13", *(clause.id for clause in CLAUSES)}
    assert len({case.seed for case in cases}) == len(cases)
    assert (SHIPPED_FOLDER / "bluepill_dodge.py").is_file()


@pytest.mark.exhaustive("thirteen minutes of bench time; the gate looks at each thing alone")
def test_every_clause_passes_and_equal_runs_are_equal():
    report = check()
    assert failed(report) == {}
    one = next(case for case in report.cases if case.id.endswith("each_sensor_ahead_is_looked_at[4]"))
    (again,) = check(select="each_sensor_ahead_is_looked_at[4]").cases
    assert again.case_hash == one.case_hash != ""


@pytest.mark.exhaustive("three minutes of bench time each; in the gate both are found in a scene of their own")
@pytest.mark.parametrize(("image", "clause"), [("broken-blind-4", "D03"), ("broken-stuck-turn", "D02")])
def test_broken_programs_are_found_in_free_drives_too(image, clause):
    assert found_by(check(image, FREE)) == {clause}
