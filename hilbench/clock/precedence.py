"""What a process asks of the system to be in time: to be run before others, and to be left alone by its memory."""

from __future__ import annotations

import gc
import os
import resource
import signal
from types import FrameType

__all__ = ["OF_A_BENCH", "OF_A_READER", "freeze_memory", "give_way", "take_precedence"]

OF_A_BENCH, OF_A_READER = 1, 2
"""Priorities among what runs first (choice): who stamps bytes waits for nobody; the lowest there is for a bench."""

_COMPUTES_US = 1_000_000
"""So long a process that runs first computes at a stretch (choice): then it may never end, as a loop in a suite."""


def take_precedence(priority: int) -> bool:
    """Have the system run this process before all that are not in real time (SCHED_FIFO; sched(7)).

    It gives way when it has computed for a second without waiting (RLIMIT_RTTIME, SIGXCPU; getrlimit(2)).

    Returns:
        Whether it does. Not where the user may not ask for that (RLIMIT_RTPRIO), where there is one processor alone,
        which the others need as well, or outside the main thread.
    """
    try:
        if len(os.sched_getaffinity(0)) < 2:
            return False
        signal.signal(signal.SIGXCPU, _give_way)
        resource.setrlimit(resource.RLIMIT_RTTIME, (_COMPUTES_US, resource.getrlimit(resource.RLIMIT_RTTIME)[1]))
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(priority))
    except (AttributeError, OSError, ValueError):  # not on Linux; refused; not in the main thread, or a lower limit
        return False
    return True


def give_way() -> None:
    """Run again as every other process; that children do, too, only who has CAP_SYS_NICE may take back (sched(7))."""
    os.sched_setscheduler(0, os.SCHED_OTHER | os.SCHED_RESET_ON_FORK, os.sched_param(0))


def _give_way(_number: int, _frame: FrameType | None) -> None:
    give_way()


def freeze_memory() -> None:
    """Take what is in memory now for lasting: looking through it again and again takes 15 ms and more each time."""
    gc.collect()
    gc.freeze()
