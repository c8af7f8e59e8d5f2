"""The SMBus timeout of an I2C interface: SCL low for too long (RM0410 section 33.4.12, "timeout detection")."""

from __future__ import annotations

import math
from collections.abc import Callable

from targets.mcu.stm32.i2c_timing import Timing
from targets.mcu.timebase import Event, Timebase

__all__ = ["LowTimeout"]

_TIDLE, _TIMOUTEN = 1 << 12, 1 << 15
_UNIT_CLOCKS = 2048


class LowTimeout:
    """Watches how long SCL is held low between two bytes.

    Choice: a change of the settings or of the kernel clock counts for the next time that SCL is held.

    Args:
        time: cycles and events.
        expired: called when it was too long.
    """

    def __init__(self, time: Timebase, expired: Callable[[], None]) -> None:
        self._time = time
        self._expired = expired
        self._event: Event | None = None

    def low(self, timeoutr: int, timing: Timing | None) -> None:
        """SCL is held low from now on, if it was not already."""
        pending = self._event is not None and self._event.pending
        if pending or timing is None or timeoutr & (_TIMOUTEN | _TIDLE) != _TIMOUTEN:
            return
        cycles = ((timeoutr & 0xFFF) + 1) * _UNIT_CLOCKS * timing.cycles
        self._event = self._time.after(math.ceil(cycles), self._expired)

    def high(self) -> None:
        """SCL is let go."""
        self._time.cancel(self._event)
        self._event = None
