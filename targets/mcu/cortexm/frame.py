"""Exception frames (DDI0403 sections B1.5.6 to B1.5.8) on the stack that was in use.

From the new stack pointer upwards: R0, R1, R2, R3, R12, LR, return address, xPSR; with a floating-point context S0 to
S15, FPSCR and a word that nobody uses behind them. With CCR.STKALIGN, and always with a floating-point context, the
frame begins at a multiple of eight, and bit 9 of the xPSR in it says that four bytes were left out for that.
"""

from __future__ import annotations

from collections.abc import Sequence

from targets.mcu.cortexm.fpu import FPCA
from targets.mcu.engine.api import CpuEngine, Reg
from targets.mcu.errors import BusFault
from targets.mcu.services import BusMaster

__all__ = [
    "BASIC",
    "EXC_RETURNS",
    "FLOATS_AT",
    "FRAME_SIZE",
    "RETURN_ADDRESS",
    "TO_HANDLER",
    "TO_THREAD_MSP",
    "TO_THREAD_PSP",
    "bank_of",
    "pull",
    "pull_floats",
    "push",
    "restore",
]

TO_HANDLER, TO_THREAD_MSP, TO_THREAD_PSP = 0xFFFF_FFF1, 0xFFFF_FFF9, 0xFFFF_FFFD
"""The values of EXC_RETURN of a core without floating point (DDI0403 table B1-8)."""
EXC_RETURNS = 0xFFFF_FFE0
"""From here on an address that a handler branches to is one (DDI0403 B1.5.8)."""
BASIC = 1 << 4
"""The bit of EXC_RETURN that is clear where the frame has floating-point registers (DDI0403 table B1-9)."""

FRAME_SIZE, _EXTENDED_SIZE = 32, 104
FLOATS_AT = FRAME_SIZE
"""Offset of the floating-point registers in a frame that has them."""
_FRAME_WORDS, _FLOAT_WORDS = 8, 17
RETURN_ADDRESS = 6
"""Which word of a frame it is."""
_WORD = 0xFFFF_FFFF
_IPSR = 0x1FF
_SPSEL = 1 << 1
_ALIGNED = 1 << 9
_STACKED = (Reg.R0, Reg.R1, Reg.R2, Reg.R3, Reg.R12, Reg.LR, Reg.PC)


def push(cpu: CpuEngine, bus: BusMaster, *, align: bool, floats: Sequence[int] | None = None) -> tuple[int, bool]:
    """Put a frame on the stack in use and move its pointer.

    Args:
        cpu: whose registers are saved.
        bus: where they are saved.
        align: CCR.STKALIGN.
        floats: S0 to S15 and FPSCR, if they belong to the frame.

    Returns:
        EXC_RETURN that takes it off again, and whether all of it could be written. If not, the pointer has moved all
        the same, as on silicon.
    """
    xpsr = cpu.get(Reg.XPSR)
    if xpsr & _IPSR:
        bank, exc_return = Reg.MSP, TO_HANDLER
    elif cpu.get(Reg.CONTROL) & _SPSEL:
        bank, exc_return = Reg.PSP, TO_THREAD_PSP
    else:
        bank, exc_return = Reg.MSP, TO_THREAD_MSP
    top = cpu.get(bank) & ~3
    size = FRAME_SIZE
    if floats is not None:
        size, align, exc_return = _EXTENDED_SIZE, True, exc_return & ~BASIC
    padding = top & 4 if align else 0
    frame = top - size - padding & _WORD
    words = cpu.get_many(_STACKED)
    words.append(xpsr & ~_ALIGNED | (_ALIGNED if padding else 0))
    if floats is not None:
        words += floats
    cpu.set(bank, frame)
    try:
        bus.write_words(frame, words)
    except BusFault:
        return exc_return, False
    return exc_return, True


def pull(cpu: CpuEngine, bus: BusMaster, exc_return: int) -> list[int]:
    """Read the eight words of the frame that `exc_return` names, without taking it off.

    Raises:
        BusFault: the stack cannot be read.
    """
    return bus.read_words(cpu.get(bank_of(exc_return)), _FRAME_WORDS)


def pull_floats(cpu: CpuEngine, bus: BusMaster, exc_return: int) -> list[int]:
    """Read S0 to S15 and FPSCR of the frame that `exc_return` names, without taking it off.

    Raises:
        BusFault: the stack cannot be read.
    """
    return bus.read_words(cpu.get(bank_of(exc_return)) + FLOATS_AT & _WORD, _FLOAT_WORDS)


def restore(cpu: CpuEngine, words: list[int], exc_return: int, *, align: bool) -> None:
    """Take the frame with these words off its stack and go on from it."""
    bank, extended = bank_of(exc_return), not exc_return & BASIC
    top = cpu.get(bank) + (_EXTENDED_SIZE if extended else FRAME_SIZE) & _WORD
    words[6] &= ~1
    cpu.set_many(_STACKED, words[:7])
    cpu.set(Reg.XPSR, words[7] & ~_ALIGNED)
    # after XPSR: in handler mode SPSEL cannot be set
    control = cpu.get(Reg.CONTROL)
    wanted = control & ~(_SPSEL | FPCA) | (_SPSEL if bank is Reg.PSP else 0) | (FPCA if extended else 0)
    if wanted != control:
        cpu.set(Reg.CONTROL, wanted)
    cpu.set(bank, top | (4 if (align or extended) and words[7] & _ALIGNED else 0))


def bank_of(exc_return: int) -> Reg:
    """Return the stack pointer that the frame is at."""
    return Reg.PSP if exc_return | BASIC == TO_THREAD_PSP else Reg.MSP
