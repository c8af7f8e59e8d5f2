"""Time inside a microcontroller: HCLK cycles, the epochs that tie them to bench time, and what happens at a cycle.

Everything in a chip runs on a clock that divides HCLK, so the whole cycle of HCLK is the tick here. When the firmware
changes the clock, an *epoch* begins: cycle number c0 falls at exactly t0 (a Fraction of seconds), and from there on
cycle c falls at t0 + (c - c0) / hclk. No rounding error accumulates; nanoseconds are derived, rounded down.

Things that happen at a moment of bench time rather than at a cycle (an edge from outside, an oscillator of its own such
as LSI) are entered with `at_time` and follow a change of the clock by themselves.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable
from fractions import Fraction

__all__ = ["NS_PER_S", "Event", "Timebase"]

NS_PER_S = 1_000_000_000


class Event:
    """Something that will happen; keep it to cancel it.

    Attributes:
        cycle: when, in HCLK cycles.
        time_s: the exact bench time it belongs to, if it was entered by time; it is then re-timed in every new epoch.
        time_ns: likewise, if that is a whole number of nanoseconds.
    """

    __slots__ = ("action", "cycle", "order", "time_ns", "time_s")

    def __init__(
        self,
        cycle: int,
        order: int,
        action: Callable[[], None],
        time_s: Fraction | None = None,
        time_ns: int | None = None,
    ) -> None:
        self.cycle = cycle
        self.order = order
        self.action: Callable[[], None] | None = action
        self.time_s = time_s
        self.time_ns = time_ns

    @property
    def pending(self) -> bool:
        """True until it has happened or was cancelled."""
        return self.action is not None


class Timebase:
    """The cycle counter and the queue of one chip.

    Args:
        hclk_hz: rate of HCLK from cycle 0 on, which falls at bench time 0.

    Attributes:
        hclk_hz: present rate of HCLK.
        read_cycle: what `now` asks while the CPU runs: the cycle at which the instruction in flight began. The machine
            sets it; while an event happens, `now` is the cycle of that event.
        on_earlier: called with the cycle of an entry that is made while the CPU runs, so that the slice can be cut.
        halted: whether `run_until` was told to go no further.
    """

    def __init__(self, hclk_hz: int | Fraction) -> None:
        self.hclk_hz = Fraction(hclk_hz)
        self._epoch_cycle = 0
        self._epoch_s = Fraction(0)
        self._heap: list[tuple[int, int, int, Event]] = []
        self._sequence = itertools.count()
        self._fixed: int | None = 0
        self.read_cycle: Callable[[], int] = lambda: 0
        self.on_earlier: Callable[[int], None] = lambda _cycle: None
        self.halted = False
        self._alone_until = 0  # while `run_until` runs: its limit
        self._set_ratio()

    # --- cycles and seconds

    @property
    def now(self) -> int:
        """The present cycle."""
        return self.read_cycle() if self._fixed is None else self._fixed

    def ns(self, cycle: int) -> int:
        """Return the bench time of `cycle`, of the present epoch, in whole nanoseconds, rounded down."""
        return (self._ns_offset + (cycle - self._epoch_cycle) * self._ns_per_cycle) // self._ns_scale

    def seconds(self, cycle: int) -> Fraction:
        """Return the exact bench time of `cycle`, of the present epoch."""
        return Fraction(self._ns_offset + (cycle - self._epoch_cycle) * self._ns_per_cycle, self._s_scale)

    def cycle_at_ns(self, ns: int) -> int:
        """Return the first cycle whose `ns` is not before `ns`."""
        return self._epoch_cycle + -((self._ns_offset - ns * self._ns_scale) // self._ns_per_cycle)

    def cycle_at(self, time_s: Fraction) -> int:
        """Return the first cycle that does not fall before `time_s`."""
        numerator, denominator = time_s.numerator, time_s.denominator
        behind = self._ns_offset * denominator - numerator * self._s_scale
        return self._epoch_cycle - behind // (self._ns_per_cycle * denominator)

    def set_hclk(self, hclk_hz: Fraction) -> None:
        """Begin a new epoch at the present cycle; entries made by time move to their new cycles."""
        now = self.now
        self._epoch_s = self.seconds(now)
        self._epoch_cycle = now
        self.hclk_hz = hclk_hz
        self._set_ratio()
        timed = [item[3] for item in self._heap if item[3].pending and _is_timed(item[3])]
        if timed:
            self._heap = [item for item in self._heap if not _is_timed(item[3])]
            heapq.heapify(self._heap)
            for event in timed:
                event.cycle = max(now, self._cycle_of(event))
                self._push(event)
        self.on_earlier(now)  # a limit in bench time is another cycle now
        self.halted = True

    def _cycle_of(self, event: Event) -> int:
        """Return the cycle of an event that was entered by time."""
        if event.time_s is not None:
            return self.cycle_at(event.time_s)
        assert event.time_ns is not None
        return self.cycle_at_ns(event.time_ns)

    def _set_ratio(self) -> None:
        # ns(c) = floor(epoch_ns + (c - epoch) * 1e9 / hclk), over the common denominator `_ns_scale`
        epoch_ns, step_ns = self._epoch_s * NS_PER_S, NS_PER_S / self.hclk_hz
        self._ns_scale = epoch_ns.denominator * step_ns.denominator
        self._ns_offset = epoch_ns.numerator * step_ns.denominator
        self._ns_per_cycle = step_ns.numerator * epoch_ns.denominator
        self._s_scale = self._ns_scale * NS_PER_S

    # --- the queue

    def at(self, cycle: int, action: Callable[[], None], *, order: int = 0) -> Event:
        """Have `action` happen at `cycle` (now or later); in the order of `order`, then of making."""
        # Every byte on every line comes by here several times, so nothing is called that need not be.
        fixed = self._fixed
        now = self.read_cycle() if fixed is None else fixed
        if cycle < now:
            cycle = now
        event = Event(cycle, order, action)
        heapq.heappush(self._heap, (cycle, order, next(self._sequence), event))
        if fixed is None:
            self.on_earlier(cycle)
        return event

    def after(self, cycles: int, action: Callable[[], None], *, order: int = 0) -> Event:
        """Have `action` happen `cycles` from now."""
        return self.at(self.now + cycles, action, order=order)

    def at_time(self, time_s: Fraction, action: Callable[[], None], *, order: int = 0) -> Event:
        """Have `action` happen at the first cycle that does not fall before bench time `time_s`."""
        event = Event(max(self.cycle_at(time_s), self.now), order, action, time_s)
        self._push(event)
        return event

    def at_ns(self, time_ns: int, action: Callable[[], None], *, order: int = 0) -> Event:
        """Do as `at_time` does, for a time in whole nanoseconds: fractions cost more than all the rest of it."""
        event = Event(max(self.cycle_at_ns(time_ns), self.now), order, action, time_ns=time_ns)
        self._push(event)
        return event

    def cancel(self, event: Event | None) -> None:
        """Make sure that `event` does not happen (again); None and past events are ignored."""
        if event is not None:
            event.action = None

    def _push(self, event: Event) -> None:
        heapq.heappush(self._heap, (event.cycle, event.order, next(self._sequence), event))
        if self._fixed is None:
            self.on_earlier(event.cycle)

    def next_cycle(self) -> int | None:
        """Return the cycle of the next event, or None."""
        heap = self._heap
        while heap and heap[0][3].action is None:
            heapq.heappop(heap)
        return heap[0][0] if heap else None

    def run_due(self, cycle: int) -> bool:
        """Let everything happen that is due by `cycle`, each at its own; return whether anything was."""
        happened = False
        heap = self._heap
        while heap and heap[0][0] <= cycle:
            due, _order, _number, event = heapq.heappop(heap)
            action = event.action
            if action is not None:
                event.action = None
                self._fixed = due
                action()
                happened = True
                heap = self._heap  # a change of the clock makes a new one
        self._fixed = cycle
        return happened

    def run_until(self, limit: int) -> int | None:
        """Let everything happen that is due before `limit`, each at its own cycle; return the cycle of the last.

        After a cycle at which `halted` was set, by whoever has made something that is not for this queue alone, nothing
        more happens. None: nothing was due.
        """
        self.halted = False
        self._alone_until = limit
        try:
            reached = self._run_alone(limit)
        finally:
            self._alone_until = 0
        if reached is not None and self.halted:
            self.run_due(reached)
        return reached

    def _run_alone(self, limit: int) -> int | None:
        reached = None
        heap = self._heap
        while heap and not self.halted:
            due, _order, _number, event = heap[0]
            action = event.action
            if action is not None and due >= limit:
                return reached
            heapq.heappop(heap)
            if action is not None:
                event.action = None
                self._fixed = reached = due
                action()
        return reached

    def nobody_looks_until(self, cycle: int) -> bool:
        """Say whether nothing happens after the present event up to and with `cycle`, and no program runs meanwhile.

        What would be entered for then may then be done at once, with `hold`: nobody can tell.
        """
        if cycle >= self._alone_until or self.halted:
            return False
        following = self.next_cycle()
        return following is None or following > cycle

    # --- the machine's side

    def hold(self, cycle: int) -> None:
        """Make `now` stand at `cycle`: the CPU is not executing."""
        self._fixed = cycle

    def follow_cpu(self) -> None:
        """Make `now` ask the CPU from here on: it executes."""
        self._fixed = None


def _is_timed(event: Event) -> bool:
    return event.time_s is not None or event.time_ns is not None
