"""The system control space at 0xE000E000: SysTick, NVIC, SCB and what more a core has share one page of the bus."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from targets.mcu.cortexm.nvic import Nvic
from targets.mcu.cortexm.ppb import LaneBlock, PpbBlock
from targets.mcu.cortexm.scb import Scb
from targets.mcu.cortexm.systick import SysTick
from targets.mcu.registers import Count, Register
from targets.mcu.services import Services

__all__ = ["SCS_BASE", "Scs"]

SCS_BASE = 0xE000_E000
_STIR = 0xF00


class Scs(PpbBlock):
    """Hands every access to the part that has the register.

    Attributes:
        parts: the blocks that live here, each with registers at offsets from `SCS_BASE`.
    """

    def __init__(
        self,
        services: Services,
        privileged: Callable[[], bool],
        systick: SysTick,
        nvic: Nvic,
        scb: Scb,
        *others: LaneBlock,
    ) -> None:
        self.parts: tuple[LaneBlock, ...] = (systick, nvic, scb, *others)
        self._scb = scb
        self._part_at = {offset: part for part in self.parts for offset in part.registers}
        super().__init__("SCS", SCS_BASE, services, privileged)

    def registers_of(self) -> Iterable[Register]:
        """Return the registers of all parts."""
        return [register for part in self.parts for register in part.registers.values()]

    def reset(self) -> None:
        """Go to the state after a system reset."""
        for part in self.parts:
            part.reset()

    def read_word(self, offset: int) -> int:
        """Read as somebody who may."""
        part = self._part_at.get(offset)
        return super().read_word(offset) if part is None else part.read(offset)

    def write_word(self, offset: int, value: int) -> None:
        """Write as somebody who may."""
        part = self._part_at.get(offset)
        if part is None:
            super().write_word(offset, value)
        else:
            part.write(offset, value)

    def is_live(self, offset: int) -> bool:
        """Say whether the register changes with time alone."""
        part = self._part_at.get(offset)
        return part is not None and part.is_live(offset)

    def count(self, offset: int) -> Count | None:
        """Return how the register counts from now on, or None."""
        part = self._part_at.get(offset)
        return None if part is None else part.count(offset)

    def open_to_all(self, offset: int) -> bool:
        """Say whether unprivileged software may touch the word at `offset`: STIR, if CCR.USERSETMPEND is set."""
        return offset == _STIR and self._scb.anybody_may_trigger

    def other_lanes(self, offset: int) -> int:
        """Return the word that a narrow write to the word at `offset` is merged into."""
        part = self._part_at.get(offset)
        return 0 if part is None else part.other_lanes(offset)
