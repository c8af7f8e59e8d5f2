"""The suite pkt-board: the right rover passes in every profile, and every clause has a rover that fails it."""

from __future__ import annotations

from contextlib import closing

import pytest

from hilbench.bench_provider import make_provider
from hilbench.check import CheckOptions, Verdict, list_cases, run_suites
from hilbench.devices import DeviceActor
from hilbench.links import Line, PtyDoor
from hilbench.options import TargetChoice
from protocols.pkt.clauses import BOARD_CLAUSES
from targets.robots.rover import DEFECTS, RoverRobot, RoverSettings
from tests.mutants.defects_page import killers
from tests.mutants.rover import BY_HAND, all_mutants, on_the_page, run

OPTIONS = CheckOptions(bench="rover-model", suites=("pkt-board",))
FOUND = on_the_page()


@pytest.fixture(scope="module")
def planned():
    return list_cases(OPTIONS, make_provider(OPTIONS))


@pytest.fixture(scope="module")
def report():
    return run(None)


def test_each_clause_is_cited_by_one_function_in_each_of_its_profiles(planned):
    cited = [(case.clauses[0].id, case.setup.program) for case in planned]
    assert sorted(cited) == sorted((clause.id, profile) for clause in BOARD_CLAUSES for profile in clause.profiles)
    functions = {(case.clauses[0].id, case.id.partition("[")[0]) for case in planned}
    assert len(functions) == len(BOARD_CLAUSES) >= 60


def test_the_rover_passes_in_every_profile(report):
    assert {case.id: case.cause for case in report.cases if case.verdict is not Verdict.PASS} == {}
    assert report.exit_code == 0


def test_two_runs_are_the_same(report):
    assert run(None, "P26").run_hash == run(None, "P26").run_hash
    again = {case.id: case.case_hash for case in run(None, "P30").cases}
    assert again.items() <= {case.id: case.case_hash for case in report.cases}.items()


@pytest.mark.parametrize("mutant", all_mutants(), ids=lambda mutant: mutant.id)
def test_a_faulty_rover_is_found(mutant):
    """By the first clause that the page names for it."""
    clause, *_ = FOUND[mutant.id]
    assert killers(run(mutant, clause)) == (clause,)


def test_each_clause_finds_something():
    found = {clause for clauses in FOUND.values() for clause in clauses}
    assert {clause.id for clause in BOARD_CLAUSES} - found == set()
    assert FOUND.keys() == {*DEFECTS, *(mutant.id for mutant in BY_HAND)}


def test_each_published_defect_is_found_by_a_promise():
    documented = {clause.id for clause in BOARD_CLAUSES if "documented" in clause.profiles}
    assert len(DEFECTS) >= 15
    for name in DEFECTS:
        assert set(FOUND[name]) & documented


@pytest.mark.exhaustive("takes too long")
def test_the_page_is_up_to_date():
    assert {mutant.id: killers(run(mutant)) for mutant in all_mutants()} == FOUND


def test_a_rover_behind_a_pty(tmp_path):
    """Through a pseudo-terminal and pyserial, in real time: what can be seen on the line alone is judged."""
    options = CheckOptions(
        bench="rover-model",
        suites=("pkt-board",),
        targets=(TargetChoice(spec=f"serial:{tmp_path / 'rover'}@115200"),),
        select="P01 or P04D or P05 or P14 or P16D or P22D or P28D",
    )
    provider = make_provider(options)
    scheduler = provider._scheduler
    with closing(PtyDoor(scheduler, str(tmp_path / "rover"), Line(baud=115200), any_baud=True)) as door:
        DeviceActor(provider._bench, RoverRobot(RoverSettings()), door, name="rover")
        report = run_suites(options, provider)
        provider.close()
    verdicts = {case.id.partition("/")[2]: case.verdict for case in report.cases}
    assert {name: verdict for name, verdict in verdicts.items() if name.endswith("[documented]")} == dict.fromkeys(
        [name for name in verdicts if name.endswith("[documented]")], Verdict.PASS
    )
    assert {verdict for name, verdict in verdicts.items() if not name.endswith("[documented]")} == {
        Verdict.NOT_APPLICABLE
    }
