"""The suite vehicle-host: our simulator's side passes in every profile; a faulty one, and a foreign one, is judged."""

from __future__ import annotations

import re
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from hilbench.bench_provider import make_provider
from hilbench.check import CheckOptions, Verdict, list_cases, run_suites
from hilbench.config import open_bench
from hilbench.journal import Journal
from hilbench.options import TargetChoice
from hilbench.shared import Shared
from hilbench.vehicle_provider import VehicleProvider
from protocols.carla.clauses import HOST_CLAUSES
from targets.robots.car_host import DEFECTS, CarHost

ROW = re.compile(r"^\| `(?P<name>[\w-]+)` \| [^|]+ \| (?P<clauses>VS[^|]+) \|$", re.MULTILINE)
PAGE = (Path(__file__).parents[3] / "docs" / "vehicle.md").read_text(encoding="utf-8")
FOUND = {row["name"]: tuple(row["clauses"].split(", ")) for row in ROW.finditer(PAGE)}
FOREIGN = """
import sys, time
import serial
port = serial.Serial(sys.argv[1], 921600)
while True:
    port.write(bytes.fromhex("23410000000042000000004300000000440000000024" + sys.argv[2]))
    time.sleep(0.05)
"""

OPTIONS = CheckOptions(bench="vehicle-model", suites=("vehicle-host",))


@pytest.fixture(scope="module")
def report():
    return run_suites(OPTIONS, make_provider(OPTIONS))


def test_each_clause_is_cited_by_one_function_in_each_of_its_profiles():
    planned = list_cases(OPTIONS, make_provider(OPTIONS))
    cited = [(case.clauses[0].id, case.setup.program) for case in planned]
    assert sorted(cited) == sorted((clause.id, profile) for clause in HOST_CLAUSES for profile in clause.profiles)
    functions = {(case.clauses[0].id, case.id.partition("[")[0]) for case in planned}
    assert len(functions) == len(HOST_CLAUSES) >= 40


def test_the_simulator_s_side_passes_in_every_profile(report):
    assert {case.id: case.cause for case in report.cases if case.verdict is not Verdict.PASS} == {}
    assert report.exit_code == 0


def test_every_edge_of_its_table_is_taken(report):
    (coverage,) = report.observed.coverage
    assert coverage.edges_missed == ()


def test_the_page_names_each_defect():
    assert FOUND.keys() == DEFECTS.keys()


@pytest.mark.parametrize("name", DEFECTS)
def test_a_faulty_one_is_found(name):
    """By the first clause that the page names for it."""

    def make(settings, power_on_ns):
        return CarHost(replace(settings, defects=(name,)), power_on_ns=power_on_ns)

    shared = Shared(bench_file=open_bench("vehicle-model"), timeout_scale=1.0, journal=Journal())
    clause, *_ = FOUND[name]
    options = replace(OPTIONS, select=f"[hardened] and {clause}")
    (case,) = run_suites(options, VehicleProvider(shared, make_host=make)).cases
    assert case.verdict is Verdict.FAIL


@pytest.mark.parametrize(("behind", "verdict"), [("", Verdict.PASS), ("00", Verdict.FAIL)])
def test_a_foreign_one_is_judged_by_its_statuses(tmp_path, behind, verdict):
    program = tmp_path / "bridge.py"
    program.write_text(FOREIGN)
    target = TargetChoice(spec=f"exec:{sys.executable} {program} {{pty}} '{behind}'")
    options = replace(OPTIONS, targets=(target,), select="[hardened] and (VS13 or VS14)")
    cases = run_suites(options, make_provider(options)).cases
    assert {case.clause_ids[0]: case.verdict for case in cases} == {"VS13": verdict, "VS14": Verdict.NOT_APPLICABLE}
