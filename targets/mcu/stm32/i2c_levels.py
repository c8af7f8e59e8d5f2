"""The levels of SCL and SDA as a logic analyser would see them, drawn after the event from what a master has done.

Nothing in the model needs them; they are drawn only while somebody wants them. A byte is drawn when it is over, for
only then it is known whether it was acknowledged. Choices: SDA changes a clock of the kernel after SCL fell; a byte
within which the clock changed is drawn at the new rate throughout.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from targets.mcu.stm32.i2c_timing import Timing

__all__ = ["I2cLevels"]

Moment = Fraction | int


class I2cLevels:
    """Draws one bus. Moments are in HCLK cycles; both lines are high at first.

    Args:
        on_edge: called with line (``scl`` or ``sda``), moment and level, in order of time.
    """

    def __init__(self, on_edge: Callable[[str, Moment, bool], None]) -> None:
        self._on_edge = on_edge
        self._level = {"scl": True, "sda": True}
        self._stuck = False

    def _set(self, line: str, at: Moment, level: bool) -> None:
        level = level and not (self._stuck and line == "sda")
        if level is not self._level[line]:
            self._level[line] = level
            self._on_edge(line, at, level)

    def start(self, at: Moment) -> None:
        """SDA falls."""
        self._set("sda", at, False)

    def clock_low(self, at: Moment) -> None:
        """SCL falls, after a START."""
        self._set("scl", at, False)

    def restart(self, begun: Moment, timing: Timing) -> None:
        """Both lines rise, for a repeated START."""
        self._set("sda", begun + timing.cycles, True)
        self._set("scl", begun + timing.low * timing.cycles, True)

    def bits(self, begun: Moment, timing: Timing, word: int, count: int) -> None:
        """So many bits, the highest first, each with a clock."""
        for index in range(count):
            at = begun + index * timing.bit * timing.cycles
            self._set("sda", at + timing.cycles, bool(word >> count - 1 - index & 1))
            self._set("scl", at + timing.low * timing.cycles, True)
            self._set("scl", at + timing.bit * timing.cycles, False)

    def stop(self, begun: Moment, timing: Timing) -> None:
        """SDA rises while SCL is high."""
        self._set("sda", begun + timing.cycles, False)
        self._set("scl", begun + timing.low * timing.cycles, True)
        self._set("sda", begun + timing.bit * timing.cycles, True)

    def release(self, at: Moment) -> None:
        """The master lets go of both lines."""
        self._set("scl", at, True)
        self._set("sda", at, True)

    def stick(self, at: Moment, stuck: bool) -> None:
        """Something begins or ends to hold SDA low; while the clock is low it is seen with the next bit."""
        self._stuck = stuck
        if stuck or self._level["scl"]:
            self._set("sda", at, not stuck)
