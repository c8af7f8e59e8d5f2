"""Bench time: one queue of things that happen later, and the only place that knows the host's clock.

Bench time is a whole number of nanoseconds since the start of the bench and one `Scheduler` owns it. Rules:

1. Everything that happens later is an entry of one queue, ordered by (ns, class, source, sequence). Two runs that make
   the same entries make the same trace.
2. Nothing runs in the past, and nothing is skipped.
3. *Free-running*, time jumps to the next entry. *Locked*, it is paced to the host's monotonic clock: the loop sleeps
   until the next entry is due and, while it sleeps, watches the real inputs. A byte from outside is stamped with the
   bench time of the moment it was seen, and becomes an entry like any other.
4. A host that is late a little is caught up: entries run as fast as they can until bench time is level again. A host
   that is late by more than `slip_threshold_ns` makes bench time *slip*: bench time did not pass during the stall.
   Both are measured, because a verdict on a deadline is worth no more than the lateness around it.
"""

from __future__ import annotations

import contextlib
import datetime
import enum
import heapq
import itertools
import select
import selectors
import signal
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from types import FrameType
from typing import Protocol

from hilbench.errors import InternalError

NS_PER_S = 1_000_000_000
NS_PER_MS = 1_000_000
NS_PER_US = 1_000

SLIP_THRESHOLD_NS = 50 * NS_PER_MS
HEARTBEAT_NS = 5 * NS_PER_MS
# While the loop is behind it looks at its inputs this often; a poll costs some microseconds.
_POLL_INTERVAL_NS = 500 * NS_PER_US
_SLIPS_KEPT = 1024


class ClockDomain:
    """Whole ticks of one clock and the bench time at which they fall.

    Tick k falls at floor(k / hz) nanoseconds after the domain's epoch. The time is computed from k every time, so no
    rounding error accumulates. `ticks` is the exact inverse: for clocks of up to 1 GHz `ticks(ns(k)) == k`.

    Args:
        hz: Rate in ticks per second, greater than zero; a Fraction for a rate such as 72 MHz / 7500.
    """

    __slots__ = ("_denominator", "_numerator", "hz")

    def __init__(self, hz: int | Fraction) -> None:
        if hz <= 0:
            raise ValueError(f"a clock needs a rate above zero, not {hz}")
        self.hz = Fraction(hz)
        # ns(k) = k * _numerator // _denominator
        self._numerator = NS_PER_S * self.hz.denominator
        self._denominator = self.hz.numerator

    def ns(self, ticks: int) -> int:
        """Return the nanoseconds from the epoch to tick number `ticks`, rounded down."""
        return ticks * self._numerator // self._denominator

    def ticks(self, ns: int) -> int:
        """Return the number of the last tick that has fallen by `ns` after the epoch."""
        return ((ns + 1) * self._denominator - 1) // self._numerator


class EventClass(enum.IntEnum):
    """The order of entries that fall on the same nanosecond.

    What comes in is seen before anybody acts on that instant: first the outside world and line faults, then the bytes
    that finish shifting in, then the physics slice that ends now. Then the controllers act on that state, then the
    timers send what they have. Checks come last, so that an answer on the very nanosecond of its limit is in time.
    """

    INPUT = 0
    BYTE = 1
    PHYSICS = 2
    CONTROL = 3
    TIMER = 4
    CHECK = 5


class InputSource(Protocol):
    """A real input that a locked scheduler watches."""

    def fileno(self) -> int:
        """Return the descriptor to watch for readability."""

    def on_readable(self, at_ns: int) -> None:
        """Take what is there and schedule its delivery at `at_ns` (bench time; never before the scheduler's now)."""


class HostClock(Protocol):
    """The host's monotonic clock, and waiting on it."""

    def monotonic_ns(self) -> int:
        """Return the host's monotonic time in nanoseconds."""

    def wait_until(self, host_ns: int | None) -> Sequence[InputSource]:
        """Wait until `host_ns` (None: for ever) or until an input is readable; return the readable ones.

        A moment that has passed makes this a poll.
        """

    def watch(self, source: InputSource) -> None:
        """Begin to watch `source`."""

    def unwatch(self, source: InputSource) -> None:
        """Stop watching `source`."""


