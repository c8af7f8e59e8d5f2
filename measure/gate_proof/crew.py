"""Does jobs side by side."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar

Bench = TypeVar("Bench")
Job = TypeVar("Job")


class StoppedError(Exception):
    """Somebody wants the program to end."""


def side_by_side(
    benches: Sequence[Bench], jobs: Iterable[Job], work: Callable[[Bench, Job], None], stop: threading.Event
) -> None:
    """Do each of some jobs at one of some benches, in a thread for each bench.

    Args:
        benches: where the work is done.
        jobs: what is to be done.
        work: does it; may raise `StoppedError` once it is to stop.
        stop: set when somebody interrupts, or one job goes wrong: the others end as soon as they can.
    """
    waiting: queue.SimpleQueue[Job] = queue.SimpleQueue()
    for job in jobs:
        waiting.put(job)
    wrong: list[BaseException] = []

    def labour(bench: Bench) -> None:
        try:
            while not stop.is_set():
                work(bench, waiting.get_nowait())
        except (StoppedError, queue.Empty):
            return
        except BaseException as error:  # noqa: BLE001 - raised again by the thread that waits
            wrong.append(error)
            stop.set()

    threads = [threading.Thread(target=labour, args=(bench,)) for bench in benches]
    for thread in threads:
        thread.start()
    try:
        _join(threads)
    except BaseException:
        stop.set()
        _join(threads)
        raise
    if wrong:
        raise wrong[0]


def _join(threads: Iterable[threading.Thread]) -> None:
    for thread in threads:
        thread.join()
