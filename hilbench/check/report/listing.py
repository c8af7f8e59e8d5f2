"""``hilbench check --list``: what would run, and how long it would take."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

import msgspec

from hilbench.check.collector import PlannedCase
from hilbench.clock.text import seconds_text
from hilbench.files import write_atomically
from hilbench.files.names import escaped_all
from hilbench.judging.verdicts import BY_OWN_REPORT
from hilbench.terminal.console import Console
from hilbench.terminal.options import CheckOptions


class ListedCase(msgspec.Struct, frozen=True, kw_only=True):
    """One line of the list, as ``--json`` gives it.

    Attributes:
        id: suite, function and parameters.
        suite: its suite.
        clause_ids: the clauses it checks.
        levels: the level of each.
        titles: the title of each.
        bench_time_s: about how long it takes, in seconds of bench time.
        needs: the capabilities it needs.
        missing: those that the bench lacks; it applies if there are none.
        by_own_report: what is needed besides, which the bench lacks and the target's own reports stand in for.
        by_hand: those of its needs for which somebody beside the target is asked.
    """

    id: str
    suite: str
    clause_ids: tuple[str, ...]
    levels: tuple[str, ...]
    titles: tuple[str, ...]
    bench_time_s: float
    needs: tuple[str, ...]
    missing: tuple[str, ...]
    by_own_report: tuple[str, ...]
    by_hand: tuple[str, ...]


def show(planned: Sequence[PlannedCase], options: CheckOptions, console: Console) -> None:
    """Print the list, or write it as JSON if the options say so.

    Raises:
        UsageError: the file cannot be written.
    """
    if options.json is None:
        console.data(as_text(planned))
        return
    listed = escaped_all(msgspec.to_builtins([_listed(case) for case in planned]))
    text = msgspec.json.format(msgspec.json.encode(listed), indent=2).decode()
    if options.json == "-":
        console.data(text)
    else:
        write_atomically(Path(options.json), f"{text}\n")


def as_text(planned: Sequence[PlannedCase]) -> str:
    """Return the list for a person: grouped by suite, with the sum of what applies."""
    lines = []
    for suite, cases in groupby(planned, key=lambda case: case.suite):
        rows = [_row(case) for case in cases]
        widths = [max(len(row[column]) for row in rows) for column in range(4)]
        lines.append(suite)
        lines += ["  " + "  ".join(_padded(row, widths)).rstrip() for row in rows]
    return "\n".join([*lines, "", _total(planned)])


def _row(case: PlannedCase) -> tuple[str, ...]:
    levels = "/".join(dict.fromkeys(clause.level for clause in case.clauses))
    if case.missing:
        remark = f"not applicable: no {', '.join(case.missing)}"
    else:
        remark = f"needs {', '.join(sorted(case.needs))}" if case.needs else ""
        remark += f"; {BY_OWN_REPORT}no {', '.join(case.by_own_report)}" if case.by_own_report else ""
        remark += f"; asks the operator for {', '.join(sorted(case.by_hand))}" if case.by_hand else ""
    return (", ".join(case.clause_ids), levels, seconds_text(case.bench_time_s), case.id.partition("/")[2], remark)


def _padded(row: Sequence[str], widths: Sequence[int]) -> list[str]:
    cells = [cell.ljust(width) for cell, width in zip(row, widths, strict=False)]
    return [*cells[:2], row[2].rjust(widths[2]), cells[3], row[4]]


def _total(planned: Sequence[PlannedCase]) -> str:
    applicable = [case for case in planned if not case.missing]
    clauses = {clause for case in applicable for clause in case.clause_ids}
    time_s = sum(case.bench_time_s for case in applicable)
    count = f"{len(clauses)} clause{'s' * (len(clauses) != 1)}"
    return f"{len(applicable)} of {len(planned)} cases apply: {count}, about {seconds_text(time_s)} of bench time"


def _listed(case: PlannedCase) -> ListedCase:
    return ListedCase(
        id=case.id,
        suite=case.suite,
        clause_ids=case.clause_ids,
        levels=tuple(clause.level for clause in case.clauses),
        titles=tuple(clause.title for clause in case.clauses),
        bench_time_s=case.bench_time_s,
        needs=tuple(sorted(case.needs)),
        missing=case.missing,
        by_own_report=case.by_own_report,
        by_hand=tuple(sorted(case.by_hand)),
    )
