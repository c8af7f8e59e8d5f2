"""``python -m measure.drive_plots``: drives, and writes ``docs/vehicle-drive.md`` and its pictures; a few minutes."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from measure.drive_plots.drives import lap, slow, stop
from measure.drive_plots.pages import SLOW, course, page, seen_from_above, stopping

DOCS = Path(__file__).parents[2] / "docs"


def main(words: Sequence[str]) -> int:
    """Drive and write."""
    parser = argparse.ArgumentParser(prog="python -m measure.drive_plots", description=__doc__)
    parser.add_argument("--docs", type=Path, default=DOCS, help="where the page goes")
    docs = parser.parse_args(words).docs
    lapped = lap()
    stopped, lost_s, emergency_s = stop()
    for name, text in {
        "vehicle-drive.md": page(lapped, stopped, lost_s, emergency_s, [slow(*kind) for kind in SLOW]),
        "images/vehicle-lap.svg": seen_from_above(lapped),
        "images/vehicle-lap-course.svg": course(lapped),
        "images/vehicle-stop.svg": stopping(stopped, lost_s, emergency_s),
    }.items():
        (docs / name).write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
