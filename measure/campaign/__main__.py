"""``python -m measure.campaign``: drives in many rooms; writes ``docs/campaign.json`` and ``docs/campaign.md``.

What is known of other seeds and ways stays; ``--pages`` drives nothing and makes the page again;
``--picture SEED`` draws ``docs/images/dodge.svg``.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hilbench.suites._clearance import outline_m
from measure.campaign.drives import WAYS, drive, track
from measure.campaign.pages import page
from worlds.above import Sheet, top_view
from worlds.vehicles.pioneer_2dx import vehicle

DOCS = Path(__file__).parents[2] / "docs"
LEGENDS = {
    "a": "a: pins to the wheels",
    "b": "b: pins over the adapter, the same program",
    "c": "c: P2OS by the program",
}


def main(words: Sequence[str]) -> int:
    """Drive what the command line says; 1 if anything was touched, or a program did not run on."""
    parser = argparse.ArgumentParser(prog="python -m measure.campaign", description=__doc__)
    parser.add_argument("--seeds", type=int, default=20, help="how many rooms (default: 20)")
    parser.add_argument("--way", action="append", choices=[*WAYS], help="only this way (repeatable)")
    parser.add_argument("--seconds", type=float, default=180.0, help="bench time of a drive (default: 180)")
    parser.add_argument("--missing", action="store_true", help="only what is not known yet")
    parser.add_argument("--picture", type=int, metavar="SEED", help="only draw the tracks in this room")
    parser.add_argument("--pages", action="store_true", help="drive nothing")
    parser.add_argument("--docs", type=Path, default=DOCS, help="where the pages go")
    chosen = parser.parse_args(words)
    if chosen.picture is not None:
        return _draw(chosen.docs, chosen.picture, chosen.seconds)
    path = chosen.docs / "campaign.json"
    record: dict[tuple[str, int], dict[str, Any]] = {}
    if path.is_file():
        record = {(row["way"], row["seed"]): row for row in json.loads(path.read_text(encoding="utf-8"))}
    todo = [] if chosen.pages else [(way, seed) for seed in range(chosen.seeds) for way in chosen.way or WAYS]
    todo = [one for one in todo if not (chosen.missing and one in record)]
    for number, (way, seed) in enumerate(todo, 1):
        figures = drive(way, seed, chosen.seconds)
        record[way, seed] = figures.data()
        _write(chosen.docs, record)
        verdict = "no contact" if figures.good else figures.touched or figures.end
        sys.stderr.write(f"{number}/{len(todo)} way {way}, seed {seed}: {figures.way_m:.1f} m, {verdict}\n")
    _write(chosen.docs, record)
    return 1 if any(row["contacts"] or row["end"] for row in record.values()) else 0


def _write(docs: Path, record: dict[tuple[str, int], dict[str, Any]]) -> None:
    rows = [record[key] for key in sorted(record)]
    lines = ",\n".join(json.dumps(row) for row in rows)
    (docs / "campaign.json").write_text(f"[\n{lines}\n]\n", encoding="utf-8")
    (docs / "campaign.md").write_text(page(rows), encoding="utf-8")


def _draw(docs: Path, seed: int, seconds: float) -> int:
    tracks, good, scene = {}, True, None
    for way, legend in LEGENDS.items():
        scene, points, figures = track(way, seed, seconds)
        tracks[f"{legend}, {figures.way_m:.1f} m"] = points
        good = good and figures.good
    assert scene is not None
    sheet = Sheet(title=f"{scene.name} from above, with the tracks of the dodger")
    text = top_view(scene, tracks, [outline_m(vehicle())], sheet)
    (docs / "images" / "dodge.svg").write_text(text, encoding="utf-8")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
