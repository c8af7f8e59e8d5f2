"""What else answers on the private peripheral bus: FPB, TPIU and the ROM table, as a program sees them.

Nothing of it acts: flash patches are remembered, no trace leaves the chip. The ROM table is that of an STM32F103
(RM0008 section 31, Cortex-M3 TRM r1p1); a core of another kind shows the same, but for the blocks' own identification.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from targets.mcu.cortexm.ppb import DebugBlock, PpbBlock, component_id
from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.services import Services

__all__ = ["Fpb", "RomTable", "Tpiu"]

_NO_PATCH = "flash is never patched, and breakpoints do not stop"


class Fpb(DebugBlock):
    """Flash patch and breakpoint unit (DDI0403 section C1.11): six code and two literal comparators, without effect."""

    _REGISTERS = (
        Register("CTRL", 0x000, 0x260, 0b11, 0b1, fidelity=Fidelity.ABSENT, note=_NO_PATCH),
        Register("REMAP", 0x004, 0x2000_0000, 0x1FFF_FFE0, fidelity=Fidelity.ABSENT, note=_NO_PATCH),
        *(
            Register(f"COMP{index}", 0x008 + 4 * index, 0, 0xDFFF_FFFD, fidelity=Fidelity.ABSENT, note=_NO_PATCH)
            for index in range(8)
        ),
    )

    def __init__(self, services: Services, privileged: Callable[[], bool], part: Sequence[int]) -> None:
        self._part = part
        super().__init__("FPB", 0xE000_2000, services, privileged)

    def registers_of(self) -> Iterable[Register]:
        """Return the registers, with the core's own identification."""
        return (*self._REGISTERS, *component_id(self._part, 0xE))

    def write_CTRL(self, value: int) -> None:
        """Keep ENABLE, if KEY is written with it; KEY reads as zero."""
        if value & 0b10:
            self[0x000] = value & ~0b10


_NO_TRACE = "no trace leaves the chip: stimulus ports are read where they are written"


class Tpiu(DebugBlock):
    """Trace port interface unit (DDI0403 section C1.10): remembers how the trace would leave the chip."""

    _REGISTERS = (
        Register("SSPSR", 0x000, 0xB, 0),
        Register("CSPSR", 0x004, 0x1, note=_NO_TRACE),
        Register("ACPR", 0x010, 0, 0x1FFF, note=_NO_TRACE),
        Register("SPPR", 0x0F0, 0x1, 0x3, note=_NO_TRACE),
        Register("FFSR", 0x300, 0x8, 0),
        Register("FFCR", 0x304, 0x102, 0x102, note=_NO_TRACE),
        Register("FSCR", 0x308, 0, 0),
        Register("ITCTRL", 0xF00, 0, 0),
        Register("CLAIMSET", 0xFA0, 0xF, 0),
        Register("CLAIMCLR", 0xFA4, 0, 0),
        Register("DEVID", 0xFC8, 0xCA1, 0),
        Register("DEVTYPE", 0xFCC, 0x11, 0),
    )

    def __init__(self, services: Services, privileged: Callable[[], bool], part: Sequence[int]) -> None:
        self._part = part
        super().__init__("TPIU", 0xE004_0000, services, privileged)

    def registers_of(self) -> Iterable[Register]:
        """Return the registers, with the core's own identification."""
        return (*self._REGISTERS, *component_id(self._part, 0x9))


class RomTable(PpbBlock):
    """The list of debug components that a debugger looks for (DDI0403 section C1.2.4), made by ST (JEP106 0x20).

    Part number 0x410 is that of medium-density devices, as in DBGMCU_IDCODE. There is no trace macrocell for
    instructions (ETM) in them: its entry says not present (assumed).
    """

    REGISTERS = (
        Register("SCS", 0x000, 0xFFF0_F003, 0),
        Register("DWT", 0x004, 0xFFF0_2003, 0),
        Register("FPB", 0x008, 0xFFF0_3003, 0),
        Register("ITM", 0x00C, 0xFFF0_1003, 0),
        Register("TPIU", 0x010, 0xFFF4_1003, 0),
        Register("ETM", 0x014, 0xFFF4_2002, 0),
        Register("END", 0x018, 0, 0),
        Register("MEMTYPE", 0xFCC, 0x1, 0),
        Register("PID4", 0xFD0, 0, 0),
        *(register for register in component_id((0x10, 0x04, 0x0A, 0x00), 0x1) if register.name != "PID4"),
    )

    def __init__(self, services: Services, privileged: Callable[[], bool]) -> None:
        super().__init__("ROM", 0xE00F_F000, services, privileged)
