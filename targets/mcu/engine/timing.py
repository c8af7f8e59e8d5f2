"""How many HCLK cycles instructions take: the two timing models.

``flat``: every instruction takes the same rational number of cycles, by core and flash wait states.
``table``: every instruction takes what the Cortex-M3 Technical Reference Manual (r2p1, table 3-1) says for it, or
what was chosen for a Cortex-M7, of which there is no such table; both stand beside the encodings in ``isa.h``.

Neither models the prefetch buffer, contention on the buses, or the folding of IT; both are the same on every host.

What counts stands in ``struct hil_state``; these classes say what the engine is to put there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any, Protocol

from targets.mcu.cortexm.kinds import CORTEX_M3, CoreKind

__all__ = ["FlatTiming", "TableTiming", "Timing", "make_timing"]


class Timing(Protocol):
    """Counts the cycles of an engine's instructions."""

    name: str

    def attach(self, state: Any) -> None:
        """Begin to count for an engine with this ``hil_state``."""

    def cycle(self, retired: Any) -> Any:
        """Return the cycle at which the instruction after the first `retired` begins; of many, for an array."""

    def add(self, cycles: int) -> None:
        """Let cycles pass without an instruction."""

    def periods_until(self, cycle: int, instructions: int, cycles: int) -> int:
        """Return how many periods of a loop, of so many instructions and cycles, end before `cycle`."""

    def skip(self, instructions: int, cycles: int) -> None:
        """Account for instructions that count as retired but were not executed."""

    def set_wait_states(self, wait_states: int) -> None:
        """Change the flash wait states, from the instruction in flight on."""


class FlatTiming:
    """Every instruction takes the same number of cycles; a fraction of a cycle is carried on.

    Args:
        cycles: per instruction, by flash wait states; where there are more of these, the last of them.
    """

    name = "flat"

    def __init__(self, cycles: Sequence[Fraction] = CORTEX_M3.flat_cpi) -> None:
        self._cycles = cycles
        self._state: Any = None

    def attach(self, state: Any) -> None:
        """Begin to count for an engine with this ``hil_state``."""
        self._state = state
        self._take(0)

    def cycle(self, retired: Any) -> Any:
        """Return the cycle at which the instruction after the first `retired` begins; of many, for an array."""
        state = self._state
        return state.base + (retired - state.since) * state.numerator // state.denominator

    def add(self, cycles: int) -> None:
        """Let cycles pass without an instruction."""
        self._state.base += cycles
        self._state.cycle += cycles

    def periods_until(self, cycle: int, instructions: int, cycles: int) -> int:
        """Return how many periods of so many instructions end before `cycle`."""
        del cycles  # a period takes now one cycle more, now one less
        state = self._state
        ahead = (cycle - state.base) * state.denominator
        reached: int = -(-ahead // state.numerator) - (state.retired - state.since)
        return (reached - 1) // instructions

    def skip(self, instructions: int, cycles: int) -> None:
        """Account for instructions that count as retired but were not executed."""
        del cycles
        self._state.retired += instructions
        self._state.cycle = self.cycle(self._state.retired)

    def set_wait_states(self, wait_states: int) -> None:
        """Change the cycles per instruction; a fraction of a cycle that was begun is lost."""
        self._state.base = self._state.cycle
        self._state.since = self._state.retired
        self._take(wait_states)

    def _take(self, wait_states: int) -> None:
        cycles = self._cycles[min(wait_states, len(self._cycles) - 1)]
        self._state.numerator, self._state.denominator = cycles.as_integer_ratio()


class TableTiming:
    """Every instruction takes its own number of cycles.

    Args:
        waits: wait states of the flash show, at every refill of the pipeline and at loads relative to PC.
    """

    name = "table"

    def __init__(self, *, waits: bool = True) -> None:
        self._waits = waits
        self._state: Any = None

    def attach(self, state: Any) -> None:
        """Begin to count for an engine with this ``hil_state``."""
        self._state = state

    def cycle(self, retired: Any) -> Any:
        """Return the present cycle: the beginning of the instruction in flight, or of the next."""
        del retired
        return self._state.cycle

    def add(self, cycles: int) -> None:
        """Let cycles pass without an instruction."""
        self._state.cycle += cycles

    def periods_until(self, cycle: int, instructions: int, cycles: int) -> int:
        """Return how many periods of so many cycles end before `cycle`."""
        del instructions
        return int(cycle - self._state.cycle - 1) // cycles

    def skip(self, instructions: int, cycles: int) -> None:
        """Account for instructions that count as retired but were not executed."""
        self._state.retired += instructions
        self._state.cycle += cycles

    def set_wait_states(self, wait_states: int) -> None:
        """Change the flash wait states, from the instruction in flight on."""
        self._state.wait_states = wait_states if self._waits else 0


def make_timing(name: str, kind: CoreKind = CORTEX_M3) -> Timing:
    """Return the timing model of that name for a core: ``flat`` or ``table``.

    Raises:
        KeyError: there is no such model.
    """
    models: dict[str, Callable[[], Timing]] = {
        "flat": lambda: FlatTiming(kind.flat_cpi),
        "table": lambda: TableTiming(waits=kind.model == "M3"),
    }
    return models[name]()
