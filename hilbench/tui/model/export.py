"""What is selected on the screen as a file: frames, counters, plots, log, console, verdicts as CSV, JSON or hex."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.checks import ChecksModel
from hilbench.tui.model.frames import FrameModel

__all__ = ["EXPORTS", "Selection", "exported"]

NS_PER_S = 1_000_000_000
Row = Mapping[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Selection:
    """What is selected.

    Attributes:
        model: of the bench.
        frames: those that the filter lets pass, or the one that is pointed at.
        signals: the names of those that are plotted.
        span_s: over how long.
        checks: the run of suites that is shown.
    """

    model: BenchModel
    frames: Sequence[FrameModel]
    signals: Sequence[str]
    span_s: int
    checks: ChecksModel


def _frames(selection: Selection) -> Iterable[Row]:
    for frame in selection.frames:
        yield {
            "number": frame.number,
            "time_s": frame.ns / NS_PER_S,
            "way": "sent" if frame.sent else "heard",
            "name": frame.item.name,
            "sound": frame.good,
            "says": frame.text,
            "bytes": frame.item.raw.hex(),
        }


def _counters(selection: Selection) -> Iterable[Row]:
    model = selection.model
    groups = [(name, one.counters) for name, one in model.machines.items()]
    groups += [(name, one.counters) for name, one in model.lines.items()]
    for source, counters in groups:
        for name, counted in counters.items():
            rate = round(counted.per_s(model.ns), 3)
            yield {"source": source, "counter": name, "value": counted.value, "per_s": rate}


def _plot(selection: Selection) -> Iterable[Row]:
    """Return a row a point, in the order of time: signals come at times of their own, and none is made up between."""
    model = selection.model
    begin_ns = model.ns - selection.span_s * NS_PER_S
    there = {name: model.signals.signal(name) for name in selection.signals}
    points = [
        (ns, name, number, value, signal.unit)
        for name, signal in there.items()
        if signal is not None
        for number, part in enumerate(signal.parts, 1)
        for ns, value in part
        if begin_ns <= ns <= model.ns
    ]
    for ns, name, number, value, unit in sorted(points):
        yield {"time_s": ns / NS_PER_S, "signal": name, "part": number, "value": value, "unit": unit}


def _log(selection: Selection) -> Iterable[Row]:
    for line in selection.model.log.lines:
        yield {
            "time_s": line.ns / NS_PER_S,
            "source": line.source,
            "text": line.text,
            "bad": line.bad,
            "times": line.count,
        }


def _console(selection: Selection) -> Iterable[Row]:
    for line in selection.model.console.lines:
        yield {"time_s": line.ns / NS_PER_S, "source": line.source, "text": line.text}


def _checks(selection: Selection) -> Iterable[Row]:
    for row in selection.checks.rows.values():
        evidence = " | ".join(map(str, row.about.get("evidence", ())))
        yield {
            "clause": row.id, "suite": row.suite, "level": row.level, "verdict": row.state,
            "title": f"{row.mark}{row.title}", "cause": row.cause, "evidence": evidence,
        }  # fmt: skip


EXPORTS: dict[str, tuple[str, Callable[[Selection], Iterable[Row]], tuple[str, ...]]] = {
    "frames": (
        "those that the filter lets pass; held: the one pointed at",
        _frames,
        ("csv", "json", "hex"),
    ),
    "counters": ("of both ends and of the line, with rates", _counters, ("csv", "json")),
    "plot": ("the points that are plotted", _plot, ("csv", "json")),
    "log": ("all lines", _log, ("csv", "json")),
    "console": ("what firmware said", _console, ("csv", "json")),
    "checks": ("clauses and verdicts", _checks, ("csv", "json")),
}
"""What can be exported: what it is, its rows, and the forms there are of it."""


def exported(what: str, form: str, selection: Selection) -> tuple[str, int]:
    """Return the text of a file, and how many rows it has.

    Args:
        what: one of `EXPORTS`.
        form: csv; json: a list of objects; hex: the bytes of a frame a line, ``>`` sent and ``<`` heard.
        selection: what is selected.
    """
    rows = list(EXPORTS[what][1](selection))
    if form == "json":
        return json.dumps(rows, indent=1, ensure_ascii=False) + "\n", len(rows)
    if form == "hex":
        return "".join(f"{'>' if row['way'] == 'sent' else '<'} {row['bytes']}\n" for row in rows), len(rows)
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]) if rows else [], lineterminator="\n")
    if rows:
        writer.writeheader()
        writer.writerows(rows)
    return text.getvalue(), len(rows)
