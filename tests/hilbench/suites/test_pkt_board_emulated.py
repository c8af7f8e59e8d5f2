"""The suite pkt-board on the emulated NUCLEO-F767ZI: firmware, motors, tachometers, IMU and GPS."""

from __future__ import annotations

import pytest

from hilbench.check import CheckOptions, Verdict, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.systems.rover.provider import AttachedRoverProvider
from hilbench.terminal.options import TargetChoice
from measure.mutants.defects_page import killers
from measure.mutants.rover import PAGE, has_image, run_image
from targets.robots.rover import DEFECTS
from tests.share import few

pytestmark = pytest.mark.needs_physics

FOUND = PAGE.said_of_firmware()
QUICK = ("no-0x81", "no-resync", "throttle-unchecked", "led-shared")


def check(select):
    options = CheckOptions(bench="rover", suites=("pkt-board",), select=select)
    return run_suites(options, make_provider(options))


one_more = pytest.mark.exhaustive("one more case of each image; all cases are run, too")


@pytest.mark.parametrize(
    "select",
    [
        "P20 and documented",
        *(
            pytest.param(select, marks=one_more)
            for select in (
                "P20",
                "(P26 or P42D) and documented",
                "P01 or P13",
                "P11 or P11D",
                "P29D or P41D",
                "P33 or P34",
            )
        ),
    ],
)
def test_each_profile_has_its_image(select):
    report = check(select)
    assert {case.id: case.cause for case in report.cases if case.verdict is not Verdict.PASS} == {}


@pytest.mark.exhaustive("the gate has equal runs of the model, and traces of images")
def test_two_runs_are_the_same():
    one, other = check("P19 and documented"), check("P19 and documented")
    assert one.run_hash == other.run_hash != ""


@pytest.mark.parametrize("name", few(QUICK, 1, "the gate has another, and each clause against the model"))
def test_a_defect_of_the_firmware_is_found(name):
    clause, *_ = FOUND[name]
    assert killers(run_image(name, [clause])) == (clause,)


def test_each_defect_with_an_image_is_found_in_the_firmware():
    emulated = {name for name in DEFECTS if has_image(name)}
    assert len(emulated) >= 15
    assert {name for name, clauses in FOUND.items() if clauses not in (("",), ("no image",))} >= emulated


@pytest.mark.exhaustive("minutes of bench time of emulated firmware; the gate has a case of each image")
def test_everything():
    report = check("")
    assert {case.id: case.cause for case in report.cases if case.verdict is not Verdict.PASS} == {}
    assert report.exit_code == 0
    assert len({clause for case in report.cases for clause in case.clause_ids}) >= 60


def test_a_port_in_the_place_of_the_board():
    options = CheckOptions(bench="rover", targets=(TargetChoice(spec="serial:/dev/none@115200"),))
    provider = make_provider(options)
    assert isinstance(provider, AttachedRoverProvider)
    assert provider.capabilities == {"PKT!", "server", "reopen", "motion reports", "program 'documented'"}
    provider.close()
