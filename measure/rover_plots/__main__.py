"""``python -m measure.rover_plots``: drives the rover, wheels in the air; writes what came of it, page and pictures.

They go to ``docs/rover-motion.json``, ``docs/rover-motion.md`` and ``docs/images``.
``--pages`` drives nothing and makes page and pictures again from what is known.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from measure.rover_plots.drives import DOWNWARDS, STEPS, UPWARDS, course, sweep
from measure.rover_plots.pages import page
from measure.rover_plots.pictures import pictures

DOCS = Path(__file__).parents[2] / "docs"


def main(words: Sequence[str]) -> int:
    """Do what the command line says."""
    parser = argparse.ArgumentParser(prog="python -m measure.rover_plots", description=__doc__)
    parser.add_argument("--pages", action="store_true", help="drive nothing")
    parser.add_argument("--docs", type=Path, default=DOCS, help="where it all goes")
    chosen = parser.parse_args(words)
    path = chosen.docs / "rover-motion.json"
    if not chosen.pages:
        path.write_text(json.dumps(_driven(), separators=(",", ":")) + "\n", encoding="utf-8")
    record = json.loads(path.read_text(encoding="utf-8"))
    (chosen.docs / "rover-motion.md").write_text(page(record), encoding="utf-8")
    for name, data in pictures(record).items():
        (chosen.docs / "images" / name).write_bytes(data)
    return 0


def _driven() -> dict[str, Any]:
    record: dict[str, Any] = {"up": _told("upwards", sweep(UPWARDS)), "down": _told("downwards", sweep(DOWNWARDS, 1.0))}
    record["steps"] = {step.name: _told(step.name, course(step)) for step in STEPS}
    return record


def _told(name: str, found: Any) -> Any:
    sys.stderr.write(f"{name}: done\n")
    return found


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
