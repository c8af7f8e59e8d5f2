"""``python -m measure.mutants.derived SUBJECT``: makes a right peer wrong in every way that its protocol knows.

Each mutant is run at a port and as a model, against the cases in which it does anything that the right peer does not,
until one of them fails; what survives at a port is run there by hand, too, where somebody is asked. What is found is
kept in ``docs/derived-mutants.json`` as it comes: a run that was ended goes on where it was.
``docs/derived-mutants.md`` is made from that file alone.
"""

from __future__ import annotations

import argparse
import os
import random
import sys
from collections.abc import Sequence
from pathlib import Path

from hilbench.judging.verdicts import Verdict
from hilbench.plugins.discovery import PLUGINS
from hilbench.terminal.options import THROUGH
from measure.mutants.derived.book import Again, Book, Entry, drawn
from measure.mutants.derived.mutant import Mutant
from measure.mutants.derived.page import page
from measure.mutants.derived.subjects import SUBJECTS, Subject, bench_of
from measure.mutants.derived.tape import Tape, derive, recorded, touched
from measure.mutants.derived.trial import Outcome, tried
from measure.mutants.side_by_side import Lost, side_by_side

DOCS = Path(__file__).parents[3] / "docs"
HANG_S = 300.0
"""A mutant that runs longer than this, on the host's clock, hangs (choice)."""


def main(words: Sequence[str]) -> int:
    """Do what the command line says; 1 if a mutant survives and nothing says why."""
    parser = argparse.ArgumentParser(
        prog="python -m measure.mutants.derived",
        description=__doc__,
        epilog="example: python -m measure.mutants.derived pkt-board --share 0.2 --jobs 2",
    )
    parser.add_argument("subject", nargs="?", choices=sorted(SUBJECTS), help="who is made wrong")
    parser.add_argument("--bench", help="instead of that, the model of any bench: a name or a file")
    parser.add_argument("--protocol", help="what it speaks there, by the name of the record")
    parser.add_argument("--suite", action="append", default=[], help="what has to find it; the bench's own by default")
    parser.add_argument("--plugin", action="append", default=[], type=Path, metavar="FILE", help="brings a protocol")
    parser.add_argument("--only", action="append", default=[], metavar="TEXT", help="mutants with this in their ids")
    parser.add_argument("--share", type=float, default=1.0, help="the share of the mutants that is drawn, 0 to 1")
    parser.add_argument("--seed", type=int, default=0, help="of that draw, and of the runs")
    parser.add_argument("--jobs", type=int, default=min(2, os.cpu_count() or 1), help="how many at a time")
    parser.add_argument("--again", action="store_true", help="run also what is known")
    parser.add_argument("--through", default="", choices=THROUGH, help="run known ones again, on lines that pass this")
    parser.add_argument("--count", type=int, default=40, help="how many of them, for --through")
    parser.add_argument("--list", action="store_true", help="list the mutants and run none")
    parser.add_argument("--pages", action="store_true", help="run nothing, make the page again from what is known")
    parser.add_argument("--docs", type=Path, default=DOCS, help="where the pages go")
    chosen = parser.parse_args(words)
    book = Book.read(chosen.docs / "derived-mutants.json")
    if not chosen.pages:
        for path in chosen.plugin:
            PLUGINS.add_file(path, "--plugin")
        if chosen.bench and chosen.protocol:
            subject = bench_of(chosen.bench, chosen.protocol, chosen.suite)
        elif chosen.subject:
            subject = SUBJECTS[chosen.subject]
        else:
            parser.error("name a subject, or --bench and --protocol")
        if chosen.through:
            _run_again(subject, chosen, book)
        else:
            _run(subject, chosen, book)
        if chosen.list:
            return 0
    (chosen.docs / "derived-mutants.md").write_text(page(book), encoding="utf-8")
    unexplained = book.unexplained()
    sys.stderr.write("".join(f"{one} survives, and nothing says why\n" for one in unexplained))
    return 1 if unexplained else 0


