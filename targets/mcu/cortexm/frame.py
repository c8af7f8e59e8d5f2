"""Exception frames (DDI0403 sections B1.5.6 to B1.5.8) as somebody sees them who looks at a program from outside."""

from __future__ import annotations

from targets.mcu.engine.api import CpuEngine, Reg
from targets.mcu.errors import BusFault
from targets.mcu.services import BusMaster

__all__ = ["EXC_RETURNS", "return_address"]

EXC_RETURNS = 0xFFFF_FFE0
"""From here on an address that a handler branches to is one (DDI0403 B1.5.8)."""

_TO_THREAD_PSP = 0xFFFF_FFFD
_BASIC = 1 << 4  # of EXC_RETURN; clear where the frame has floating-point registers
_RETURN_ADDRESS = 24  # in a frame
_NO_MEMORY = 0x4000_0000  # here the peripherals begin


def return_address(cpu: CpuEngine, bus: BusMaster, exc_return: int) -> int | None:
    """Return where the program goes on after a return by `exc_return`; None if its frame is not in memory."""
    frame = cpu.get(Reg.PSP if exc_return | _BASIC == _TO_THREAD_PSP else Reg.MSP)
    if frame >= _NO_MEMORY:
        return None
    try:
        return bus.read(frame + _RETURN_ADDRESS, 4)
    except BusFault:
        return None
