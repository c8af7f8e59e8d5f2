"""What there was before an instruction, for the case that an access of it fails, or that it may not execute.

Unicorn goes on after such an access, at least to the end of the IT block, so all that follows is undone. Registers of
peripherals are not accessed any more, but for one case: that a store into flash is refused is known after the slice
alone, and what the same IT block then writes to registers stays.
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Before"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Before:
    """The state of core and RAM before an instruction.

    Attributes:
        registers: R0 to R15 and xPSR.
        floats: S0 to S31 and FPSCR, if the core has them.
        context: CONTROL.FPCA, in its place.
        ram: base and contents of the memories that can be written.
        flash_stores: how many stores into flash there were in the same slice.
        instructions: retired so far.
        cycle: at which the instruction begins.
    """

    registers: list[int]
    floats: list[int]
    context: int
    ram: list[tuple[int, bytes]]
    flash_stores: int
    instructions: int
    cycle: int
