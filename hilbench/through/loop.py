"""The time of one program on the way of the bytes: it stands still but while something is under way.

Doors and real ports are made for benches in real time. Here each has a scheduler of its own, locked to the host's
clock, that runs for as long as some bytes take from one to the next. The bench whose bytes they are waits meanwhile: on
its own clock nothing passes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from hilbench.clock import NS_PER_MS, NS_PER_S, InputSource, MonotonicHostClock, Scheduler

__all__ = ["Loop", "Stage", "arrived", "settle"]

_SLICE_NS = 2 * NS_PER_MS
"""How long one waits before the others are looked at again (choice)."""
_NEVER_NS = NS_PER_S << 32
"""A loop that slipped would be behind its own clock from then on: what the host was late by is over with the run."""
_ROUNDS = 5000
"""What has not come after so many slices does not come (choice): 10 s."""


class _OwnTime:
    """The host's clock, which begins where it is told to; before the first time it is 0."""

    def __init__(self) -> None:
        self._host = MonotonicHostClock()
        self._behind_ns: int | None = None

    def go_on_at(self, time_ns: int) -> None:
        """Let it be `time_ns` now."""
        self._behind_ns = self._host.monotonic_ns() - time_ns

    def monotonic_ns(self) -> int:
        """Return this clock's time in nanoseconds."""
        return 0 if self._behind_ns is None else self._host.monotonic_ns() - self._behind_ns

    def wait_until(self, host_ns: int | None) -> Sequence[InputSource]:
        """Wait until `host_ns` or until an input is readable; return the readable ones."""
        return self._host.wait_until(None if host_ns is None else host_ns + (self._behind_ns or 0))

    def watch(self, source: InputSource) -> None:
        """Begin to watch `source`."""
        self._host.watch(source)

    def unwatch(self, source: InputSource) -> None:
        """Stop watching `source`."""
        self._host.unwatch(source)

    def close(self) -> None:
        """Let go of the host's clock."""
        self._host.close()


class Loop:
    """The scheduler of one program."""

    def __init__(self) -> None:
        self.scheduler = Scheduler()
        self._time = _OwnTime()
        self.scheduler.lock(self._time, heartbeat_ns=None, slip_threshold_ns=_NEVER_NS)

    def run_until(self, condition: Callable[[], bool]) -> bool:
        """Run for a slice at most; say whether the condition holds. What is due by then has been done."""
        self._time.go_on_at(self.scheduler.now_ns)  # the pause since the last run was none for this program
        came = self.scheduler.run_until(condition, self.scheduler.now_ns + _SLICE_NS)
        self.scheduler.run_until(None, self.scheduler.now_ns)
        return came

    def close(self) -> None:
        """Let go of the host's clock; whatever was on it is closed by now."""
        self.scheduler.unlock()
        self._time.close()


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """A program, and how it is known that the bytes are through with it."""

    loop: Loop
    done: Callable[[], bool]


def arrived(entrance: Loop, stages: Sequence[Stage]) -> bool:
    """Let bytes go in, and the stages run one behind the other until they are through with the last; say if they are.

    Args:
        entrance: whose port they have been written to.
        stages: the others, in the order of the way.
    """
    for number in range(_ROUNDS):
        entrance.run_until(partial(bool, number == 0))  # what did not go in at once goes in a little later
        through = [stage.loop.run_until(stage.done) for stage in stages]
        if all(through):
            return True
    return False


def settle(loops: Sequence[Loop], done: Callable[[], bool]) -> bool:
    """Let the loops run in turn until a condition holds that none of them decides alone; say whether it does."""
    for _ in range(_ROUNDS):
        for loop in loops:
            loop.run_until(lambda: False)
        if done():
            return True
    return False
