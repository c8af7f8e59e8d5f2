"""A run of a suite in which each case meets a fault that it has to find.

So a suite proves in one run that each of its clauses can fail: whatever passes has not found its fault. A case that has
to find several faults meets them in as many runs.
"""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace

from hilbench.check import CheckOptions, Verdict, list_cases, run_suites
from hilbench.check.collector import PlannedCase
from hilbench.check.results import CaseResult
from hilbench.check.selection import Candidate, compile_selection
from hilbench.judging.provider import BenchProvider, CaseBench, CaseInfo


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """A fault, and the clause that has to find it.

    Attributes:
        name: what is wrong, for people.
        clause_id: the clause.
        open_case: opens the bench of a case with the fault in it.
        select: which of the cases of the clause; all of them if empty.
    """

    name: str
    clause_id: str
    open_case: Callable[[CaseInfo], AbstractContextManager[CaseBench]]
    select: str = ""

    @property
    def expression(self) -> str:
        """Selects its cases."""
        return f"({self.clause_id} and ({self.select}))" if self.select else self.clause_id

    @property
    def key(self) -> str:
        """Its clause and its name."""
        return f"{self.clause_id}: {self.name}"


@dataclass(slots=True)
class Verdicts:
    """What came of faults.

    Attributes:
        found_by: the clauses that found one.
        not_found: why not, by the fault's name.
    """

    found_by: set[str] = field(default_factory=set)
    not_found: dict[str, str] = field(default_factory=dict)

    @property
    def open_clauses(self) -> set[str]:
        """The clauses that did not find a fault."""
        return {name.partition(":")[0] for name in self.not_found}

    def take(self, fault: Fault, cases: Sequence[CaseResult]) -> None:
        """Judge a fault by its cases: one has to fail by its clause, and none may do anything but pass or fail."""
        failed = [case for case in cases if case.verdict is Verdict.FAIL]
        clause_ids = {clause for case in failed for clause in case.failed_clause_ids or case.clause_ids}
        if fault.clause_id in clause_ids and {case.verdict for case in cases} <= {Verdict.PASS, Verdict.FAIL}:
            self.found_by.add(fault.clause_id)
            self.not_found.pop(fault.key, None)
        else:
            said = [f"{case.id} {case.verdict.value} {case.cause}".rstrip() for case in cases]
            self.not_found[fault.key] = "; ".join(said) or "no case is selected"


def one_for_each(clause_ids: Iterable[str], found: Mapping[str, Collection[str]]) -> Iterator[tuple[str, str]]:
    """Yield each clause with one of the faults that it finds: one that others do not stand for, nor find.

    Args:
        clause_ids: the clauses.
        found: by fault, the clauses that find it.
    """
    taken = Counter[str]()
    for clause_id in clause_ids:
        names = [name for name, by in found.items() if clause_id in by]
        name = min(names, key=lambda name: (taken[name], len(found[name])))
        taken[name] += 1
        yield clause_id, name


def judge(
    options: CheckOptions, right: BenchProvider, faults: Iterable[Fault], *, until_found: bool = False
) -> Verdicts:
    """Let each fault be looked for.

    Args:
        options: the suite; what they select is not looked at.
        right: opens benches without a fault; asked for what they can do.
        faults: all of them.
        until_found: run the cases of a fault one by one, the shortest first, until one finds it; otherwise all.
    """
    verdicts = Verdicts()
    options = replace(options, select="")
    planned = list_cases(options, right)
    left = [(fault, _steps(fault, planned, until_found=until_found)) for fault in faults]
    while left:
        for by_case in _runs([(fault, steps.pop(0)) for fault, steps in left]):
            provider, only = _EachItsOwn(right, by_case), frozenset(by_case)
            cases = run_suites(options, provider, only=only).cases
            for fault in dict.fromkeys(by_case.values()):
                verdicts.take(fault, [case for case in cases if by_case[case.id] is fault])
        left = [(fault, steps) for fault, steps in left if steps and fault.key in verdicts.not_found]
    return verdicts


def _steps(fault: Fault, planned: Sequence[PlannedCase], *, until_found: bool) -> list[list[str]]:
    """Return the ids of the cases of a fault: of those that run together, and then of others if it is not found."""
    known_ids = {clause_id for case in planned for clause_id in case.clause_ids}
    selected = compile_selection(fault.expression, known_ids)
    cases = [case for case in planned if selected(_candidate(case))]
    assert cases, f"no case is selected by {fault.expression}"
    if not until_found:
        return [[case.id for case in cases]]
    return [[case.id] for case in sorted(cases, key=lambda case: (bool(case.missing), case.bench_time_s))]


def _runs(met: Iterable[tuple[Fault, Sequence[str]]]) -> list[dict[str, Fault]]:
    """Distribute faults over runs: by case the one that it meets, a fault in all of its cases at once."""
    runs: list[dict[str, Fault]] = []
    for fault, case_ids in met:
        run = next((run for run in runs if not run.keys() & set(case_ids)), None)
        if run is None:
            runs.append(run := {})
        run.update(dict.fromkeys(case_ids, fault))
    return runs


def _candidate(case: PlannedCase) -> Candidate:
    titles = [clause.title for clause in case.clauses]
    return Candidate.of(case.clause_ids, [case.id, case.suite, *titles])


class _EachItsOwn:
    """Opens the bench of the fault that a case has to find."""

    def __init__(self, right: BenchProvider, by_case: Mapping[str, Fault]) -> None:
        self._by_case = by_case
        self.capabilities = right.capabilities
        self.describe = right.describe
        self.close = right.close

    @contextlib.contextmanager
    def open_case(self, case: CaseInfo) -> Iterator[CaseBench]:
        with self._by_case[case.id].open_case(case) as bench:
            yield bench
