"""The SysTick timer (DDI0403 section B3.3, PM0056 section 4.5), exact to the cycle.

The counter steps once per clock: from zero to the reload value, from anything else down by one. Arriving at zero from
one sets COUNTFLAG and, with TICKINT, makes the exception pending. So a reload value of N gives a period of N + 1, a
reload value of zero stops at zero, and enabling does not itself reload: it goes on from the value there is.

The clock is HCLK, or HCLK/8 from a divider that runs on its own (choice: it steps at multiples of eight cycles since
the chip was made, whenever the timer starts; in QEMU a period of the reference begins with each start, which a clock
that others share cannot do). Both divide HCLK, so a change of the clock needs no care here. The value is computed when
it is read; COUNTFLAG and the exception are events.

In silicon no two stores come to it in one cycle; with less than a cycle for an instruction they do here. A LOAD written
in the cycle in which VAL was cleared, or in which the timer started at zero, then comes after the reload from the LOAD
before it, as the program has it.
"""

from __future__ import annotations

from collections.abc import Iterable

from targets.mcu.cortexm.exceptions import Exceptions, Number
from targets.mcu.cortexm.kinds import CORTEX_M3
from targets.mcu.cortexm.ppb import LaneBlock
from targets.mcu.registers import Count, Register
from targets.mcu.services import Services
from targets.mcu.timebase import Event

__all__ = ["SysTick"]

_CTRL, _LOAD, _VAL, _CALIB = 0x10, 0x14, 0x18, 0x1C
_ENABLE, _TICKINT, _CLKSOURCE, _COUNTFLAG = 1 << 0, 1 << 1, 1 << 2, 1 << 16
_WIDTH = 0x00FF_FFFF
_REFERENCE_DIVIDER = 8


