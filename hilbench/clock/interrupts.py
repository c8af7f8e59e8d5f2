"""Signals that interrupt a bench between two entries of its queue, and never within one."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Iterator, Sequence
from types import FrameType

from hilbench.clock.scheduler import Scheduler


@contextlib.contextmanager
def deferred_interrupts(scheduler: Scheduler, signals: Sequence[signal.Signals] = (signal.SIGINT,)) -> Iterator[None]:
    """While in this context, let `signals` interrupt `scheduler` only between its entries. Main thread only.

    Only the first of them interrupts what runs no entries: what comes after it must not tear apart what is closed then.
    """
    heard = False

    def handle(_number: int, _frame: FrameType | None) -> None:
        nonlocal heard
        if scheduler.running or not heard:
            heard = True
            scheduler.interrupt()

    before = {number: signal.signal(number, handle) for number in signals}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
