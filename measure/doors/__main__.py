"""``python -m measure.doors``: checks through each door; writes ``docs/doors-verdicts.json`` and the page beside it.

What is known of other suites and doors stays; ``--pages`` checks nothing and makes the page again. ``--whole`` checks
all suites of a bench in virtual time, an hour for all and on any host, into ``docs/doors-whole.json``. The rest takes
half an hour or more, in real time: the host should have nothing else to do.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from measure.doors.benches import BENCHES, DOORS
from measure.doors.pages import compared, page
from measure.doors.runs import run_through
from measure.doors.whole import WHOLE, check_whole, whole_page

DOCS = Path(__file__).parents[2] / "docs"

_VERDICTS, _WHOLE = "doors-verdicts.json", "doors-whole.json"

Key = tuple[str, str, str]


def main(words: Sequence[str]) -> int:
    """Check what the command line says; 1 if a verdict differs without being inconclusive."""
    parser = argparse.ArgumentParser(prog="python -m measure.doors", description=__doc__)
    names = list(dict.fromkeys([*WHOLE, *(one.bench for one in BENCHES)]))
    parser.add_argument("--bench", action="append", choices=names, help="only this bench")
    parser.add_argument("--door", action="append", choices=DOORS, help="only this door (repeatable)")
    parser.add_argument("-k", dest="select", default="", metavar="EXPR", help="only these cases")
    parser.add_argument("--whole", action="store_true", help="whole suites, in virtual time")
    parser.add_argument("--pages", action="store_true", help="check nothing")
    parser.add_argument("--docs", type=Path, default=DOCS, help="where the pages go")
    chosen = parser.parse_args(words)
    served = WHOLE if chosen.whole else [one.bench for one in BENCHES]
    if wrong := set(chosen.bench or ()) - set(served):
        parser.error(f"not checked so: {', '.join(sorted(wrong))}; there are {', '.join(served)}")
    if chosen.whole and chosen.select:
        parser.error("--whole is all cases: leave -k away")
    if chosen.whole:
        return _whole(chosen)
    rows = _read(chosen.docs / _VERDICTS)
    record: dict[Key, dict[str, Any]] = {(row["bench"], row["suite"], row["door"]): row for row in rows}
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
    docs.joinpath(_VERDICTS).write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    _write_page(docs, rows)


def _whole(chosen: argparse.Namespace) -> int:
    """Check whole suites; 1 if a run is another than in memory."""
    other = False
    for bench in chosen.bench or WHOLE:
        known = any((one["bench"], one["door"]) == (bench, "memory") for one in _read(chosen.docs / _WHOLE))
        for door in dict.fromkeys([*([] if known else ["memory"]), *(chosen.door or DOORS)]):
            row = check_whole(bench, door)
            rows = {(one["bench"], one["door"]): one for one in _read(chosen.docs / _WHOLE)} | {(bench, door): row}
            other |= row["run_hash"] != rows[bench, "memory"]["run_hash"]
            ordered = sorted(rows.values(), key=lambda one: (WHOLE.index(one["bench"]), DOORS.index(one["door"])))
            text = "[\n" + ",\n".join(map(json.dumps, ordered)) + "\n]\n"
            chosen.docs.joinpath(_WHOLE).write_text(text, encoding="utf-8")
            _write_page(chosen.docs, _read(chosen.docs / _VERDICTS))
            sys.stderr.write(f"{bench} whole {door}: {row['host_time_s']} s, run hash {row['run_hash']}\n")
    return int(other)


def _read(path: Path) -> list[dict[str, Any]]:
    return list(json.loads(path.read_text(encoding="utf-8"))) if path.is_file() else []


def _write_page(docs: Path, rows: Sequence[dict[str, Any]]) -> None:
    text = page(rows, whole_page(_read(docs / _WHOLE)))
    docs.joinpath("doors-verdicts.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