class MonotonicHostClock:
    """The real host clock. Inputs are watched with epoll (kqueue elsewhere), waits end within some 0.1 ms."""

    def __init__(self) -> None:
        self._selector = selectors.DefaultSelector()
        # The descriptor of epoll and kqueue is itself selectable. epoll alone rounds its timeout up to a millisecond.
        self._gate: int | None = getattr(self._selector, "fileno", lambda: None)()

    def monotonic_ns(self) -> int:
        """Return the host's monotonic time in nanoseconds."""
        return time.monotonic_ns()

    def wait_until(self, host_ns: int | None) -> Sequence[InputSource]:
        """Wait until `host_ns` or until an input is readable; return the readable ones."""
        timeout_s = None if host_ns is None else max(0, host_ns - time.monotonic_ns()) / NS_PER_S
        if timeout_s and self._gate is not None:
            select.select((self._gate,), (), (), timeout_s)
            timeout_s = 0
        return [key.data for key, _ in self._selector.select(timeout_s)]

    def watch(self, source: InputSource) -> None:
        """Begin to watch `source`."""
        self._selector.register(source.fileno(), selectors.EVENT_READ, source)

    def unwatch(self, source: InputSource) -> None:
        """Stop watching `source`; its descriptor must still be open."""
        self._selector.unregister(source.fileno())

    def close(self) -> None:
        """Release the descriptor the clock watches with."""
        self._selector.close()


class ScaledHostClock:
    """Another host clock that passes at a multiple of its speed, so that a bench does.

    Args:
        host: the clock.
        factor: how many seconds it tells for one of the host's; above 0.
    """

    def __init__(self, host: HostClock, factor: float) -> None:
        self._host = host
        self._factor = factor
        self._start_ns = host.monotonic_ns()

    def monotonic_ns(self) -> int:
        """Return the scaled time in nanoseconds; at the beginning it is the host's."""
        return self._start_ns + round((self._host.monotonic_ns() - self._start_ns) * self._factor)

    def wait_until(self, host_ns: int | None) -> Sequence[InputSource]:
        """Wait until the scaled time `host_ns` or until an input is readable; return the readable ones."""
        if host_ns is None:
            return self._host.wait_until(None)
        return self._host.wait_until(self._start_ns + round((host_ns - self._start_ns) / self._factor))

    def watch(self, source: InputSource) -> None:
        """Begin to watch `source`."""
        self._host.watch(source)

    def unwatch(self, source: InputSource) -> None:
        """Stop watching `source`."""
        self._host.unwatch(source)


class Stopwatch:
    """Host time since it was made; for reports, never for verdicts."""

    def __init__(self, host: HostClock | None = None) -> None:
        self._read_ns = host.monotonic_ns if host else time.monotonic_ns
        self._start_ns = self._read_ns()

    def elapsed_s(self) -> float:
        """Return the host seconds since the stopwatch was made."""
        return (self._read_ns() - self._start_ns) / NS_PER_S


def wall_time_iso() -> str:
    """Return the date and time of day in UTC, as ISO 8601, for the heading of a report."""
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")


class LatenessMeter:
    """How late the host was, in buckets of an eighth of an octave (an answer is never low, and high by at most 1/8).

    Args:
        last_ns: `BUCKETS` numbers to keep the times in, which others may look at; its own by default.
    """

    __slots__ = ("_counts", "_last_ns", "count", "max_ns")

    _STEPS_BITS = 3
    BUCKETS = 64 << _STEPS_BITS

    def __init__(self, last_ns: list[int] | memoryview[int] | None = None) -> None:
        self._counts = [0] * self.BUCKETS
        self._last_ns = [-1] * self.BUCKETS if last_ns is None else last_ns
        self.count = 0
        self.max_ns = 0

    def record(self, late_ns: int, at_ns: int) -> None:
        """Count a wake-up that was `late_ns` (0 or more) late for an entry due at bench time `at_ns`."""
        shift = max(0, late_ns.bit_length() - self._STEPS_BITS - 1)
        bucket = (shift << self._STEPS_BITS) + (late_ns >> shift)
        self._counts[bucket] += 1
        self._last_ns[bucket] = at_ns
        self.count += 1
        self.max_ns = max(self.max_ns, late_ns)

    def max_since_ns(self, since_ns: int) -> int:
        """Return the greatest lateness of entries due at bench time `since_ns` or later; 0 if there were none."""
        for bucket in range(len(self._counts) - 1, -1, -1):
            if self._last_ns[bucket] >= since_ns:
                return min(self.max_ns, self._upper_edge_ns(bucket))
        return 0

    def quantile_ns(self, share: float) -> int:
        """Return the lateness that `share` (0 to 1) of all wake-ups did not exceed; 0 if there were none."""
        wanted = share * self.count
        seen = 0
        for bucket, count in enumerate(self._counts):
            seen += count
            if count and seen >= wanted:
                return min(self.max_ns, self._upper_edge_ns(bucket))
        return 0

    def _upper_edge_ns(self, bucket: int) -> int:
        steps = 1 << self._STEPS_BITS
        if bucket < 2 * steps:
            return bucket
        shift = (bucket >> self._STEPS_BITS) - 1
        return ((bucket - (shift << self._STEPS_BITS) + 1) << shift) - 1


