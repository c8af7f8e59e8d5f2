"""Adds up what several providers saw of one run, each of other cases, and puts what was seen into an order."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import msgspec

from hilbench.judging.observations import Coverage, EmulationNote, IgnoredCommand, Ledger, Observations, TouchedFeature

__all__ = ["added_up", "in_order"]

_Places = Mapping[str, int]


def in_order(observed: Observations) -> Observations:
    """Return the same with everything sorted that has no order of its own: it does not matter who has seen it first."""
    ledger = observed.ledger
    if ledger is not None:
        touched = [msgspec.structs.replace(one, commands=tuple(sorted(one.commands))) for one in ledger.touched]
        ledger = msgspec.structs.replace(
            ledger,
            touched=tuple(sorted(touched, key=lambda one: one.feature)),
            ignored=tuple(sorted(ledger.ignored, key=lambda one: (one.command, one.reason))),
        )
    coverage = tuple(sorted(observed.coverage, key=lambda one: one.peer))
    return msgspec.structs.replace(observed, coverage=coverage, ledger=ledger)


def added_up(observed: Sequence[Observations], places: _Places) -> Observations:
    """Return what one provider would have seen of all of it, of benches in virtual time.

    Args:
        observed: by each.
        places: the place of each case in the plan of the run.
    """
    ledgers = [one.ledger for one in observed if one.ledger is not None]
    return Observations(
        coverage=_coverage([one.coverage for one in observed]),
        ledger=_ledger(ledgers, places) if ledgers else None,
        notes=_notes([one.notes for one in observed], places),
    )


def _coverage(observed: Sequence[Sequence[Coverage]]) -> tuple[Coverage, ...]:
    found: dict[str, Coverage] = {}
    for one in (one for several in observed for one in several):
        known = found.get(one.peer, one)
        found[one.peer] = msgspec.structs.replace(
            known,
            states_missed=tuple(name for name in known.states_missed if name in one.states_missed),
            edges_missed=tuple(name for name in known.edges_missed if name in one.edges_missed),
        )
    return tuple(found.values())


def _ledger(ledgers: Sequence[Ledger], places: _Places) -> Ledger:
    touched: dict[str, TouchedFeature] = {}
    for feature in (one for ledger in ledgers for one in ledger.touched):
        known = touched.get(feature.feature, feature)
        touched[feature.feature] = msgspec.structs.replace(
            known,
            commands=tuple({*known.commands, *feature.commands}),
            case_ids=_cases([known.case_ids, feature.case_ids], places),
        )
    ignored: dict[tuple[str, str], IgnoredCommand] = {}
    for command in (one for ledger in ledgers for one in ledger.ignored):
        before = ignored.get((command.command, command.reason), command)
        ignored[command.command, command.reason] = msgspec.structs.replace(
            before, case_ids=_cases([before.case_ids, command.case_ids], places)
        )
    return msgspec.structs.replace(ledgers[0], touched=tuple(touched.values()), ignored=tuple(ignored.values()))


def _notes(observed: Sequence[Sequence[EmulationNote]], places: _Places) -> tuple[EmulationNote, ...]:
    """Each stands where it was seen first: in the first of its cases, behind what came before it there."""
    found: dict[tuple[str, str, str, str], tuple[int, int, EmulationNote]] = {}
    for several in observed:
        for position, note in enumerate(several):
            key = (note.board, note.kind, note.where, note.text)
            seen = (min(places[case_id] for case_id in note.case_ids), position, note)
            known = found.get(key, seen)
            first = min(known, seen, key=lambda one: one[:2])
            cases = _cases([known[2].case_ids, note.case_ids], places)
            found[key] = (*first[:2], msgspec.structs.replace(first[2], case_ids=cases))
    return tuple(note for _, _, note in sorted(found.values(), key=lambda one: one[:2]))


def _cases(several: Iterable[Sequence[str]], places: _Places) -> tuple[str, ...]:
    return tuple(sorted({case_id for case_ids in several for case_id in case_ids}, key=places.__getitem__))
