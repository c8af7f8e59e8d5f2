"""How late a bench in real time was, over a stretch of it."""

from __future__ import annotations

from dataclasses import dataclass

from hilbench.clock import NS_PER_MS, NS_PER_S

__all__ = ["IN_TIME", "Lateness"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Lateness:
    """See the module.

    Attributes:
        late_ns: how late it did a thing at most, where it caught up afterwards, in ns.
        lost_ns: how long its time stood still in all, in ns.
    """

    late_ns: int = 0
    lost_ns: int = 0

    @property
    def whole_ns(self) -> int:
        """How far off a span may be that somebody else measured of what it did, in ns."""
        return self.late_ns + self.lost_ns

    def __add__(self, other: Lateness) -> Lateness:
        """Return that of two benches of which one is behind the other."""
        return Lateness(late_ns=self.late_ns + other.late_ns, lost_ns=self.lost_ns + other.lost_ns)

    def __str__(self) -> str:
        """Say it to people, behind the name of the bench."""
        late = f"was up to {self.late_ns / NS_PER_MS:.1f} ms late"
        return f"{late} and stood still for {self.lost_ns / NS_PER_S:.3f} s" if self.lost_ns else late


IN_TIME = Lateness()
"""Of a bench that never was late."""
