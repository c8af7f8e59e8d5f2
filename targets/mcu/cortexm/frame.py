"""Exception frames (DDI0403 sections B1.5.6 and B1.5.8): eight words on the stack that was in use.

From the new stack pointer upwards: R0, R1, R2, R3, R12, LR, return address, xPSR. With CCR.STKALIGN the frame begins at
a multiple of eight, and bit 9 of the xPSR in it says that four bytes were left out for that.
"""

from __future__ import annotations

from targets.mcu.engine.api import CpuEngine, Reg
from targets.mcu.errors import BusFault
from targets.mcu.services import BusMaster

__all__ = ["FRAME_SIZE", "TO_HANDLER", "TO_THREAD_MSP", "TO_THREAD_PSP", "pull", "push", "restore"]

TO_HANDLER, TO_THREAD_MSP, TO_THREAD_PSP = 0xFFFF_FFF1, 0xFFFF_FFF9, 0xFFFF_FFFD
"""The values of EXC_RETURN of a core without floating point (DDI0403 table B1-8)."""

FRAME_SIZE = 32
_FRAME_WORDS = 8
_WORD = 0xFFFF_FFFF
_IPSR = 0x1FF
_SPSEL = 1 << 1
_ALIGNED = 1 << 9
_STACKED = (Reg.R0, Reg.R1, Reg.R2, Reg.R3, Reg.R12, Reg.LR, Reg.PC)


def push(cpu: CpuEngine, bus: BusMaster, *, align: bool) -> tuple[int, bool]:
    """Put a frame on the stack in use and move its pointer.

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
    padding = top & 4 if align else 0
    frame = top - FRAME_SIZE - padding & _WORD
    words = cpu.get_many(_STACKED)
    words.append(xpsr & ~_ALIGNED | (_ALIGNED if padding else 0))
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
    frame = cpu.get(_bank(exc_return))
    return bus.read_words(frame, _FRAME_WORDS)


def restore(cpu: CpuEngine, words: list[int], exc_return: int, *, align: bool) -> None:
    """Take the frame with these words off its stack and go on from it."""
    bank = _bank(exc_return)
    top = cpu.get(bank) + FRAME_SIZE & _WORD
    words[6] &= ~1
    cpu.set_many(_STACKED, words[:7])
    cpu.set(Reg.XPSR, words[7] & ~_ALIGNED)
    # after XPSR: in handler mode SPSEL cannot be set
    control = cpu.get(Reg.CONTROL)
    wanted = control | _SPSEL if exc_return == TO_THREAD_PSP else control & ~_SPSEL
    if wanted != control:
        cpu.set(Reg.CONTROL, wanted)
    cpu.set(bank, top | (4 if align and words[7] & _ALIGNED else 0))


def _bank(exc_return: int) -> Reg:
    return Reg.PSP if exc_return == TO_THREAD_PSP else Reg.MSP
