"""What the page shows of a run: a row for each clause or, of a journal alone, for each case."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from hilbench.check.page.story import Story, story_of
from hilbench.check.report import footer
from hilbench.check.report.matrix import counted, headline, word_for
from hilbench.check.results import CaseResult, ClauseResult, Report, relative_margin
from hilbench.journal import Recording
from hilbench.judging.verdicts import Measure, Verdict
from hilbench.plugins.protocol import ProtocolPlugin
from hilbench.recordings.frames import spoken
from hilbench.recordings.layout import laid_out

__all__ = ["Cell", "Figure", "Row", "Run", "run_of_journal", "run_of_report"]

MOST_STORIES = 40
"""Cases whose last moments are told, of those that are not shown (choice: a page stays below a few megabytes)."""
_SHOWN = {Verdict.PASS, Verdict.NOT_APPLICABLE}


@dataclass(frozen=True, slots=True, kw_only=True)
class Figure:
    """A figure that was measured, and where it stands between its limits.

    Attributes:
        text: what it is, with unit.
        limits: in words.
        place: 0 at the lower limit, 1 at the upper; None where it has but one limit or none.
        good: whether it keeps them.
    """

    text: str
    limits: str
    place: float | None
    good: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """What a run says of a row.

    Attributes:
        word: the verdict, as the matrix has it.
        cause: why it is not a pass.
        evidence: lines that show what happened.
        margin: of the figure that came nearest to its limit, in words.
        figures: what was measured.
        cases: the ids of the cases, those that are not shown first.
        reproduce: the command that runs it again.
        stories: the last moments of cases that are not shown.
        screens: files with pictures of the dashboard.
    """

    word: str
    cause: str = ""
    evidence: tuple[str, ...] = ()
    margin: str = ""
    figures: tuple[Figure, ...] = ()
    cases: tuple[str, ...] = ()
    reproduce: str = ""
    stories: tuple[Story, ...] = ()
    screens: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """A clause, or a case of a journal.

    Attributes:
        id: what it is called.
        suite: of it.
        level: ``must`` or ``should``; empty for a case.
        title: a few words.
        text: the rule.
        source: where that is written.
    """

    id: str
    suite: str = ""
    level: str = ""
    title: str = ""
    text: str = ""
    source: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """A run.

    Attributes:
        name: what its column is called.
        headline: what was checked, on what, with which seed.
        ending: exit code and what it means.
        counts: clauses by verdict, in words.
        rows: what it has, in order.
        cells: what it says of each, by id.
        remarks: coverage, margins, what was touched that is not modelled, notes of the firmware, pace, hash.
        environment: whatever else its result depends on, by name.
    """

    name: str
    headline: str
    ending: str
    counts: str = ""
    rows: tuple[Row, ...] = ()
    cells: Mapping[str, Cell] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    environment: Mapping[str, str] = field(default_factory=dict)


def run_of_report(report: Report, name: str, recording: Recording | None = None) -> Run:
    """Return what a report says, and what a recording of the run shows beside it."""
    stories = _stories(recording, [case.id for case in report.cases if case.verdict not in _SHOWN])
    cases = {case.id: case for case in report.cases}
    remarks = [f"run hash {report.run_hash}" if report.run_hash else f"no run hash: {report.no_run_hash}"]
    remarks += [f"stopped: {report.stopped}"] if report.stopped else []
    return Run(
        name=name,
        headline=headline(report.bench, report.seed, report.hilbench),
        ending=f"exit {report.exit_code}: {report.exit_meaning}",
        counts=counted(report.counts),
        rows=tuple(
            Row(id=one.id, suite=one.suite, level=one.level, title=one.title, text=one.text, source=one.source)
            for one in report.clauses
        ),
        cells={clause.id: _cell(clause, cases, stories) for clause in report.clauses},
        remarks=(*remarks, *footer.lines(report)),
        environment=_environment(recording),
    )


def run_of_journal(recording: Recording, name: str) -> Run:
    """Return what a journal alone says: the verdict of each case."""
    verdicts: dict[str, tuple[str, str]] = {}
    case = ""
    for event in recording.events:
        if event["kind"] == "case":
            case = str(event["case"])
            verdicts[case] = ("not run", "")
        elif event["kind"] == "verdict" and case:
            verdicts[case] = (str(event.get("verdict", "")), str(event.get("cause", "")))
    stories = _stories(recording, [case for case, (word, _) in verdicts.items() if word != "pass"])
    told = {case: (stories[case],) if case in stories else () for case in verdicts}
    return Run(
        name=name,
        headline=f"hilbench {recording.header.get('hilbench', '?')} · bench {recording.header.get('bench', '?')}",
        ending=recording.problem or ("" if recording.ended else "the journal was not closed"),
        counts=f"{len(verdicts)} cases, {sum(word == 'pass' for word, _ in verdicts.values())} pass",
        rows=tuple(Row(id=case, suite=case.partition("/")[0], title=case.partition("/")[2]) for case in verdicts),
        cells={
            case: Cell(word=word, cause=cause, cases=(case,), stories=told[case])
            for case, (word, cause) in verdicts.items()
        },
        environment=_environment(recording),
    )


def _cell(clause: ClauseResult, cases: Mapping[str, CaseResult], stories: Mapping[str, Story]) -> Cell:
    bad = clause.verdict not in _SHOWN
    first = clause.verdict_case_ids if bad else ()
    ids = (*first, *(case for case in clause.case_ids if case not in first))
    measures = [measure for case in ids if case in cases for measure in cases[case].measures]
    return Cell(
        word=word_for(clause),
        cause=clause.mark + clause.cause,
        evidence=clause.evidence,
        margin=footer.margin_text(clause.worst_margin),
        figures=tuple(_figure(one) for one in measures if one.clause in {"", clause.id}),
        cases=ids,
        reproduce=clause.reproduce,
        stories=tuple(stories[case] for case in first if case in stories),
        screens=tuple(cases[case].screen for case in first if case in cases and cases[case].screen),
    )


def _figure(measure: Measure) -> Figure:
    low, high, unit = measure.low, measure.high, f" {measure.unit}".rstrip()
    limits = [f"at least {low:g}{unit}"] if low is not None else []
    limits += [f"at most {high:g}{unit}"] if high is not None else []
    place = None
    if low is not None and high is not None and high > low:
        place = min(max((measure.value - low) / (high - low), 0.0), 1.0)
    good = measure.margin is None or relative_margin(measure) >= 0
    text = f"{measure.name} {measure.value:.4g}{unit}".strip()
    return Figure(text=text, limits=", ".join(limits), place=place, good=good)


def _stories(recording: Recording | None, cases: Iterable[str]) -> dict[str, Story]:
    """Tell the last moments of cases."""
    wanted = dict.fromkeys(list(cases)[:MOST_STORIES])
    if recording is None or not wanted:
        return {}
    protocol: ProtocolPlugin | None = spoken(laid_out(recording.events))
    return {case: story for case in wanted if (story := story_of(recording, case, protocol)) is not None}


def _environment(recording: Recording | None) -> dict[str, str]:
    header: Mapping[str, Any] = {} if recording is None else recording.header
    return {
        name: value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
        for name, value in header.items()
        if name not in {"kind", "part", "format"}
    }
