"""Makes the report of a run out of the results of its cases."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from hilbench import __version__
from hilbench.check.adding_up import in_order
from hilbench.check.catalogue import Clause
from hilbench.check.collector import Collector, PlannedCase
from hilbench.check.report.footer import named
from hilbench.check.results import (
    FORMAT,
    CaseResult,
    ClauseResult,
    Report,
    count,
    tightest_margins,
    verdict_for,
    worst_case,
    worst_margin,
)
from hilbench.exit_codes import ExitCode, worst
from hilbench.journal.run_hash import run_hash
from hilbench.judging.observations import Observations
from hilbench.judging.verdicts import Verdict
from hilbench.terminal.options import CheckOptions

EXIT_MEANINGS = {
    ExitCode.OK: "all checks passed",
    ExitCode.VIOLATION: "the target violates a clause",
    ExitCode.USAGE: "an error in a suite or plug-in of your own",
    ExitCode.UNAVAILABLE: "bench or target not available",
    ExitCode.INCONCLUSIVE: "inconclusive",
    ExitCode.DEFECT: "defect in hilbench",
    ExitCode.INTERRUPTED: "interrupted; this report is complete for what was run",
}

_NUMBER = re.compile(r"(\d+)")

NO_HASH_IN_REAL_TIME = "in real time no two runs are the same to the nanosecond"
NO_HASH_WITHOUT_CASES = "no case ran"
NOTHING_JUDGED = "inconclusive: nothing that was selected applies to this bench"


@dataclass(frozen=True, slots=True, kw_only=True)
class _ClauseCases:
    clause: Clause
    planned: list[PlannedCase]
    results: list[CaseResult]


def make_report(
    collector: Collector,
    options: CheckOptions,
    bench: Mapping[str, str],
    host_time_s: float = 0.0,
    observed: Observations | None = None,
) -> Report:
    """Return the report of a run, complete for what was run, whenever and however it ended."""
    observed = in_order(observed or Observations())
    cases = collector.cases()
    clauses = tuple(_clause_result(group, options) for group in _by_clause(collector.planned, cases))
    code = _exit_code(collector, cases, clauses, strict=options.strict)
    hashes = {case.id: case.case_hash for case in cases if case.case_hash}
    whole_hash = run_hash(hashes, bench.get("physics", "none"))
    return Report(
        format=FORMAT,
        hilbench=__version__,
        bench=dict(bench),
        seed=options.seed,
        strict=options.strict,
        select=options.select,
        exit_code=int(code),
        exit_meaning=_meaning(code, clauses),
        stopped=collector.stopped or "; ".join(collector.defects),
        run_hash=whole_hash,
        no_run_hash="" if whole_hash else _why_no_hash(observed),
        bench_time_s=sum(case.bench_time_s for case in cases if _ran(case)),
        host_time_s=host_time_s,
        counts=count(clauses),
        clauses=clauses,
        cases=cases,
        tightest=tightest_margins(cases),
        observed=observed,
    )


def _why_no_hash(observed: Observations) -> str:
    return NO_HASH_IN_REAL_TIME if observed.pace is not None else NO_HASH_WITHOUT_CASES


def _by_clause(planned: Iterable[PlannedCase], results: Iterable[CaseResult]) -> list[_ClauseCases]:
    """Group by clause: one that several suites check counts once, in the suite that came first.

    Suites come in the order in which they run, the clauses of each in the order of their ids, S9 before S10.
    """
    groups: dict[str, _ClauseCases] = {}
    for plan, result in zip(planned, results, strict=True):
        for clause in plan.clauses:
            group = groups.setdefault(clause.id, _ClauseCases(clause=clause, planned=[], results=[]))
            group.planned.append(plan)
            group.results.append(result)
    suites = list(dict.fromkeys(group.planned[0].suite for group in groups.values()))
    places = {group.clause.id: suites.index(group.planned[0].suite) for group in groups.values()}
    return sorted(groups.values(), key=lambda group: (places[group.clause.id], _by_number(group.clause.id)))


def _by_number(clause_id: str) -> list[tuple[int, str]]:
    return [(int(part), "") if part.isdigit() else (0, part) for part in _NUMBER.split(clause_id)]


def _clause_result(group: _ClauseCases, options: CheckOptions) -> ClauseResult:
    clause = group.clause
    worst_one = worst_case(group.results, clause.id)
    verdict = verdict_for(worst_one, clause.id)
    elsewhere = verdict is not worst_one.verdict
    return ClauseResult(
        id=clause.id,
        suite=group.planned[0].suite,
        level=clause.level,
        title=clause.title,
        text=clause.text,
        source=clause.source,
        verdict=verdict,
        counts=options.strict or clause.level == "must",
        cause=f"not judged to the end: {worst_one.cause}" if elsewhere else worst_one.cause,
        evidence=worst_one.evidence,
        worst_margin=worst_margin(group.results, clause.id),
        bench_time_s=sum(result.bench_time_s for result in group.results if _ran(result)),
        case_ids=tuple(result.id for result in group.results),
        verdict_case_ids=tuple(one.id for one in group.results if verdict_for(one, clause.id) is verdict),
        by_own_report=_by_own_report(group),
        reproduce=_reproduce(group, options),
        screen=worst_one.screen,
        reruns=sum(len(result.reruns) for result in group.results),
    )


def _by_own_report(group: _ClauseCases) -> tuple[str, ...]:
    """Return what the clause needs that nobody saw in one of its cases which ran."""
    unseen = {name for result in group.results if _ran(result) for name in result.by_own_report}
    return tuple(sorted(unseen & group.clause.needs))


def _reproduce(group: _ClauseCases, options: CheckOptions) -> str:
    words = ["hilbench", "check"]
    if options.bench is not None:
        words.append(options.bench)
    for change in options.changes:
        words += ["--set", change.text]
    for target in options.targets:
        words += ["--target", f"{target.name}={target.spec}" if target.name else target.spec]
    for suite in dict.fromkeys(plan.suite_argument for plan in group.planned):
        words += ["--suite", suite]
    words += ["-k", group.clause.id, "--seed", str(options.seed)]
    words += ["--operator"] if options.operator else []
    words += ["--operator-hook", shlex.join(options.operator_hook)] if options.operator_hook else []
    if options.timeout_scale != 1:
        words += ["--timeout-scale", f"{options.timeout_scale:g}"]
    if options.through:
        words += ["--through", options.through]
    return shlex.join(words)


def _ran(result: CaseResult) -> bool:
    return result.verdict not in {Verdict.NOT_RUN, Verdict.NOT_APPLICABLE}


def _exit_code(
    collector: Collector, cases: Iterable[CaseResult], clauses: Sequence[ClauseResult], *, strict: bool
) -> ExitCode:
    codes = [ExitCode.INTERRUPTED] if collector.interrupted else []
    codes += [ExitCode.DEFECT] if collector.defects else []
    codes += [_code_of(case) for case in cases if case.verdict is Verdict.ERROR]
    judged = [clause.verdict for clause in clauses if clause.counts]
    if Verdict.FAIL in judged:
        codes.append(ExitCode.VIOLATION)
    if Verdict.INCONCLUSIVE in judged or not _anything_judged(clauses) or (strict and _not_shown(clauses)):
        codes.append(ExitCode.INCONCLUSIVE)
    return worst(codes)


def _code_of(error: CaseResult) -> ExitCode:
    if error.suite_error:
        return ExitCode.USAGE
    return ExitCode.DEFECT if error.defect else ExitCode.UNAVAILABLE


def _anything_judged(clauses: Iterable[ClauseResult]) -> bool:
    return any(clause.verdict not in {Verdict.NOT_APPLICABLE, Verdict.NOT_RUN} for clause in clauses)


def _not_shown(clauses: Iterable[ClauseResult]) -> list[str]:
    """Return the ids of what a target must do and this bench cannot see."""
    return [clause.id for clause in clauses if clause.level == "must" and clause.verdict is Verdict.NOT_APPLICABLE]


def _by_report_alone(clauses: Iterable[ClauseResult]) -> list[str]:
    """Return the ids of what a target must do and only says that it does."""
    passed = (clause for clause in clauses if clause.level == "must" and clause.verdict is Verdict.PASS)
    return [clause.id for clause in passed if clause.by_own_report]


def _meaning(code: ExitCode, clauses: Sequence[ClauseResult]) -> str:
    if code is ExitCode.INCONCLUSIVE and not _anything_judged(clauses):
        return NOTHING_JUDGED
    words = [EXIT_MEANINGS[code]]
    if code in {ExitCode.OK, ExitCode.INCONCLUSIVE}:
        words += _counted("not shown here", _not_shown(clauses))
        words += _counted("shown by the target's own report alone", _by_report_alone(clauses))
    return "; ".join(words)


def _counted(what: str, ids: Sequence[str]) -> list[str]:
    return [f"{len(ids)} must clause{'s' * (len(ids) != 1)} {what}: {named(ids)}"] if ids else []
