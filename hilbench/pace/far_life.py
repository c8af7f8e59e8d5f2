"""Waits that are as long for a bench of ours at the far end of a line as for this one.

A bench that runs in another process may be late, and its time may stand still. Who then waits a second for nothing to
happen has not waited a second: not so much has passed for the other. So the wait goes on until it has.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from hilbench.clock import NS_PER_MS, NS_PER_S, Scheduler
from hilbench.pace.lateness import Lateness

__all__ = ["FarBench", "FarLife"]

_ENOUGH_NS = NS_PER_MS
"""So much less than was waited may have passed for a far bench (choice)."""
_LONGEST = 20
"""So many times as long as asked is waited at most (choice): a bench of a twentieth of real time is none to check."""
_STANDING_NS = NS_PER_S
"""Who has not got on for so long, and for a whole wait, is not waited for (choice): a busy host pauses for less."""


class FarBench(Protocol):
    """What tells how a bench in another process keeps up; `hilbench.pace.far_pace.FarPace` is one.

    All moments are the host's monotonic time, in ns.
    """

    def lateness(self, since_ns: int, now_ns: int) -> Lateness:
        """Return how late it was between two moments, of which the second is now."""

    def due_between(self, after_ns: int, by_ns: int) -> tuple[int, int] | None:
        """Return when was due, at the earliest and at the latest, what it wrote at a moment between two, if known."""

    def life_since(self, begin_ns: int) -> Callable[[int], int]:
        """Return what tells, at a moment, how much time has passed for it since now, which is `begin_ns`."""


class FarLife:
    """See the module.

    Waits that follow each other without a pause are one: what the far bench has made up for meanwhile is not waited
    for again, so that many short ones do not get longer and longer.

    Args:
        scheduler: whose time passes; locked to the host's clock when there is a far bench.
        far: the benches; more may be added.

    Attributes:
        starved_ns: bench time at which a wait last ended although too little had passed for one of them; -1 for never.
    """

    def __init__(self, scheduler: Scheduler, far: Sequence[FarBench]) -> None:
        self.starved_ns = -1
        self._scheduler = scheduler
        self._far = far
        self._lives: list[Callable[[int], int]] = []
        self._wanted_ns = 0
        self._ended_ns = -1

    def wait(self, condition: Callable[[], bool] | None, wait_ns: int) -> bool:
        """Let `wait_ns` of bench time pass, and as much for each far bench, unless `condition` holds before.

        Returns:
            Whether it holds.
        """
        scheduler = self._scheduler
        if not self._far:
            return scheduler.run_until(condition, scheduler.now_ns + wait_ns)
        if scheduler.now_ns != self._ended_ns:
            begin_ns = self._host_now_ns()
            self._lives = [far.life_since(begin_ns) for far in self._far]
            self._wanted_ns = 0
        last_ns = scheduler.now_ns + _LONGEST * wait_ns
        missing_ns = got_on_missing_ns = wait_ns
        got_on_ns = scheduler.now_ns
        while not scheduler.run_until(condition, scheduler.now_ns + missing_ns):
            missing_ns = self._missing_ns(wait_ns)
            if missing_ns <= _ENOUGH_NS:
                self._wanted_ns += wait_ns  # only now: a wait that ends early has not been one for all of it
                self._ended_ns = scheduler.now_ns
                return False
            spent_ns = scheduler.now_ns - got_on_ns
            if (got_on_missing_ns - missing_ns) * _LONGEST >= spent_ns:
                got_on_ns, got_on_missing_ns = scheduler.now_ns, missing_ns
            elif spent_ns >= _STANDING_NS:
                last_ns = scheduler.now_ns
            if scheduler.now_ns + missing_ns > last_ns:
                self.starved_ns = scheduler.now_ns
                return False
        return True

    def _missing_ns(self, wait_ns: int) -> int:
        now_ns = self._host_now_ns()
        return self._wanted_ns + wait_ns - min(life(now_ns) for life in self._lives)

    def _host_now_ns(self) -> int:
        return self._scheduler.host_ns(self._scheduler.now_ns)[1]
