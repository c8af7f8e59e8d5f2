"""Caches and tightly coupled memories of a Cortex-M7 as software sees them (DDI0489 section 3.3, DDI0403 B2.2.7, B4.8).

Neither is modelled: memory is always what was last written to it, code too, and everything takes the same time. Sizes
can be read, operations on caches are accepted. QEMU has none of these registers of a Cortex-M7, and cannot tell.
"""

from __future__ import annotations

from collections.abc import Iterable

from targets.mcu.cortexm.ppb import LaneBlock
from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.services import Services

__all__ = ["Caches"]

_CCSIDR, _CSSELR = 0xD80, 0xD84
_OPERATIONS = {
    "ICIALLU": 0xF50,
    "ICIMVAU": 0xF58,
    "DCIMVAC": 0xF5C,
    "DCISW": 0xF60,
    "DCCMVAU": 0xF64,
    "DCCMVAC": 0xF68,
    "DCCSW": 0xF6C,
    "DCCIMVAC": 0xF70,
    "DCCISW": 0xF74,
    "BPIALL": 0xF78,
}
# Those that bring memory and data cache together; DCISW, by which a program empties it before use, does not count.
_MAINTENANCE = {_OPERATIONS[name] for name in ("DCIMVAC", "DCCMVAU", "DCCMVAC", "DCCSW", "DCCIMVAC", "DCCISW")}
_NO_EFFECT = "caches and tightly coupled memories are not modelled: it is only kept"


class Caches(LaneBlock):
    """Sizes, operations, control.

    Args:
        sizes: what CCSIDR reads by CSSELR.
        tcm: ITCMCR and DTCMCR after reset.

    Attributes:
        maintained: the program has cleaned or invalidated the data cache since the last reset.
    """

    def __init__(self, base: int, services: Services, sizes: tuple[int, ...], tcm: tuple[int, ...]) -> None:
        self._sizes = sizes
        self._tcm = tcm
        self.maintained = False
        super().__init__("CACHE", base, services)

    def registers_of(self) -> Iterable[Register]:
        """Return the registers."""
        partly = Fidelity.PARTLY
        itcm, dtcm = self._tcm
        yield Register("CLIDR", 0xD78, 0x0900_0003, 0)  # separate caches at level 1, nothing beyond
        yield Register("CTR", 0xD7C, 0x8303_C003, 0)  # lines of 32 bytes
        yield Register("CCSIDR", _CCSIDR, self._sizes[0], 0)
        yield Register("CSSELR", _CSSELR, 0, 1)
        for name, offset in _OPERATIONS.items():
            yield Register(name, offset, note="accepted: there is nothing to be done")
        yield Register("ITCMCR", 0xF90, itcm, 0b111, fidelity=partly, note=_NO_EFFECT)
        yield Register("DTCMCR", 0xF94, dtcm, 0b111, fidelity=partly, note=_NO_EFFECT)
        yield Register("AHBPCR", 0xF98, 0b1001, 0b1, fidelity=partly, note=_NO_EFFECT)  # 512 MB (assumed), enabled
        yield Register("CACR", 0xF9C, 0, 0b111, fidelity=partly, note=_NO_EFFECT)
        yield Register("AHBSCR", 0xFA0, 0x800, 0xFFFF, fidelity=partly, note=_NO_EFFECT)
        yield Register("ABFSR", 0xFA8, 0, 0)

    def reset(self) -> None:
        """Go to the state after reset."""
        super().reset()
        self.maintained = False

    def read_CCSIDR(self) -> int:
        """Return the size of the cache that CSSELR selects: 0 data, 1 instructions."""
        return self._sizes[self[_CSSELR]]

    def write(self, offset: int, value: int) -> None:
        """Write the word at `offset`; an operation reads as zero again."""
        super().write(offset, value)
        if offset in _OPERATIONS.values():
            self[offset] = 0
            self.maintained |= offset in _MAINTENANCE
