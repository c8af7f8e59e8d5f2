"""Registers of the NVIC (DDI0403 section B3.4) for everybody but the program, whose accesses ``nvic.c`` answers itself.

Registers for interrupts that the chip does not have read as zero and ignore writes, up to the 240 of the architecture.
"""

from __future__ import annotations

from typing import ClassVar

from targets.mcu.cortexm.exceptions import Exceptions
from targets.mcu.cortexm.ppb import LaneBlock
from targets.mcu.registers import Register
from targets.mcu.services import Services

__all__ = ["Nvic"]

_ISER, _ICER, _ISPR, _ICPR, _IABR, _IPR, _STIR = 0x100, 0x180, 0x200, 0x280, 0x300, 0x400, 0xF00
_SETS = {_ISER: "ISER", _ICER: "ICER", _ISPR: "ISPR", _ICPR: "ICPR", _IABR: "IABR"}
_IPR_WORDS = 60


def _registers() -> tuple[Register, ...]:
    sets = [Register(f"{name}{word}", base + 4 * word) for base, name in _SETS.items() for word in range(8)]
    priorities = [Register(f"IPR{word}", _IPR + 4 * word) for word in range(_IPR_WORDS)]
    return (*sets, *priorities, Register("STIR", _STIR))


class Nvic(LaneBlock):
    """Enables, pending and active states and priorities of the interrupts.

    Args:
        exceptions: what the registers show.
    """

    REGISTERS = _registers()
    ONES_ACT: ClassVar[frozenset[str]] = frozenset({f"{name}{word}" for name in _SETS.values() for word in range(8)})

    def __init__(self, base: int, services: Services, exceptions: Exceptions) -> None:
        super().__init__("NVIC", base, services)
        self._exceptions = exceptions

    def read(self, offset: int) -> int:
        """Read the word at `offset`; there are no side effects."""
        return self._exceptions.read_word(offset)

    def write(self, offset: int, value: int) -> None:
        """Write the word at `offset`."""
        if not self._exceptions.write_word(offset, value):
            self.note("misuse", "STIR", f"this chip has no interrupt {value & 0x1FF}")

    def other_lanes(self, offset: int) -> int:
        """Return the word that a narrow write to `offset` is merged into."""
        return self.read(offset) if _IPR <= offset < _STIR else 0
