"""Time inside a microcontroller: HCLK cycles, the epochs that tie them to bench time, and what happens at a cycle.

Everything in a chip runs on a clock that divides HCLK, so the whole cycle of HCLK is the tick here. When the firmware
changes the clock, an *epoch* begins: cycle number c0 falls at exactly t0 (a Fraction of seconds), and from there on
cycle c falls at t0 + (c - c0) / hclk. No rounding error accumulates; nanoseconds are derived, rounded down.

Things that happen at a moment of bench time rather than at a cycle (an edge from outside, an oscillator of its own such
as LSI) are entered with `at_time` and follow a change of the clock by themselves.

The queue itself is in C (``queue.c``), for the peripherals that are.
"""

from __future__ import annotations

import ctypes
import functools
import sys
import weakref
from collections.abc import Callable
from fractions import Fraction
from typing import Any

from targets.mcu.core.library import owner_of, structure, with_lock_held
from targets.mcu.errors import EngineError

__all__ = ["NS_PER_S", "Event", "Timebase"]

NS_PER_S = 1_000_000_000

_NOW, _NEXT, _HALTED = range(3)  # fields of ``struct hil_time``
_HAPPEN = ctypes.PYFUNCTYPE(ctypes.c_bool, ctypes.c_int32)
_NEVER = (1 << 64) - 1


