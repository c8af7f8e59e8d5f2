"""The clock that a USART puts out in synchronous mode, and what it samples by it (RM0008 section 27.3.9).

CK has a pulse for each bit of data, none for start and stop bit, preamble and break, and for the last bit only with
LBCL; CPOL is its idle level. With CPHA clear the first edge is in the middle of a bit, else the second. That edge
samples RX, once. A word comes in while one goes out, and never without.

Choices: what was sampled is there with the last sample; the last bit without a pulse is sampled where the pulse would
be. CK stops with TE, also within a word.
"""

from __future__ import annotations

from collections.abc import Callable

from targets.mcu.services import InputSignal, OutputSignal, Watch
from targets.mcu.stm32.usart_line import UsartLine
from targets.mcu.timebase import Event, Timebase

__all__ = ["CLKEN", "CPHA", "CPOL", "LBCL", "ClockPin"]

LBCL, CPHA, CPOL, CLKEN = (1 << bit for bit in range(8, 12))  # of CR2
_HALF = 8  # sixteenths of a bit


class ClockPin:
    """See the module.

    Args:
        time: the chip's cycles and events.
        output: CK.
        heard: RX.
        line: what sends.
        take: called with a word that has come in.
    """

    def __init__(
        self,
        time: Timebase,
        output: OutputSignal,
        heard: InputSignal,
        line: UsartLine,
        take: Callable[[int], None],
    ) -> None:
        self._time = time
        self._output = output
        self._heard = heard
        self._line = line
        self._take = take
        self._control = 0  # CR2 as obeyed
        self._edges: list[tuple[int, int, bool]] = []  # cycle, sixteenths of a bit of its frame, level
        self._samples: list[int] = []
        self._word = self._bits = 0
        self._events: dict[str, Event] = {}
        output.on_watch = self.follow

    def set(self, control: int) -> None:
        """Obey CR2, or a value without CLKEN while the transmitter is off."""
        self._control = control
        if not control & CLKEN:
            self.refresh()
            self._edges, self._samples = [], []
            self.follow()
        self._output.refresh = self.refresh if control & CLKEN else None
        if not self._edges:
            self._output.set(bool(control & CPOL) if control & CLKEN else None)

    def begin(self, bits: int, *, receives: bool) -> None:
        """A word of so many bits begins to be sent, and perhaps one to be received."""
        if not self._control & CLKEN:
            return
        self.refresh()
        shift = 0 if self._control & CPHA else _HALF
        rises = not self._control & CPOL
        last = bits if self._control & LBCL else bits - 1
        self._edges = [
            (0, 16 * bit + shift + half, level)
            for bit in range(1, last + 1)
            for half, level in ((0, rises), (_HALF, not rises))
        ]
        self._samples = [16 * bit + _HALF for bit in range(1, bits + 1)] if receives else []
        self._word, self._bits = 0, bits
        self.rate_changed()

    def refresh(self) -> None:
        """Bring level and record of the pin up to the present cycle."""
        while self._edges and self._edges[0][0] <= self._time.now:
            cycle, _, level = self._edges.pop(0)
            self._output.set_at(cycle, level)

    def rate_changed(self) -> None:
        """Go on where bits have another length; level and record of the pin must be up to date."""
        sent_at = self._line.sent_at
        self._edges = [(sent_at(sixteenths), sixteenths, level) for _, sixteenths, level in self._edges]
        self.follow()

    def follow(self) -> None:
        """Wait for the next sample, and for the next edge if somebody may react to it."""
        self._wait("sample", self._line.sent_at(self._samples[0]) if self._samples else None, self._sample)
        live = self._output.watch() is Watch.LIVE
        if live:
            self.refresh()
        self._wait("edge", self._edges[0][0] if live and self._edges else None, self.follow)

    def _wait(self, name: str, cycle: int | None, action: Callable[[], None]) -> None:
        self._time.cancel(self._events.pop(name, None))
        if cycle is not None:
            self._events[name] = self._time.at(cycle, action)

    def _sample(self) -> None:
        self._word |= self._heard.level() << self._bits - len(self._samples)
        del self._samples[0]
        if not self._samples:
            self._take(self._word)
        self.follow()
