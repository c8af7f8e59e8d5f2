"""The counter of a low-power timer with its comparators, in steps of its clock; it knows neither time nor registers.

A period has ARR + 1 steps. A match with CMP or ARR shows with the step that follows the equal value, when the counter
moves on: so it was measured on silicon (CMPM rises at CMP + 1), and so a compare value equal to ARR still matches. The
comparator for CMP is "greater or equal", as the vendor's errata say and as drivers work around: a value written below
the counter matches with the next step. The output is high while the counter is above CMP (RM0410 and RM0433, waveform
generation: "exceeds"), so for ARR - CMP of ARR + 1 steps.

Choices where manuals and measurements are silent: CMP matches once in a period, and anew after it was written; ARR is
compared for equality, so that a counter above it runs on to 0xFFFF; counting down (encoder mode) CMP matches where the
counter arrives at it, and ARR where it goes from 0 to ARR.
"""

from __future__ import annotations

__all__ = ["ARRM", "CMPM", "FULL", "LptimCounter"]

CMPM, ARRM = 1 << 0, 1 << 1  # as in LPTIM_ISR
FULL = 0xFFFF


class LptimCounter:
    """The counter.

    Attributes:
        count: its value.
        reload: ARR as the comparator has it.
        compare: CMP as the comparator has it.
        running: steps count.
        single: it stops at the end of the period.
        later: values for `reload` and `compare` that come into force at the end of the period; None for none.
        rose: the output was high since the last `clear`: where it is to stay so, it still is.
    """

    def __init__(self) -> None:
        self.reload, self.compare = 1, 0
        self.clear()

    def clear(self) -> None:
        """Stop at 0; the comparators keep their values."""
        self.count = 0
        self.running = self.single = self.rose = False
        self.later: tuple[int | None, int | None] = (None, None)
        self._matched = False

    def restart(self) -> None:
        """Go on from 0, in a new period."""
        self.count = 0
        self._matched = False

    def set_compare(self, value: int) -> None:
        """Compare with another value from now on."""
        self.compare = value
        self._matched = False
        self._look()

    @property
    def high(self) -> bool:
        """The output, without polarity."""
        return self.count > self.compare

    def advance(self, steps: int) -> int:
        """Make steps, as long as it runs; return the flags that rise."""
        flags = 0
        while steps and self.running:
            top = self._top()
            taken = min(steps, top - self.count)
            if taken:
                flags |= self._match(self.count + taken - 1)
                self.count += taken
                self._look()
                steps -= taken
            if steps:
                flags |= self._wrap(top)
                steps -= 1
                if not self.single and steps > self.reload:  # whole periods, all alike
                    flags |= ARRM | (CMPM if self.compare <= self.reload else 0)
                    self.rose = self.rose or self.compare < self.reload
                    steps %= self.reload + 1
        return flags

    def step(self, *, up: bool) -> int:
        """Make a step of encoder mode in either direction; return the flags that rise."""
        if up:
            return self.advance(1)
        if self.count == 0:
            self.count = self.reload
            flags = ARRM
        else:
            self.count -= 1
            flags = 0
        self._matched = self.count > self.compare
        self._look()
        return flags | (CMPM if self.count == self.compare else 0)

    def steps_to_event(self, flags: int, *, output: bool) -> int | None:
        """Return after how many steps something can happen that matters; None for never.

        Args:
            flags: those that would rise.
            output: its edges matter.
        """
        if not self.running or not (flags or output or self.single or self.later != (None, None)):
            return None
        top = self._top()
        found = top - self.count + 1
        if flags & CMPM and not self._matched and self.compare <= top:
            found = min(found, max(self.compare - self.count, 0) + 1)
        if output and self.count <= self.compare < top:
            found = min(found, self.compare + 1 - self.count)
        return found

    def _top(self) -> int:
        return self.reload if self.count <= self.reload else FULL

    def _match(self, last: int) -> int:
        """Return CMPM if one of the values up to `last`, which the counter leaves, matches."""
        if self._matched or last < self.compare:
            return 0
        self._matched = True
        return CMPM

    def _wrap(self, top: int) -> int:
        flags = self._match(top) | (ARRM if top == self.reload else 0)
        self.restart()
        reload, compare = self.later
        self.later = (None, None)
        self.reload = self.reload if reload is None else reload
        self.compare = self.compare if compare is None else compare
        self.running = not self.single
        return flags

    def _look(self) -> None:
        self.rose = self.rose or self.high
