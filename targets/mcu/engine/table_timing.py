"""The timing model ``table``: every instruction takes what a table says for it; slow in Python.

The table is that of the Cortex-M3's manual, or what was chosen for a Cortex-M7. Before each instruction a hook settles
the one before it: its own cycles, and, if it was a branch taken, the refill of the pipeline. Where flash wait states
show at all, they come on top of every refill and of every load from flash relative to PC; what runs straight ahead is
fetched in time by the prefetch buffer. Instructions that an IT passes over take a cycle each. What fills the pipeline
after an exception return belongs to the cycles of the return.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from targets.mcu.engine import opcode_cycles, opcode_cycles_m7
from targets.mcu.engine.api import Reg
from targets.mcu.engine.opcode_cycles import Cost, is_wide

__all__ = ["CORTEX_M3_TABLE", "CORTEX_M7_TABLE", "CostTable", "TableTiming"]

_NO_LIMIT = 1 << 62
_EXC_RETURN = 0xFFFF_FFE0
_RAM_BASE = 0x2000_0000


@dataclass(frozen=True, slots=True)
class CostTable:
    """What instructions of a core take.

    Attributes:
        cost_of: one of them, by its half-words.
        refill: of the pipeline after a branch taken.
        waits: wait states of the flash show, at every refill and at loads relative to PC.
        ram_end: first address behind RAM that begins at 0; 0 if none does.
    """

    cost_of: Callable[[int, int], Cost]
    refill: int
    waits: bool
    ram_end: int = 0


CORTEX_M3_TABLE = CostTable(opcode_cycles.cost_of, opcode_cycles.REFILL, waits=True)
CORTEX_M7_TABLE = CostTable(opcode_cycles_m7.cost_of, opcode_cycles_m7.REFILL, waits=False, ram_end=0x0010_0000)


class TableTiming:
    """Every instruction takes its own number of cycles.

    Args:
        table: how many.
    """

    name = "table"

    def __init__(self, table: CostTable = CORTEX_M3_TABLE) -> None:
        self._cost_of = table.cost_of
        self._refill = table.refill
        self._waits = table.waits
        self._ram_end = table.ram_end
        self._cycles = 0  # at the beginning of the instruction last seen
        self._wait_states = 0
        self._limit = _NO_LIMIT
        self._seen: Cost | None = None  # the instruction that has begun and is not settled
        self._at = 0  # its address
        self._begun = 0  # instructions begun so far, those retired and the one in flight
        self._it_end = 0  # address behind the instructions that the last IT governs
        self._it_from = 0
        self._costs: dict[int, Cost] = {}

    def attach(
        self,
        core: Any,
        words: ctypes.Array[ctypes.c_uint64],
        get: Callable[[Reg], int],
        half: Callable[[int], int],
    ) -> None:
        """Hook every instruction of `core`."""
        import unicorn

        self._core, self._words, self._get, self._half = core, words, get, half
        core.hook_add(unicorn.UC_HOOK_CODE, self._on_instruction)

    # --- counting

    def _on_instruction(self, _uc: object, address: int, _size: int, _data: object) -> None:
        self._settle(address)
        if self._cycles >= self._limit and not self._it_from < address < self._it_end:
            # as if Unicorn's own count had run out before this instruction
            self._words[1] = self._words[0] - 1
            self._core.emu_stop()
            return
        self._seen = cost = self._cost_at(address)
        self._at = address
        self._begun += 1
        if cost.it_length:
            self._it_from, self._it_end = address, self._end_of(address + 2, cost.it_length)

    def _settle(self, following: int) -> None:
        """Count the instruction that has begun; `following` is where the program went after it."""
        cost = self._seen
        if cost is None:
            return
        self._seen = None
        cycles = cost.cycles + (self._wait_states if cost.literal else 0)
        straight = self._at + cost.size
        if following != straight and following < _EXC_RETURN:
            passed = self._passed_over(straight, following)
            cycles += passed or self._refill + self._wait_states
        self._cycles += cycles

    def _passed_over(self, start: int, end: int) -> int:
        """Return how many instructions of an IT block lie from `start` to `end`; 0 if that was a branch."""
        if not self._it_from < start < end <= self._it_end:
            return 0
        count = 0
        while start < end:
            start += 4 if is_wide(self._half(start)) else 2
            count += 1
        return count

    def _cost_at(self, address: int) -> Cost:
        cost = self._costs.get(address)
        if cost is None:
            cost = self._cost_of(self._half(address), self._half(address + 2))
            if self._ram_end <= address < _RAM_BASE:  # code in RAM may change
                self._costs[address] = cost
        return cost

    def _end_of(self, address: int, instructions: int) -> int:
        for _ in range(instructions):
            address += 4 if is_wide(self._half(address)) else 2
        return address

    # --- what the engine asks

    def cycle(self, _retired: int) -> int:
        """Return the present cycle: the beginning of the instruction in flight, or of the next."""
        return self._cycles

    def begin_slice(self, cycle: int, _retired: int) -> int:
        """Set the limit of a slice; the engine need not count instructions."""
        self._limit = cycle
        return _NO_LIMIT

    def lower_limit(self, cycle: int, _retired: int) -> int:
        """Lower the limit of the running slice; return how many instructions it may have in all at most."""
        self._limit = min(self._limit, cycle)
        return 0 if cycle <= self._cycles else _NO_LIMIT

    def end_slice(self, retired: int) -> None:
        """Settle the last instruction, if it has retired."""
        if self._seen is not None and self._begun <= retired:
            self._settle(self._get(Reg.PC))
        self._seen = None
        self._begun = retired

    def go_back(self, retired: int, cycle: int) -> None:
        """What came after the first `retired` instructions, which took up to `cycle`, has not happened."""
        self._begun, self._cycles = retired, cycle

    def add(self, cycles: int) -> None:
        """Let cycles pass without an instruction."""
        self._cycles += cycles

    def periods_until(self, cycle: int, _retired: int, _instructions: int, cycles: int) -> int:
        """Return how many periods of so many cycles end before `cycle`."""
        return (cycle - self._cycles - 1) // cycles

    def skip(self, instructions: int, cycles: int) -> None:
        """Account for cycles of instructions that were not executed."""
        self._begun += instructions
        self._cycles += cycles

    def set_wait_states(self, wait_states: int, _retired: int) -> None:
        """Change the flash wait states, from the instruction in flight on."""
        self._wait_states = wait_states if self._waits else 0

    def forget(self) -> None:
        """Code has changed."""
        self._costs.clear()
