"""``python -m measure.mutants``: runs the mutants and writes ``docs/mutants.json`` and ``docs/mutants.md``.

With ``--only`` or ``--family`` a part is run, and what is known of the others stays.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from measure.mutants.bench import edges_taken
from measure.mutants.catalogue import mutants_of
from measure.mutants.farm import Found, examine_all
from measure.mutants.mutant import Family
from measure.mutants.pages import page, unexplained
from measure.mutants.record import merged, save
from measure.mutants.survivors import explained

DOCS = Path(__file__).parents[2] / "docs"


def main(arguments: list[str]) -> int:
    """Run what the command line says; 1 if a mutant survives and nothing says why."""
    parser = argparse.ArgumentParser(prog="python -m measure.mutants", description=__doc__)
    parser.add_argument("--only", action="append", default=[], metavar="ID", help="only this mutant (repeatable)")
    parser.add_argument("--family", action="append", default=[], choices=[family.value for family in Family])
    parser.add_argument("--pages", action="store_true", help="run nothing, make the pages again from what is known")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="how many at a time")
    parser.add_argument("--docs", type=Path, default=DOCS, help="where the pages go")
    chosen = parser.parse_args(arguments)
    try:
        mutants = mutants_of(tuple(Family(name) for name in chosen.family), tuple(chosen.only))
    except KeyError as error:
        parser.error(f"no mutant is called {error}")
    found = [] if chosen.pages else examine_all(mutants, chosen.jobs, _tell)
    path = chosen.docs / "mutants.json"
    record = explained(merged(path, found), edges_taken())
    save(record, path)
    (chosen.docs / "mutants.md").write_text(page(record), encoding="utf-8")
    for id_ in unexplained(record):
        sys.stderr.write(f"{id_} survives, and nothing says why\n")
    return 1 if unexplained(record) else 0


def _tell(found: Found, number: int, total: int) -> None:
    verdict = "hangs" if found.hung else ", ".join(found.killers) or "SURVIVES"
    if found.killed and not found.hung:
        verdict += f"   {found.cause[:90]}"
    odd = [f"{clause} {verdict.value}" for clause, verdict in found.verdicts.items() if clause not in found.killers]
    sys.stderr.write(f"{number}/{total} {found.mutant.id}: {verdict} {' '.join(odd)}\n")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
