"""When bytes came and left, and how exactly that is known, where a process of its own reads the ports."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from hilbench.clock import LatenessMeter
from hilbench.judging.uncertainty import OfTimes
from hilbench.links.stamped import Stamped, Stamper
from hilbench.pace.far_life import FarBench

__all__ = ["Arrival", "ByteStamps", "PortStamps", "Span"]

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
    """What all ports of a bench tell of their bytes.

    Args:
        read: makes what reads a port.
    """

    def __init__(self, read: Callable[[int], Stamper]) -> None:
        self.read = read
        self.stampers: list[Stamper] = []
        self.left = LatenessMeter()
        self._arrivals: dict[int, Arrival] = {}

    @property
    def words(self) -> str:
        """Who stamps, for people; empty if nobody does."""
        if not self.stampers:
            return ""
        first = all(one.runs_first for one in self.stampers)
        how = "which Linux runs before others" if first else "which Linux runs as any other (no SCHED_FIFO)"
        return f"by a process for each port, {how}"

    def keep(self, at_ns: int, came: Arrival) -> None:
        """Keep how exactly is known when bytes came that have this stamp, in ns.

        Bytes of two ports may have the same: then what is less exact counts, and when they were due is not known.
        """
        before = self._arrivals.get(at_ns)
        if before is not None:
            came = Arrival(min(came.after_ns, before.after_ns), max(came.by_ns, before.by_ns), None)
        self._arrivals[at_ns] = came
        if len(self._arrivals) > _KEPT:
            del self._arrivals[next(iter(self._arrivals))]

    def arrival(self, at_ns: int) -> Arrival | None:
        """Return how exactly is known when bytes came that have this stamp, in ns; None if none have."""
        return self._arrivals.get(at_ns)

    def left_late_ns(self, since_ns: int) -> int:
        """Return how late bytes left at most that were to leave at a bench time or later, in ns."""
        return self.left.max_since_ns(since_ns)


class PortStamps:
    """The `hilbench.links.stamped.Stamps` of one port.

    Args:
        bench: those of its bench.

    Attributes:
        far: the bench behind the port; None if none is known.
    """

    def __init__(self, bench: ByteStamps) -> None:
        self._bench = bench
        self.far: FarBench | None = None

    def open(self, descriptor: int) -> Stamper:
        """See `Stamps`."""
        stamper = self._bench.read(descriptor)
        self._bench.stampers.append(stamper)
        return stamper

    def came(self, at_ns: int, read: Stamped) -> None:
        """See `Stamps`."""
        due_ns = None if self.far is None else self.far.due_between(read.after_ns, read.by_ns)
        self._bench.keep(at_ns, Arrival(read.after_ns, read.by_ns, due_ns))

    def left(self, asked_ns: int, late_ns: int) -> None:
        """See `Stamps`."""
        self._bench.left.record(max(0, late_ns), asked_ns)
