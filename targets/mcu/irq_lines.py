"""Interrupt inputs that several peripherals drive: the input is high while any of them drives it high."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

from targets.mcu.services import IrqLine

__all__ = ["IrqLines"]


class IrqLines:
    """The interrupt inputs of a chip.

    Args:
        inputs: the input of the core by number.
    """

    def __init__(self, inputs: Callable[[int], IrqLine]) -> None:
        self._inputs = inputs
        self._sources: dict[int, list[_Source]] = {}

    def line(self, number: int) -> IrqLine:
        """Return a line of its own to the input of that number. Raises ValueError if there is no such input."""
        sources = self._sources.setdefault(number, [])
        assert not any(source.driven_in_c for source in sources), "who drives it in C drives it alone"
        source = _Source(self._inputs(number), sources)
        sources.append(source)
        return source


class _Source:
    """What one peripheral drives."""

    __slots__ = ("_input", "_others", "driven_in_c", "level")

    def __init__(self, target: IrqLine, others: list[_Source]) -> None:
        self._input = target
        self._others = others
        self.level = self.driven_in_c = False

    @property
    def core(self) -> ctypes.c_void_p | None:
        """See `IrqLine`."""
        return self._input.core if len(self._others) == 1 else None

    def set(self, level: bool) -> None:
        """Drive the line."""
        if level is not self.level:
            self.level = level
            self._input.set(level or any(source.level for source in self._others))
