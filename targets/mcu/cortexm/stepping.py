"""Going on behind an instruction that the core does not execute itself: a call of the debugger, an ignored access."""

from __future__ import annotations

from targets.mcu.engine.api import CpuEngine, Reg
from targets.mcu.engine.it_state import advanced

__all__ = ["step_over"]


def step_over(cpu: CpuEngine, size: int) -> None:
    """Move PC and ITSTATE on behind an instruction of `size` bytes; it takes one cycle, a choice."""
    cpu.set(Reg.PC, cpu.get(Reg.PC) + size)
    xpsr = cpu.get(Reg.XPSR)
    behind = advanced(xpsr)
    if behind != xpsr:
        cpu.set(Reg.XPSR, behind)
    cpu.add_cycles(1)
