"""Whole suites through each door, in virtual time: every case of a bench, and the run hash."""

from __future__ import annotations

import json
import subprocess
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from measure.doors.benches import DOORS

__all__ = ["WHOLE", "check_whole", "whole_page"]

Row = Mapping[str, Any]

WHOLE = ("rover", "vehicle", "rover-model", "pioneer")
"""Benches whose checker has a line; that of the Blue Pill looks at pins and the world."""

_HEAD = """\
## Whole suites, in virtual time

Made by `python -m measure.doors --whole`; the data is in [doors-whole.json](doors-whole.json). All suites of a bench
run on the emulated board or the model by `hilbench check BENCH --through ENDPOINT`, those with pins, wheels and cars
included. Every byte of the checker's lines passes the endpoint, which is made of the same classes as in real time
([doors.md](doors.md#an-endpoint-in-virtual-time)). The cells say how many cases have the same verdict as in memory. The
Blue Pill's suites are not here: they look at pins, and their checker has no line.

"""

_BETWEEN = """
The run hash covers all that was sent, done and judged, and when. The times are those of a host that had other work:

"""


def check_whole(bench: str, door: str) -> Row:
    """Check all suites of a bench with a door on the way; ``memory`` is none."""
    words = ["check", bench, "--json", "-"] + (["--through", door] if door != "memory" else [])
    done = subprocess.run([sys.executable, "-m", "hilbench", *words], capture_output=True, text=True, check=False)
    if not done.stdout.startswith("{"):
        raise RuntimeError(f"{' '.join(words)}: {done.stderr.strip()}")
    report = json.loads(done.stdout)
    counts: dict[str, Counter[str]] = {}
    for case in report["cases"]:
        counts.setdefault(case["suite"], Counter())[case["verdict"]] += 1
    return {
        "bench": bench,
        "door": door,
        "exit": done.returncode,
        "run_hash": report["run_hash"],
        "bench_time_s": round(report["bench_time_s"], 1),
        "host_time_s": round(report["host_time_s"], 1),
        "counts": {suite: dict(verdicts) for suite, verdicts in counts.items()},
        "not_passed": {case["id"]: case["verdict"] for case in report["cases"] if case["verdict"] != "pass"},
    }


def whole_page(rows: Sequence[Row]) -> str:
    """Return the part of the page that is about whole suites; nothing without rows."""
    by_key = {(row["bench"], row["door"]): row for row in rows}
    benches = [bench for bench in WHOLE if (bench, "memory") in by_key]
    if not benches:
        return ""
    doors = DOORS[1:]
    head = f"| Bench | Suite | Cases | In memory | {' | '.join(doors)} |\n|---|---|--:|---|{'--:|' * len(doors)}\n"
    lines = [line for bench in benches for line in _suites(bench, by_key)]
    hashes = (
        f"| Bench | Run hash | Bench time | memory | {' | '.join(doors)} |\n|---|---|--:|--:|{'--:|' * len(doors)}\n"
    )
    times = [_times(bench, by_key) for bench in benches]
    return _HEAD + head + "\n".join(lines) + "\n" + _BETWEEN + hashes + "\n".join(times) + "\n"


def _suites(bench: str, by_key: Mapping[tuple[str, str], Row]) -> Sequence[str]:
    memory = by_key[bench, "memory"]
    lines = []
    suites = dict.fromkeys(suite for (its, _), row in by_key.items() if its == bench for suite in row["counts"])
    for suite in suites:
        verdicts = memory["counts"].get(suite, {})
        told = ", ".join(f"{count} {verdict}" for verdict, count in sorted(verdicts.items()))
        cells = [_same(by_key.get((bench, door)), memory, suite) for door in DOORS[1:]]
        lines.append(f"| {bench} | {suite} | {sum(verdicts.values())} | {told} | {' | '.join(cells)} |")
    return lines


def _same(row: Row | None, memory: Row, suite: str) -> str:
    """Return how many cases of a suite have the same verdict as in memory."""
    if row is None:
        return "-"
    cases, in_memory = (sum(one["counts"].get(suite, {}).values()) for one in (row, memory))
    here, there = row["not_passed"], memory["not_passed"]
    other = {case for case in {*here, *there} if _suite(case) == suite and here.get(case) != there.get(case)}
    same = str(cases - len(other)) + (f", other: {', '.join(sorted(other))}" if other else "")
    return same if cases == in_memory else f"**{cases} of {in_memory} cases**, {same}"


def _times(bench: str, by_key: Mapping[tuple[str, str], Row]) -> str:
    memory = by_key[bench, "memory"]
    cells = []
    for door in DOORS:
        row = by_key.get((bench, door))
        if row is None:
            cells.append("-")
            continue
        said = "same, " if row["run_hash"] == memory["run_hash"] else f"**{row['run_hash'][:12]}**, "
        cells.append(f"{said if door != 'memory' else ''}{row['host_time_s']:.0f} s")
    return f"| {bench} | {memory['run_hash'][:12]} | {memory['bench_time_s']:.0f} s | {' | '.join(cells)} |"


def _suite(case: str) -> str:
    return case.partition("/")[0]
