"""The page of the matrix, made from the record."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby

from measure.mutants.mutant import Family
from measure.mutants.record import Entry, Record
from measure.mutants.survivors import EQUIVALENT, UNTAKEN
from protocols.p2os.clauses import CLAUSES

_TITLES = {
    Family.SERVER_TABLE: "Server, from the state table",
    Family.SERVER_HAND: "Server, by hand",
    Family.CLIENT_TABLE: "Client, from the state table",
    Family.CLIENT_HAND: "Client, by hand",
    Family.MOTION_HAND: "Robot in its world, by hand",
}

_HEAD = """\
# Mutants: proof that the checks can fail

Made by `make mutants` (`python -m measure.mutants`); the data is in [mutants.json](mutants.json). Do not edit.

A mutant is a server, a client or a robot with one fault. Those *from the state table* have one edge of the protocol's
state table removed, led to another state, or one of its actions dropped or replaced. Those *by hand* are wrong in their
settings, on the wire, or in their body, in the way their line says. Each is run against its suite (`p2os-server`,
`p2os-client` or `pioneer-motion`) on the virtual bench, and is found out when a clause fails. Through the same harness
the right device passes every clause.
"""


def page(record: Record) -> str:
    """Return the page."""
    parts = [_HEAD, "## Scores", *_scores(record), "## Clauses", *_clauses(record), "## Survivors", *_survivors(record)]
    parts += ["## Matrix", *_matrix(record)]
    return "\n".join(parts).rstrip() + "\n"


def unexplained(record: Record) -> list[str]:
    """Return the survivors that nothing is known about."""
    return [id_ for id_, entry in record.mutants.items() if not entry.killed and not entry.survives]


def killing_nothing(record: Record, level: str) -> list[str]:
    """Return the clauses of a level that find no mutant out."""
    useful = {clause for entry in record.mutants.values() for clause in entry.killers}
    return [clause for clause, its_level in record.clauses.items() if its_level == level and clause not in useful]


# --- scores


def _scores(record: Record) -> Iterator[str]:
    yield "\nThe score is the share found of those not equivalent to the right device. *By a must* counts those that a"
    yield "clause of level *must* finds, so that `hilbench check` fails without `--strict` too. *Untaken* are those who"
    yield "survive on edges that no case goes along; the last column leaves them out.\n"
    yield "| Family | Mutants | Found | By a must | Equivalent | Survive | Untaken | Score | On edges taken |"
    yield "|---|--:|--:|--:|--:|--:|--:|--:|--:|"
    for family in Family:
        yield _score(_TITLES[family], _of(record, family), record)
    yield _score("**All**", list(record.mutants.values()), record)
    yield ""


def _score(title: str, entries: Sequence[Entry], record: Record) -> str:
    found = [entry for entry in entries if entry.killed]
    by_must = sum(entry.hung or any(record.clauses[clause] == "must" for clause in entry.killers) for entry in found)
    same = sum(_is_equivalent(entry) for entry in entries)
    survivors = len(entries) - len(found) - same
    untaken = sum(entry.survives == UNTAKEN for entry in entries)
    counts = (len(entries), len(found), by_must, same, survivors, untaken)
    scores = (len(found) / max(1, len(found) + survivors), len(found) / max(1, len(found) + survivors - untaken))
    cells = [title, *map(str, counts), *(f"{score:.1%}" for score in scores)]
    return f"| {' | '.join(cells)} |"


def _is_equivalent(entry: Entry) -> bool:
    return entry.survives.startswith(EQUIVALENT)


def _of(record: Record, family: Family) -> list[Entry]:
    return [entry for entry in record.mutants.values() if entry.family == family.value]


# --- clauses


def _clauses(record: Record) -> Iterator[str]:
    for level in ("must", "should"):
        idle = killing_nothing(record, level)
        yield f"\nClauses of level *{level}* that find no mutant: {', '.join(idle) or 'none'}."
    yield "\nExamples are the mutants that the fewest other clauses find; *alone* counts those no other clause finds.\n"
    yield "| Clause | Level | Title | Finds | Alone | Examples |"
    yield "|---|---|---|--:|--:|---|"
    for clause in CLAUSES:
        finds = {id_: len(entry.killers) for id_, entry in record.mutants.items() if clause.id in entry.killers}
        alone = sum(count == 1 for count in finds.values())
        examples = ", ".join(f"`{id_}`" for id_ in sorted(finds, key=lambda id_: (finds[id_], id_))[:3])
        yield f"| {clause.id} | {clause.level} | {clause.title} | {len(finds)} | {alone} | {examples} |"
    yield ""


# --- survivors


def _survivors(record: Record) -> Iterator[str]:
    yield "\n*equivalent*: nothing outside can tell the mutant from the right device. *unasked*: it could be told, but"
    yield "no clause asks for what would. *elsewhere*: another suite finds it.\n"
    for family in Family:
        ids = [id_ for id_, entry in record.mutants.items() if entry.family == family.value and not entry.killed]
        if not ids:
            continue
        yield f"### {_TITLES[family]}: {len(ids)}\n"
        yield "| Mutants | Why |"
        yield "|---|---|"
        for (place, why), group in groupby(ids, key=lambda id_: (_place(id_), _why(record.mutants[id_]))):
            yield f"| {_together(place, list(group), record)} | {why} |"
        yield ""


def _place(id_: str) -> str:
    """The edge of a mutant from a table; the id of any other."""
    return id_.rpartition(":")[0] or id_


def _why(entry: Entry) -> str:
    notes = [f"{clause} is {verdict.value}" for clause, verdict in entry.verdicts.items()]
    return "; ".join([entry.survives or "**not known**", *notes])


def _together(place: str, ids: Sequence[str], record: Record) -> str:
    if place in ids:
        return f"`{place}`: {record.mutants[place].what}"
    return f"`{place}:` " + ", ".join(f"`{id_.rpartition(':')[2]}`" for id_ in ids)


# --- matrix


def _matrix(record: Record) -> Iterator[str]:
    yield "\nWhich clauses find which mutant. *(E)* behind a clause: the case broke down instead of failing.\n"
    for family in Family:
        yield f"### {_TITLES[family]}\n"
        yield "| Mutant | Fault | Found by |"
        yield "|---|---|---|"
        for id_, entry in record.mutants.items():
            if entry.family == family.value:
                found_by = "hangs" if entry.hung else _ranges(_marked(entry)) or "-"
                yield f"| `{id_}` | {entry.what} | {found_by} |"
        yield ""


def _marked(entry: Entry) -> list[str]:
    return [clause if entry.verdicts[clause].value == "fail" else f"{clause} (E)" for clause in entry.killers]


def _ranges(clauses: Iterable[str]) -> str:
    """Write S02, S03, S04 as S02-S04."""
    runs: list[list[str]] = []
    for clause in sorted(clauses):
        if runs and _follows(runs[-1][-1], clause):
            runs[-1].append(clause)
        else:
            runs.append([clause])
    return ", ".join(f"{run[0]}-{run[-1]}" if len(run) > 2 else ", ".join(run) for run in runs)


def _follows(before: str, after: str) -> bool:
    return before[1:].isdigit() and after[1:].isdigit() and int(after[1:]) == int(before[1:]) + 1
