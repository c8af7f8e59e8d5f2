"""Going on behind an instruction that the core does not execute itself: a call of the debugger, an ignored access."""

from __future__ import annotations

from targets.mcu.engine.api import CpuEngine, Reg

__all__ = ["advanced", "step_over"]

_IT_BITS = 0x0600_FC00


def step_over(cpu: CpuEngine, size: int) -> None:
    """Move PC and ITSTATE on behind an instruction of `size` bytes; it takes one cycle, a choice."""
    cpu.set(Reg.PC, cpu.get(Reg.PC) + size)
    xpsr = cpu.get(Reg.XPSR)
    behind = advanced(xpsr)
    if behind != xpsr:
        cpu.set(Reg.XPSR, behind)
    cpu.add_cycles(1)


def advanced(xpsr: int) -> int:
    """Return xPSR with ITSTATE behind the instruction in flight (``ITAdvance``, DDI0403 section A7.3.2).

    Its bits 7 to 2 are in 15 to 10 of xPSR, bits 1 and 0 in 26 and 25.
    """
    it = xpsr >> 8 & 0xFC | xpsr >> 25 & 3
    it = it & 0xE0 | it << 1 & 0x1F if it & 7 else 0
    return xpsr & ~_IT_BITS | (it & 3) << 25 | (it & 0xFC) << 8
