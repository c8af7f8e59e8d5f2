"""The page of the derived mutants, made from the file alone."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator

from measure.mutants.derived.book import Book, Entry, Run
from measure.mutants.derived.reasons import hidden, reason
from measure.mutants.derived.subjects import SUBJECTS

__all__ = ["page"]

_MODES = {"port": "at a port", "hand": "at a port by hand", "model": "as a model"}


_HEAD = """
A relay on the line turns a right peer into a wrong one. Which messages and fields there are is read off what the right
peer and the checker say to each other in the suites, by the protocol's own record (its decoder, `regions`, `checksum`),
and timers and edges off its state machines: nothing is written down for a protocol. Each field is stuck, stale, one too
many, one too few, with the other sign, with its bytes the other way round, exchanged with the one behind it; each
message is lost, doubled, late, early, behind the next one; each rule of the checksum is bent; each timer runs half and
twice its time; each edge is refused, leads nowhere, or does nothing. *says* is what the peer sends, *hears* what it
receives. What stands around every message is changed in all of them at once. Of a frame that the specification gives
byte for byte (`fixed` of the record: EMERGENCY of CARLA, whose figures are all 0), none is made that leaves it so.

Every mutant is run in virtual time, *at a port*, where the bench can do what a bench with a port can, and *as a model*,
where it can do everything; in both against the cases in which it does anything that the right peer does not, and until
the first of them fails. What survives at a port is run there *by hand*, too: somebody stands beside the target who does
and sees what a case asks for, as a command does that [`--operator-hook`](checks.md#somebody-beside-the-target) names. A
case that breaks down counts as well. A host at a port is one that
[tells what it understood](checks.md#a-client-that-tells-what-it-understood); of one that does not, only what it sends
is judged, and most of its faults do not show. Any protocol of a plug-in gets the same:
`python -m measure.mutants.derived --bench FILE --protocol NAME`.

The score is the share of the mutants that were found, less the equivalent ones. *Without effect* are those with which
no case of the suites meets a frame, timer or edge that differs: they survive, and count so. *Of those that can show* is
the score by hand without those that no stimulus at a port shows, whoever stands there; they are named with the reason.

""".removeprefix("\n")


def page(book: Book) -> str:
    """Return the page."""
    return "\n".join(_lines(book)) + "\n"


def _lines(book: Book) -> Iterator[str]:
    yield "# Wrong peers made from what a protocol says of itself\n"
    yield "Made by `python -m measure.mutants.derived`. Do not edit.\n"
    yield from _HEAD.splitlines()
    yield "| Peer | Mutants | Run | Equivalent | Found at a port | by hand, too | of those that can show | as a model |"
    yield "|---|---|---|---|---|---|---|---|"
    for name, run in book.file.subjects.items():
        yield _row(book, name, run)
    for name, run in book.file.subjects.items():
        yield from _subject(book, name, run)


def _row(book: Book, name: str, run: Run) -> str:
    equal = book.equivalent(name)
    counted = {id_: entry for id_, entry in run.mutants.items() if id_ not in equal}
    can_show = [entry for id_, entry in counted.items() if entry.found("hand") or not hidden(name, id_)]
    port, hand, model = (_score(counted.values(), mode) for mode in _MODES)
    asked = "hand" in run.cases
    showing = _score(can_show, "hand" if asked else "port") if len(can_show) < len(counted) else "-"
    scores = [port, hand if asked else "-", showing, model]
    share = "all" if run.share >= 1 else f"{run.share:.0%}, seed {run.seed}"
    cells = [run.title, run.derived, f"{len(run.mutants)} ({share})", len(equal), *scores]
    return f"| {' | '.join(map(str, cells))} |"


def _score(entries: Iterable[Entry], mode: str) -> str:
    found = [was for entry in entries if (was := entry.found(mode)) is not None]
    if not found:
        return "not run"
    return f"{sum(found)} of {len(found)}, {sum(found) / len(found):.1%}"


def _subject(book: Book, name: str, run: Run) -> Iterator[str]:
    yield f"\n## {run.title}\n"
    cases = ", ".join(f"{count} {_MODES[mode]}" for mode, count in run.cases.items())
    yield f"Cases that the right peer passes: {cases}."
    for mode, ids in run.unsound.items():
        if ids:
            yield f"Not counted {_MODES[mode]}, since it does not: {', '.join(ids)}."
    for kind, again in run.through.items():
        same = again.drawn - len(again.otherwise)
        differ = "".join(f"; otherwise: `{id_}`" for id_ in again.otherwise)
        yield f"{again.drawn} of the mutants that have an effect, drawn by seed, were run again as a model on lines"
        yield f"that pass a {kind} of the machine: {same} came out the same{differ}."
    yield "\n| Of a | Run | Found at a port | by hand, too | as a model | Without effect at a port, as a model |"
    yield "|---|---|---|---|---|---|"
    by_group: dict[str, list[Entry]] = defaultdict(list)
    for entry in run.mutants.values():
        by_group[entry.group].append(entry)
    for group, entries in sorted(by_group.items()):
        scores = " | ".join(_score(entries, mode) if mode != "hand" or mode in run.cases else "-" for mode in _MODES)
        idle = ", ".join(
            str(sum(not one.outcomes[mode].cases for one in entries if mode in one.outcomes))
            for mode in ("port", "model")
        )
        yield f"| {group} | {len(entries)} | {scores} | {idle} |"
    yield from _survivors(book, name)


def _survivors(book: Book, name: str) -> Iterator[str]:
    of_model = dict(book.survivors(name, "model"))
    by_reason: dict[str, list[tuple[str, Entry]]] = defaultdict(list)
    for id_, entry in of_model.items():
        by_reason[reason(name, id_, entry.outcomes["model"]) or "not explained"].append((id_, entry))
    yield "\n### Survivors as a model\n"
    if not by_reason:
        yield "None."
    for why, those in sorted(by_reason.items()):
        yield f"{why[:1].upper()}{why[1:]}:\n"
        for id_, entry in those:
            yield f"- `{id_}`: {entry.what}{_trace(entry, 'model')}"
        yield ""
    at_port = {id_: entry for id_, entry in book.survivors(name, "port") if id_ not in of_model}
    left = {id_: entry for id_, entry in at_port.items() if not entry.found("hand")}
    yield from _by_hand({id_: entry for id_, entry in at_port.items() if id_ not in left})
    yield from _hidden(name, {id_: entry for id_, entry in left.items() if hidden(name, id_)})
    yield from _others(name, {id_: entry for id_, entry in left.items() if not hidden(name, id_)})


def _by_hand(found: dict[str, Entry]) -> Iterator[str]:
    if found:
        yield "\n### Found at a port by hand alone\n"
        yield "| Mutant | Fault | Found by |"
        yield "|---|---|---|"
        for id_, entry in found.items():
            outcome = entry.outcomes["hand"]
            yield f"| `{id_}` | {entry.what} | {', '.join(outcome.found_by) or outcome.lost} |"


def _hidden(name: str, those: dict[str, Entry]) -> Iterator[str]:
    by_reason: dict[str, list[str]] = defaultdict(list)
    for id_, entry in those.items():
        by_reason[hidden(name, id_)].append(f"- `{id_}`: {entry.what}")
    if by_reason:
        yield "\n### What no stimulus at a port shows\n"
    for why, lines in sorted(by_reason.items()):
        yield f"{why[:1].upper()}{why[1:]}:\n"
        yield from lines
        yield ""


def _others(name: str, rest: dict[str, Entry]) -> Iterator[str]:
    lacks = _lacking(name)
    if rest:
        yield "\n### Survivors at a port alone\n"
        yield "| Mutant | Fault | Found as a model by (and what that needs beside a line) |"
        yield "|---|---|---|"
        for id_, entry in rest.items():
            outcome = entry.outcomes["model"]
            by = ", ".join(f"{one}{lacks(one)}" for one in outcome.found_by) or outcome.lost
            yield f"| `{id_}` | {entry.what}{_trace(entry, 'port')} | {by} |"


def _lacking(name: str) -> Callable[[str], str]:
    """Return what says, of a clause, which capability it needs beside those that every clause of the subject needs."""
    if name not in SUBJECTS:
        return lambda _clause: ""
    needs = {clause.id: {*clause.needs} for clause in SUBJECTS[name].record.clauses()}
    usual = {"server", "client", "board", "simulator", "stack"}
    return lambda clause: f" ({', '.join(sorted(needs.get(clause, set()) - usual))})".replace(" ()", "")


def _trace(entry: Entry, mode: str) -> str:
    outcome = entry.outcomes[mode]
    doubt = f", {len(outcome.inconclusive)} of them inconclusive" if outcome.inconclusive else ""
    return f" ({outcome.cases} cases{doubt})" if outcome.cases else " (without effect)"
