"""What was found, as a file: every mutant that was run, with what came of it at a port and as a model."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec

from measure.mutants.derived.mutant import Mutant
from measure.mutants.derived.reasons import EQUIVALENT, reason
from measure.mutants.derived.subjects import Subject
from measure.mutants.derived.trial import Outcome

__all__ = ["Book", "Entry", "Run", "drawn"]

FORMAT = "hilbench-derived-mutants/1"


def drawn(mutants: Sequence[Mutant], share: float, seed: int) -> list[Mutant]:
    """Return a share of the mutants; which ones, the seed and their ids decide."""

    def place(mutant: Mutant) -> float:
        digest = hashlib.sha256(f"{seed}\n{mutant.id}".encode()).digest()
        return int.from_bytes(digest[:8], "big") / 2**64

    return [mutant for mutant in mutants if place(mutant) < share]


class Entry(msgspec.Struct, frozen=True, kw_only=True):
    """A mutant.

    Attributes:
        what: its fault.
        group: what it is a fault of.
        outcomes: what came of it, by ``port``, ``hand`` and ``model``; by hand alone what survives at a port.
    """

    what: str
    group: str
    outcomes: dict[str, Outcome]

    def found(self, mode: str) -> bool | None:
        """Say whether it was found in a mode; None if it was not run. By hand counts what was found at the port."""
        if mode == "hand" and "hand" not in self.outcomes and "port" in self.outcomes:
            return self.outcomes["port"].found
        return self.outcomes[mode].found if mode in self.outcomes else None


class Again(msgspec.Struct, frozen=True, kw_only=True):
    """Mutants that were run again.

    Attributes:
        drawn: how many.
        otherwise: those that came out otherwise, with what came of them now.
    """

    drawn: int
    otherwise: dict[str, Outcome] = msgspec.field(default_factory=dict)


class Run(msgspec.Struct, kw_only=True):
    """All mutants of a subject.

    Attributes:
        title: of the subject.
        derived: how many mutants there are.
        share: which share of them was drawn.
        seed: of that draw.
        cases: how many cases the right peer passes, by ``port``, ``hand`` and ``model``.
        unsound: cases that it does not pass, whose verdicts are not counted.
        mutants: those that were run.
        through: how many of them were run again as a model on a line that passes such a door of the machine, and those
            that came out otherwise.
    """

    title: str
    derived: int
    share: float
    seed: int
    cases: dict[str, int] = msgspec.field(default_factory=dict)
    unsound: dict[str, list[str]] = msgspec.field(default_factory=dict)
    through: dict[str, Again] = msgspec.field(default_factory=dict)
    mutants: dict[str, Entry] = msgspec.field(default_factory=dict)


class _File(msgspec.Struct, kw_only=True):
    format: str = FORMAT
    subjects: dict[str, Run] = msgspec.field(default_factory=dict)


@dataclass(slots=True)
class Book:
    """The file."""

    path: Path
    file: _File

    @classmethod
    def read(cls, path: Path) -> Book:
        """Return what a file says; nothing if it is not there."""
        return cls(path, msgspec.json.decode(path.read_bytes(), type=_File) if path.exists() else _File())

    def begin(self, subject: Subject, *, derived: int, share: float, seed: int, keep: Collection[str]) -> Run:
        """Return what is known of a subject, less the mutants that are no more, or were drawn otherwise."""
        known = self.file.subjects.get(subject.name)
        run = Run(title=subject.title, derived=derived, share=share, seed=seed)
        if known is not None and known.seed == seed:
            run.mutants = {id_: entry for id_, entry in known.mutants.items() if id_ in keep}
            run.through = known.through
        self.file.subjects[subject.name] = run
        return run

    def save(self) -> None:
        """Write the file, one mutant a line."""
        subjects = []
        for name, run in self.file.subjects.items():
            head = msgspec.json.encode(msgspec.structs.replace(run, mutants={})).decode().removesuffix('"mutants":{}}')
            lines = [
                f"{json.dumps(id_)}: {msgspec.json.encode(run.mutants[id_]).decode()}" for id_ in sorted(run.mutants)
            ]
            subjects.append(f"{json.dumps(name)}: {head}" + '"mutants": {\n' + ",\n".join(lines) + "\n}}")
        text = f'{{"format": {json.dumps(FORMAT)}, "subjects": {{\n' + ",\n".join(subjects) + "\n}}\n"
        self.path.write_text(text, encoding="utf-8")

    def survivors(self, name: str, mode: str) -> Iterator[tuple[str, Entry]]:
        """Yield the mutants of a subject that are not found out in a mode."""
        for id_, entry in sorted(self.file.subjects[name].mutants.items()):
            if entry.found(mode) is False:
                yield id_, entry

    def unexplained(self) -> list[str]:
        """Return the survivors of the model without a reason, with their subjects."""
        return [
            f"{name} {id_}"
            for name in self.file.subjects
            for id_, entry in self.survivors(name, "model")
            if not reason(name, id_, entry.outcomes["model"])
        ]

    def equivalent(self, name: str) -> set[str]:
        """Return the mutants of a subject that the specification permits."""
        run = self.file.subjects[name]
        return {
            id_
            for id_, entry in run.mutants.items()
            if all(not one.found for one in entry.outcomes.values())
            and reason(name, id_, entry.outcomes["model"]).startswith(EQUIVALENT)
        }
