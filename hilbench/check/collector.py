"""Gathers what a run says, case by case, as the pytest plugin tells it; knows nothing of pytest.

A run is complete at any moment: a case is entered as not run when it is planned, and its result replaces that.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from hilbench.check.catalogue import Clause
from hilbench.check.results import CaseResult
from hilbench.judging.provider import CaseSetup
from hilbench.judging.verdicts import Verdict


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedCase:
    """A case that was selected.

    Attributes:
        id: suite, function and parameters.
        suite: the suite it is in.
        suite_argument: what ``--suite`` has to be given to find it again.
        clauses: the clauses it checks.
        bench_time_s: about how long it takes, in seconds of bench time.
        needs: the capabilities it needs, those of its clauses included.
        missing: those of them that the bench lacks.
        scene: the scene it asks for.
        setup: how else its bench differs from that of the bench file.
        seed: its seed.
        by_own_report: what its clauses need besides, which the bench lacks and the target's own reports stand in for.
        by_hand: those of its needs for which somebody beside the target is asked.
    """

    id: str
    suite: str
    suite_argument: str
    clauses: tuple[Clause, ...]
    bench_time_s: float
    needs: frozenset[str]
    missing: tuple[str, ...]
    scene: str
    setup: CaseSetup
    seed: int
    by_own_report: tuple[str, ...] = ()
    by_hand: frozenset[str] = frozenset()

    @property
    def clause_ids(self) -> tuple[str, ...]:
        """The ids of its clauses, in the order cited."""
        return tuple(clause.id for clause in self.clauses)

    def result(self, verdict: Verdict, cause: str) -> CaseResult:
        """Return the result of this case as long as nothing was measured."""
        return CaseResult(
            id=self.id,
            suite=self.suite,
            clause_ids=self.clause_ids,
            verdict=verdict,
            cause=cause,
            missing=self.missing,
            by_own_report=self.by_own_report,
            seed=self.seed,
            bench_time_s=self.bench_time_s,
        )


@dataclass(slots=True)
class Collector:
    """Everything known about a run so far.

    Attributes:
        planned: the selected cases in the order in which they are to run.
        results: the result of each so far, by case id.
        stopped: why the run ended early; empty if it did not.
        interrupted: whether a person or a CI job ended it.
        defects: what went wrong in the engine itself, outside any case.
        max_failures: after how many cases that fail the run ends; 0 for no limit.
        strict: whether a *should* counts like a *must*.
    """

    planned: list[PlannedCase] = field(default_factory=list)
    results: dict[str, CaseResult] = field(default_factory=dict)
    stopped: str = ""
    interrupted: bool = False
    defects: list[str] = field(default_factory=list)
    max_failures: int = 0
    strict: bool = False

    def plan(self, cases: Iterable[PlannedCase]) -> None:
        """Enter the selected cases."""
        for planned in cases:
            self.planned.append(planned)
            if planned.missing:
                cause = f"the bench has no {' and no '.join(planned.missing)}"
                self.results[planned.id] = planned.result(Verdict.NOT_APPLICABLE, cause)
            else:
                self.results[planned.id] = planned.result(Verdict.NOT_RUN, "not reached")

    def enter(self, result: CaseResult) -> None:
        """Enter the result of a case, in the place of what was known of it."""
        self.results[result.id] = result
        if self.max_failures and sum(map(self._counts_as_failure, self.results.values())) >= self.max_failures:
            self.stop(f"{self.max_failures} case{'s' * (self.max_failures > 1)} failed, as many as --maxfail allows")

    def _counts_as_failure(self, result: CaseResult) -> bool:
        if result.verdict is not Verdict.FAIL or self.strict:
            return result.verdict in {Verdict.FAIL, Verdict.ERROR}
        about = result.failed_clause_ids or result.clause_ids
        return any(clause.level == "must" for clause in self._clauses_of(result.id) if clause.id in about)

    def _clauses_of(self, case_id: str) -> tuple[Clause, ...]:
        return next((planned.clauses for planned in self.planned if planned.id == case_id), ())

    def stop(self, reason: str, *, interrupted: bool = False) -> None:
        """Take note that the run ends early; the first reason given stands."""
        self.stopped = self.stopped or reason
        self.interrupted = self.interrupted or interrupted

    def cases(self) -> tuple[CaseResult, ...]:
        """Return the results in the order of the plan, naming why what did not run did not."""
        return tuple(self._known(planned) for planned in self.planned)

    def _known(self, planned: PlannedCase) -> CaseResult:
        result = self.results[planned.id]
        if result.verdict is Verdict.NOT_RUN and self.stopped:
            return planned.result(Verdict.NOT_RUN, f"not run: {self.stopped}")
        return result