class SysTick(LaneBlock):
    """The 24-bit timer of the core.

    Args:
        exceptions: where its exception becomes pending.
        calibration: what CALIB reads.
    """

    _REGISTERS = (
        Register("CTRL", _CTRL, 0, _ENABLE | _TICKINT | _CLKSOURCE),
        Register("LOAD", _LOAD, 0, _WIDTH),
        Register("VAL", _VAL, 0, 0, live=True),
    )

    def __init__(
        self, base: int, services: Services, exceptions: Exceptions, calibration: int = CORTEX_M3.systick_calibration
    ) -> None:
        self._calibration = calibration
        super().__init__("STK", base, services)
        self._exceptions = exceptions
        self._event: Event | None = None
        self._start = 0  # the counter was `_value` from cycle `_start` on
        self._value = 0
        self._cleared: int | None = (
            None  # the cycle at which a reload became due, by VAL or a start, unless it is taken
        )
        self._flag = 0
        self._held = False

    def registers_of(self) -> Iterable[Register]:
        """Return the registers."""
        return (*self._REGISTERS, Register("CALIB", _CALIB, self._calibration, 0))

    def reset(self) -> None:
        """Stop, with all registers zero; that LOAD and VAL are, which silicon leaves unknown, is a choice; QEMU too."""
        super().reset()
        self.time.cancel(self._event)
        self._event = None
        self._value = self._flag = 0
        self._held = False

    def hold(self, held: bool) -> None:
        """Let the clock stand still, as in Stop mode, or run again; the counter keeps its value."""
        self._settle()
        self._held = held
        self._plan()

    # --- registers

    def read_CTRL(self) -> int:
        """Return control and COUNTFLAG, which the read clears."""
        self._catch_up()
        value = self[_CTRL] | self._flag
        if self._flag:
            self._flag = 0
            self._plan()
        return value

    def write_CTRL(self, value: int) -> None:
        """Start, stop, choose the clock; the counter keeps its value."""
        self._settle()
        stood = not self._counts()
        self[_CTRL] = value
        if stood and self._counts() and not self._value:
            self._cleared = self.time.now
        self._plan()

    def write_LOAD(self, value: int) -> None:
        """Set the value to reload; it takes effect when the counter is next reloaded."""
        self._settle()
        now = self.time.now
        if self._cleared == now and self._counts() and self[_CTRL] & _CLKSOURCE:
            self._value, self._start = self[_LOAD], now + 1
        self._cleared = None
        self[_LOAD] = value
        self._plan()

    def read_VAL(self) -> int:
        """Return the counter."""
        return self._value_at(self.time.now)

    def write_VAL(self, _value: int) -> None:
        """Clear the counter and COUNTFLAG, whatever is written; no exception follows from it."""
        self._settle()
        self._value = self._flag = 0
        self._start = self._cleared = self.time.now
        self._plan()

    def is_live(self, offset: int) -> bool:
        """VAL changes while the timer counts."""
        return offset == _VAL and self._counts()

    def count(self, offset: int) -> Count | None:
        """Return how VAL counts down to zero."""
        if offset != _VAL or not self._counts() or self._start > self.time.now:
            return None
        ahead, value, first = self._steps(self.time.now) - self._value, self._value, 0
        if ahead > 0:  # it was reloaded since
            value = self[_LOAD]
            first = self._value + 1 + (ahead - 1) // (value + 1) * (value + 1)
        divider = 1 if self[_CTRL] & _CLKSOURCE else _REFERENCE_DIVIDER
        return Count(value, self._cycle_of(first), divider, until=self._cycle_of(first + value + 1), down=True)

    def interrupts(self) -> bool:
        """Say whether it makes its exception pending from time to time."""
        return bool(self[_CTRL] & _ENABLE and self[_CTRL] & _TICKINT and self[_LOAD]) and not self._held

    # --- counting

    def _counts(self) -> bool:
        return bool(self[_CTRL] & _ENABLE) and not self._held

    def _steps(self, cycle: int) -> int:
        """Return how often the counter has stepped from `_start` to `cycle`, which may be the one before it."""
        if self[_CTRL] & _CLKSOURCE:
            return max(cycle - self._start, 0)
        return max(cycle // _REFERENCE_DIVIDER - self._start // _REFERENCE_DIVIDER, 0)

    def _cycle_of(self, steps: int) -> int:
        """Return the cycle at which the counter has stepped `steps` times from `_start`; for 0 one not after that."""
        if self[_CTRL] & _CLKSOURCE:
            return self._start + steps
        return (self._start // _REFERENCE_DIVIDER + steps) * _REFERENCE_DIVIDER

    def _value_at(self, cycle: int) -> int:
        if not self._counts():
            return self._value
        steps = self._steps(cycle)
        if steps <= self._value:
            return self._value - steps
        reload_value = self[_LOAD]
        return reload_value - (steps - self._value - 1) % (reload_value + 1)

    def _settle(self) -> None:
        """Make the present value the one to count on from, after what was due."""
        self._catch_up()
        now = self.time.now
        if self._start < now:
            self._value, self._start = self._value_at(now), now

    def _catch_up(self) -> None:
        """Let a zero that is due happen before an access, which may come late within an IT block."""
        event = self._event
        if event is not None and event.cycle <= self.time.now:
            self.time.cancel(event)
            self._zero()

    def _plan(self) -> None:
        """Enter the next arrival at zero, if anybody could notice it."""
        self.time.cancel(self._event)
        self._event = None
        if self._held or not self[_CTRL] & _ENABLE or (self._flag and not self[_CTRL] & _TICKINT):
            return
        steps = self._zero_after(self._steps(self.time.now))
        if steps is not None:
            self._event = self.time.at(self._cycle_of(steps), self._zero)

    def _zero_after(self, steps: int) -> int | None:
        """Return the first number of steps after `steps` at which the counter arrives at zero."""
        if self._value > steps:
            return self._value
        period = self[_LOAD] + 1
        if period == 1:
            return None
        return self._value + ((steps - self._value) // period + 1) * period

    def _zero(self) -> None:
        """The counter has gone from one to zero, at the cycle of the event."""
        assert self._event is not None
        self._value, self._start = 0, self._event.cycle
        self._flag = _COUNTFLAG
        if self[_CTRL] & _TICKINT:
            self._exceptions.pend(Number.SYSTICK)
        self._plan()
