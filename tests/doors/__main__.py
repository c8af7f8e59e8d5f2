"""``python -m tests.doors``: checks through each door; writes ``docs/doors-verdicts.json`` and the page beside it.

What is known of other suites and doors stays; ``--pages`` checks nothing and makes the page again. Everything takes an
hour or more, in real time: the host should have nothing else to do.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tests.doors.benches import BENCHES, DOORS
from tests.doors.pages import compared, page
from tests.doors.runs import run_through

DOCS = Path(__file__).parents[2] / "docs"

Key = tuple[str, str, str]


def main(words: Sequence[str]) -> int:
    """Check what the command line says; 1 if a verdict differs without being inconclusive."""
    parser = argparse.ArgumentParser(prog="python -m tests.doors", description=__doc__)
    parser.add_argument("--bench", action="append", choices=[one.bench for one in BENCHES], help="only this bench")
    parser.add_argument("--door", action="append", choices=DOORS, help="only this door (repeatable)")
    parser.add_argument("-k", dest="select", default="", metavar="EXPR", help="only these cases")
    parser.add_argument("--pages", action="store_true", help="check nothing")
    parser.add_argument("--docs", type=Path, default=DOCS, help="where the pages go")
    chosen = parser.parse_args(words)
    path = chosen.docs / "doors-verdicts.json"
    record: dict[Key, dict[str, Any]] = {}
    if path.is_file():
        rows = json.loads(path.read_text(encoding="utf-8"))
        record = {(row["bench"], row["suite"], row["door"]): row for row in rows}
    benches = [] if chosen.pages else [one for one in BENCHES if one.bench in (chosen.bench or [one.bench])]
    for served in benches:
        for door in chosen.door or DOORS:
            row = dict(run_through(door, served, chosen.select))
            record[served.bench, served.suite, door] = row
            _write(chosen.docs, record)
            sys.stderr.write(f"{served.bench} {served.suite} {door}: {row['host_time_s']} s\n")
    _write(chosen.docs, record)
    return 1 if any(_differs(row, record) for row in record.values()) else 0


def _differs(row: dict[str, Any], record: dict[Key, dict[str, Any]]) -> bool:
    memory = record.get((row["bench"], row["suite"], "memory"))
    return memory is not None and compared(row, memory)["other"] > 0


def _write(docs: Path, record: dict[Key, dict[str, Any]]) -> None:
    order = {(one.bench, one.suite): number for number, one in enumerate(BENCHES)}
    rows = sorted(record.values(), key=lambda row: (order[row["bench"], row["suite"]], DOORS.index(row["door"])))
    docs.joinpath("doors-verdicts.json").write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    docs.joinpath("doors-verdicts.md").write_text(page(rows), encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
