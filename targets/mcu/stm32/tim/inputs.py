"""The inputs of a timer: filters, the XOR of three channels, the external trigger with its divider.

RM0008 sections 14.3.5 (input stage), 14.3.16 (TI1S) and 15.3.14 (ETR). An edge takes effect at its own cycle; the two
or three timer clocks of resynchronisation are left out (choice), which shifts every edge by the same time. A filter
samples at ticks that are multiples of its sampling period (choice), and passes a level that N samples in a row saw. As
a flip-flop does, a sample takes the level from before its cycle: an edge at that cycle is for the next one.
With TI1S an edge of channel 2 reaches TI1 before it reaches TI2 (choice).
"""

from __future__ import annotations

from collections.abc import Callable

from targets.mcu.services import InputSignal
from targets.mcu.timebase import Event, Timebase

__all__ = ["ChannelInputs", "ExternalTrigger", "Filter", "TickClock"]

_SAMPLES = (1, 2, 4, 8, 6, 8, 6, 8, 6, 8, 5, 6, 8, 5, 6, 8)
_DTS_PERIODS = (1, 0, 0, 0, 2, 2, 4, 4, 8, 8, 16, 16, 16, 32, 32, 32)
"""By ICxF or ETF: samples in a row, and sampling periods in tDTS; 0 means at the timer's clock itself."""
_BEFORE_EDGES = -1  # order of events: whatever makes an edge at the cycle of a sample comes after the sample


class TickClock:
    """Ticks of a timer's clock in HCLK cycles.

    Attributes:
        cycles: HCLK cycles per tick; 0 while the clock stands.
    """

    __slots__ = ("_cycle", "_tick", "_time", "cycles")

    def __init__(self, time: Timebase) -> None:
        self._time = time
        self._cycle = 0
        self._tick = 0
        self.cycles = 1

    @property
    def now(self) -> int:
        """The present tick."""
        if not self.cycles:
            return self._tick
        return self._tick + (self._time.now - self._cycle) // self.cycles

    def cycle_of(self, tick: int) -> int:
        """Return the cycle of a tick; not while the clock stands."""
        return self._cycle + (tick - self._tick) * self.cycles

    def change(self, cycles: int) -> None:
        """Change the rate; the first tick of the new rate begins at the present cycle (choice)."""
        if cycles != self.cycles:
            self._tick = self.now
            self._cycle = self._time.now
            self.cycles = cycles


