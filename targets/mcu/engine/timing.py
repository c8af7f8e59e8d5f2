"""How many HCLK cycles instructions take: the two timing models.

``flat``: every instruction takes the same rational number of cycles, by core and flash wait states.
``table``: every instruction takes what the Cortex-M3 Technical Reference Manual (r1p1, section 18.2) says for it, or
what was chosen for a Cortex-M7, of which there is no such table.

Neither models the prefetch buffer, contention on the buses, or the folding of IT; both are the same on every host.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any, Protocol

from targets.mcu.cortexm.kinds import CORTEX_M3, CoreKind
from targets.mcu.engine.api import Reg

__all__ = ["FlatTiming", "Timing", "make_timing"]


class Timing(Protocol):
    """Counts the cycles of an engine's instructions."""

    name: str

    def attach(
        self,
        core: Any,
        words: ctypes.Array[ctypes.c_uint64],
        get: Callable[[Reg], int],
        half: Callable[[int], int],
    ) -> None:
        """Begin to count for an engine: `words` are Unicorn's counter and limit, `half` reads code."""

    def cycle(self, retired: int) -> int:
        """Return the cycle at which the instruction after the first `retired` begins."""

    def begin_slice(self, cycle: int, retired: int) -> int:
        """Begin to run up to `cycle`; return how many instructions after the first `retired` the engine may execute."""

    def lower_limit(self, cycle: int, retired: int) -> int:
        """Lower the limit of the running slice, which began after the first `retired`; return as `begin_slice`."""

    def end_slice(self, retired: int) -> None:
        """A slice has ended with `retired` instructions in all."""

    def go_back(self, retired: int, cycle: int) -> None:
        """What came after the first `retired` instructions, which took up to `cycle`, has not happened."""

    def add(self, cycles: int) -> None:
        """Let cycles pass without an instruction."""

    def periods_until(self, cycle: int, retired: int, instructions: int, cycles: int) -> int:
        """Return how many periods of a loop, of so many instructions and cycles, end before `cycle`."""

    def skip(self, instructions: int, cycles: int) -> None:
        """Account for instructions that count as retired from here on but were not executed."""

    def set_wait_states(self, wait_states: int, retired: int) -> None:
        """Change the flash wait states after the first `retired` instructions."""

    def forget(self) -> None:
        """Code has changed."""


class FlatTiming:
    """Every instruction takes the same number of cycles.

    Args:
        cycles: per instruction, by flash wait states; where there are more of these, the last of them.
    """

    name = "flat"

    def __init__(self, cycles: Sequence[Fraction] = CORTEX_M3.flat_cpi) -> None:
        self._cycles = cycles
        self._base = 0  # cycle at which instruction number `_from` began
        self._from = 0
        self._numerator, self._denominator = cycles[0].as_integer_ratio()

    def attach(
        self,
        core: Any,
        words: ctypes.Array[ctypes.c_uint64],
        get: Callable[[Reg], int],
        half: Callable[[int], int],
    ) -> None:
        """Nothing is needed of the engine but its count."""

    def cycle(self, retired: int) -> int:
        """Return the cycle at which the instruction after the first `retired` begins."""
        return self._base + (retired - self._from) * self._numerator // self._denominator

    def begin_slice(self, cycle: int, retired: int) -> int:
        """Return how many instructions after the first `retired` reach `cycle`."""
        ahead = (cycle - self._base) * self._denominator
        return -(-ahead // self._numerator) - (retired - self._from)

    def lower_limit(self, cycle: int, retired: int) -> int:
        """Return how many instructions after the first `retired` reach `cycle`."""
        return self.begin_slice(cycle, retired)

    def end_slice(self, retired: int) -> None:
        """Nothing is counted but instructions."""

    def go_back(self, retired: int, cycle: int) -> None:
        """Nothing to do: the cycles follow from the instructions."""

    def add(self, cycles: int) -> None:
        """Let cycles pass without an instruction."""
        self._base += cycles

    def periods_until(self, cycle: int, retired: int, instructions: int, cycles: int) -> int:
        """Return how many periods of so many instructions end before `cycle`."""
        del cycles  # a period takes now one cycle more, now one less
        return (self.begin_slice(cycle, retired) - 1) // instructions

    def skip(self, instructions: int, cycles: int) -> None:
        """Nothing to do: the cycles follow from the instructions."""

    def set_wait_states(self, wait_states: int, retired: int) -> None:
        """Change the cycles per instruction; a fraction of a cycle that was begun is lost."""
        self._base = self.cycle(retired)
        self._from = retired
        self._numerator, self._denominator = self._cycles_at(wait_states).as_integer_ratio()

    def forget(self) -> None:
        """Nothing is known of the code."""

    def _cycles_at(self, wait_states: int) -> Fraction:
        return self._cycles[min(wait_states, len(self._cycles) - 1)]


def make_timing(name: str, kind: CoreKind = CORTEX_M3) -> Timing:
    """Return the timing model of that name for a core: ``flat`` or ``table``.

    Raises:
        KeyError: there is no such model.
    """
    from targets.mcu.engine.table_timing import CORTEX_M3_TABLE, CORTEX_M7_TABLE, TableTiming

    table = CORTEX_M7_TABLE if kind.model == "M7" else CORTEX_M3_TABLE
    models: dict[str, Callable[[], Timing]] = {
        "flat": lambda: FlatTiming(kind.flat_cpi),
        "table": lambda: TableTiming(table),
    }
    return models[name]()
