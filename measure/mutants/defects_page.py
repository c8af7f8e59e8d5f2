"""The pages of faulty boards: which clauses find which defect, written and read again."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, TypeVar

from hilbench.check import Verdict
from hilbench.check.results import Report

__all__ = ["DefectsPage", "Found", "Mutant", "by_clauses", "killers"]

Found = Mapping[str, Sequence[str]]
"""By fault, the clauses that find it."""

_ROW = re.compile(r"^\| `(?P<name>[^`]+)` \|.*\| (?P<clauses>[^|]*) \|$", re.MULTILINE)
_FIRMWARE = re.compile(r"^\| `(?P<name>[^`]+)` \|[^|]*\|[^|]*\| (?P<clauses>[^|]*) \| [^|]* \|$", re.MULTILINE)
_NO_IMAGE = ("no image",)


class Clause(Protocol):
    """A clause, as such a page shows it."""

    @property
    def id(self) -> str:
        """Its short name."""

    @property
    def level(self) -> str:
        """How binding it is."""

    @property
    def title(self) -> str:
        """A few words."""


class Defect(Protocol):
    """A defect of a published firmware."""

    @property
    def name(self) -> str:
        """Its short name."""

    @property
    def text(self) -> str:
        """What it does."""

    @property
    def source(self) -> str:
        """Where it was published."""


class Mutant(Protocol):
    """A board with one fault."""

    @property
    def id(self) -> str:
        """Its stable name."""

    @property
    def what(self) -> str:
        """What it does wrong."""

    @property
    def profile(self) -> str:
        """Of the cases that have to find it."""


MutantT = TypeVar("MutantT", bound=Mutant)


@dataclass(frozen=True, slots=True, kw_only=True)
class DefectsPage:
    """One such page.

    Attributes:
        path: where it stands.
        clauses: the catalogue.
    """

    path: Path
    clauses: Sequence[Clause]

    def published(self, defects: Iterable[Defect], found: Found, firmware: Found) -> Iterator[str]:
        """Yield the lines of the table of published defects."""
        yield "| Defect | What it does | Where it was published | Found in the firmware by | Found in the model by |"
        yield "|---|---|---|---|---|"
        for one in defects:
            emulated = self._shown(firmware.get(one.name, _NO_IMAGE))
            yield f"| `{one.name}` | {one.text} | {one.source} | {emulated} | {self._shown(found[one.name])} |"

    def faults(self, mutants: Iterable[Mutant], found: Found) -> Iterator[str]:
        """Yield the lines of a table of other faults."""
        yield "| Fault | What it does | Profile | Clauses that find it |"
        yield "|---|---|---|---|"
        for mutant in mutants:
            yield f"| `{mutant.id}` | {mutant.what} | `{mutant.profile}` | {self._shown(found[mutant.id])} |"

    def by_clause(self, found: Found) -> Iterator[str]:
        """Yield the lines of the section that has the faults by clause."""
        yield "\n## Clauses\n"
        yield "| Clause | Faults it finds |"
        yield "|---|---|"
        for clause in self.clauses:
            names = [f"`{name}`" for name, clauses in found.items() if clause.id in clauses]
            yield f"| {clause.id} {clause.title} | {', '.join(names) or 'none'} |"

    def _shown(self, clauses: Sequence[str]) -> str:
        """Clauses, those that say *should* with a star."""
        soft = {clause.id for clause in self.clauses if clause.level == "should"}
        return ", ".join(f"{clause}*" if clause in soft else clause for clause in clauses) or "none"

    def said(self) -> dict[str, tuple[str, ...]]:
        """What the page says already: by fault, the clauses that find it in the model."""
        return self._read(_ROW)

    def said_of_firmware(self) -> dict[str, tuple[str, ...]]:
        """As `said`, in the firmware; without those that have no image."""
        return {name: clauses for name, clauses in self._read(_FIRMWARE).items() if clauses != _NO_IMAGE}

    def _read(self, row: re.Pattern[str]) -> dict[str, tuple[str, ...]]:
        rows = row.finditer(self.path.read_text(encoding="utf-8"))
        said = {row["name"]: row["clauses"].replace("*", "") for row in rows}
        return {name: () if clauses == "none" else tuple(clauses.split(", ")) for name, clauses in said.items()}


def killers(report: Report) -> tuple[str, ...]:
    """Return the clauses that fail."""
    return tuple(sorted({case.clause_ids[0] for case in report.cases if case.verdict is Verdict.FAIL}))


def by_clauses(
    said: Found,
    mutants: Iterable[MutantT],
    chosen: Collection[str],
    *,
    asked: Callable[[MutantT], Collection[str]],
    run: Callable[[MutantT, str], Report],
) -> dict[str, tuple[str, ...]]:
    """Return what a page says, with some clauses run anew; with all of them for a fault that is not there.

    Args:
        said: what it says.
        mutants: the faulty boards.
        chosen: the clauses that are run.
        asked: the clauses that a mutant is run against.
        run: runs the cases of a mutant that an expression selects; all of its own for an empty one.
    """

    def of(mutant: MutantT) -> tuple[str, ...]:
        if mutant.id not in said:
            return killers(run(mutant, ""))
        anew = sorted({*chosen} & {*asked(mutant)})
        found = killers(run(mutant, f"({' or '.join(anew)})")) if anew else ()
        return tuple(sorted({*said[mutant.id]} - {*chosen} | {*found}))

    return {mutant.id: of(mutant) for mutant in mutants}
