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

import enum
import heapq
import itertools
from collections.abc import Callable, Sequence

from hilbench.clock.host import HostClock, InputSource, Stopwatch
from hilbench.clock.lateness import LatenessMeter
from hilbench.clock.pace import HEARTBEAT_NS, SLIP_THRESHOLD_NS, Pace, PaceListener
from hilbench.errors import InternalError


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
        self._pace: Pace | None = None
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

    @property
    def running(self) -> bool:
        """Whether entries are being run."""
        return self._running

    def interrupt(self) -> None:
        """Raise KeyboardInterrupt at the next boundary between entries: at once while waiting. For signal handlers.

        A second call while one entry is still running raises at once, so that an entry that hangs can be stopped.
        """
        if self._waiting or not self._running or self._interrupted:
            self._interrupted = False
            raise KeyboardInterrupt
        self._interrupted = True

    def _run_free(self, condition: Callable[[], bool] | None, deadline_ns: int | None) -> bool:
        # `next_ns` and `_run_first` in one: most of what a free-running bench does passes here, entry by entry.
        while not self._interrupted:
            heap = self._heap
            if not heap or (deadline_ns is not None and heap[0][0] > deadline_ns):
                if deadline_ns is not None:
                    self.now_ns = deadline_ns
                return False
            when_ns, _, _, _, entry = heapq.heappop(heap)
            action = entry.action
            if action is None:
                self._cancelled -= 1
                continue
            entry.action = None
            self.now_ns = when_ns
            action()
            if condition is not None and condition():
                return True
        self.interrupt()
        raise AssertionError  # interrupt() has raised

    def _run_locked(self, pace: Pace, condition: Callable[[], bool] | None, deadline_ns: int | None) -> bool:
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
            pace.done(self.now_ns)
            if condition is not None and condition():
                return True

    def _took_input(self, pace: Pace, target_ns: int | None) -> bool:
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

    def _wait(self, pace: Pace, until_ns: int | None) -> Sequence[InputSource]:
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
            listener: Notified how bench time keeps up.
        """
        if self._pace is not None:
            raise InternalError("bench time is locked to a host clock already")
        self._pace = Pace(host, self.now_ns, slip_threshold_ns, listener)
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
        if self._pace is not None:
            self._pace.host.watch(source)  # first: who is interrupted here must not find one that is not watched
        self._sources.append(source)

    def remove_source(self, source: InputSource) -> bool:
        """Stop watching a real input; call it while the descriptor is still open. Return whether it was watched."""
        if source not in self._sources:
            return False
        self._sources.remove(source)
        if self._pace is not None:
            self._pace.host.unwatch(source)
        return True

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
        pace = self._locked_pace
        return pace.host_ns(since_ns), pace.host.monotonic_ns()

    def speak(self, door: int) -> None:
        """Take note that the entry that runs sends something outside, by the door of a number."""
        if self._pace is not None:
            self._pace.spoke |= 1 << door

    def bench_ns(self, host_ns: int) -> int:
        """Return the bench time at the host's monotonic time `host_ns`, which has passed; on a locked bench.

        Raises:
            InternalError: the bench is not locked.
        """
        return self._locked_pace.bench_ns(host_ns)

    @property
    def behind_ns(self) -> int:
        """How far the host is beyond bench time, in ns: what is done now happens so much later; 0 if not locked."""
        return 0 if self._pace is None else max(0, self.bench_ns(self._pace.host.monotonic_ns()) - self.now_ns)

    @property
    def _locked_pace(self) -> Pace:
        if self._pace is None:
            raise InternalError("bench time is not locked to a host clock")
        return self._pace

    @property
    def real_time_factor(self) -> float | None:
        """Bench seconds per host second since the lock; None on a free-running bench."""
        return self._pace.real_time_factor(self.now_ns) if self._pace else None
