"""``python -m measure.resync``: measures, and writes ``docs/carla/resync.md``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from measure.resync.measure import KINDS, Outcome, worst

DOCS = Path(__file__).parents[2] / "docs"
COUNTS = range(1, 31)
SEEDS = 50
SHORT_S = 2.0
LONG_S = 60.0

HEAD = """<!-- Made by `python -m measure.resync`; change that, then run it. -->

# What stray bytes cost the board

A status has neither number nor checksum, so a byte that does not belong to one can only be told by its place. The
board as it was shipped (profiles `v0` and `v1`) takes 22 bytes at a time and reads each such block from its start: one
stray or lost byte shifts all that follow, no block holds a whole frame any more, and the mode goes to EMERGENCY after
ten misses. Only 22 stray bytes, or as many as make whole blocks of them, leave it where it was. The hardened board
looks for the next `#` in whatever failed.

The experiment: the board drives in AUTOWARE with statuses at 20 Hz and commands at 30 Hz; after 2 s the stray bytes
come in, then statuses as before. *Lost* is the number of sound statuses before the first that is accepted: the worst of
{kinds},
{seeds} seeds each. *Accepted* is counted over {long:g} s, {sent} statuses; *emergency* from the stray bytes on.

The hardened board can lose one status, but only where the stray bytes are the beginning of a status and the next one
happens to have the missing letters within its floats, each at its place: one in 256 for each letter that is missing.
Where the values are possible, too, it then believes one that nobody sent. The status after that is found.

| Stray bytes | As shipped: accepted | Emergency after | At the end | Hardened: lost | Emergency | At the end |
|--:|--:|--:|---|--:|---|---|
"""


def main(words: Sequence[str]) -> int:
    """Measure and write."""
    parser = argparse.ArgumentParser(prog="python -m measure.resync", description=__doc__)
    parser.add_argument("--docs", type=Path, default=DOCS, help="where the page goes")
    chosen = parser.parse_args(words)
    (chosen.docs / "carla" / "resync.md").write_text(page(), encoding="utf-8")
    return 0


def page(counts: Sequence[int] = COUNTS, *, seeds: int = SEEDS, long_s: float = LONG_S) -> str:
    """The page, with a row for each number of stray bytes."""
    rows = [
        (count, worst("v0", count, seeds=1, seconds=long_s), worst("hardened", count, seeds=seeds, seconds=SHORT_S))
        for count in counts
    ]
    kinds = ", ".join(KINDS)
    text = HEAD.format(kinds=kinds, seeds=seeds, long=long_s, sent=rows[0][1].sent)
    return text + "".join(row(*one) for one in rows)


def row(count: int, shipped: Outcome, hardened: Outcome) -> str:
    """One line of the table."""
    return (
        f"| {count} | {shipped.accepted} | {_after(shipped)} | {shipped.mode.name} "
        f"| {hardened.lost} | {_after(hardened)} | {hardened.mode.name} |\n"
    )


def _after(outcome: Outcome) -> str:
    return "none" if outcome.emergency_ms is None else f"{outcome.emergency_ms} ms"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
