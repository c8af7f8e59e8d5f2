"""When bytes came and left, and how exactly that is known, where a process of its own reads the ports."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from hilbench.clock import LatenessMeter
from hilbench.judging.uncertainty import OfTimes
from hilbench.links.stamped import Stamped, Stamper
from hilbench.pace.far_life import FarBench

__all__ = ["Arrival", "ByteStamps", "Span"]

_KEPT = 4096
"""Of so many arrivals it is known how exactly (choice): minutes of a busy line."""


class Span(NamedTuple):
    """How far apart two moments are, and how far off that may be, in seconds."""

    s: float
    doubt_s: OfTimes


@dataclass(frozen=True, slots=True)
class Arrival:
    """How exactly is known when bytes came; all moments are the host's, in ns.

    Attributes:
        after_ns: the last moment at which they were not there.
        by_ns: a moment at which they were.
        due_ns: between which moments they were due, where a bench of ours has sent them late; else None.
    """

    after_ns: int
    by_ns: int
    due_ns: tuple[int, int] | None

    @property
    def early_ns(self) -> int:
        """How much before the stamp they may have come."""
        return self.by_ns - self.after_ns


class ByteStamps:
    """The `hilbench.links.stamped.Stamps` of a bench.

    Args:
        read: makes what reads a port.
        far: the benches behind the ports; more may be added.
    """

    def __init__(self, read: Callable[[int], Stamper], far: Sequence[FarBench]) -> None:
        self._far = far
        self._arrivals: dict[int, Arrival] = {}
        self._left = LatenessMeter()
        self._read = read
        self._stampers: list[Stamper] = []

    def open(self, descriptor: int) -> Stamper:
        """See `Stamps`."""
        self._stampers.append(self._read(descriptor))
        return self._stampers[-1]

    @property
    def words(self) -> str:
        """Who stamps, for people; empty if nobody does."""
        if not self._stampers:
            return ""
        first = all(one.runs_first for one in self._stampers)
        how = "which Linux runs before others" if first else "which Linux runs as any other (no SCHED_FIFO)"
        return f"by a process for each port, {how}"

    def came(self, at_ns: int, read: Stamped) -> None:
        """See `Stamps`."""
        before = self._arrivals.get(at_ns)
        after_ns = read.after_ns if before is None else min(read.after_ns, before.after_ns)
        due = [far.due_between(after_ns, read.by_ns) for far in self._far]
        known = [one for one in due if one is not None]
        whole = (min(one[0] for one in known), max(one[1] for one in known)) if due and due == known else None
        self._arrivals[at_ns] = Arrival(after_ns, read.by_ns, whole)
        if len(self._arrivals) > _KEPT:
            del self._arrivals[next(iter(self._arrivals))]

    def left(self, asked_ns: int, late_ns: int) -> None:
        """See `Stamps`."""
        self._left.record(max(0, late_ns), asked_ns)

    def arrival(self, at_ns: int) -> Arrival | None:
        """Return how exactly is known when bytes came that have this stamp, in ns; None if none have."""
        return self._arrivals.get(at_ns)

    def left_late_ns(self, since_ns: int) -> int:
        """Return how late bytes left at most that were to leave at a bench time or later, in ns."""
        return self._left.max_since_ns(since_ns)
