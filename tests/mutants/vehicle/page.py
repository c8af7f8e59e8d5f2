"""The page ``docs/vehicle-defects.md``: which clauses find which fault."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from protocols.carla.clauses import BOARD_CLAUSES
from targets.robots.vehicle_interface import DEFECTS
from tests.mutants.vehicle.mutant import SLOW, VehicleMutant
from tests.mutants.vehicle.published import CURES
from tests.mutants.vehicle.tables import BY_HAND

_ROW = re.compile(r"^\| `(?P<name>[^`]+)` \|.*\| (?P<clauses>[^|]*) \|$", re.MULTILINE)
_FIRMWARE = re.compile(r"^\| `(?P<name>[^`]+)` \|[^|]*\|[^|]*\| (?P<clauses>[^|]*) \| [^|]* \|$", re.MULTILINE)
_LEVELS = {clause.id: clause.level for clause in BOARD_CLAUSES}

PAGE = Path(__file__).parents[3] / "docs" / "vehicle-defects.md"


def page(found: Mapping[str, Sequence[str]], firmware: Mapping[str, Sequence[str]]) -> str:
    """The page of the table, from the clauses that find each mutant, as a model and in the firmware."""
    return "\n".join([*_head(), *_table(found, firmware), *_clauses(found)]) + "\n"


def _head() -> Iterator[str]:
    yield "# Defects of the vehicle interface, and the clauses that find them\n"
    yield "Made by `python -m tests.mutants.vehicle`. Do not edit.\n"
    yield "Each defect of the published firmwares is put back by itself into a board that is otherwise as we would"
    yield "ship it (a behavioural model: `defects` in the settings of the bench `vehicle-model`), and the suite"
    yield "`vehicle-board` is run against it. Then some of the clauses that found it are run against our firmware with"
    yield "the same defect, on the emulated NUCLEO-H753ZI (images `vehicle-DEFECT`). A star marks a clause that says"
    yield f"*should*. Left out, for they take 20 s and more: {', '.join(SLOW)}, but for `H9`, which they are about.\n"


def _table(found: Mapping[str, Sequence[str]], firmware: Mapping[str, Sequence[str]]) -> Iterator[str]:
    yield "| Defect | What it does | Where it was published | Found in the firmware by | Found in the model by |"
    yield "|---|---|---|---|---|"
    for defect in DEFECTS.values():
        emulated = _shown(firmware.get(defect.name, ("no image",)))
        yield f"| `{defect.name}` | {defect.text} | {defect.source} | {emulated} | {_shown(found[defect.name])} |"
    yield "\n## The published firmwares without one of their defects\n"
    yield "A clause that describes a hazard has to notice where it is gone; run are these clauses alone.\n"
    yield from _plain(found, CURES)
    yield "\n## Other faults\n"
    yield "Each is run against the clauses that it is about.\n"
    yield from _plain(found, BY_HAND)


def _plain(found: Mapping[str, Sequence[str]], mutants: Iterable[VehicleMutant]) -> Iterator[str]:
    yield "| Fault | What it does | Profile | Clauses that find it |"
    yield "|---|---|---|---|"
    for mutant in mutants:
        yield f"| `{mutant.id}` | {mutant.what} | `{mutant.profile}` | {_shown(found[mutant.id])} |"


def _shown(clauses: Sequence[str]) -> str:
    """Clauses, those that say *should* with a star."""
    return ", ".join(f"{clause}*" if _LEVELS.get(clause) == "should" else clause for clause in clauses) or "none"


def _clauses(found: Mapping[str, Sequence[str]]) -> Iterator[str]:
    yield "\n## Clauses\n"
    yield "| Clause | Faults it finds |"
    yield "|---|---|"
    for clause in BOARD_CLAUSES:
        names = [f"`{name}`" for name, clauses in found.items() if clause.id in clauses]
        yield f"| {clause.id} {clause.title} | {', '.join(names) or 'none'} |"


def on_the_page(row: re.Pattern[str] = _ROW) -> dict[str, tuple[str, ...]]:
    """What the page says already: by fault, the clauses that find it in the model."""
    rows = row.finditer(PAGE.read_text(encoding="utf-8"))
    said = {row["name"]: row["clauses"].replace("*", "") for row in rows}
    return {name: () if clauses == "none" else tuple(clauses.split(", ")) for name, clauses in said.items()}


def firmware_on_the_page() -> dict[str, tuple[str, ...]]:
    """As `on_the_page`, in the firmware."""
    return {name: clauses for name, clauses in on_the_page(_FIRMWARE).items() if clauses != ("no image",)}
