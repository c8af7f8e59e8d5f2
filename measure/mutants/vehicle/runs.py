"""Runs the suite ``vehicle-board`` against a faulty board, or a faulty image on the emulated one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from hilbench.bench.shared import Shared
from hilbench.benchfile.reader import open_bench
from hilbench.check import CheckOptions, run_suites
from hilbench.check.results import Report
from hilbench.journal import Journal
from hilbench.mcu.board_provider import BoardProvider
from hilbench.systems.vehicle.provider import VehicleProvider
from hilbench.terminal.options import TargetChoice
from measure.mutants.each_its_own import Fault
from measure.mutants.vehicle.mutant import SLOW, VehicleMutant
from protocols.carla.clauses import BOARD_CLAUSES
from targets.firmware import image_path

SHOWN = 1
"""So many of the clauses that find a defect in the model are run on the emulated board."""


def run(mutant: VehicleMutant | None, select: str = "") -> Report:
    """Run the cases of a mutant's profile against it; those of all profiles against the right board for None."""
    shared = Shared(bench_file=open_bench("vehicle-model"), timeout_scale=1.0, journal=Journal())
    provider = VehicleProvider(shared, make_vehicle=mutant.make) if mutant is not None else VehicleProvider(shared)
    words = [word for word in (f"[{mutant.profile}]" if mutant is not None else "", select) if word]
    if mutant is not None and not select:
        words.append(f"({' or '.join(mutant.about)})" if mutant.about else f"not ({' or '.join(SLOW)})")
    options = CheckOptions(bench="vehicle-model", suites=("vehicle-board",), select=" and ".join(words))
    return run_suites(options, provider)


def fault(mutant: VehicleMutant, clause_id: str) -> Fault:
    """A mutant as something that a clause has to find."""
    shared = Shared(bench_file=open_bench("vehicle-model"), timeout_scale=1.0, journal=Journal())
    open_case = VehicleProvider(shared, make_vehicle=mutant.make).open_case
    return Fault(name=mutant.id, clause_id=clause_id, select=f"[{mutant.profile}]", open_case=open_case)


def image_of(defect: str) -> Path:
    """Our firmware with a defect; there need not be one."""
    return image_path(f"vehicle-{'flag-clash' if defect == 'V1' else defect.lower()}")


def run_image(defect: str, clauses: Sequence[str]) -> Report:
    """Run some clauses of `hardened` on the emulated board, with the image that has this defect."""
    shared = Shared(bench_file=open_bench("vehicle"), timeout_scale=1.0, journal=Journal())
    choice = TargetChoice(name="brain.hardened", spec=f"nucleo-h753zi:{image_of(defect)}")
    select = f"[hardened] and ({' or '.join(clauses)})"
    options = CheckOptions(bench="vehicle", suites=("vehicle-board",), select=select)
    return run_suites(options, BoardProvider(shared, [choice]))


def to_run(clauses: Iterable[str]) -> tuple[str, ...]:
    """Which of the clauses that find a defect in the model are run on the emulated board."""
    return tuple(sorted(clauses, key=lambda clause: (clause in SLOW, clause)))[:SHOWN]


def asked(mutant: VehicleMutant) -> set[str]:
    """The clauses that a board is run against."""
    held = {clause.id for clause in BOARD_CLAUSES if mutant.profile in clause.profiles}
    return held & {*mutant.about} if mutant.about else held - {*SLOW}
