"""A bench: one scheduler, one journal, and the things that live on them.

Everything that happens on a bench happens at a bench time, counted in whole nanoseconds from 0 and owned by its
scheduler; everything worth knowing afterwards is an event in its journal. What is attached decides how time passes:
nothing real, and it runs free (as fast as the processor goes, repeatable bit for bit); a port, a pty or a socket, and
it is locked to the host's monotonic clock.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from hilbench.bench.stamps import Arrival, ByteStamps, Span
from hilbench.clock import NS_PER_S, SLIP_THRESHOLD_NS, Scheduler
from hilbench.journal import Journal
from hilbench.judging.uncertainty import OfTimes
from hilbench.links.memory import REAL_TIME_GROUP_NS
from hilbench.pace.far_life import FarBench, FarLife
from hilbench.pace.lateness import IN_TIME, Lateness
from hilbench.pace.pty_probe import PtyProbe

if TYPE_CHECKING:
    from hilbench.links.port import Port
    from protocols.common.tables import LooksAtTables

LOCKED_FLOOR_S = 0.002
"""The least uncertainty of a time at a port of which nothing is known, in seconds: a USB adapter passes a byte on
within 1 to 16 ms. A choice; see `hilbench.ports.calibration`."""

LOCAL_PORT_S = 0.0003
"""What a port adds to every time that no adapter is behind, in seconds: a pseudo-terminal, a socket of this host. A
choice: through either, a byte and its echo by another process take 0.02 to 0.4 ms (99 % of the time, measured on
Linux), of which the way there is half; that a process wakes up late is measured as lateness besides."""

_LATELY_NS = NS_PER_S
"""How late a host wakes up for a byte is not measured, but for an entry that is due meanwhile; so how late it was in
the second before (choice) counts as well, as far as `LOCKED_FLOOR_S`."""


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
        port_uncertainty_s: what the ports add to every time, as far as it is known or was measured, in seconds.
        port_floor_s: what the uncertainty of a time is at least, in seconds: more than 0 where a port is not known.
        adapter_s: what of `port_uncertainty_s` is behind what this host's kernel tells: of an adapter, or of a program
            in between, in seconds.
        stamps: when bytes came and left, where a process of its own reads the ports; None where none does.
        route: what a port of the checker stands behind; see `near_end`.
        far: benches of ours behind the ports, which tell how they keep up.
        way: measures how late the host hands on what passes pseudo-terminals; None where there are none.
        on_settled: called whenever a device of the bench has been called; None while nobody looks at devices.
        tables: what devices have to show as tables, by their names in the journal; looked at on a live bench alone.
    """

    def __init__(self, scheduler: Scheduler, journal: Journal, *, timeout_scale: float = 1.0) -> None:
        self.scheduler = scheduler
        self.journal = journal
        self.timeout_scale = timeout_scale
        self.port_uncertainty_s = 0.0
        self.port_floor_s = LOCKED_FLOOR_S
        self.adapter_s = 0.0
        self.stamps: ByteStamps | None = None
        self.route: Callable[[Port], Port] | None = None
        self.far: list[FarBench] = []
        self.way: PtyProbe | None = None
        self.on_settled: Callable[[], None] | None = None
        self.tables: dict[str, LooksAtTables] = {}
        self._far_life = FarLife(scheduler, self.far)

    def near_end(self, port: Port) -> Port:
        """Return what the checker has of a line: the port itself, unless its bytes are to pass something else."""
        return port if self.route is None else self.route(port)

    @property
    def now_ns(self) -> int:
        """Bench time, in nanoseconds since the bench started."""
        return self.scheduler.now_ns

    @property
    def now_s(self) -> float:
        """Bench time, in seconds since the bench started; for people, not for comparing."""
        return self.scheduler.now_ns / NS_PER_S

    def run_for(self, duration_s: float) -> None:
        """Let ``duration_s`` seconds of bench time pass, and as much for a far bench of ours that is slow or late."""
        self._run(None, to_ns(duration_s))

    def run_until(self, condition: Callable[[], bool], within_s: float) -> bool:
        """Let time pass until ``condition`` holds, or ``within_s`` seconds times the timeout scale are over.

        They are over when so much has passed for a far bench of ours, too.

        Returns:
            Whether the condition holds.
        """
        return self._run(condition, to_ns(within_s * self.timeout_scale))

    def _run(self, condition: Callable[[], bool] | None, wait_ns: int) -> bool:
        holds = self._far_life.wait(condition, wait_ns)
        self.journal.flush_step()
        return holds

    def own_lateness(self, since_ns: int) -> Lateness:
        """Return how late the host was for this bench since bench time ``since_ns``."""
        late_ns = min(self.scheduler.lateness_max_ns(since_ns), SLIP_THRESHOLD_NS)
        return Lateness(late_ns=late_ns, lost_ns=self.scheduler.slipped_since_ns(since_ns))

    def far_lateness(self, since_ns: int) -> Lateness:
        """Return how late the latest of the far benches was since bench time ``since_ns`` of this one."""
        if not self.far:
            return IN_TIME
        begin_ns, now_ns = self.scheduler.host_ns(since_ns)
        begin_ns -= self.own_lateness(since_ns).late_ns  # what is stamped now may have come before
        return max((far.lateness(begin_ns, now_ns) for far in self.far), key=lambda one: one.whole_ns)

    def way_lateness(self, since_ns: int) -> Lateness:
        """Return how late the host handed on what passed a pseudo-terminal since bench time ``since_ns``."""
        return IN_TIME if self.way is None else self.way.lateness(self.scheduler.host_ns(since_ns)[0])

    def lateness(self, since_ns: int) -> Lateness:
        """Return how late this bench, those behind its ports and the way there were since bench time ``since_ns``."""
        return self.own_lateness(since_ns) + self.far_lateness(since_ns) + self.way_lateness(since_ns)

    def far_lived(self, since_ns: int) -> bool:
        """Say whether as much time passed for the far benches in each wait since ``since_ns`` as was waited."""
        return self._far_life.starved_ns <= since_ns

    def uncertainty_s(self, since_ns: int) -> OfTimes:
        """Return how far off a time measured since ``since_ns`` may be, in seconds.

        Zero on a free-running bench. On a locked one it is the sum of two things. First the worst lateness of the host
        in that span, for this bench, for a far one of ours and on the way there, and what its ports add; but at least
        `port_floor_s`, or as late as the host was shortly before: what the bench itself cannot see. Then every moment
        that slipped, for while bench time stood still what is real went on.
        """
        if not self.scheduler.locked:
            return OfTimes(0)
        late = self.lateness(since_ns)
        floor_s = self.port_floor_s or min(LOCKED_FLOOR_S, self._seen_s(max(0, since_ns - _LATELY_NS)))
        return OfTimes(max(floor_s, self._seen_s(since_ns)) + late.lost_ns / NS_PER_S)

    def _seen_s(self, since_ns: int) -> float:
        late = self.lateness(since_ns)
        return late.late_ns / NS_PER_S + self.port_uncertainty_s

    def span(self, first_ns: int, last_ns: int, *, unprompted: bool = False) -> Span:
        """Return how far apart two moments are, of which the second is the stamp of bytes, and how far off that may be.

        Where a process of its own has stamped the bytes, it counts how exactly it knows when they came, and how late
        this bench sent; not how late it read. Else it is `uncertainty_s`.

        Args:
            first_ns: the stamp of other bytes, or a bench time at which something was asked for or sent.
            last_ns: the stamp of the bytes.
            unprompted: both came by the clock of who sent them, whatever was sent there meanwhile. A bench of ours
                tells when they were due by that clock.
        """
        first, last = self._arrival(first_ns), self._arrival(last_ns)
        if last is None or (unprompted and first is None):
            return Span((last_ns - first_ns) / NS_PER_S, self.uncertainty_s(first_ns))
        late = self.far_lateness(first_ns)
        if first is None:
            moved_ns = self.scheduler.slipped_since_ns(first_ns) - self.scheduler.slipped_since_ns(first_ns + 1)
            begin_ns, early_ns = self.scheduler.host_ns(first_ns)[0], last.early_ns
        else:
            moved_ns, begin_ns, early_ns = 0, first.by_ns, max(first.early_ns, last.early_ns)
        if first is None or not unprompted:
            late += self.way_lateness(first_ns)
            early_ns, port_s = max(early_ns, self._left_late_ns(first_ns)), self.port_uncertainty_s
        elif not self.adapter_s and (due := _due_span(first, last)):
            return self._span(due, 0, 0.0, late.lost_ns)
        else:
            port_s = self.adapter_s
        apart = (last.by_ns - begin_ns, early_ns)
        return self._span(apart, late.late_ns, port_s, late.lost_ns + moved_ns)

    def _span(self, apart: tuple[float, float], late_ns: int, port_s: float, lost_ns: int) -> Span:
        """Return a span of so many ns, give or take so many, as far off as benches and ports may have it besides."""
        apart_ns, doubt_ns = apart
        doubt_s = max(self.port_floor_s, (doubt_ns + late_ns) / NS_PER_S + port_s) + lost_ns / NS_PER_S
        return Span(apart_ns / NS_PER_S, OfTimes(doubt_s))

    def _arrival(self, at_ns: int) -> Arrival | None:
        return None if self.stamps is None or not self.scheduler.locked else self.stamps.arrival(at_ns)

    def _left_late_ns(self, since_ns: int) -> int:
        """Return how late left what a span may be measured from, in ns: what was sent before counts up to the floor."""
        assert self.stamps is not None
        before_ns = self.stamps.left_late_ns(max(0, since_ns - _LATELY_NS))
        return max(self.stamps.left_late_ns(since_ns), min(before_ns, to_ns(LOCKED_FLOOR_S)))

    def record(self, kind: str, source: str, **fields: object) -> None:
        """Write an event that happens now into the journal."""
        self.journal.record(kind, source, self.now_ns, **fields)

    def record_event(self, source: str, event: object) -> None:
        """Write an event that is an object, such as one a robot reports, into the journal."""
        self.journal.record_value("event", source, self.now_ns, event)


def _due_span(first: Arrival, last: Arrival) -> tuple[float, float] | None:
    """Return how far apart bytes were due, and how far off that may be, in ns; None if nobody tells when they were.

    Bytes pass the lines of a bench that tells in groups.
    """
    if first.due_ns is None or last.due_ns is None:
        return None
    doubt_ns = sum(latest_ns - earliest_ns for earliest_ns, latest_ns in (first.due_ns, last.due_ns)) / 2
    return (sum(last.due_ns) - sum(first.due_ns)) / 2, REAL_TIME_GROUP_NS + doubt_ns
