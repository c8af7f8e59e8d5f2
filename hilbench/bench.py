"""A bench: one scheduler, one journal, and the things that live on them.

Everything that happens on a bench happens at a bench time, counted in whole nanoseconds from 0 and owned by its
scheduler; everything worth knowing afterwards is an event in its journal. What is attached decides how time passes:
nothing real, and it runs free (as fast as the processor goes, repeatable bit for bit); a port, a pty or a socket, and
it is locked to the host's monotonic clock.
"""

from __future__ import annotations

from collections.abc import Callable

from hilbench.clock import NS_PER_S, SLIP_THRESHOLD_NS, Scheduler
from hilbench.journal import Journal

LOCKED_FLOOR_S = 0.002
"""The least uncertainty of a time on a locked bench, in seconds: a pty passes a byte on within some 0.02 to 0.6 ms
(99 % of the time, measured on Linux), a USB adapter within 1 to 16 ms. A choice; see `hilbench.calibration`."""


def to_ns(seconds: float) -> int:
    """Return a span of bench time in whole nanoseconds, rounded to the nearest."""
    return round(seconds * NS_PER_S)


class Bench:
    """The clock and the journal that everything on a bench shares.

    Args:
        scheduler: owner of bench time.
        journal: where everything is recorded.
        timeout_scale: how much longer than asked to wait for something, at least 1; it never changes the limit that is
            judged.

    Attributes:
        port_uncertainty_s: what a real port was measured to add to every time, in seconds; 0 without a calibration.
    """

    def __init__(self, scheduler: Scheduler, journal: Journal, *, timeout_scale: float = 1.0) -> None:
        self.scheduler = scheduler
        self.journal = journal
        self.timeout_scale = timeout_scale
        self.port_uncertainty_s = 0.0

    @property
    def now_ns(self) -> int:
        """Bench time, in nanoseconds since the bench started."""
        return self.scheduler.now_ns

    @property
    def now_s(self) -> float:
        """Bench time, in seconds since the bench started; for people, not for comparing."""
        return self.scheduler.now_ns / NS_PER_S

    def run_for(self, duration_s: float) -> None:
        """Let ``duration_s`` seconds of bench time pass."""
        self.scheduler.run_until(None, self.now_ns + to_ns(duration_s))
        self.journal.flush_step()

    def run_until(self, condition: Callable[[], bool], within_s: float) -> bool:
        """Let time pass until ``condition`` holds, or ``within_s`` seconds times the timeout scale are over.

        Returns:
            Whether the condition holds.
        """
        wait_ns = to_ns(within_s * self.timeout_scale)
        holds = self.scheduler.run_until(condition, self.now_ns + wait_ns)
        self.journal.flush_step()
        return holds

    def uncertainty_s(self, since_ns: int) -> float:
        """Return how far off a time measured since ``since_ns`` may be, in seconds.

        Zero on a free-running bench. On a locked one it is the sum of two things. First the worst lateness of the host
        in that span and what its port was measured to add, but at least `LOCKED_FLOOR_S`: what the bench itself cannot
        see, such as the way of a byte through the kernel. Then every moment that slipped, for while bench time stood
        still what is real went on.
        """
        if not self.scheduler.locked:
            return 0.0
        late_ns = min(self.scheduler.lateness_max_ns(since_ns), SLIP_THRESHOLD_NS)
        seen_s = late_ns / NS_PER_S + self.port_uncertainty_s
        return max(LOCKED_FLOOR_S, seen_s) + self.scheduler.slipped_since_ns(since_ns) / NS_PER_S

    def record(self, kind: str, source: str, **fields: object) -> None:
        """Write an event that happens now into the journal."""
        self.journal.record(kind, source, self.now_ns, **fields)

    def record_event(self, source: str, event: object) -> None:
        """Write an event that is an object, such as one a robot reports, into the journal."""
        self.journal.record_value("event", source, self.now_ns, event)
