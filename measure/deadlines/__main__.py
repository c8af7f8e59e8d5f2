"""``python -m measure.deadlines``: measures, and writes ``docs/carla/deadlines.md`` and its picture.

Each board's samples are kept in ``docs/carla/deadlines.json``: measuring one again leaves the others as they are. The
models take a minute each, the emulated boards a quarter of an hour.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from measure.deadlines.measure import Sample, measure
from measure.deadlines.pages import Samples, page, picture
from measure.deadlines.rigs import RIGS

DOCS = Path(__file__).parents[2] / "docs"
SEED = 1


def main(words: Sequence[str]) -> int:
    """Measure and write."""
    parser = argparse.ArgumentParser(prog="python -m measure.deadlines", description=__doc__)
    parser.add_argument("boards", nargs="*", metavar="BOARD", help=f"one of: {'; '.join(RIGS)} (default: all)")
    parser.add_argument("--count", type=int, default=100, help="how many times each (default: 100)")
    parser.add_argument("--docs", type=Path, default=DOCS, help="where the page goes")
    parser.add_argument("--pages", action="store_true", help="measure nothing: page and picture from what is kept")
    chosen = parser.parse_args(words)
    store = chosen.docs / "carla" / "deadlines.json"
    store.parent.mkdir(exist_ok=True)
    for name in () if chosen.pages else chosen.boards or RIGS:
        with RIGS[name](SEED) as rig:
            samples = measure(rig, chosen.count)
        kept: dict[str, Any] = json.loads(store.read_text(encoding="utf-8")) if store.is_file() else {}
        kept[name] = {event: [_rounded(sample) for sample in found] for event, found in samples.items()}
        store.write_text(json.dumps({board: kept[board] for board in RIGS if board in kept}) + "\n", encoding="utf-8")
    measured = read(store)
    (chosen.docs / "carla" / "deadlines.md").write_text(page(measured, SEED), encoding="utf-8")
    (chosen.docs / "images" / "carla-deadlines.svg").write_text(picture(measured), encoding="utf-8")
    return 0


def read(store: Path) -> Mapping[str, Samples]:
    """Return what was measured, by the names of the boards."""
    kept = json.loads(store.read_text(encoding="utf-8"))
    return {
        board: {
            event: [Sample(deadline_s=deadline, seen_s=seen) for deadline, seen in pairs]
            for event, pairs in events.items()
        }
        for board, events in kept.items()
    }


def _rounded(sample: Sample) -> tuple[float | None, float]:
    """To microseconds: a byte takes eleven."""
    deadline_s = None if sample.deadline_s is None else round(sample.deadline_s, 6)
    return deadline_s, round(sample.seen_s, 6) + 0.0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
