"""What was found, as a file: every mutant with the clauses that do not pass; the pages are made from it alone.

A run of a part replaces what is known of that part, and forgets mutants that are no more.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

import msgspec

from hilbench.judging.verdicts import Verdict
from measure.mutants.catalogue import all_mutants
from measure.mutants.farm import Found
from protocols.p2os.clauses import CLAUSES

FORMAT = "hilbench-mutants/1"


class Entry(msgspec.Struct, frozen=True, kw_only=True):
    """One mutant and what was found.

    Attributes:
        family: where it comes from.
        what: its fault.
        verdicts: of the clauses that do not pass; all others of its suites do.
        cause: why the first of them does not.
        hung: the run had to be ended.
        survives: why it is not found out; empty if it is.
    """

    family: str
    what: str
    verdicts: dict[str, Verdict]
    cause: str = ""
    hung: bool = False
    survives: str = ""

    @property
    def killers(self) -> list[str]:
        """The clauses that find it out."""
        return [clause for clause, verdict in self.verdicts.items() if verdict in (Verdict.FAIL, Verdict.ERROR)]

    @property
    def killed(self) -> bool:
        """Whether it is found out."""
        return self.hung or bool(self.killers)


class Record(msgspec.Struct, frozen=True, kw_only=True):
    """The whole matrix.

    Attributes:
        format: name and version of this format.
        clauses: every clause of the catalogue with its level.
        mutants: by id.
    """

    format: str
    clauses: dict[str, str]
    mutants: dict[str, Entry]


def merged(path: Path, found: Iterable[Found]) -> Record:
    """Return what the file says, with what was found now in its place."""
    known = msgspec.json.decode(path.read_bytes(), type=Record).mutants if path.exists() else {}
    known |= {one.mutant.id: _entry(one) for one in found}
    order = [mutant.id for mutant in all_mutants() if mutant.id in known]
    return Record(
        format=FORMAT,
        clauses={clause.id: clause.level for clause in CLAUSES},
        mutants={id_: known[id_] for id_ in order},
    )


def _entry(found: Found) -> Entry:
    return Entry(
        family=found.mutant.family.value,
        what=found.mutant.what,
        verdicts=found.verdicts,
        cause=found.cause,
        hung=found.hung,
    )


def save(record: Record, path: Path) -> None:
    """Write the file, one mutant a line."""
    head = {"format": record.format, "clauses": record.clauses}
    lines = [f"{json.dumps(id_)}: {msgspec.json.encode(entry).decode()}" for id_, entry in record.mutants.items()]
    text = json.dumps(head)[:-1] + ', "mutants": {\n' + ",\n".join(lines) + "\n}}\n"
    path.write_text(text, encoding="utf-8")
