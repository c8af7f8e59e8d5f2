"""Runs jobs side by side, each in a process of its own, so that one that hangs or dies takes no other with it."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection as Pipe
from multiprocessing.connection import wait
from multiprocessing.process import BaseProcess
from typing import Any, Generic, TypeVar

from hilbench.clock import Stopwatch

__all__ = ["Lost", "side_by_side"]

JobT = TypeVar("JobT")
ResultT = TypeVar("ResultT")

_POLL_S = 1.0
_fork = multiprocessing.get_context("fork")


@dataclass(frozen=True, slots=True)
class Lost:
    """What became of a job whose process had to be ended, or died."""

    why: str


@dataclass(slots=True)
class _Worker(Generic[JobT]):
    job: JobT
    process: BaseProcess
    pipe: Pipe
    watch: Stopwatch

    def ended(self, limit_s: float) -> Any:
        """Return what came of it, or None if it still runs."""
        found: Any
        if self.pipe.poll():
            try:
                found = self.pipe.recv()
            except EOFError:
                found = Lost("the process died")
        elif self.watch.elapsed_s() < limit_s:
            return None
        else:
            self.process.kill()
            found = Lost(f"ran for more than {limit_s:g} s")
        self.process.join()
        self.pipe.close()
        return found


def side_by_side(
    jobs: Sequence[JobT], work: Callable[[JobT], ResultT], at_a_time: int, limit_s: float
) -> Iterator[tuple[JobT, ResultT | Lost]]:
    """Yield each job with what came of it, as they end.

    Args:
        jobs: all of them; they are begun in this order.
        work: does one, in a process that was forked from this one; what it returns has to fit through a pipe.
        at_a_time: how many processes.
        limit_s: a job that runs longer on the host's clock, in seconds, hangs.
    """
    waiting, running = list(reversed(jobs)), list[_Worker[JobT]]()
    try:
        while waiting or running:
            while waiting and len(running) < at_a_time:
                running.append(_start(waiting.pop(), work))
            wait([worker.pipe for worker in running], timeout=_POLL_S)
            for worker in list(running):
                if (found := worker.ended(limit_s)) is not None:
                    running.remove(worker)
                    yield worker.job, found
    finally:
        for worker in running:
            worker.process.kill()


def _start(job: JobT, work: Callable[[JobT], Any]) -> _Worker[JobT]:
    here, there = _fork.Pipe(duplex=False)

    def run() -> None:
        there.send(work(job))

    process = _fork.Process(target=run, daemon=True)
    process.start()
    there.close()
    return _Worker(job, process, here, Stopwatch())
