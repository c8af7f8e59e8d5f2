"""Runs the points of a campaign in processes of this machine.

A process that dies costs no other point anything: those that were being run are run again one by one, and one that
ends its process then has died of itself.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool

from hilbench.campaign.point import Outcome, Point, run_point
from hilbench.exit_codes import ExitCode

__all__ = ["run_here"]

Run = Callable[[Point], Outcome]

_POINTS_OF_A_PROCESS = 200
"""After so many a process makes room for a fresh one (choice): no point depends on what ran long before it."""

_DIED = Outcome(verdict="error", exit_code=ExitCode.DEFECT, cause="the process that ran it ended: out of memory?")


def run_here(points: Mapping[str, Point], jobs: int, run: Run = run_point) -> Iterator[tuple[str, Outcome]]:
    """Yield what comes of points, as it comes.

    Args:
        points: by their keys.
        jobs: how many processes.
        run: runs one of them.
    """
    waiting = deque(points)
    suspects: deque[str] = deque()
    while waiting or suspects:
        alone = bool(suspects)
        queue = deque([suspects.popleft()]) if alone else waiting
        lost = yield from _until_one_dies(points, queue, 1 if alone else jobs, run)
        if alone:
            yield from ((key, _DIED) for key in lost)
        else:
            suspects.extend(lost)


def _until_one_dies(
    points: Mapping[str, Point], queue: deque[str], jobs: int, run: Run
) -> Generator[tuple[str, Outcome], None, list[str]]:
    """Yield what comes of the points in a queue until a process dies; return those that were being run then."""
    running: dict[Future[Outcome], str] = {}
    with _pool(jobs) as pool:
        try:
            while queue or running:
                while queue and len(running) < 2 * jobs:
                    running[pool.submit(run, points[queue[0]])] = queue[0]
                    queue.popleft()
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    outcome = future.result()
                    yield running.pop(future), outcome
        except BrokenProcessPool:
            return list(running.values())
    return []


@contextlib.contextmanager
def _pool(jobs: int) -> Iterator[ProcessPoolExecutor]:
    pool = ProcessPoolExecutor(
        jobs,
        mp_context=multiprocessing.get_context("spawn"),
        initializer=_begin,
        max_tasks_per_child=_POINTS_OF_A_PROCESS,
    )
    try:
        yield pool
    finally:
        # Nobody waits for what is being run when the campaign is interrupted.
        for process in list((pool._processes or {}).values()):  # noqa: SLF001 - kill_workers() is of 3.14
            process.terminate()
        pool.shutdown(wait=True, cancel_futures=True)


def _begin() -> None:
    """Leave Ctrl-C to the process of the campaign, and end with it if that is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_the_campaign, daemon=True).start()


def _end_with_the_campaign() -> None:
    campaign = multiprocessing.parent_process()
    if campaign is not None:
        campaign.join()
        os._exit(ExitCode.INTERRUPTED)
