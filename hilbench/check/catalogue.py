"""Finds the clause behind an id.

Each protocol brings its clauses with its record; a system may have rules of its benches beside them.
A clause of a protocol needs a bench that speaks it: without the capability of that name its cases do not apply.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

from hilbench.judging.verdicts import Level
from hilbench.plugins.discovery import PLUGINS
from hilbench.plugins.protocol import ClauseEntry, ProtocolPlugin
from hilbench.plugins.registry import Registry
from hilbench.plugins.system import System


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
        stand_ins: capabilities with which it can be checked by the target's own reports where some of `needs` are
            missing; empty if it cannot.
        by_hand: whether a person beside the target can do and see what it needs, on request.
    """

    id: str
    suite: str
    level: Level
    title: str
    text: str
    source: str
    needs: frozenset[str] = frozenset()
    stand_ins: frozenset[str] = frozenset()
    by_hand: bool = False

    def unseen(self, capabilities: Collection[str]) -> frozenset[str]:
        """Return what a bench lacks that the target's own reports stand in for; nothing if they do not."""
        reported = self.stand_ins and self.stand_ins.issubset(capabilities)
        return self.needs.difference(capabilities) if reported else frozenset()

    def handed(self, capabilities: Collection[str], by_hand: Collection[str]) -> frozenset[str]:
        """Return what a bench lacks that somebody beside the target can do, of what is `by_hand` there."""
        return self.needs.intersection(by_hand).difference(capabilities) if self.by_hand else frozenset()


def find_clause(clause_id: str) -> Clause | None:
    """Return the clause with this id, or None."""
    systems = tuple(system.name for system in PLUGINS.systems.there())
    return _clauses((*PLUGINS.names(), *systems)).get(clause_id)


def titles() -> frozenset[str]:
    """Return the capability of each protocol: what a bench has that speaks it."""
    return frozenset(protocol.title for protocol in PLUGINS.all())


@cache
def _clauses(names: tuple[str, ...]) -> Mapping[str, Clause]:
    """Return all clauses; a protocol that has one of an id that is taken is refused."""
    del names  # of what there is: they change when a file brings another one
    found: dict[str, Clause] = {}
    for system in PLUGINS.systems.there():
        found |= _taken(PLUGINS.systems, system.name, partial(_of_system, system), found)
    for protocol in PLUGINS.all():
        found |= _taken(PLUGINS, protocol.name, partial(clauses_of, protocol), found)
    return found


def _taken(
    registry: Registry[Any], name: str, make: Callable[[], list[Clause]], found: Mapping[str, Clause]
) -> dict[str, Clause]:
    """Return the clauses that a plug-in brings beside those that were found; none of one that cannot be used."""
    try:
        entries = make()
    except Exception as error:  # noqa: BLE001 - whatever the code of a plug-in raises: the others are there
        registry.fails(name, error)
        return {}
    taken = sorted(found.keys() & {entry.id for entry in entries}) or _twice(entry.id for entry in entries)
    if taken:
        registry.refuse(name, f"has a clause '{taken[0]}', and so has another catalogue")
        return {}
    return {entry.id: entry for entry in entries}


def _of_system(system: System) -> list[Clause]:
    return [_clause(entry) for entry in system.clauses()]


def clauses_of(protocol: ProtocolPlugin) -> list[Clause]:
    """Return the rules that a protocol brings.

    Raises:
        TypeError: they are none; or whatever the code of a plug-in raises.
    """
    return [_clause(entry, protocol.title) for entry in protocol.clauses()]


def _twice(ids: Iterable[str]) -> list[str]:
    seen: set[str] = set()
    return [one for one in ids if one in seen or seen.add(one)]  # type: ignore[func-returns-value]


def _clause(entry: ClauseEntry, *spoken: str) -> Clause:
    for name in ("id", "suite", "title", "text", "source"):
        if not isinstance(getattr(entry, name, None), str):
            raise TypeError(f"a clause has no text as its {name}")
    stand_ins = getattr(entry, "stand_ins", ())  # a plug-in may bring clauses that know of none
    if entry.level not in ("must", "should") or isinstance(entry.needs, str) or isinstance(stand_ins, str):
        raise TypeError(f"clause {entry.id}: its level is must or should, its needs and stand_ins are several names")
    return Clause(
        id=entry.id,
        suite=entry.suite,
        level=entry.level,
        title=entry.title,
        text=entry.text,
        source=entry.source,
        needs=frozenset({*entry.needs, *spoken}),
        stand_ins=frozenset({*stand_ins, *spoken}) if stand_ins else frozenset(),
        by_hand=getattr(entry, "by_hand", False) is True,
    )