class Entry:
    """One thing that will happen; keep it to cancel it."""

    __slots__ = ("action", "when_ns")

    def __init__(self, when_ns: int, action: Callable[[], None]) -> None:
        self.when_ns = when_ns
        self.action: Callable[[], None] | None = action

    @property
    def pending(self) -> bool:
        """True until the entry has run or was cancelled."""
        return self.action is not None


class PaceListener(Protocol):
    """Whoever is told how a bench keeps up with the host's clock; all times are the host's, in ns."""

    def due(self, host_ns: int) -> None:
        """Learn when the next entry is due: until it has run, the bench is no further than that."""

    def ran(self, late_ns: int, host_ns: int) -> None:
        """Learn how late an entry runs now."""

    def slipped(self, slip_ns: int, host_ns: int) -> None:
        """Learn that bench time stood still for so long until now."""


class _Pace:
    """The tie between bench time and a host clock: epoch, slips, lateness."""

    def __init__(self, host: HostClock, now_ns: int, slip_threshold_ns: int, listener: PaceListener | None) -> None:
        self.host = host
        self.lateness = LatenessMeter()
        self._listener = listener
        self.slips = 0
        self.slipped_ns = 0
        self._slip_log: deque[tuple[int, int]] = deque(maxlen=_SLIPS_KEPT)  # (bench time, slipped before it)
        self._slip_threshold_ns = slip_threshold_ns
        self._start_bench_ns = now_ns
        self._start_host_ns = host.monotonic_ns()
        self._last_look_ns = self._start_host_ns
        self._epoch_ns = self._start_host_ns - now_ns

    def aim(self, due_ns: int | None) -> None:
        """Learn which entry is the next."""
        if self._listener is not None and due_ns is not None:
            self._listener.due(due_ns + self._epoch_ns)

    def ran(self, late_ns: int, due_ns: int) -> None:
        """Take down how late an entry runs that was due at bench time `due_ns`."""
        self.lateness.record(late_ns, due_ns)
        if self._listener is not None:
            self._listener.ran(late_ns, due_ns + self._epoch_ns + late_ns)

    def host_ns(self, bench_ns: int) -> int:
        """Return the host's time at bench time `bench_ns`, which has passed; never too late a time."""
        return bench_ns + self._epoch_ns - self.slipped_since_ns(bench_ns)

    def look(self, due_ns: int | None) -> int:
        """Return the bench time the host has reached, slipping first if it is far beyond `due_ns`."""
        reached_ns = self.host.monotonic_ns() - self._epoch_ns
        if due_ns is not None and reached_ns - due_ns > self._slip_threshold_ns:
            self._slip(reached_ns - due_ns, due_ns)
            return due_ns
        return reached_ns

    def resume(self, now_ns: int) -> None:
        """Begin to run: a long pause since the last run was not bench time.

        It counts as lateness just before `now_ns`. A span measured from now on, after the pause, is not spoilt by it.
        """
        pause_ns = self.host.monotonic_ns() - self._epoch_ns - now_ns
        if pause_ns > self._slip_threshold_ns:
            self._slip(pause_ns, now_ns - 1)

    def _slip(self, slip_ns: int, at_ns: int) -> None:
        self.lateness.record(slip_ns, at_ns)
        self._slip_log.append((at_ns, self.slipped_ns))
        self.slips += 1
        self.slipped_ns += slip_ns
        self._epoch_ns += slip_ns
        if self._listener is not None:
            self._listener.slipped(slip_ns, at_ns + self._epoch_ns)

    def slipped_since_ns(self, since_ns: int) -> int:
        """Return the host time that slips since bench time `since_ns` took; never understated."""
        before_ns = self.slipped_ns
        for at_ns, slipped_before_ns in reversed(self._slip_log):
            if at_ns < since_ns:
                return self.slipped_ns - before_ns
            before_ns = slipped_before_ns
        return self.slipped_ns  # no slip before that is remembered

    def wait(self, until_ns: int | None) -> Sequence[InputSource]:
        """Wait until bench time `until_ns` or for an input."""
        ready = self.host.wait_until(None if until_ns is None else until_ns + self._epoch_ns)
        self._last_look_ns = self.host.monotonic_ns()
        return ready

    def poll_is_due(self, reached_ns: int) -> bool:
        """Say whether the inputs have not been looked at for a while, the host having reached `reached_ns`."""
        return reached_ns + self._epoch_ns - self._last_look_ns >= _POLL_INTERVAL_NS

    def real_time_factor(self, now_ns: int) -> float:
        """Return bench seconds per host second since the lock."""
        host_ns = self.host.monotonic_ns() - self._start_host_ns
        return (now_ns - self._start_bench_ns) / host_ns if host_ns > 0 else 1.0


