"""INT_STATUS and the interrupt pin (RM-MPU-9250A-00 sections 4.23 to 4.25).

Choices where the manual is silent: a status bit is set whether or not its interrupt is enabled; a pulse that falls
into another one prolongs it; a change of INT_PIN_CFG or INT_ENABLE acts on the pin at once.
"""

from __future__ import annotations

from targets.parts.part import DigitalOutput

__all__ = ["FIFO_OVERFLOW", "RAW_DATA_READY", "WAKE_ON_MOTION", "Interrupts"]

RAW_DATA_READY, FIFO_OVERFLOW, WAKE_ON_MOTION = 0x01, 0x10, 0x40

_PULSE_NS = 50_000
_ACTIVE_LOW, _OPEN_DRAIN, _LATCH, _ANY_READ_CLEARS = 0x80, 0x40, 0x20, 0x10


class Interrupts:
    """See the module.

    Args:
        output: the pin.
    """

    def __init__(self, output: DigitalOutput) -> None:
        self._output = output
        self._pin: bool | None = None
        self._status = 0
        self._enabled = 0
        self._config = 0
        self._pulse_end_ns: int | None = None

    @property
    def enabled(self) -> int:
        """INT_ENABLE."""
        return self._enabled

    @property
    def pulse_end_ns(self) -> int | None:
        """When the pin goes back by itself; None if it does not."""
        return self._pulse_end_ns

    @property
    def waits_for_reader(self) -> bool:
        """The pin is latched: nothing that happens moves it before somebody reads."""
        return bool(self._config & _LATCH and self._status & self._enabled)

    def reset(self, now_ns: int) -> None:
        """As after power-on."""
        self._status = 0
        self._pulse_end_ns = None
        self.configure(0, 0, now_ns)

    def configure(self, config: int, enabled: int, now_ns: int) -> None:
        """Take INT_PIN_CFG and INT_ENABLE."""
        self._config, self._enabled = config, enabled
        if config & _LATCH:
            self._pulse_end_ns = None
        self._show(now_ns)

    def happen(self, bits: int, at_ns: int) -> None:
        """Something has happened, as it stands in INT_STATUS."""
        self._status |= bits
        if bits & self._enabled and not self._config & _LATCH:
            self._pulse_end_ns = at_ns + _PULSE_NS
        self._show(at_ns)

    def end_pulse(self, at_ns: int) -> None:
        """The pulse is over."""
        self._pulse_end_ns = None
        self._show(at_ns)

    def read_status(self, now_ns: int) -> int:
        """INT_STATUS is read, and cleared by that."""
        status = self._status
        self._clear(now_ns)
        return status

    def any_read(self, now_ns: int) -> None:
        """Another register is read."""
        if self._config & _ANY_READ_CLEARS:
            self._clear(now_ns)

    def _clear(self, now_ns: int) -> None:
        self._status = 0
        if self._config & _LATCH:
            self._show(now_ns)

    def _show(self, at_ns: int) -> None:
        active = self.waits_for_reader or self._pulse_end_ns is not None
        level: bool | None = active is not bool(self._config & _ACTIVE_LOW)
        if level and self._config & _OPEN_DRAIN:
            level = None
        if level is not self._pin:
            self._pin = level
            self._output.set(level, at_ns)
