"""The report of a run as data, and how verdicts of cases become verdicts of clauses.

These structures are what ``--json`` writes; the published schema is generated from them. Whatever is added here is
added for the readers of reports: names and meanings stay.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import msgspec

from hilbench.judging.observations import Observations
from hilbench.judging.verdicts import BY_OWN_REPORT, WORST_FIRST, Level, Measure, Sampled, Verdict

FORMAT = "hilbench-report/1"
TIGHTEST = 5


class CaseResult(msgspec.Struct, frozen=True, kw_only=True):
    """What came of one case.

    Attributes:
        id: suite, function and parameters; stable.
        suite: the suite it is in.
        clause_ids: the clauses it checks.
        verdict: its outcome.
        cause: why it is not a pass; empty for a pass.
        failed_clause_ids: the clauses the outcome is about; empty unless the case told them apart.
        evidence: lines that show what happened.
        measures: figures it measured.
        families: families of stimuli that it tried members of.
        missing: capabilities that are missing, for a case that is not applicable.
        by_own_report: capabilities that are missing and that the target's own reports stood in for: what it says of
            itself was judged, and not what somebody saw. Empty for a case that saw all it needs.
        defect: whether an error is hilbench's own (exit code 5) and not the target's absence (3).
        suite_error: whether an error is that of a suite of the user's own (2).
        seed: seed of the case.
        bench_time_s: how much bench time it took; what was declared, for a case that did not run.
        case_hash: hash over its canonical events; empty if it opened no bench, or one in real time.
        screen: the picture of the dashboard at the moment it failed; empty if there is none.
        reruns: why it was inconclusive, each time that it was run again for that.
        asked: what somebody beside the target was asked for, each with the answer.
    """

    id: str
    suite: str
    clause_ids: tuple[str, ...]
    verdict: Verdict
    cause: str = ""
    failed_clause_ids: tuple[str, ...] = ()
    evidence: tuple[str, ...] = ()
    measures: tuple[Measure, ...] = ()
    families: tuple[Sampled, ...] = ()
    missing: tuple[str, ...] = ()
    by_own_report: tuple[str, ...] = ()
    defect: bool = False
    suite_error: bool = False
    seed: int = 0
    bench_time_s: float = 0.0
    case_hash: str = ""
    screen: str = ""
    reruns: tuple[str, ...] = ()
    asked: tuple[str, ...] = ()


class ClauseResult(msgspec.Struct, frozen=True, kw_only=True):
    """What came of one clause, over all the cases that check it.

    Attributes:
        id: the clause.
        suite: the suite that checks it; the first, if several do.
        level: ``must`` or ``should``.
        title: a few words.
        text: the rule.
        source: where it is written.
        verdict: the worst of its cases.
        counts: whether the verdict counts towards the exit code; a *should* does only with ``--strict``.
        cause: that of the worst case.
        evidence: that of the worst case.
        worst_margin: the figure that came nearest to its limit, relative to the limit.
        bench_time_s: of all its cases.
        case_ids: its cases.
        verdict_case_ids: those of them that have its verdict: of a clause that does not pass, those that do not.
        by_own_report: what it needs that nobody saw in one of its cases: the target's own reports were believed.
        reproduce: the command that runs it again.
        screen: the picture of the worst case; empty if there is none.
        reruns: how often cases of it were run again, as they were inconclusive.
    """

    id: str
    suite: str
    level: Level
    title: str
    text: str
    source: str
    verdict: Verdict
    counts: bool
    cause: str = ""
    evidence: tuple[str, ...] = ()
    worst_margin: Measure | None = None
    bench_time_s: float = 0.0
    case_ids: tuple[str, ...] = ()
    verdict_case_ids: tuple[str, ...] = ()
    by_own_report: tuple[str, ...] = ()
    reproduce: str = ""
    screen: str = ""
    reruns: int = 0

    @property
    def mark(self) -> str:
        """What stands before its cause and its title where it was judged by less than it needs; else empty."""
        return BY_OWN_REPORT if self.by_own_report else ""


class TightMargin(msgspec.Struct, frozen=True, kw_only=True):
    """A figure that came near to its limit.

    Attributes:
        clause_ids: the clauses it was measured for.
        case_id: the case that measured it.
        measure: the figure.
        share: its margin as a share of the tolerance: 0 at the limit, negative outside.
    """

    clause_ids: tuple[str, ...]
    case_id: str
    measure: Measure
    share: float


class Counts(msgspec.Struct, frozen=True, kw_only=True):
    """How many clauses have which verdict.

    Attributes:
        clauses: all of them.
        passed: pass.
        failed: fail, and it counts.
        warned: a *should* that fails without ``--strict``.
        inconclusive: inconclusive.
        error: error.
        not_applicable: not applicable to this bench.
        not_run: selected and applicable, but the run ended before.
        by_own_report: of those that pass, how many do so by what the target says of itself alone.
    """

    clauses: int
    passed: int
    failed: int
    warned: int
    inconclusive: int
    error: int
    not_applicable: int
    not_run: int
    by_own_report: int = 0


class Report(msgspec.Struct, frozen=True, kw_only=True):
    """Everything there is to say about a run.

    Attributes:
        format: name and version of this format.
        hilbench: version of hilbench.
        bench: the parts of the bench: ``bench``, ``target``, ``physics`` and whatever else the bench names.
        seed: seed of the run.
        strict: whether a *should* counts like a *must*.
        select: the expression of ``-k``.
        exit_code: what the command returns.
        exit_meaning: what that says, in words.
        stopped: why the run ended early; empty if it did not.
        run_hash: hash over the hashes of the cases that ran, in the order of their ids; null if there is none.
        no_run_hash: why there is none; empty if there is one.
        bench_time_s: sum over the cases.
        host_time_s: what that took on the host's clock; no part of the run hash.
        counts: clauses by verdict.
        clauses: in the order of their suites.
        cases: in the order in which they were to run.
        tightest: the figures that came nearest to their limits, at most one for each set of clauses.
        observed: what the run showed beside its verdicts.
    """

    format: str
    hilbench: str
    bench: dict[str, str]
    seed: int
    strict: bool
    select: str
    exit_code: int
    exit_meaning: str
    stopped: str
    run_hash: str | None
    no_run_hash: str
    bench_time_s: float
    host_time_s: float
    counts: Counts
    clauses: tuple[ClauseResult, ...]
    cases: tuple[CaseResult, ...]
    tightest: tuple[TightMargin, ...] = ()
    observed: Observations = Observations()


def verdict_for(result: CaseResult, clause_id: str) -> Verdict:
    """Return what a case says about one of its clauses.

    A case that cites several and failed at one of them has not finished judging the others.
    """
    if result.failed_clause_ids and clause_id not in result.failed_clause_ids:
        return Verdict.INCONCLUSIVE
    return result.verdict


def worst_case(results: Sequence[CaseResult], clause_id: str) -> CaseResult:
    """Return the first case with the worst verdict about a clause."""
    return min(results, key=lambda result: WORST_FIRST.index(verdict_for(result, clause_id)))


def worst_margin(results: Iterable[CaseResult], clause_id: str = "") -> Measure | None:
    """Return the measure that came nearest to its limit, relative to that limit, or None if none has a limit.

    Args:
        results: of cases.
        clause_id: look at the figures that are about this clause only; empty for all.
    """
    measures = [measure for result in results for measure in result.measures if measure.margin is not None]
    if clause_id:
        measures = [measure for measure in measures if measure.clause in {"", clause_id}]
    return min(measures, key=relative_margin, default=None)


def tightest_margins(results: Iterable[CaseResult], number: int = TIGHTEST) -> tuple[TightMargin, ...]:
    """Return the figures that came nearest to their limits, the nearest first, one for each set of clauses."""
    found: dict[tuple[str, ...], TightMargin] = {}
    for result in results:
        measure = worst_margin([result])
        if measure is None:
            continue
        share = relative_margin(measure)
        about = (measure.clause,) if measure.clause in result.clause_ids else result.clause_ids
        known = found.get(about)
        if known is None or share < known.share:
            found[about] = TightMargin(clause_ids=about, case_id=result.id, measure=measure, share=share)
    return tuple(sorted(found.values(), key=lambda margin: (margin.share, margin.case_id))[:number])


def relative_margin(measure: Measure) -> float:
    """Return the margin as a share of the tolerance: 1 is in the middle or at zero, 0 at a limit, negative outside."""
    return (measure.margin or 0.0) / _tolerance(measure)


def _tolerance(measure: Measure) -> float:
    if measure.low is not None and measure.high is not None:
        return (measure.high - measure.low) / 2 or 1.0
    limit = measure.high if measure.high is not None else measure.low
    return abs(limit or 0.0) or 1.0


def count(clauses: Sequence[ClauseResult]) -> Counts:
    """Count clauses by verdict; a *should* that fails without ``--strict`` is a warning."""

    def having(verdict: Verdict) -> int:
        return sum(clause.verdict is verdict for clause in clauses)

    warned = sum(clause.verdict is Verdict.FAIL and not clause.counts for clause in clauses)
    return Counts(
        clauses=len(clauses),
        passed=having(Verdict.PASS),
        failed=having(Verdict.FAIL) - warned,
        warned=warned,
        inconclusive=having(Verdict.INCONCLUSIVE),
        error=having(Verdict.ERROR),
        not_applicable=having(Verdict.NOT_APPLICABLE),
        not_run=having(Verdict.NOT_RUN),
        by_own_report=sum(clause.verdict is Verdict.PASS and bool(clause.by_own_report) for clause in clauses),
    )
