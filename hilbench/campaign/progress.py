"""Says how far a campaign has come: a line that changes on a terminal, a line every ten seconds in a log."""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Callable, Iterator

from hilbench.campaign.point import Outcome
from hilbench.check.heartbeat import Heartbeat
from hilbench.clock import Stopwatch
from hilbench.terminal.console import Console

__all__ = ["shown"]

_WORDS = ("pass", "fail", "inconclusive", "error")


@contextlib.contextmanager
def shown(console: Console, total: int) -> Iterator[Callable[[Outcome], None]]:
    """Give a function that takes the outcome of each point as it comes.

    Args:
        console: where to say it.
        total: how many points there will be.
    """
    watch, counts = Stopwatch(), Counter[str]()

    def text() -> str:
        done = counts.total()
        left = _time_left(watch.elapsed_s() / done * (total - done)) if done else ""
        found = ", ".join(f"{counts[word]} {word}" for word in _WORDS if counts[word])
        return f"{done}/{total} points{left}{': ' if found else ''}{found}"

    with contextlib.ExitStack() as stack:
        if console.watched:
            show = stack.enter_context(console.progress())
        else:
            show = stack.enter_context(Heartbeat(console.mention)).show

        def take(outcome: Outcome) -> None:
            counts[outcome.verdict] += 1
            show(text())

        if total:
            show(text())
        yield take


def _time_left(left_s: float) -> str:
    if left_s < 1:
        return ""
    return f", {left_s:.0f} s left" if left_s < 100 else f", {left_s / 60:.0f} min left"