class Scheduler:
    """The owner of bench time. Not thread-safe: everything runs in the thread that calls `run_until`.

    Attributes:
        now_ns: Bench time in nanoseconds: the instant of the entry that runs, or ran last.
        deadline_ns: How far the present run goes at most; None without a deadline, or while nothing runs.
    """

    def __init__(self) -> None:
        self.now_ns = 0
        self.deadline_ns: int | None = None
        self._heap: list[tuple[int, int, str, int, Entry]] = []
        self._sequence = itertools.count()
        self._cancelled = 0
        self._sources: list[InputSource] = []
        self._last_input_ns = 0
        self._pace: _Pace | None = None
        self._heartbeat_ns: int | None = None
        self._heartbeat: Entry | None = None
        self._running = False
        self._waiting = False
        self._interrupted = False

    # --- the queue

    def at(
        self, when_ns: int, action: Callable[[], None], *, order: EventClass = EventClass.TIMER, source: str = ""
    ) -> Entry:
        """Have `action` run at bench time `when_ns`.

        Args:
            when_ns: Bench time in ns, not before now.
            action: Called without arguments.
            order: Its class among entries of the same nanosecond.
            source: Who asked for it; the second criterion among entries of the same nanosecond.

        Raises:
            InternalError: `when_ns` has passed.
        """
        if when_ns < self.now_ns:
            raise InternalError(
                f"{source or action!r} wants to run at {when_ns} ns, but it is {self.now_ns} ns already"
            )
        entry = Entry(when_ns, action)
        heapq.heappush(self._heap, (when_ns, order, source, next(self._sequence), entry))
        return entry

    def after(
        self, delay_ns: int, action: Callable[[], None], *, order: EventClass = EventClass.TIMER, source: str = ""
    ) -> Entry:
        """Have `action` run `delay_ns` from now; see `at`."""
        return self.at(self.now_ns + delay_ns, action, order=order, source=source)

    def cancel(self, entry: Entry) -> None:
        """Make sure that `entry` does not run (again). It may have run or been cancelled already."""
        if entry.action is None:
            return
        entry.action = None
        self._cancelled += 1
        # Cancelled entries leave the heap when their time comes; this keeps a timer restarted per byte from piling up.
        if self._cancelled > 64 and self._cancelled * 2 > len(self._heap):
            self._heap = [item for item in self._heap if item[4].action is not None]
            heapq.heapify(self._heap)
            self._cancelled = 0

    def next_ns(self) -> int | None:
        """Return the time of the next entry, or None if there is none."""
        while self._heap and self._heap[0][4].action is None:
            heapq.heappop(self._heap)
            self._cancelled -= 1
        return self._heap[0][0] if self._heap else None

    # --- running

    def run_for(self, duration_ns: int) -> None:
        """Let `duration_ns` of bench time pass."""
        self.run_until(None, self.now_ns + duration_ns)

    def run_until(self, condition: Callable[[], bool] | None, deadline_ns: int | None) -> bool:
        """Run entries until `condition` holds, at most up to and including those at `deadline_ns`.

        The condition is looked at before the first entry and after every entry. When it does not come true, bench time
        stands at the deadline afterwards. Without a deadline the run also ends, with False, when nothing can happen
        any more.

        Args:
            condition: None to run up to the deadline.
            deadline_ns: Bench time in ns, or None.

        Returns:
            Whether the condition holds.

        Raises:
            InternalError: called from within an entry, the deadline has passed, or real inputs are attached to a
                free-running bench.
            KeyboardInterrupt: `interrupt` was called; no entry has been left half done.
        """
        if self._running:
            raise InternalError("an entry of the scheduler tried to run the scheduler")
        if deadline_ns is not None and deadline_ns < self.now_ns:
            raise InternalError(f"cannot run until {deadline_ns} ns: it is {self.now_ns} ns already")
        if self._pace is None and self._sources:
            raise InternalError("real inputs are attached, but bench time is not locked to the host's clock")
        self._running = True
        self.deadline_ns = deadline_ns
        try:
            if condition is not None and condition():
                return True
            if self._pace is None:
                return self._run_free(condition, deadline_ns)
            self._pace.resume(self.now_ns)
            return self._run_locked(self._pace, condition, deadline_ns)
        finally:
            self._running = False
            self.deadline_ns = None

    def interrupt(self) -> None:
        """Raise KeyboardInterrupt at the next boundary between entries: at once while waiting. For signal handlers.

        A second call while one entry is still running raises at once, so that an entry that hangs can be stopped.
        """
        if self._waiting or not self._running or self._interrupted:
            self._interrupted = False
            raise KeyboardInterrupt
        self._interrupted = True

    def _run_free(self, condition: Callable[[], bool] | None, deadline_ns: int | None) -> bool:
        while not self._interrupted:
            when_ns = self.next_ns()
            if when_ns is None or (deadline_ns is not None and when_ns > deadline_ns):
                if deadline_ns is not None:
                    self.now_ns = deadline_ns
                return False
            self._run_first()
            if condition is not None and condition():
                return True
        self.interrupt()
        raise AssertionError  # interrupt() has raised

    def _run_locked(self, pace: _Pace, condition: Callable[[], bool] | None, deadline_ns: int | None) -> bool:
        while True:
            when_ns = self.next_ns()
            due = when_ns is not None and (deadline_ns is None or when_ns <= deadline_ns)
            target_ns = when_ns if due else deadline_ns
            if target_ns is None and not self._sources:
                return False
            if self._took_input(pace, target_ns):
                continue
            if not due:
                if target_ns is not None:
                    self.now_ns = target_ns
                return False
            self._run_first()
            if condition is not None and condition():
                return True

    def _took_input(self, pace: _Pace, target_ns: int | None) -> bool:
        """Wait until bench time `target_ns`; True if inputs came first, so that the queue must be looked at again."""
        pace.aim(target_ns)
        reached_ns = pace.look(target_ns)
        late = target_ns is not None and reached_ns >= target_ns
        ready: Sequence[InputSource] = ()
        if not late or pace.poll_is_due(reached_ns):
            ready = self._wait(pace, target_ns)
            reached_ns = pace.look(target_ns)
        elif self._interrupted:
            self.interrupt()
        if ready:
            # A slip sets the host's bench time back, but what comes in later must not overtake what came in before.
            self._last_input_ns = max(self._last_input_ns, self.now_ns, reached_ns)
            for source in ready:
                source.on_readable(self._last_input_ns)
            return True
        if target_ns is not None:
            pace.ran(max(0, reached_ns - target_ns), target_ns)
        return False

    def _wait(self, pace: _Pace, until_ns: int | None) -> Sequence[InputSource]:
        # A signal handler runs in this thread: after `_waiting` is set it raises by itself, before that it has set the
        # flag that is looked at here. Neither order loses the interrupt.
        self._waiting = True
        try:
            if self._interrupted:
                self.interrupt()
            return pace.wait(until_ns)
        finally:
            self._waiting = False

    def _run_first(self) -> None:
        when_ns, _, _, _, entry = heapq.heappop(self._heap)
        action = entry.action
        entry.action = None
        self.now_ns = when_ns
        if action is not None:
            action()

    # --- the host

    def lock(
        self,
        host: HostClock,
        *,
        slip_threshold_ns: int = SLIP_THRESHOLD_NS,
        heartbeat_ns: int | None = HEARTBEAT_NS,
        listener: PaceListener | None = None,
    ) -> None:
        """Pace bench time to `host` from now on.

        Args:
            host: The clock to follow.
            slip_threshold_ns: Lateness up to this is caught up; beyond it bench time slips.
            heartbeat_ns: Period of an entry that does nothing but measure lateness while nothing else is due; None
                for no such entry.
            listener: Told how bench time keeps up.
        """
        if self._pace is not None:
            raise InternalError("bench time is locked to a host clock already")
        self._pace = _Pace(host, self.now_ns, slip_threshold_ns, listener)
        for source in self._sources:
            host.watch(source)
        self._heartbeat_ns = heartbeat_ns
        self._beat()

    def unlock(self) -> None:
        """Let bench time run free again."""
        if self._pace is None:
            return
        for source in self._sources:
            self._pace.host.unwatch(source)
        self._pace = None
        self._heartbeat_ns = None
        if self._heartbeat is not None:
            self.cancel(self._heartbeat)

    def _beat(self) -> None:
        if self._heartbeat_ns is not None:
            self._heartbeat = self.after(self._heartbeat_ns, self._beat, order=EventClass.CHECK, source="heartbeat")

    def add_source(self, source: InputSource) -> None:
        """Watch a real input while running. The bench must be locked before it runs."""
        self._sources.append(source)
        if self._pace is not None:
            self._pace.host.watch(source)

    def remove_source(self, source: InputSource) -> None:
        """Stop watching a real input; call it while the descriptor is still open. Unknown sources are ignored."""
        if source not in self._sources:
            return
        self._sources.remove(source)
        if self._pace is not None:
            self._pace.host.unwatch(source)

    def stopwatch(self) -> Stopwatch | None:
        """Return a stopwatch of the host clock that bench time follows; None on a free-running bench."""
        return Stopwatch(self._pace.host) if self._pace else None

    # --- what was measured (all zero, and None, on a bench that is not locked)

    @property
    def locked(self) -> bool:
        """True while bench time follows a host clock."""
        return self._pace is not None

    @property
    def lateness(self) -> LatenessMeter:
        """How late entries ran since the lock."""
        return self._pace.lateness if self._pace else LatenessMeter()

    def lateness_max_ns(self, since_ns: int) -> int:
        """Return how late the latest entry since bench time `since_ns` ran, in ns, never understated."""
        return self.lateness.max_since_ns(since_ns)

    @property
    def slips(self) -> int:
        """How often bench time slipped since the lock."""
        return self._pace.slips if self._pace else 0

    @property
    def slipped_ns(self) -> int:
        """Host time, in ns, that was not bench time since the lock."""
        return self._pace.slipped_ns if self._pace else 0

    def slipped_since_ns(self, since_ns: int) -> int:
        """Return the host time, in ns, that was not bench time since bench time `since_ns`, never understated.

        A span of bench time is that much shorter than what something real went through meanwhile.
        """
        return self._pace.slipped_since_ns(since_ns) if self._pace else 0

    def host_ns(self, since_ns: int) -> tuple[int, int]:
        """Return the host's monotonic time at bench time `since_ns`, never too late a time, and now; on a locked bench.

        Raises:
            InternalError: the bench is not locked.
        """
        if self._pace is None:
            raise InternalError("bench time is not locked to a host clock")
        return self._pace.host_ns(since_ns), self._pace.host.monotonic_ns()

    @property
    def real_time_factor(self) -> float | None:
        """Bench seconds per host second since the lock; None on a free-running bench."""
        return self._pace.real_time_factor(self.now_ns) if self._pace else None


@contextlib.contextmanager
def deferred_interrupts(scheduler: Scheduler, signals: Sequence[signal.Signals] = (signal.SIGINT,)) -> Iterator[None]:
    """While in this context, let `signals` interrupt `scheduler` only between its entries. Main thread only."""

    def handle(_number: int, _frame: FrameType | None) -> None:
        scheduler.interrupt()

    before = {number: signal.signal(number, handle) for number in signals}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