class Filter:
    """A digital filter, and the level behind it.

    Args:
        time: the cycles of the chip.
        clock: the ticks of the timer.
        on_change: called with each new level behind the filter, at its cycle.

    Attributes:
        level: behind the filter.
    """

    __slots__ = ("_broken", "_clock", "_event", "_on_change", "_period", "_raw", "_run", "_samples", "_time", "level")

    def __init__(self, time: Timebase, clock: TickClock, on_change: Callable[[bool], None]) -> None:
        self._time = time
        self._clock = clock
        self._on_change = on_change
        self._period = 1
        self._samples = 1
        self._event: Event | None = None
        self.start(False)

    def start(self, level: bool) -> None:
        """Begin with `level` on both sides."""
        self._time.cancel(self._event)
        self.level = self._raw = level
        self._run: int | None = None
        self._broken: tuple[int, int] | None = None

    def configure(self, code: int, dts_ticks: int) -> None:
        """Set ICxF or ETF, and tDTS in ticks."""
        period, samples = (_DTS_PERIODS[code] * dts_ticks or 1), _SAMPLES[code]
        if code == 0:
            period = 1
        if (period, samples) != (self._period, self._samples):
            self._period, self._samples = period, samples
            self._time.cancel(self._event)
            self._run = self._broken = None
            if self._raw is not self.level:
                self._begin(self._next_sample())

    def feed(self, level: bool) -> None:
        """The level before the filter is `level` from the present cycle on."""
        if level is self._raw:
            return
        self._raw = level
        if self._samples == 1:
            if self._clock.cycles:
                self._pass()
        elif level is self.level:
            self._break()
        else:
            sample = self._next_sample()
            broken = self._broken
            # a change back that no sample has seen does not end the run
            self._begin(broken[0] if broken is not None and broken[1] == sample else sample)

    def replan(self) -> None:
        """The rate of the ticks has changed: time the samples anew; what changed while they stood is seen now."""
        if self._run is not None:
            self._begin(self._run)
        elif self._samples == 1 and self._clock.cycles:
            self._pass()

    def _next_sample(self) -> int:
        return (self._clock.now // self._period + 1) * self._period

    def _begin(self, first: int) -> None:
        self._time.cancel(self._event)
        self._run, self._broken = first, None
        if self._clock.cycles:
            last = first + (self._samples - 1) * self._period
            self._event = self._time.at(self._clock.cycle_of(last), self._pass, order=_BEFORE_EDGES)

    def _break(self) -> None:
        self._time.cancel(self._event)
        if self._run is not None:
            self._broken = (self._run, self._next_sample())
            self._run = None

    def _pass(self) -> None:
        self._run = self._broken = None
        if self._raw is not self.level:
            self.level = self._raw
            self._on_change(self.level)


class ChannelInputs:
    """TI1 to TI4 behind their filters.

    Args:
        time: the cycles of the chip.
        clock: the ticks of the timer.
        signals: the four channel inputs.
        on_change: called with the number (0 to 3) and the new level of a filtered input.
    """

    def __init__(
        self, time: Timebase, clock: TickClock, signals: list[InputSignal], on_change: Callable[[int, bool], None]
    ) -> None:
        self._signals = signals
        self._filters = [
            Filter(time, clock, lambda level, number=number: on_change(number, level))  # type: ignore[misc]
            for number in range(4)
        ]
        self._used = [False] * 4
        self._xor = False
        self._listeners = [self._listener(number) for number in range(4)]

    def level(self, number: int) -> bool:
        """Return the level of a filtered input."""
        return self._filters[number].level

    def configure(self, used: list[bool], xor: bool, codes: list[int], dts_ticks: int) -> None:
        """Listen to the inputs in use; TI1 is the XOR of channels 1 to 3 if `xor`."""
        sources = [used[number] or (xor and used[0] and number < 3) for number in range(4)]
        fresh = [
            used[number] and (not self._used[number] or (number == 0 and xor is not self._xor)) for number in range(4)
        ]
        self._used, self._xor = used, xor
        for number, signal in enumerate(self._signals):
            listener = self._listeners[number] if sources[number] else None
            if signal.on_change is not listener:
                signal.on_change = listener
        for number, filtered in enumerate(self._filters):
            filtered.configure(codes[number], dts_ticks)
            if fresh[number]:
                filtered.start(self._raw(number))

    def replan(self) -> None:
        """The rate of the ticks has changed."""
        for filtered in self._filters:
            filtered.replan()

    def _raw(self, number: int) -> bool:
        if number == 0 and self._xor:
            return self._signals[0].level() ^ self._signals[1].level() ^ self._signals[2].level()
        return self._signals[number].level()

    def _listener(self, number: int) -> Callable[[bool], None]:
        def changed(level: bool) -> None:
            if self._xor and number < 3 and self._used[0]:
                self._filters[0].feed(self._raw(0))
            if self._used[number] and not (number == 0 and self._xor):
                self._filters[number].feed(level)

        return changed


class ExternalTrigger:
    """ETR with its polarity, divider and filter: ETRF.

    Args:
        time: the cycles of the chip.
        clock: the ticks of the timer.
        signal: the input ETR.
        on_change: called with each new level of ETRF.
    """

    def __init__(
        self, time: Timebase, clock: TickClock, signal: InputSignal, on_change: Callable[[bool], None]
    ) -> None:
        self._signal = signal
        self._filter = Filter(time, clock, on_change)
        self._used = False
        self._inverted = False
        self._divider = 1
        self._count = 0

    def level(self) -> bool:
        """Return the level of ETRF."""
        return self._filter.level

    def configure(self, *, used: bool, inverted: bool, divider: int, code: int, dts_ticks: int) -> None:
        """Set ETP, the divider 1, 2, 4 or 8 of ETPS, and ETF."""
        fresh = (used, inverted, divider) != (self._used, self._inverted, self._divider)
        self._used, self._inverted, self._divider = used, inverted, divider
        listener = self._changed if used else None
        if self._signal.on_change != listener:
            self._signal.on_change = listener
        self._filter.configure(code, dts_ticks)
        if fresh:
            self._count = 0
            self._filter.start(used and divider == 1 and self._signal.level() is not inverted)

    def replan(self) -> None:
        """The rate of the ticks has changed."""
        self._filter.replan()

    def _changed(self, level: bool) -> None:
        active = level is not self._inverted
        if self._divider == 1:
            self._filter.feed(active)
        elif active:
            # the divided signal rises with each Nth edge and falls with the one after it (choice)
            self._count = (self._count + 1) % self._divider
            self._filter.feed(self._count == 0)
