"""One point of a campaign: a check that depends on nothing but what stands here, and what came of it."""

from __future__ import annotations

import hashlib
import json
import math
import shlex
import traceback
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import msgspec

from hilbench.errors import HilbenchError
from hilbench.exit_codes import ExitCode
from hilbench.judging.verdicts import Measure, Verdict
from hilbench.strict.changes import parse_change
from hilbench.terminal.options import CheckOptions

if TYPE_CHECKING:
    from hilbench.check.results import Report

__all__ = ["Clause", "Figure", "Outcome", "Point", "command_of", "key_of", "options_of", "run_point"]

Word = Literal["pass", "fail", "inconclusive", "error"]

_WORDS: Mapping[int, Word] = {ExitCode.OK: "pass", ExitCode.VIOLATION: "fail", ExitCode.INCONCLUSIVE: "inconclusive"}
_SHOWN = {Verdict.PASS, Verdict.FAIL, Verdict.INCONCLUSIVE, Verdict.ERROR}


class Point(msgspec.Struct, frozen=True, kw_only=True):
    """A check to run.

    Attributes:
        bench: name of a built-in bench, or path of a bench file.
        seed: of the run.
        changes: what is to be otherwise than the bench file says, as ``check --set`` takes it.
        suites: as ``check --suite`` takes them.
        select: as ``check -k`` takes it.
        levels: what each factor is at this point, by its name: a number, or a word for what is none.
    """

    bench: str
    seed: int
    changes: tuple[str, ...] = ()
    suites: tuple[str, ...] = ()
    select: str = ""
    levels: dict[str, float | str] = msgspec.field(default_factory=dict)

    def __hash__(self) -> int:
        """Points are told apart by all that they are."""
        return hash((self.bench, self.seed, self.changes, self.suites, self.select))


class Clause(msgspec.Struct, frozen=True, kw_only=True):
    """What a clause came to at a point.

    Attributes:
        id: of the clause.
        verdict: ``pass``, ``fail``, ``inconclusive`` or ``error``; of a *should* that fails, too.
        cause: why it is no pass.
    """

    id: str
    verdict: str
    cause: str = ""


class Figure(msgspec.Struct, frozen=True, kw_only=True):
    """What a case measured; see `hilbench.judging.verdicts.Measure`.

    Attributes:
        case: the case.
        clause: the clause, or the clauses, that it is about.
        name: what was measured.
        value: the figure.
        unit: its unit.
        low: the lowest value allowed, if there is one.
        high: the highest value allowed, if there is one.
    """

    case: str
    clause: str
    name: str
    value: float
    unit: str
    low: float | None = None
    high: float | None = None


class Outcome(msgspec.Struct, frozen=True, kw_only=True):
    """What came of a point.

    Attributes:
        verdict: of the whole check.
        exit_code: as that of ``hilbench check``.
        cause: why there is no verdict; empty if there is one.
        run_hash: of the run; empty if there is none.
        bench_time_s: how much bench time it took.
        clauses: those that were judged.
        figures: what its cases measured.
    """

    verdict: Word
    exit_code: int
    cause: str = ""
    run_hash: str = ""
    bench_time_s: float = 0.0
    clauses: tuple[Clause, ...] = ()
    figures: tuple[Figure, ...] = ()


def key_of(point: Point, inputs: Iterable[str]) -> str:
    """Return what tells a point from all others, and from itself with another firmware: a SHA-256 in hex.

    Args:
        point: it; what its factors are called does not count.
        inputs: digests of what it is made of, in their order: hilbench, the bench file, images, suites.
    """
    changes = [parse_change(text).canonical() for text in point.changes]
    names = [Path(text).name for text in (point.bench, *point.suites)]  # wherever they lie: their digests are inputs
    about = [names, point.seed, changes, point.select, list(inputs)]
    return hashlib.sha256(json.dumps(about).encode()).hexdigest()


def command_of(point: Point) -> str:
    """Return the command that runs a point by itself."""
    words = ["hilbench", "check", point.bench]
    for change in point.changes:
        words += ["--set", change]
    for suite in point.suites:
        words += ["--suite", suite]
    words += ["-k", point.select] if point.select else []
    return shlex.join([*words, "--seed", str(point.seed)])


def options_of(point: Point) -> CheckOptions:
    """Return the options of ``hilbench check`` that run a point."""
    return CheckOptions(
        bench=point.bench,
        suites=point.suites,
        select=point.select,
        seed=point.seed,
        changes=tuple(map(parse_change, point.changes)),
    )


def run_point(point: Point) -> Outcome:
    """Run a point in this process; whatever goes wrong is its outcome."""
    from hilbench.check.bench_provider import make_provider
    from hilbench.check.runner import run_suites

    options = options_of(point)
    try:
        provider = make_provider(options)
        try:
            return _outcome(run_suites(options, provider))
        finally:
            provider.close()
    except HilbenchError as error:
        return Outcome(verdict="error", exit_code=error.exit_code, cause=str(error))
    except Exception as error:  # noqa: BLE001 - a defect costs its own point, and is named there
        place = traceback.extract_tb(error.__traceback__)[-1]
        said = f"{type(error).__name__}: {error} (in {place.name})"
        return Outcome(verdict="error", exit_code=ExitCode.DEFECT, cause=f"defect in hilbench: {said}")


def _outcome(report: Report) -> Outcome:
    word = _WORDS.get(report.exit_code, "error")
    return Outcome(
        verdict=word,
        exit_code=report.exit_code,
        cause=_cause(report) if word == "error" else "",
        run_hash=report.run_hash or "",
        bench_time_s=round(report.bench_time_s, 6),
        clauses=tuple(
            Clause(id=clause.id, verdict=clause.verdict.value, cause=clause.cause)
            for clause in report.clauses
            if clause.verdict in _SHOWN
        ),
        figures=tuple(
            _figure(case.id, measure, case.clause_ids)
            for case in report.cases
            for measure in case.measures
            if math.isfinite(measure.value)  # what is none has no place in a distribution, nor in JSON
        ),
    )


def _cause(report: Report) -> str:
    causes = [case.cause for case in report.cases if case.verdict is Verdict.ERROR]
    return report.stopped or next(iter(causes), report.exit_meaning)


def _figure(case: str, measure: Measure, clauses: tuple[str, ...]) -> Figure:
    return Figure(
        case=case,
        clause=measure.clause or ", ".join(clauses),
        name=measure.name,
        value=measure.value,
        unit=measure.unit,
        low=_limit(measure.low),
        high=_limit(measure.high),
    )


def _limit(limit: float | None) -> float | None:
    """Return a limit; one that is infinite is none."""
    return limit if limit is not None and math.isfinite(limit) else None
