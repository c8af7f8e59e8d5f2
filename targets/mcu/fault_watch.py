"""Sees that a program will not come out of its faults any more: a handler that waits, or the same fault for ever.

It looks at times that depend on the program alone, so the end of a run is the same however the run is cut and whether
loops are passed over or executed: a millisecond of bench time after a fault (a choice), then after two, four and so on
while the handler has not returned.

A jump to itself cannot be left. Any other loop may wait for something, as handlers do that print: only after a second
in which nothing was written (a choice) it waits for ever. One that sleeps is lost if nothing may still come that is
more urgent than the fault; an NMI is not waited for, nor a button.

A supervisor call that was escalated returns behind itself and is a way to enter a kernel: it may come back as often as
it likes.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from targets.mcu.cortexm.exceptions import Number
from targets.mcu.cortexm.faults import Fault
from targets.mcu.timebase import Event, Timebase

__all__ = ["FaultWatch"]

_FIRST_LOOK_S = Fraction(1, 1000)
_LAST_LOOK_S = Fraction(60)
_SAME_FAULTS = 1000
_PROOF_S = Fraction(1)
_SHORT = 2  # so many instructions cannot load, compare and branch


class FaultWatch:
    """Watches the faults of one core.

    Args:
        time: cycles and events.
        look: called when it is time to look whether the handler of a fault waits for ever.

    Attributes:
        hopeless: the fault that came back so often, at the same instruction, that nothing else will happen; or None.
    """

    def __init__(self, time: Timebase, look: Callable[[], None]) -> None:
        self._time = time
        self._look = look
        self._next: Event | None = None
        self._wait_s = _FIRST_LOOK_S
        self._same = 0
        self._last: tuple[int, int, tuple[str, ...]] | None = None
        self._written: object = None
        self._since_s = Fraction(0)
        self.hopeless: Fault | None = None

    def reset(self) -> None:
        """The chip was reset."""
        self._time.cancel(self._next)
        self._same, self._last, self.hopeless = 0, None, None

    def fault(self, fault: Fault) -> None:
        """Take a fault that has just happened."""
        what = fault.pc, fault.sp, fault.causes
        again = what == self._last and fault.origin != Number.SVCALL
        self._same = self._same + 1 if again else 1
        self._last = what
        if self._same >= _SAME_FAULTS:
            self.hopeless = fault
        self._wait_s = _FIRST_LOOK_S
        self._written = None
        self._book()

    def waits_for_ever(self, instructions: int, written: object) -> bool:
        """Say whether the handler, found in a loop of so many instructions, will stay there; if not, look later.

        Args:
            instructions: in one period of the loop.
            written: what differs from the look before if anything was written in between.
        """
        now_s = self._time.seconds(self._time.now)
        if written != self._written:
            self._written, self._since_s = written, now_s
        if instructions <= _SHORT or now_s - self._since_s >= _PROOF_S:
            return True
        self.look_again()
        return False

    def look_again(self) -> None:
        """The handler runs on, but it does something: look later."""
        self._wait_s *= 2
        if self._wait_s <= _LAST_LOOK_S:
            self._book()

    def _book(self) -> None:
        self._time.cancel(self._next)
        when_s = self._time.seconds(self._time.now) + self._wait_s
        self._next = self._time.at_time(when_s, self._look)