def _run(subject: Subject, chosen: argparse.Namespace, book: Book) -> None:
    tapes = {"model": recorded(subject, at_port=False, seed=chosen.seed)}
    if subject.ports:
        tapes["port"] = recorded(subject, at_port=True, seed=chosen.seed)
    if subject.beside:
        tapes["hand"] = recorded(subject, at_port=True, by_hand=True, seed=chosen.seed)
    derived = derive(subject, tapes["model"])
    share = drawn(derived, chosen.share, chosen.seed)
    mutants = [one for one in share if not chosen.only or any(text in one.id for text in chosen.only)]
    if chosen.list:
        sys.stdout.write("".join(f"{mutant.id}: {mutant.what}\n" for mutant in mutants))
        return
    keep = [one.id for one in share]
    run = book.begin(subject, derived=len(derived), share=chosen.share, seed=chosen.seed, keep=keep)
    run.cases = {mode: len(_sound(tape)) for mode, tape in tapes.items()}
    run.unsound = {mode: sorted(_unsound(tape)) for mode, tape in tapes.items()}
    waiting = [mutant for mutant in mutants if chosen.again or mutant.id not in run.mutants]

    def work(mutant: Mutant) -> dict[str, Outcome]:
        came: dict[str, Outcome] = {}
        for mode, tape in tapes.items():
            if mode != "hand" or not came["port"].found:
                came[mode] = _trial(subject, mutant, tape, mode=mode, seed=chosen.seed)
        return came

    for number, (mutant, came) in enumerate(side_by_side(waiting, work, chosen.jobs, HANG_S), 1):
        if isinstance(came, Lost):
            came = {mode: Outcome(cases=0, lost=came.why) for mode in tapes}
        run.mutants[mutant.id] = Entry(what=mutant.what, group=mutant.fault.group.value, outcomes=came)
        book.save()
        said = ", ".join(f"{mode}: {_words(one)}" for mode, one in came.items())
        sys.stderr.write(f"{number}/{len(waiting)} {mutant.id}: {said}\n")
    book.save()


def _run_again(subject: Subject, chosen: argparse.Namespace, book: Book) -> None:
    """Run some of the known mutants on lines that pass a door of this machine, and compare."""
    run, tape = book.file.subjects[subject.name], recorded(subject, at_port=False, seed=chosen.seed)
    acting = {id_ for id_, entry in run.mutants.items() if entry.outcomes["model"].cases}
    known = [mutant for mutant in derive(subject, tape) if mutant.id in acting]
    drawn_by_seed = random.Random(chosen.seed).sample(known, min(chosen.count, len(known)))

    def work(mutant: Mutant) -> Outcome:
        return _trial(subject, mutant, tape, mode="model", seed=chosen.seed, through=chosen.through)

    otherwise: dict[str, Outcome] = {}
    for number, (mutant, came) in enumerate(side_by_side(drawn_by_seed, work, chosen.jobs, HANG_S), 1):
        outcome = Outcome(cases=0, lost=came.why) if isinstance(came, Lost) else came
        if _end_of(outcome) != _end_of(run.mutants[mutant.id].outcomes["model"]):
            otherwise[mutant.id] = outcome
        sys.stderr.write(f"{number}/{len(drawn_by_seed)} {mutant.id}: {_words(outcome)}\n")
    run.through[chosen.through] = Again(drawn=len(drawn_by_seed), otherwise=otherwise)
    book.save()


def _end_of(outcome: Outcome) -> tuple[tuple[str, ...], str]:
    return outcome.found_by, outcome.case


def _trial(subject: Subject, mutant: Mutant, tape: Tape, *, mode: str, seed: int, through: str = "") -> Outcome:
    """Run the cases that the right peer was run in, and that may show the mutant."""
    cases = [case for case in touched(subject, mutant, tape) if tape.verdicts.get(case) in _RAN]
    where = {"at_port": mode != "model", "by_hand": mode == "hand"}
    return tried(subject, mutant, cases, **where, unsound=_unsound(tape), seed=seed, through=through)


_RAN = (Verdict.PASS, Verdict.FAIL, Verdict.ERROR, Verdict.INCONCLUSIVE)


def _sound(tape: Tape) -> list[str]:
    return [case for case, verdict in tape.verdicts.items() if verdict is Verdict.PASS]


def _unsound(tape: Tape) -> set[str]:
    return {case for case, verdict in tape.verdicts.items() if verdict in _RAN and verdict is not Verdict.PASS}


def _words(outcome: Outcome) -> str:
    if outcome.lost:
        return outcome.lost
    if outcome.found_by:
        return ", ".join(outcome.found_by) + (" (broke down)" if outcome.error else "")
    return f"SURVIVES {outcome.cases} cases" + (
        f", {len(outcome.inconclusive)} inconclusive" * bool(outcome.inconclusive)
    )


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
