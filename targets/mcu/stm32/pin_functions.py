"""Which signals each pin carries, by alternate function, on chips whose every pin has a multiplexer of its own.

The F1 moves whole groups of signals (AFIO); from the F2 on each pin chooses one of sixteen functions (RM0410 section
6.3.2), and a signal that no pin has chosen is connected to nothing. Several pins may carry the same output. Choices
where the manual is silent: an input that no pin carries reads low, but the lines of a serial port high, as they idle;
one that several pins carry hears the pin that chose it last. Programs that put a pin in its mode before they choose its
function have it in AF0 in between: a function that the pin lacks is noted when it has stood for a millisecond.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from fractions import Fraction

from targets.mcu.fidelity import Notes
from targets.mcu.signals import Signals
from targets.mcu.timebase import Event, Timebase

__all__ = ["PinFunctions"]

_EVENTOUT = "EVENTOUT"
_IDLES_HIGH = re.compile(r"(LP)?US?ART\d_(TX|RX)")
_PATIENCE_S = Fraction(1, 1000)
_INPUT = re.compile(r"(LP)?US?ART\d_(RX|CTS)|TIM([18]|1[567])_BKIN2?|TIM[13458]_ETR")


class PinFunctions:
    """The multiplexers of all ports.

    Args:
        table: for each pin the signals of each alternate function that it has.
        signals: the signals of the chip.
        time: the chip's cycles and events.
        notes: where it is noted that a pin lacks a function.
    """

    def __init__(
        self, table: Mapping[str, Mapping[int, tuple[str, ...]]], signals: Signals, time: Timebase, notes: Notes
    ) -> None:
        self._table = table
        self._signals = signals
        self._time = time
        self._notes = notes
        self._chosen: dict[str, int] = {}
        self._doubts: dict[str, Event] = {}
        self._carriers: dict[str, list[str]] = {}
        names = {name for functions in table.values() for of_one in functions.values() for name in of_one}
        signals.only_at_pins({name: bool(_IDLES_HIGH.fullmatch(name)) for name in sorted(names)})

    def choose(self, pin: str, function: int | None) -> None:
        """Let `pin` carry the signals of an alternate function; None for none."""
        old = self._chosen.get(pin)
        if old == function:
            return
        if old is not None:
            del self._chosen[pin]
            self._time.cancel(self._doubts.pop(pin, None))
            for name in self._table[pin].get(old, ()):
                self._leave(name, pin)
        if function is not None:
            self._chosen[pin] = function
            self._check(pin, function)
            for name in self._table[pin].get(function, ()):
                self._enter(name, pin)

    def pin_of(self, signal: str) -> str | None:
        """Return the pin that carries a signal."""
        carriers = self._carriers.get(signal)
        return carriers[-1] if carriers else None

    def _check(self, pin: str, function: int) -> None:
        names = self._table[pin].get(function)
        if names is None:
            self._doubt(pin, function)
        elif _EVENTOUT in names:
            self._notes.add("unmodelled", f"{pin}_AF{function}", "EVENTOUT is not put out: SEV makes no pulse")

    def _doubt(self, pin: str, function: int) -> None:
        pc = self._notes.pc()

        def note() -> None:
            self._notes.add("misuse", f"{pin}_AF{function}", f"{pin} has no alternate function {function}", pc=pc)

        self._doubts[pin] = self._time.at_time(self._time.seconds(self._time.now) + _PATIENCE_S, note)

    def _enter(self, name: str, pin: str) -> None:
        carriers = self._carriers.setdefault(name, [])
        if carriers and _INPUT.fullmatch(name):
            text = f"{name} is chosen at {carriers[-1]} too: what it hears then is not in the manual; here it is {pin}"
            self._notes.add("assumed", f"{pin}_{name}", text)
        carriers.append(pin)
        self._signals.route_all(name, carriers)

    def _leave(self, name: str, pin: str) -> None:
        carriers = self._carriers[name]
        carriers.remove(pin)
        self._signals.route_all(name, carriers)
