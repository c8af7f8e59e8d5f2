"""Runs mutants side by side: what the suites say of each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from hilbench.judging.verdicts import Verdict
from measure.mutants.bench import run_mutant
from measure.mutants.mutant import Mutant
from measure.mutants.side_by_side import Lost, side_by_side

HANG_S = 240.0
"""A mutant that runs longer than this, on the host's clock, hangs; an idle machine needs 2 to 6 s for one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """What the suites say of a mutant.

    Attributes:
        mutant: which one.
        verdicts: of each clause that does not pass.
        cause: why the first of them does not.
        hung: the run had to be ended.
    """

    mutant: Mutant
    verdicts: dict[str, Verdict]
    cause: str = ""
    hung: bool = False

    @property
    def killers(self) -> list[str]:
        """The clauses that find the mutant out: they fail, or the checked device breaks down."""
        return [clause for clause, verdict in self.verdicts.items() if verdict in (Verdict.FAIL, Verdict.ERROR)]

    @property
    def killed(self) -> bool:
        """Whether the mutant is found out."""
        return self.hung or bool(self.killers)


def examine(mutant: Mutant) -> Found:
    """Run the suites of a mutant's family against it, in this process."""
    report = run_mutant(mutant, mutant.family)
    bad = [clause for clause in report.clauses if clause.verdict is not Verdict.PASS]
    cause = next((clause.cause for clause in bad if clause.verdict is not Verdict.INCONCLUSIVE), "")
    return Found(mutant=mutant, verdicts={clause.id: clause.verdict for clause in bad}, cause=cause)


def _work(mutant: Mutant) -> tuple[dict[str, Verdict], str]:
    """What fits through a pipe of what was found."""
    found = examine(mutant)
    return found.verdicts, found.cause


def examine_all(mutants: Sequence[Mutant], jobs: int, tell: Callable[[Found, int, int], None]) -> list[Found]:
    """Examine mutants, ``jobs`` at a time; return what was found in the order of the mutants.

    Args:
        mutants: all of them.
        jobs: how many processes.
        tell: called for each that has ended, with how many have and how many there are.
    """
    found: dict[str, Found] = {}
    for mutant, came in side_by_side(mutants, _work, jobs, HANG_S):
        if isinstance(came, Lost):
            one = Found(mutant=mutant, verdicts={}, cause=came.why, hung=True)
        else:
            one = Found(mutant=mutant, verdicts=came[0], cause=came[1])
        found[mutant.id] = one
        tell(one, len(found), len(mutants))
    return [found[mutant.id] for mutant in mutants]
