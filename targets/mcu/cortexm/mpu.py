"""The memory protection unit (DDI0403 section B3.5): its regions are remembered, and nothing is refused.

Choice: of a region number that does not exist, the lower bits count, and it is noted. The manual calls it
UNPREDICTABLE, and its pseudocode (`ValidateAddress`) only ever asks for regions that there are; a register of as many
bits as regions need does this. QEMU ignores such a write whole: with 8 regions 9 leaves RNR as it was, and RBAR too
where it has VALID.
"""

from __future__ import annotations

from collections.abc import Iterable

from targets.mcu.cortexm.ppb import LaneBlock
from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.services import Services

__all__ = ["Mpu"]

_TYPE, _CTRL, _RNR, _RBAR, _RASR = 0xD90, 0xD94, 0xD98, 0xD9C, 0xDA0
_ALIASES = 3
_ENABLE = 1 << 0
_VALID, _REGION = 1 << 4, 0xF
_RASR_BITS = 0x173F_FF3F
_S, _LEAST_WITH_SUBREGIONS = 1 << 18, 256
_CACHED = {(0, 0b10), (0, 0b11), (1, 0b11)}  # TEX, and C with B, of normal memory that is cached (DDI0403 B3.5.9)
_CACHED_BY_DEFAULT = {0, 1, 3, 4}  # by half gigabyte: code, SRAM, external RAM (DDI0403 B3.1)
_NOTHING_REFUSED = "no access is ever refused: regions are only remembered"


class Mpu(LaneBlock):
    """Regions and their attributes.

    Args:
        regions: how many there are, a power of two.
    """

    def __init__(self, base: int, services: Services, regions: int) -> None:
        self._count = regions
        self._regions = [(0, 0)] * regions
        super().__init__("MPU", base, services)

    def registers_of(self) -> Iterable[Register]:
        """Return the registers."""
        absent = Fidelity.PARTLY
        yield Register("TYPE", _TYPE, self._count << 8, 0)
        yield Register("CTRL", _CTRL, 0, 0b111, fidelity=absent, note=_NOTHING_REFUSED)
        yield Register("RNR", _RNR, 0, self._count - 1)
        for alias in range(_ALIASES + 1):
            suffix = f"_A{alias}" if alias else ""
            yield Register(f"RBAR{suffix}", _RBAR + 8 * alias)
            yield Register(f"RASR{suffix}", _RASR + 8 * alias, 0, _RASR_BITS)

    def cached(self, address: int) -> bool:
        """Say whether data at an address may be cached, by its region or by the default memory map.

        Shareable memory is not: so a Cortex-M7 takes it unless CACR.SIWT is set (DDI0489 section 5.2).
        """
        if self[_CTRL] & _ENABLE:
            for base, attributes in reversed(self._regions):
                if attributes & 1 and self._covers(base, attributes, address):
                    return _is_cached(attributes)
        return address >> 29 in _CACHED_BY_DEFAULT

    def _covers(self, base: int, attributes: int, address: int) -> bool:
        size = 2 << (attributes >> 1 & 0x1F)
        offset = address - (base & -size)
        if not 0 <= offset < size:
            return False
        return size < _LEAST_WITH_SUBREGIONS or not attributes >> 8 + offset * 8 // size & 1

    def reset(self) -> None:
        """Go to the state after reset; that regions are zero, which silicon leaves unknown, is a choice; QEMU too."""
        super().reset()
        self._regions = [(0, 0)] * self._count

    def write_CTRL(self, value: int) -> None:
        """Remember; say once that nothing comes of it."""
        self[_CTRL] = value
        if value & _ENABLE:
            self.note("unmodelled", "CTRL.ENABLE", _NOTHING_REFUSED)

    def read(self, offset: int) -> int:
        """Read the word at `offset`."""
        if offset < _RBAR:
            return super().read(offset)
        address, attributes = self._regions[self[_RNR]]
        return attributes if offset - _RBAR & 4 else address | self[_RNR]

    def write(self, offset: int, value: int) -> None:
        """Write the word at `offset`."""
        if offset == _RNR:
            self._check(value)
        if offset < _RBAR:
            super().write(offset, value)
        elif offset - _RBAR & 4:
            self._regions[self[_RNR]] = self._regions[self[_RNR]][0], value & _RASR_BITS
        else:
            if value & _VALID:
                self._check(value & _REGION)
                self[_RNR] = value & _REGION & self._count - 1
            self._regions[self[_RNR]] = value & ~0x1F, self._regions[self[_RNR]][1]

    def _check(self, region: int) -> None:
        if region >= self._count:
            text = f"there is no region {region}, which is UNPREDICTABLE; region {region & self._count - 1} is meant"
            self.note("misuse", "RNR", text)


def _is_cached(attributes: int) -> bool:
    tex, cache = attributes >> 19 & 7, attributes >> 16 & 3
    if attributes & _S:
        return False
    return bool(cache) if tex & 4 else (tex, cache) in _CACHED
