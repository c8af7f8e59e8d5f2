"""Runs mutants side by side, each in a process of its own, so that one that hangs or dies takes no other with it."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection as Pipe
from multiprocessing.connection import wait
from multiprocessing.process import BaseProcess

from hilbench.clock import Stopwatch
from hilbench.judging.verdicts import Verdict
from measure.mutants.bench import run_mutant
from measure.mutants.mutant import Mutant

HANG_S = 240.0
"""A mutant that runs longer than this, on the host's clock, hangs; an idle machine needs 2 to 6 s for one."""

_POLL_S = 1.0
_fork = multiprocessing.get_context("fork")


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


@dataclass(slots=True)
class _Worker:
    mutant: Mutant
    process: BaseProcess
    pipe: Pipe
    watch: Stopwatch

    def ended(self) -> Found | None:
        """Return what came of it, or None if it still runs."""
        if self.pipe.poll():
            found = self._receive()
        elif self.watch.elapsed_s() < HANG_S:
            return None
        else:
            self.process.kill()
            found = Found(mutant=self.mutant, verdicts={}, cause=f"ran for more than {HANG_S:g} s", hung=True)
        self.process.join()
        self.pipe.close()
        return found

    def _receive(self) -> Found:
        try:
            verdicts, cause = self.pipe.recv()
        except EOFError:
            return Found(mutant=self.mutant, verdicts={}, cause="the process died", hung=True)
        return Found(mutant=self.mutant, verdicts=verdicts, cause=cause)


def _work(mutant: Mutant, pipe: Pipe) -> None:
    found = examine(mutant)
    pipe.send((found.verdicts, found.cause))


def examine_all(mutants: Sequence[Mutant], jobs: int, tell: Callable[[Found, int, int], None]) -> list[Found]:
    """Examine mutants, ``jobs`` at a time; return what was found in the order of the mutants.

    Args:
        mutants: all of them.
        jobs: how many processes.
        tell: called for each that has ended, with how many have and how many there are.
    """
    found: dict[str, Found] = {}
    for one in _ended(mutants, jobs):
        found[one.mutant.id] = one
        tell(one, len(found), len(mutants))
    return [found[mutant.id] for mutant in mutants]


def _ended(mutants: Sequence[Mutant], jobs: int) -> Iterator[Found]:
    waiting, running = list(reversed(mutants)), list[_Worker]()
    try:
        while waiting or running:
            while waiting and len(running) < jobs:
                running.append(_start(waiting.pop()))
            wait([worker.pipe for worker in running], timeout=_POLL_S)
            for worker in list(running):
                if (found := worker.ended()) is not None:
                    running.remove(worker)
                    yield found
    finally:
        for worker in running:
            worker.process.kill()


def _start(mutant: Mutant) -> _Worker:
    here, there = _fork.Pipe(duplex=False)
    process = _fork.Process(target=_work, args=(mutant, there), daemon=True)
    process.start()
    there.close()
    return _Worker(mutant, process, here, Stopwatch())
