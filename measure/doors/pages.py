"""The page of the doors, made from its record."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from measure.doors.benches import DOORS

__all__ = ["compared", "page"]

Row = Mapping[str, Any]

_HEAD = """\
# The same verdicts through each endpoint

Made by `make doors`. Do not edit.

Each suite runs on a board in memory, and on the same board behind an endpoint: a pty, a TCP port, RFC 2217, and a pty
with `hilbench proxy` in between. Whole suites are compared in virtual time, where nothing can be late. Parts of them
are also compared in real time, with separate processes.

"""

_REAL_TIME = """\
## In real time

Made by `python -m measure.doors`; the data is in [doors-verdicts.json](doors-verdicts.json). One process checks what
another, `hilbench serve`, has behind an endpoint.

| Column | Cases |
|---|---|
| As in memory | have the same verdict |
| Inconclusive | have a limit within what the bench could measure, or failed for no figure while it was late |
| Other | have another verdict: a defect |

The board behind an endpoint is a separate process on the same host. It reports its lateness to the checker
([doors.md](doors.md#if-the-host-is-late)). So a board that stands still for 0.3 s makes a case inconclusive and not a
fail. The last columns show how late both were: lateness p50, p99 and max in ms, then slips; for the board its speed as
a part of real time comes first. On an idle host fewer cases are inconclusive.

A board behind an endpoint runs one program, so cases of other programs do not apply there. Cases that need pins, wheels
or the world do not apply either. The column *Cases* says which were run.

"""


def compared(row: Row, memory: Row) -> Counter[str]:
    """Return how many cases have the same verdict as in memory, are inconclusive, differ, or do not apply."""
    return Counter(_relations(row, memory).values())


def _relations(row: Row, memory: Row) -> Mapping[str, str]:
    """Return how each case's verdict relates to that in memory."""
    return {case: _relation(verdict, memory["verdicts"].get(case)) for case, verdict in row["verdicts"].items()}


def _relation(verdict: str, in_memory: str | None) -> str:
    if in_memory is None or verdict in {"n/a", "not-applicable"}:
        return "n/a"
    if verdict == in_memory:
        return "same"
    return "inconclusive" if verdict == "inconclusive" else "other"


def page(record: Sequence[Row], whole: str = "") -> str:
    """Return the page, with the part of whole suites."""
    by_key = {(row["bench"], row["suite"], row["door"]): row for row in record}
    lines = [
        "| Bench | Suite | Cases | Endpoint | As in memory | Inconclusive | Other | Checker | Board |",
        "|---|---|---|---|--:|--:|--:|--:|--:|",
    ]
    others: list[str] = []
    open_ones: list[str] = []
    for bench, suite in dict.fromkeys((row["bench"], row["suite"]) for row in record):
        memory = by_key.get((bench, suite, "memory"))
        if memory is None:
            continue
        for door in DOORS:
            row = by_key.get((bench, suite, door))
            if row is not None:
                lines.append(_line(row, memory))
                others += _cases(row, memory, "other")
                open_ones += _cases(row, memory, "inconclusive")
    slipped = sum(1 for row in record if row["served"] is not None and row["served"]["slips"])
    if slipped:
        lines.append(f"\nThe host was busy with other work: the board slipped in {slipped} of these rows.")
    text = _HEAD + (f"{whole}\n" if whole else "") + _REAL_TIME + "\n".join(lines) + "\n"
    for heading, cases in (("Other verdicts than in memory", others), ("Inconclusive", open_ones)):
        if cases:
            text += f"\n### {heading}\n\n" + "\n".join(cases) + "\n"
    return text


def _line(row: Row, memory: Row) -> str:
    count = compared(row, memory)
    select = f'`-k "{row["select"]}"`' if row["select"] else "all"
    counts = (count[relation] for relation in ("same", "inconclusive", "other"))
    cells = (row["bench"], row["suite"], select, row["door"], *counts, _checker(row["pace"]), _board(row["served"]))
    return "| " + " | ".join(map(str, cells)) + " |"


def _checker(pace: Mapping[str, float] | None) -> str:
    if pace is None:
        return "virtual time"
    figures = (pace[f"lateness_{name}_s"] * 1000 for name in ("p50", "p99", "max"))
    return ", ".join(f"{value:.2f}" for value in figures) + f"; {pace['slips']}"


def _board(served: Mapping[str, float] | None) -> str:
    if served is None:
        return "-"
    figures = ", ".join(f"{served[name]:.2f}" for name in ("p50", "p99", "max"))
    return f"{served['factor']:.3f}; {figures}; {served['slips']:.0f}"


def _cases(row: Row, memory: Row, wanted: str) -> list[str]:
    """Return a line for each case whose verdict relates so to that in memory."""
    here, there, causes = row["verdicts"], memory["verdicts"], row["causes"]
    return [
        f"- {row['bench']}, {row['door']}: `{case}` {here[case]}, in memory {there[case]}: "
        f"{' '.join(causes.get(case, '').split())}"
        for case, relation in _relations(row, memory).items()
        if relation == wanted
    ]
