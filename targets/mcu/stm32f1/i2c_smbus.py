"""What SMBus adds to an I2C interface of the STM32F1: timeouts of SCL, and the pin SMBA (RM0008 section 26.3.6).

SR1.TIMEOUT has three reasons (section 26.6.6): SCL low for 25 ms, whoever holds it; a master that has held it for more
than 10 ms of a byte by itself (t_LOW:MEXT); a slave that has done so for more than 25 ms of a message (t_LOW:SEXT).

Choices: these times are those of bench time, whatever FREQ says. SMBA is driven and heard only while PE and SMBUS are
set; in the alternate function, not open-drain, it is driven high between alerts.
"""

from __future__ import annotations

from collections.abc import Callable

from targets.mcu.services import Services
from targets.mcu.stm32f1.i2c_registers import ALERT, PE, SMBTYPE, SMBUS
from targets.mcu.timebase import Event, Timebase

__all__ = ["LOW_NS", "MASTER_NS", "SLAVE_NS", "AlertPin", "LowLimit"]

LOW_NS = 25_000_000
"""t_TIMEOUT: how long SCL may be low at once."""
MASTER_NS = 10_000_000
"""t_LOW:MEXT: how long a master may hold it low within a byte."""
SLAVE_NS = 25_000_000
"""t_LOW:SEXT: how long a slave may hold it low within a message."""


class LowLimit:
    """How long SCL may be held low, at once or in several pieces.

    Args:
        time: events.
        expired: called when it was too long.
    """

    def __init__(self, time: Timebase, expired: Callable[[], None]) -> None:
        self._time = time
        self._expired = expired
        self._event: Event | None = None
        self._since_ns = 0
        self._used_ns = 0

    def hold(self, limit_ns: int) -> None:
        """SCL is held low from now on, if it was not already."""
        if self._event is None:
            self._since_ns = self._time.ns(self._time.now)
            self._event = self._time.at_ns(self._since_ns + limit_ns - self._used_ns, self._expired)

    def pause(self) -> None:
        """SCL is not held any more; what has gone by counts the next time."""
        if self._event is not None:
            self._used_ns += self._time.ns(self._time.now) - self._since_ns
            self._time.cancel(self._event)
            self._event = None

    def restart(self) -> None:
        """Nothing has gone by; if SCL is held, it is from now on."""
        self._time.cancel(self._event)
        self._event = None
        self._used_ns = 0


class AlertPin:
    """SMBA: driven low by a device that wants to be asked, heard by a host.

    Args:
        name: of the interface: ``I2C1``.
        services: the signal NAME_SMBA, both ways.
        alerted: called when it falls, at a host.
    """

    def __init__(self, name: str, services: Services, alerted: Callable[[], None]) -> None:
        self._output, self._input = services.output(f"{name}_SMBA"), services.input(f"{name}_SMBA")
        self._alerted = alerted
        self._hears = False

    def update(self, control: int) -> None:
        """Do what CR1 says now."""
        used = control & (PE | SMBUS) == PE | SMBUS
        self._output.set(not control & ALERT if used else None)
        hears = bool(used and control & SMBTYPE)
        if hears is not self._hears:
            self._hears = hears
            self._input.on_change = self._changed if hears else None

    def _changed(self, level: bool) -> None:
        if not level:
            self._alerted()
