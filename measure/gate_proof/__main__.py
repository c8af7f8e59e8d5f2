"""``python -m measure.gate_proof``: puts small defects into the product and writes which of them the gate's tests find.

The steps are record, choose, run, old and report; without one, all of them, in this order. What each has found is kept
in a folder, so that Ctrl-C and another run lose nothing but the test at hand. The tree that is measured is the one that
is committed: copies of it are made in a temporary folder, and nobody's checkout is touched. It takes an hour or two on
two cores. After tests were added for what was missed, commit them and say ``again`` with the steps: what was found
stays found, and the rest is put before the tests of that commit. Why something is missed stands in
``measure/gate_proof/reasons.toml``, by the ids of the table.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from measure.gate_proof.choice import PER_MODULE
from measure.gate_proof.copies import ROOT, git
from measure.gate_proof.proof import GATE, OLD, OLD_THOROUGH, Plan, Proof, say
from measure.gate_proof.report import Judged, Totals, page, reasons

BEFORE = "94a86ad"
"""The last commit before there were two tiers."""
OUT = ROOT / "out" / "gate-proof"
_INTERRUPTED = 130


def record(proof: Proof) -> None:
    """Record what the tests of both gates run."""
    for name in (GATE, OLD, OLD_THOROUGH):
        proof.record(name)


def choose(proof: Proof) -> None:
    """Choose the defects."""
    say(f"{len(proof.defects())} defects")


def run(proof: Proof) -> None:
    """Put the defects before the tests of the gate."""
    proof.run(GATE, proof.defects())


def old(proof: Proof) -> None:
    """Put what it misses before the tests of the old gate."""
    results = proof.results(GATE)
    missed = {name for name, one in results.items() if one.outcome is None or not one.outcome.found}
    proof.run(OLD, [one for one in proof.defects() if one.id in missed])


def report(proof: Proof) -> None:
    """Write the page."""
    gate, before = proof.results(GATE), proof.results(OLD)
    judged = []
    for defect in proof.defects():
        mine, old_one = gate.get(defect.id), before.get(defect.id)
        judged.append(
            Judged(defect, mine.outcome if mine else None, old_one.outcome if old_one else None, old_one is not None)
        )
    plan = proof.plan
    thorough = proof.recording(OLD_THOROUGH) is not None
    about = {
        "commit": plan.commit,
        "before": plan.before,
        "seed": plan.seed,
        "per_module": PER_MODULE,
        "thorough": ", and those that its `.ci/run` alone ran"
        if thorough
        else " (what its `.ci/run` alone ran was not)",
    }
    text = page(judged, about, totals(proof), reasons())
    target = (proof.folder if plan.tests else ROOT / "docs") / "gate-proof.md"
    target.write_text(text, encoding="utf-8")
    sys.stdout.write(text)
    say(f"wrote {target}")


def totals(proof: Proof) -> dict[str, Totals]:
    """Return what the tests reach of each package, before and after."""
    found: dict[str, Totals] = {}
    for title, name in {"before": OLD, "after": GATE}.items():
        kept = proof.folder / f"{name}-{proof.commit_of(name)}.json"
        if not kept.is_file() and (recording := proof.recording(name)):
            with proof.tree(name) as tree:
                kept.write_text(json.dumps(recording.totals(tree.root)) + "\n")
        if kept.is_file():
            found[title] = json.loads(kept.read_text())
    return found


STEPS: dict[str, Callable[[Proof], None]] = {
    "record": record,
    "choose": choose,
    "run": run,
    "old": old,
    "report": report,
}


def main(words: Sequence[str]) -> int:
    """Do what is asked."""
    parser = argparse.ArgumentParser(
        prog="python -m measure.gate_proof", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("steps", nargs="*", metavar="STEP", help=f"{', '.join(STEPS)}, or again (default: all in turn)")
    parser.add_argument("--commit", default="HEAD", help="whose tests and product (default: HEAD)")
    parser.add_argument("--before", default=BEFORE, help=f"whose tests were the old gate (default: {BEFORE})")
    parser.add_argument("--seed", type=int, default=17, help="what modules and defects are drawn from (default: 17)")
    parser.add_argument("--count", type=int, default=300, help="how many defects, about (default: 300)")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="side by side (default: one a core)")
    parser.add_argument("--out", type=Path, default=OUT, help=f"the folder (default: {OUT.relative_to(ROOT)})")
    parser.add_argument("--forget", nargs="+", default=[], metavar="ID", help="judge these defects anew")
    parser.add_argument("--tests", nargs="+", default=[], metavar="PATH", help="these tests alone; no page of the docs")
    chosen = parser.parse_args(words)
    unknown = set(chosen.steps) - {*STEPS, "again"}
    if unknown:
        parser.error(f"no such step: {', '.join(sorted(unknown))}; there are {', '.join(STEPS)} and again")
    commit = git("rev-parse", "--short", chosen.commit)
    proof = Proof(
        chosen.out, Plan(commit, chosen.before, chosen.seed, chosen.count, tuple(chosen.tests)), chosen.workers
    )
    if chosen.forget:
        proof.forget(chosen.forget)
    if "again" in chosen.steps:
        proof.again(commit)
    for step in [name for name in chosen.steps if name in STEPS] or STEPS:
        STEPS[step](proof)
    return 0


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # the copies of the tree are to go in any case
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        say("stopped; the same command goes on from here")
        sys.exit(_INTERRUPTED)
