"""What the blocks of the private peripheral bus have in common: lanes, and who may touch them.

Lanes: a byte or half-word written there reaches its own lanes alone, nothing is repeated. A register that keeps what it
is told sees the word with the other lanes unchanged; one whose ones act (set, clear, pend) sees zeros in them.

Access: unprivileged software gets a bus fault (DDI0403 section B3.1), with two exceptions that their blocks make: STIR
if CCR.USERSETMPEND is set, and stimulus ports that ITM_TPR opens.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import ClassVar

from targets.mcu.errors import BusFault
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services

__all__ = ["DebugBlock", "LaneBlock", "PpbBlock", "component_id"]

_COMPONENT_NAMES = ("PID4", "PID5", "PID6", "PID7", "PID0", "PID1", "PID2", "PID3", "CID0", "CID1", "CID2", "CID3")
_ARM = 0x04  # PID4: the continuation code of JEP106


def component_id(part: Sequence[int], component_class: int) -> Iterator[Register]:
    """Yield the identification registers at the end of a block.

    Args:
        part: PID0 to PID3.
        component_class: bits 15 to 12 of the component's identification: 1 ROM table, 9 debug, 14 of Arm's own.
    """
    values = (_ARM, 0, 0, 0, *part, 0x0D, component_class << 4, 0x05, 0xB1)
    for index, (name, value) in enumerate(zip(_COMPONENT_NAMES, values, strict=True)):
        yield Register(name, 0xFD0 + 4 * index, value, 0)


class LaneBlock(Peripheral):
    """Registers of which bytes and half-words can be written alone.

    Attributes:
        ONES_ACT: registers of which a narrow write shows zeros in the other lanes.
    """

    ONES_ACT: ClassVar[frozenset[str]] = frozenset()
    size: ClassVar[int] = 0x1000

    def read_part(self, offset: int, size: int) -> int:
        """Read 1 or 2 bytes. Raises `BusFault`."""
        return self.read(offset & ~3) >> 8 * (offset & 3) & ((1 << 8 * size) - 1)

    def write_part(self, offset: int, size: int, value: int) -> None:
        """Write 1 or 2 bytes. Raises `BusFault`."""
        shift, mask = 8 * (offset & 3), (1 << 8 * size) - 1
        self.write(offset & ~3, self.other_lanes(offset & ~3) & ~(mask << shift) | (value & mask) << shift)

    def other_lanes(self, offset: int) -> int:
        """Return the word that a narrow write to the word at `offset` is merged into."""
        register = self.registers.get(offset)
        if register is None or register.name in self.ONES_ACT:
            return 0
        return self[offset]


class PpbBlock(LaneBlock):
    """Registers at an address of the private peripheral bus, closed to unprivileged software.

    Args:
        name: as in the manual.
        base: address of offset 0.
        services: what the chip offers.
        privileged: says whether the access in flight is privileged.
    """

    def __init__(self, name: str, base: int, services: Services, privileged: Callable[[], bool]) -> None:
        super().__init__(name, base, services)
        self._privileged = privileged

    def read(self, offset: int) -> int:
        """Read the word at `offset`, with its side effects. Raises `BusFault`."""
        self.check(offset)
        return self.read_word(offset)

    def write(self, offset: int, value: int) -> None:
        """Write the word at `offset`, with its effects. Raises `BusFault`."""
        self.check(offset)
        self.write_word(offset, value)

    # --- what a subclass may do its own way

    def read_word(self, offset: int) -> int:
        """Read as somebody who may."""
        return super().read(offset)

    def write_word(self, offset: int, value: int) -> None:
        """Write as somebody who may."""
        super().write(offset, value)

    def check(self, offset: int) -> None:
        """Raise `BusFault` if the access in flight may not touch the word at `offset`."""
        if not self._privileged() and not self.open_to_all(offset):
            raise BusFault(self.base + offset, f"{self.name} is for privileged software only")

    def open_to_all(self, _offset: int) -> bool:
        """Say whether unprivileged software may touch the word at `_offset`; it may not, unless a block says so."""
        return False


class DebugBlock(PpbBlock):
    """A block that a system reset does not reach, only power-on."""

    def reset(self) -> None:
        """Keep everything."""

    def power_on(self) -> None:
        """Go to the state after power-on."""
        super().reset()
