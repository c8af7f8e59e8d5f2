"""``python -m measure.loss``: measures, and writes ``docs/pkt/loss.md`` and ``docs/images/pkt-loss.svg``."""

from __future__ import annotations

import argparse
import random
import sys
from collections.abc import Sequence
from itertools import islice
from pathlib import Path

from measure.loss.measure import Loss, lost_by_lines, lost_by_newline
from measure.loss.pages import page, picture
from measure.loss.payloads import STRUCTURED, random_payloads

DOCS = Path(__file__).parents[2] / "docs"
SIZES = (1, 3, 5, 6, 10, 12, 24, 36, 52, 60, 64, 80, 96)
SEED = 1


def main(words: Sequence[str]) -> int:
    """Measure and write."""
    parser = argparse.ArgumentParser(prog="python -m measure.loss", description=__doc__)
    parser.add_argument("--count", type=int, default=100_000, help="how many frames each (default: 100000)")
    parser.add_argument("--docs", type=Path, default=DOCS, help="where the page goes")
    chosen = parser.parse_args(words)
    random_losses = {
        size: lost_by_newline(random_payloads(size, random.Random(SEED + size)), chosen.count) for size in SIZES
    }
    structured: dict[str, tuple[int, Loss, Loss]] = {}
    for name, (_, make) in STRUCTURED.items():
        (first,) = islice(make(random.Random(SEED)), 1)
        if len(first) == 10:  # its length is a newline: no line-splitting client ever sees it
            loss = lost_by_newline(make(random.Random(SEED)), chosen.count)
            structured[name] = (len(first), loss, Loss(0, chosen.count))
        else:
            structured[name] = (len(first), *lost_by_lines(make(random.Random(SEED)), chosen.count))
    (chosen.docs / "pkt" / "loss.md").write_text(page(random_losses, structured, chosen.count), encoding="utf-8")
    (chosen.docs / "images" / "pkt-loss.svg").write_text(picture(random_losses, structured), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
