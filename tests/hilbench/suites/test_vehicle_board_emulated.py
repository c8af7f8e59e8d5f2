"""The suite vehicle-board on the emulated NUCLEO-H753ZI: our firmware in three profiles, and with each defect."""

from __future__ import annotations

import pytest

from hilbench.bench_provider import make_provider
from hilbench.check import CheckOptions, Verdict, run_suites
from hilbench.options import TargetChoice
from hilbench.vehicle.provider import AttachedVehicleProvider
from targets.firmware import image_names
from targets.robots.vehicle_interface import DEFECTS
from tests.mutants.defects_page import killers
from tests.mutants.vehicle.page import PAGE
from tests.mutants.vehicle.runs import image_of, run_image

FOUND = PAGE.said_of_firmware()
QUICK = ("H2", "H7", "V1", "axes-swapped")


def check(select):
    options = CheckOptions(bench="vehicle", suites=("vehicle-board",), select=select)
    return run_suites(options, make_provider(options))


@pytest.mark.parametrize("select", ["VB01", "VB04 or VB04H", "VB19 or VB22", "VB32 or VB32H"])
def test_each_profile_has_its_image(select):
    report = check(select)
    assert {case.id: case.cause for case in report.cases if case.verdict is not Verdict.PASS} == {}


def test_two_runs_are_the_same():
    one, other = check("VB12 and [hardened]"), check("VB12 and [hardened]")
    assert one.run_hash == other.run_hash != ""


@pytest.mark.parametrize("name", QUICK)
def test_a_defect_of_the_firmware_is_found(name):
    clause, *_ = FOUND[name]
    assert killers(run_image(name, [clause])) == (clause,)


def test_every_image_with_a_defect_is_on_the_page():
    images = {name.removeprefix("vehicle-") for name in image_names() if name.startswith("vehicle-")} - {"v0", "v1"}
    known = {image_of(name).stem.removeprefix("vehicle-") for name in DEFECTS}
    assert images == known
    assert {name for name, clauses in FOUND.items() if clauses} == {*DEFECTS}


@pytest.mark.exhaustive("takes too long")
def test_everything():
    report = check("")
    assert {case.id: case.cause for case in report.cases if case.verdict is not Verdict.PASS} == {}
    assert report.exit_code == 0
    assert len({clause for case in report.cases for clause in case.clause_ids}) >= 60


@pytest.mark.exhaustive("takes too long")
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