class Event:
    """Something that will happen; keep it to cancel it.

    Attributes:
        cycle: when, in HCLK cycles.
        order: what it comes after at the same cycle.
        action: what it is; None once it has happened or was cancelled.
        time_s: the exact bench time it belongs to, if it was entered by time; it is then re-timed in every new epoch.
        time_ns: the same for a whole number of nanoseconds.
    """

    __slots__ = ("action", "cycle", "number", "order", "time_ns", "time_s")

    def __init__(
        self,
        number: int,
        cycle: int,
        order: int,
        action: Callable[[], None],
        time_s: Fraction | None = None,
        time_ns: int | None = None,
    ) -> None:
        self.number = number
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
        queue: the queue, for what is in C.

    Raises:
        EngineError: the library is missing and cannot be made.
    """

    def __init__(self, hclk_hz: int | Fraction) -> None:
        self.hclk_hz = Fraction(hclk_hz)
        self._epoch_cycle = 0
        self._epoch_s = Fraction(0)
        library = _library()
        self._callback = _HAPPEN(self._happen)
        queue = library.hil_queue_new(self._callback)
        if not queue:
            raise EngineError("there is no memory for a queue")
        self.queue = ctypes.c_void_p(queue)
        weakref.finalize(self, library.hil_queue_free, self.queue).atexit = False  # what runs at exit may still ask
        self._kept = structure("hil_time").from_address(library.hil_time_of(self.queue))
        self._view = memoryview(self._kept).cast("B").cast("Q")
        self._events: dict[int, Event] = {}
        self._enter: Callable[[int, int], int] = functools.partial(library.hil_queue_enter, self.queue)
        self._move: Callable[[int, int, int], None] = functools.partial(library.hil_queue_move, self.queue)
        self._leave: Callable[[int], None] = functools.partial(library.hil_queue_leave, self.queue)
        self._due: Callable[[int], None] = functools.partial(library.hil_queue_due, self.queue)
        self._cut: Callable[[], None] = functools.partial(library.hil_queue_cut, self.queue)
        self._trouble: BaseException | None = None
        self._in_c: list[object] = []
        self._set_ratio()

    # --- cycles and seconds

    @property
    def now(self) -> int:
        """The present cycle; while the CPU runs, the one at which the instruction in flight began."""
        return self._view[_NOW]

    @property
    def halted(self) -> bool:
        """Whether a run of the CPU was told to let nothing more happen."""
        return bool(self._view[_HALTED])

    @halted.setter
    def halted(self, halted: bool) -> None:
        self._view[_HALTED] = halted

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
        timed = [event for event in self._events.values() if event.time_s is not None or event.time_ns is not None]
        for event in sorted(timed, key=lambda event: (event.cycle, event.order)):
            event.cycle = max(now, self._cycle_of(event))
            self._move(event.number, event.cycle, event.order)
        self.cut()
        self.halted = True  # a limit in bench time is another cycle now

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
        now = self._view[_NOW]
        if cycle < now:
            cycle = now
        number = self._enter(cycle, order)
        event = self._events[number] = Event(number, cycle, order, action)
        return event

    def after(self, cycles: int, action: Callable[[], None], *, order: int = 0) -> Event:
        """Have `action` happen `cycles` from now."""
        return self.at(self.now + cycles, action, order=order)

    def at_time(self, time_s: Fraction, action: Callable[[], None], *, order: int = 0) -> Event:
        """Have `action` happen at the first cycle that does not fall before bench time `time_s`."""
        event = self.at(self.cycle_at(time_s), action, order=order)
        event.time_s = time_s
        return event

    def at_ns(self, time_ns: int, action: Callable[[], None], *, order: int = 0) -> Event:
        """Do as `at_time` does, for a time in whole nanoseconds: fractions cost more than all the rest of it."""
        event = self.at(self.cycle_at_ns(time_ns), action, order=order)
        event.time_ns = time_ns
        return event

    def cancel(self, event: Event | None) -> None:
        """Make sure that `event` does not happen (again); None and past events are ignored."""
        if event is not None and event.action is not None:
            event.action = None
            del self._events[event.number]
            self._leave(event.number)

    def next_cycle(self) -> int | None:
        """Return the cycle of the next event, or None."""
        cycle = self._view[_NEXT]
        return None if cycle == _NEVER else cycle

    def run_due(self, cycle: int) -> bool:
        """Let everything happen that is due by `cycle`, each at its own; return whether anything was."""
        view = self._view
        if view[_NEXT] > cycle:
            view[_NOW] = cycle
            self.raise_kept()
            return False
        others = sys.unraisablehook
        sys.unraisablehook = functools.partial(self._on_unraisable, others)
        try:
            self._due(cycle)
        finally:
            sys.unraisablehook = others
        self.raise_kept()
        return True

    def _happen(self, number: int) -> bool:
        try:
            event = self._events.pop(number)
            action, event.action = event.action, None
            assert action is not None
            action()
        except BaseException as trouble:  # noqa: BLE001 - ctypes would swallow it
            self.keep(trouble)
            return False
        return True

    def _on_unraisable(self, others: Callable[[Any], Any], unraisable: Any) -> None:
        """Keep what a signal raises where `_happen` begins, before its ``try``: ctypes would ignore it."""
        if owner_of(unraisable) is self and unraisable.exc_value is not None:
            self.keep(unraisable.exc_value)
        else:
            others(unraisable)

    def cut(self) -> None:
        """End the run of the CPU after the instruction in flight."""
        self._cut()

    def keep_alive(self, one: object) -> None:
        """Let something live as long as this does: its part in C is in the queue, or looks at it."""
        self._in_c.append(one)

    # --- what goes wrong where C has called

    def keep(self, trouble: BaseException) -> None:
        """Keep the first exception that C cannot pass on, and end the run of the CPU for it."""
        if self._trouble is None:
            self._trouble = trouble
        self._cut()
        self.halted = True

    def raise_kept(self) -> None:
        """Raise what was kept, if there is anything, and forget it."""
        if self._trouble is not None:
            trouble, self._trouble = self._trouble, None
            raise trouble

    # --- the machine's side

    def hold(self, cycle: int) -> None:
        """Make `now` stand at `cycle`: the CPU is not executing."""
        self._view[_NOW] = cycle


@functools.cache
def _library() -> Any:
    """Return the library, with the functions of the queue declared, called with Python's lock held."""
    library: Any = with_lock_held()
    pointer, number, cycle = ctypes.c_void_p, ctypes.c_int32, ctypes.c_uint64
    library.hil_queue_new.argtypes, library.hil_queue_new.restype = (_HAPPEN,), pointer
    library.hil_queue_free.argtypes, library.hil_queue_free.restype = (pointer,), None
    library.hil_time_of.argtypes, library.hil_time_of.restype = (pointer,), pointer
    library.hil_queue_enter.argtypes, library.hil_queue_enter.restype = (pointer, cycle, number), number
    library.hil_queue_move.argtypes, library.hil_queue_move.restype = (pointer, number, cycle, number), None
    library.hil_queue_leave.argtypes, library.hil_queue_leave.restype = (pointer, number), None
    library.hil_queue_cut.argtypes, library.hil_queue_cut.restype = (pointer,), None
    library.hil_queue_due.argtypes, library.hil_queue_due.restype = (pointer, cycle), None
    return library
