"""Finds the clause behind an id.

Each protocol brings a table ``CLAUSES`` in its module ``clauses``; so does the bench of emulated boards. Those of this
distribution are looked at first; another distribution's, found by its entry point in the group ``hilbench.protocols``,
only for an id they do not hold.

A clause of a protocol needs a bench that speaks it: without the capability of that name its cases do not apply.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from types import MappingProxyType

from hilbench.check.verdicts import Level

OWN_CATALOGUES = (
    "protocols.p2os.clauses",
    "protocols.pkt.clauses",
    "protocols.carla.clauses",
    "hilbench.suites._bluepill_clauses",
    "hilbench.suites._dodge_clauses",
    "hilbench.suites._rover_motion_clauses",
    "hilbench.suites._vehicle_drive_clauses",
)


SPOKEN: Mapping[str, str] = MappingProxyType(
    {"protocols.p2os.clauses": "P2OS", "protocols.pkt.clauses": "PKT!", "protocols.carla.clauses": "CARLA"}
)
"""The capability that the clauses of a protocol need, besides their own needs."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Clause:
    """One rule that a target follows or violates.

    Attributes:
        id: short name, unique over all catalogues.
        suite: the suite it belongs to.
        level: ``"must"`` or ``"should"``.
        title: a few words.
        text: the rule.
        source: where it is written: a manual's section, a line of a program.
        needs: capabilities without which it cannot be checked.
    """

    id: str
    suite: str
    level: Level
    title: str
    text: str
    source: str
    needs: frozenset[str] = frozenset()


def find_clause(clause_id: str) -> Clause | None:
    """Return the clause with this id, or None."""
    own = _own_clauses().get(clause_id)
    return own if own is not None else _foreign_clauses().get(clause_id)


@cache
def _own_clauses() -> dict[str, Clause]:
    return _by_id(OWN_CATALOGUES)


@cache
def _foreign_clauses() -> dict[str, Clause]:
    catalogues = [f"{point.value}.clauses" for point in metadata.entry_points(group="hilbench.protocols")]
    return _by_id(name for name in catalogues if name not in OWN_CATALOGUES)


def _by_id(modules: Iterable[str]) -> dict[str, Clause]:
    found = {}
    for module in modules:
        spoken = {SPOKEN[module]} if module in SPOKEN else set()
        for entry in importlib.import_module(module).CLAUSES:
            found[entry.id] = Clause(
                id=entry.id,
                suite=entry.suite,
                level=entry.level,
                title=entry.title,
                text=entry.text,
                source=entry.source,
                needs=frozenset({*entry.needs, *spoken}),
            )
    return found
