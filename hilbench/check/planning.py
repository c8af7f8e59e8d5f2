"""Makes planned cases of declared ones: looks up their clauses, names them, derives their seeds."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from hilbench.check.cases import CaseSpec
from hilbench.check.catalogue import Clause, find_clause
from hilbench.check.collector import PlannedCase
from hilbench.errors import UsageError
from hilbench.judging.provider import ANSWERS, RECORDING, case_seed


def plan_case(
    spec: CaseSpec,
    *,
    suite: str,
    suite_argument: str,
    name: str,
    run_seed: int,
    capabilities: Collection[str],
    by_hand: Collection[str] = (),
) -> PlannedCase:
    """Return the plan for one case.

    Args:
        spec: what its decorator says.
        suite: name of its suite.
        suite_argument: what ``--suite`` has to be given to find it.
        name: function and parameters.
        run_seed: seed of the run.
        capabilities: what the bench can do.
        by_hand: what somebody beside the target can do for the clauses that allow it.

    Raises:
        UsageError: it cites a clause that nobody defines.
    """
    case_id = f"{suite}/{name}"
    clauses = tuple(_clause(clause_id, spec, case_id, suite) for clause_id in spec.clause_ids)
    handed = frozenset[str]().union(*(clause.handed(capabilities, by_hand) for clause in clauses))
    there = handed.union(capabilities)
    unseen = [clause.unseen(there) for clause in clauses]
    needs = spec.needs.union(*(clause.needs - lacks for clause, lacks in zip(clauses, unseen, strict=True)))
    missing = needs.difference(there)
    if RECORDING in capabilities and RECORDING not in spec.needs:
        missing = frozenset({ANSWERS})
    return PlannedCase(
        id=case_id,
        suite=suite,
        suite_argument=suite_argument,
        clauses=clauses,
        bench_time_s=spec.bench_time_s,
        needs=needs,
        missing=tuple(sorted(missing)),
        by_own_report=() if missing else tuple(sorted(frozenset[str]().union(*unseen))),
        by_hand=frozenset() if missing else handed,
        scene=spec.scene,
        setup=spec.setup,
        seed=case_seed(run_seed, case_id),
    )


def refuse_conflicts(plans: Iterable[PlannedCase]) -> None:
    """Make sure that each id means one thing.

    Raises:
        UsageError: two cases have one id, or two clauses.
    """
    suites: dict[str, str] = {}
    clauses: dict[str, Clause] = {}
    for plan in plans:
        if plan.id in suites:
            both = f"is in {suites[plan.id]} and in {plan.suite_argument}"
            raise UsageError(both, where=plan.id, hint="rename one suite")
        suites[plan.id] = plan.suite_argument
        for clause in plan.clauses:
            known = clauses.setdefault(clause.id, clause)
            if (known.text, known.level) != (clause.text, clause.level):
                message = f"defines the clause '{clause.id}', which is already '{known.text}' ({known.level})"
                raise UsageError(message, where=plan.id, hint="use an id of its own")


def _clause(clause_id: str, spec: CaseSpec, case_id: str, suite: str) -> Clause:
    if spec.clause is not None:
        own = spec.clause
        return Clause(id=own.id, suite=suite, level=own.level, title=own.title, text=own.text, source=own.source)
    found = find_clause(clause_id)
    if found is None:
        raise UsageError(
            f"cites the clause '{clause_id}', which no catalogue holds",
            where=case_id,
            hint="give @case its text=, level= and source=",
        )
    return found
