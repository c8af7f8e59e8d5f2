"""Frames on the RX line of a USART that are known before they begin: C hears them one by one, and asks nobody.

A frame that C cannot hear by itself comes here when it begins, as if it had been put on the line then.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable
from fractions import Fraction

from targets.mcu.serial_line import SerialFrame, Words
from targets.mcu.stm32.usart_line import News, UsartLine
from targets.mcu.timebase import NS_PER_S, Timebase

__all__ = ["Expected"]

_LOOK = 1 << 63  # LOOK_AT_WORD


class Expected:
    """See the module.

    Args:
        time: the chip's cycles and events.
        line: hears the frames.
        receive: called with a frame that begins now; returns whether C hears it by itself.
    """

    def __init__(self, time: Timebase, line: UsartLine, receive: Callable[[SerialFrame], bool]) -> None:
        self._time = time
        self._line = line
        self._receive = receive
        # of the frame heard last, and of those that follow
        self._starts_ns: list[int] = []
        self._bits: list[int] = []
        self._forms: list[tuple[Fraction, int]] = []
        self._waiting = 0  # while the clock changes
        self._arriving = 0  # 1 while a frame is looked at: it is not heard yet
        line.handlers[News.ARRIVED] = lambda following, _more: self._arrived(following)

    @property
    def count(self) -> int:
        """How many have not begun yet."""
        return self._line.line.coming or self._waiting

    def add(self, words: Words) -> None:
        """Expect frames behind the others; what has begun in the past begins now.

        Raises:
            MemoryError: there is no memory left.
        """
        begun = len(self._bits) - self.count - 1
        if begun > 0:
            del self._starts_ns[:begun], self._bits[:begun], self._forms[:begun]
        self._starts_ns += words.starts_ns
        self._bits += words.bits
        self._forms += [(words.bit_s, words.bit_count)] * len(words.bits)
        self._tell(len(words.bits))

    def keep(self, count: int) -> None:
        """Expect no more than the next so many."""
        if (superfluous := self.count - count) > 0:
            self._line.expect_only(count)
            del self._starts_ns[-superfluous:], self._bits[-superfluous:], self._forms[-superfluous:]

    def heard(self) -> SerialFrame:
        """Return the last of them that C has begun to hear."""
        return self._frame(self.count + self._arriving)

    def before_clock_change(self) -> None:
        """Hold them back: they follow bench time, and cycles are about to change."""
        self._waiting = self._line.line.coming
        self._line.expect_only(0)

    def after_clock_change(self) -> None:
        """Go on."""
        waiting, self._waiting = self._waiting, 0
        if waiting:
            self._tell(waiting)

    def _tell(self, count: int) -> None:
        """Hand the last so many over to C."""
        if not count:
            return
        cycle_at_ns = self._time.cycle_at_ns
        first = len(self._bits) - count
        # What has begun in the past may lie before the first cycle, as long as cycles are now.
        cycles = array("Q", [max(cycle_at_ns(ns), 0) for ns in self._starts_ns[first:]])
        words = array("Q", self._bits[first:])
        forms = self._forms
        for index in range(first, len(forms)):
            if not index or (forms[index] is not forms[index - 1] and forms[index] != forms[index - 1]):
                words[index - first] |= _LOOK
        self._line.expect(cycles, words)

    def _arrived(self, following: int) -> None:
        self._line.line.plain = False
        self._arriving = 1
        try:
            self._line.line.plain = self._receive(self._frame(following))
        finally:
            self._arriving = 0

    def _frame(self, following: int) -> SerialFrame:
        """Return the frame that so many others follow."""
        index = len(self._bits) - 1 - following
        bit_s, bit_count = self._forms[index]
        start_s = Fraction(self._starts_ns[index], NS_PER_S)
        return SerialFrame(start_s=start_s, bit_s=bit_s, bits=self._bits[index], bit_count=bit_count)
