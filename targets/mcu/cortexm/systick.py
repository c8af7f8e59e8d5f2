"""The SysTick timer as others than the program see it; it is in ``systick.c``."""

from __future__ import annotations

from collections.abc import Iterable

from targets.mcu.cortexm.exceptions import Exceptions
from targets.mcu.cortexm.kinds import CORTEX_M3
from targets.mcu.cortexm.ppb import LaneBlock
from targets.mcu.engine.core_engine import CoreEngine
from targets.mcu.registers import Count, Register
from targets.mcu.services import Services

__all__ = ["SysTick"]

_CTRL, _LOAD, _VAL, _CALIB = 0x10, 0x14, 0x18, 0x1C
_ENABLE, _TICKINT, _CLKSOURCE = 1 << 0, 1 << 1, 1 << 2
_WIDTH = 0x00FF_FFFF


class SysTick(LaneBlock):
    """The 24-bit timer of the core.

    Args:
        engine: has it.
        exceptions: where its registers are.
        calibration: what CALIB reads.
    """

    _REGISTERS = (
        Register("CTRL", _CTRL, 0, _ENABLE | _TICKINT | _CLKSOURCE),
        Register("LOAD", _LOAD, 0, _WIDTH),
        Register("VAL", _VAL, 0, 0, live=True),
    )

    def __init__(
        self,
        base: int,
        services: Services,
        engine: CoreEngine,
        exceptions: Exceptions,
        calibration: int = CORTEX_M3.systick_calibration,
    ) -> None:
        self._calibration = calibration
        super().__init__("STK", base, services)
        self._engine = engine
        self._kept = engine.systick
        self._exceptions = exceptions

    def registers_of(self) -> Iterable[Register]:
        """Return the registers."""
        return (*self._REGISTERS, Register("CALIB", _CALIB, self._calibration, 0))

    def reset(self) -> None:
        """Stop, with all registers zero."""
        self._engine.ask("hil_reset_systick")

    def hold(self, held: bool) -> None:
        """Let the clock stand still, as in Stop mode, or run again; the counter keeps its value."""
        self._engine.ask("hil_hold_systick", held)

    # --- registers

    def read(self, offset: int) -> int:
        """Read the word at `offset`; reading CTRL clears COUNTFLAG."""
        return self[_CALIB] if offset == _CALIB else self._exceptions.read_word(offset)

    def write(self, offset: int, value: int) -> None:
        """Write the word at `offset`."""
        self._exceptions.write_word(offset, value)

    def other_lanes(self, offset: int) -> int:
        """Return the word that a narrow write to `offset` is merged into."""
        return self._engine.ask("hil_systick_lanes", offset)

    def is_live(self, offset: int) -> bool:
        """VAL changes while the timer counts."""
        return offset == _VAL and bool(self._kept.ctrl & _ENABLE) and not self._kept.held

    def count(self, offset: int) -> Count | None:
        """Return how VAL counts down to zero."""
        ticks = self._engine.ticks()
        if offset != _VAL or ticks is None:
            return None
        value, divider, origin, until = ticks
        return Count(value, origin, divider, until, down=True)

    def interrupts(self) -> bool:
        """Say whether it makes its exception pending from time to time."""
        kept = self._kept
        return bool(kept.ctrl & _ENABLE and kept.ctrl & _TICKINT and kept.load) and not kept.held
