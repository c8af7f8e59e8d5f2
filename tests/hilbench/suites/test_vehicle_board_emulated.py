"""The suite vehicle-board on the emulated NUCLEO-H753ZI: our firmware in three profiles, and with each defect."""

from __future__ import annotations

import pytest

from hilbench.check import CheckOptions, Verdict, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.systems.vehicle.provider import AttachedVehicleProvider
from hilbench.terminal.options import TargetChoice
from measure.mutants.defects_page import killers
from measure.mutants.vehicle.page import PAGE
from measure.mutants.vehicle.runs import image_of, run_image
from targets.firmware import image_names
from targets.robots.vehicle_interface import DEFECTS, PROFILE_NAMES
from tests.share import few

FOUND = PAGE.said_of_firmware()
QUICK = ("H2", "H7")


def check(select):
    options = CheckOptions(bench="vehicle", suites=("vehicle-board",), select=select)
    return run_suites(options, make_provider(options))


def causes(report):
    return {case.id: case.cause for case in report.cases if case.verdict is not Verdict.PASS}


@pytest.fixture(scope="module")
def begun():
    return check("VB04 and [v0]")


def test_our_image_begins(begun):
    assert causes(begun) == {}
    assert len(begun.cases) == 1


@pytest.mark.exhaustive("three images of our firmware; the gate has one of them, and golden traces of all")
def test_each_profile_has_its_image():
    begun = check("VB04 or (VB01 and [hardened])")
    assert causes(begun) == {}
    assert len(begun.cases) == len(PROFILE_NAMES)


def test_two_runs_are_the_same(begun):
    (again,) = check("VB04 and [v0]").cases
    assert again.case_hash in {case.case_hash for case in begun.cases}
    assert again.case_hash != ""


@pytest.mark.parametrize(
    "select",
    [
        pytest.param(select, marks=pytest.mark.exhaustive("more cases; the gate has one, and what finds two defects"))
        for select in ("VB32H", "VB01 or VB04H", "VB19 or VB22", "VB32")
    ],
)
def test_our_firmware_passes(select):
    assert causes(check(select)) == {}


@pytest.mark.parametrize("name", few(QUICK, 1, "the gate has another, and each clause against the model"))
def test_a_defect_of_the_firmware_is_found(name):
    clause, *_ = FOUND[name]
    assert killers(run_image(name, [clause])) == (clause,)


def test_every_image_with_a_defect_is_on_the_page():
    names = {name.removeprefix("vehicle-") for name in image_names() if name.startswith("vehicle-")}
    images = {name for name in names if not name.startswith("micro-ros")} - {"v0", "v1"}
    known = {image_of(name).stem.removeprefix("vehicle-") for name in DEFECTS}
    assert images == known
    assert {name for name, clauses in FOUND.items() if clauses} == {*DEFECTS}


@pytest.mark.exhaustive("minutes of bench time of emulated firmware; the gate has one case of each image")
def test_everything():
    report = check("")
    assert causes(report) == {}
    assert report.exit_code == 0
    assert len({clause for case in report.cases for clause in case.clause_ids}) >= 60


@pytest.mark.exhaustive("each image with a defect against what finds it in the model; the gate has two of them")
@pytest.mark.parametrize("name", DEFECTS)
def test_each_defect_of_the_firmware_is_found(name):
    clauses = FOUND[name]
    assert set(killers(run_image(name, clauses))) == {*clauses}


def test_ports_in_the_place_of_the_board():
    targets = tuple(TargetChoice(name=line, spec="serial:/dev/none-" + line) for line in ("simulator", "stack"))
    provider = make_provider(CheckOptions(bench="vehicle", targets=targets))
    assert isinstance(provider, AttachedVehicleProvider)
    assert provider.capabilities == {"CARLA", "board", "stack", "program 'hardened'"}
    provider.close()
