"""The page ``docs/vehicle-defects.md``: which clauses find which fault."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from measure.mutants.defects_page import DefectsPage, Found
from measure.mutants.vehicle.mutant import SLOW
from measure.mutants.vehicle.published import CURES
from measure.mutants.vehicle.tables import BY_HAND
from protocols.carla.clauses import BOARD_CLAUSES
from targets.robots.vehicle_interface import DEFECTS

PAGE = DefectsPage(path=Path(__file__).parents[3] / "docs" / "vehicle-defects.md", clauses=BOARD_CLAUSES)


def page(found: Found, firmware: Found) -> str:
    """The page of the table, from the clauses that find each mutant, as a model and in the firmware."""
    return "\n".join([*_head(), *_table(found, firmware), *PAGE.by_clause(found)]) + "\n"


def _head() -> Iterator[str]:
    yield "# Defects of the vehicle interface, and the clauses that find them\n"
    yield "Made by `python -m measure.mutants.vehicle`. Do not edit.\n"
    yield "Each defect of the published firmwares is put back by itself into a board that is otherwise as we would"
    yield "ship it (a behavioural model: `defects` in the settings of the bench `vehicle-model`), and the suite"
    yield "`vehicle-board` is run against it. Then some of the clauses that found it are run against our firmware with"
    yield "the same defect, on the emulated NUCLEO-H753ZI (images `vehicle-DEFECT`). A star marks a clause that says"
    yield f"*should*. Left out, for they take 20 s and more: {', '.join(SLOW)}, but for `H9`, which they are about.\n"


def _table(found: Found, firmware: Found) -> Iterator[str]:
    yield from PAGE.published(DEFECTS.values(), found, firmware)
    yield "\n## The published firmwares without one of their defects\n"
    yield "A clause that describes a hazard has to notice where it is gone; run are these clauses alone.\n"
    yield from PAGE.faults(CURES, found)
    yield "\n## Other faults\n"
    yield "Each is run against the clauses that it is about.\n"
    yield from PAGE.faults(BY_HAND, found)
