"""The report for a person: a matrix of clauses, an account of what went wrong, a summary."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import groupby

from hilbench.check.report import footer
from hilbench.check.results import ClauseResult, Counts, Report
from hilbench.clock.text import factor_text, seconds_text
from hilbench.exit_codes import ExitCode
from hilbench.judging.note_lines import notes_counted
from hilbench.judging.verdicts import Verdict

_EVIDENCE_LINES = 22
_LAST_LINES = 4
_MOST_CASES = 4
_MOST_CAUSES, _FEW = 3, 3
"""How many common causes are named, and of how many clauses one has to be (choice)."""
_PLAIN_WIDTH = 10_000

_STYLES = {
    "pass": "green",
    "fail": "bold red",
    "warn": "yellow",
    "inconclusive": "magenta",
    "error": "bold red",
    "n/a": "dim",
    "not run": "dim",
}


def render(report: Report, *, colours: bool, width: int | None, quiet: bool = False) -> str:
    """Return the whole report as text.

    Args:
        report: what to show.
        colours: whether to mark verdicts with terminal colours.
        width: columns to cut titles to; None does not cut.
        quiet: leave out what is shown or does not apply, and all of the summary but why it stopped and the exit code.
    """
    lines = [] if quiet else [headline(report.bench, report.seed, report.hilbench), ""]
    for suite, clauses in groupby([] if quiet else report.clauses, key=lambda clause: clause.suite):
        lines += [*_suite(suite, list(clauses), colours, width or _PLAIN_WIDTH), ""]
    first: dict[tuple[str, ...], ClauseResult] = {}
    for clause in _accounted(report):
        known = first.setdefault(_alike(clause), clause)
        lines += [*(_account(clause, colours) if known is clause else _again(clause, known, colours)), ""]
    summary = _summary(report, colours)
    last = 2 if report.stopped else 1
    return "\n".join([*lines, *(summary[-last:] if quiet else summary)])


def headline(bench: dict[str, str], seed: int, version: str) -> str:
    """Return the first line: what was checked, on what, and with which seed."""
    parts = [f"{key} {value}" for key, value in bench.items() if value]
    return " · ".join([f"hilbench {version}", *parts, f"seed {seed}"])


def word_for(clause: ClauseResult) -> str:
    """Return the verdict in the words of the matrix: a failing *should* only warns unless it counts."""
    if clause.verdict is Verdict.FAIL and not clause.counts:
        return "warn"
    short = {Verdict.NOT_APPLICABLE: "n/a", Verdict.NOT_RUN: "not run"}
    return short.get(clause.verdict, clause.verdict.value)


def _suite(suite: str, clauses: Sequence[ClauseResult], colours: bool, width: int) -> list[str]:
    rows = [_row(clause) for clause in clauses]
    head = ("clause", "level", "verdict", "margin", "time", suite)
    widths = [max(len(row[column]) for row in [head, *rows]) for column in range(5)]
    lines = [_painted(_joined(head, widths, width), "bold", colours)]
    for clause, row in zip(clauses, rows, strict=True):
        text = _joined(row, widths, width)
        word = word_for(clause)
        start = sum(widths[:2]) + 6
        lines.append(
            text[:start] + _painted(text[start : start + len(word)], _STYLES[word], colours) + text[start + len(word) :]
        )
    return lines


def _row(clause: ClauseResult) -> tuple[str, ...]:
    note = ""
    if clause.verdict in {Verdict.NOT_APPLICABLE, Verdict.NOT_RUN}:
        note = f" [{clause.cause.removeprefix('not run: ')}]"
    return (
        clause.id,
        clause.level,
        word_for(clause),
        footer.margin_text(clause.worst_margin),
        seconds_text(clause.bench_time_s),
        clause.mark + clause.title + note,
    )


def _joined(row: Sequence[str], widths: Sequence[int], width: int) -> str:
    *cells, title = row
    padded = [cell.ljust(size) for cell, size in zip(cells, widths, strict=True)]
    padded[-1] = cells[-1].rjust(widths[-1])
    line = "  " + "  ".join([*padded, title])
    return line if len(line) <= width else f"{line[: width - 1]}…"


def _accounted(report: Report) -> list[ClauseResult]:
    """Return the clauses with an account: what failed, then what the bench cannot tell."""
    groups = ({Verdict.FAIL, Verdict.ERROR}, {Verdict.INCONCLUSIVE})
    return [clause for verdicts in groups for clause in report.clauses if clause.verdict in verdicts]


def _head(clause: ClauseResult, colours: bool) -> str:
    word = word_for(clause)
    return f"{_painted(word.upper(), _STYLES[word], colours)} {clause.id} ({clause.level}) {clause.title}"


def _alike(clause: ClauseResult) -> tuple[str, ...]:
    """Return what accounts have in common of which only the first is whole."""
    return clause.suite, clause.verdict.value, clause.cause or clause.id


def _again(clause: ClauseResult, known: ClauseResult, colours: bool) -> list[str]:
    """Return the account of a clause whose cause is in the words of one further up: only the last of its evidence."""
    return [
        _head(clause, colours),
        f"  cause      as {known.id}: {clause.mark}{clause.cause}",
        f"  clause     {clause.text}",
        *_labelled("case", _cases(clause)),
        *_labelled("evidence", clause.evidence[:_EVIDENCE_LINES][-_LAST_LINES:]),
        *_labelled("screen", [clause.screen] if clause.screen else []),
        f"  reproduce  {clause.reproduce}",
    ]


def _common(report: Report) -> list[str]:
    """Return the causes of several clauses: what is behind them may be one defect."""
    accounted = _accounted(report)
    alike = Counter(_alike(clause) for clause in accounted)
    return [
        f"the same words for {count} of {len(accounted)}: {cause} "
        f"(first {next(one.id for one in accounted if _alike(one) == (suite, verdict, cause))})"
        for (suite, verdict, cause), count in alike.most_common(_MOST_CAUSES)
        if count >= _FEW
    ]


def _account(clause: ClauseResult, colours: bool) -> list[str]:
    more = len(clause.evidence) - _EVIDENCE_LINES
    evidence = list(clause.evidence[:_EVIDENCE_LINES]) + ([f"and {more} lines more (--json FILE)"] if more > 0 else [])
    return [
        _head(clause, colours),
        f"  cause      {clause.mark}{clause.cause}",
        f"  clause     {clause.text}",
        f"  source     {clause.source}",
        *_labelled("case", _cases(clause)),
        *_labelled("not seen", [", ".join(clause.by_own_report)] if clause.by_own_report else []),
        *_labelled("evidence", evidence),
        *_labelled("screen", [clause.screen] if clause.screen else []),
        f"  reproduce  {clause.reproduce}",
    ]


def _cases(clause: ClauseResult) -> list[str]:
    """Name the cases that a clause with several fails in: the first, whose cause and evidence are shown, and others."""
    if len(clause.case_ids) < 2 or not clause.verdict_case_ids:
        return []
    first, *others = clause.verdict_case_ids
    so_many = f"{1 + len(others)} of {len(clause.case_ids)} cases"
    return [f"{first} ({so_many})", *others[: _MOST_CASES - 1]]


def _labelled(label: str, lines: Iterable[str]) -> list[str]:
    return [f"  {label if number == 0 else '':<9}  {line}" for number, line in enumerate(lines)]


def _summary(report: Report, colours: bool) -> list[str]:
    count = f"{len(report.cases)} case{'s' * (len(report.cases) != 1)}"
    speed = f", {factor_text(report.bench_time_s / report.host_time_s)} times real time" if report.host_time_s else ""
    code = ExitCode(report.exit_code)
    lines = [
        *_common(report),
        counted(report.counts),
        f"{count}, {seconds_text(report.bench_time_s)} of bench time in {seconds_text(report.host_time_s)}{speed}",
        *footer.lines(report),
        f"run hash {report.run_hash}" if report.run_hash else f"no run hash: {report.no_run_hash}",
    ]
    if report.stopped:
        not_run = sum(case.verdict is Verdict.NOT_RUN for case in report.cases)
        lines.append(f"stopped: {report.stopped}; {not_run} case{'s' * (not_run != 1)} not run")
    style = "green" if code is ExitCode.OK else "bold red"
    said, notes = f"exit {report.exit_code}: {report.exit_meaning}", len(report.observed.notes)
    return [*lines, _painted(f"{said}; {notes_counted(notes)}" if notes else said, style, colours)]


def counted(counts: Counts) -> str:
    """Return how many clauses there are, and how many have which verdict, in words."""
    weaker = f" ({counts.by_own_report} by its own report)" if counts.by_own_report else ""
    words = [
        (counts.passed, f"pass{weaker}"),
        (counts.failed, "fail"),
        (counts.warned, "warn"),
        (counts.inconclusive, "inconclusive"),
        (counts.error, "error"),
        (counts.not_applicable, "not applicable"),
        (counts.not_run, "not run"),
    ]
    said = ", ".join(f"{number} {word}" for number, word in words if number) or "none"
    return f"{counts.clauses} clause{'s' * (counts.clauses != 1)}: {said}"


def _painted(text: str, style: str, colours: bool) -> str:
    if not colours:
        return text
    from rich.style import Style

    return Style.parse(style).render(text)
