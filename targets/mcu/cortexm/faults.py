"""What went wrong: the bits of the fault status registers by name, and records of faults and lockup for people."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from targets.mcu.cortexm.exceptions import Number

__all__ = ["Cfsr", "Fault", "Hfsr", "Lockup", "exception_name"]


class Cfsr(enum.IntFlag):
    """Configurable fault status (DDI0403 section B3.2.15): MMFSR, BFSR and UFSR in one word."""

    IACCVIOL = 1 << 0
    DACCVIOL = 1 << 1
    MUNSTKERR = 1 << 3
    MSTKERR = 1 << 4
    MMARVALID = 1 << 7
    IBUSERR = 1 << 8
    PRECISERR = 1 << 9
    IMPRECISERR = 1 << 10
    UNSTKERR = 1 << 11
    STKERR = 1 << 12
    BFARVALID = 1 << 15
    UNDEFINSTR = 1 << 16
    INVSTATE = 1 << 17
    INVPC = 1 << 18
    NOCP = 1 << 19
    UNALIGNED = 1 << 24
    DIVBYZERO = 1 << 25


class Hfsr(enum.IntFlag):
    """Hard fault status (DDI0403 section B3.2.16)."""

    VECTTBL = 1 << 1
    FORCED = 1 << 30
    DEBUGEVT = 1 << 31


_MEANING = {
    "IACCVIOL": "a jump to an address where nothing can be executed",
    "IBUSERR": "an instruction fetch from an address where nothing answers",
    "PRECISERR": "an access to an address where nothing answers",
    "UNSTKERR": "the stack could not be read at exception return",
    "STKERR": "the stack could not be written at exception entry",
    "UNDEFINSTR": "an undefined instruction",
    "INVSTATE": "a jump to an even address, which would leave Thumb state",
    "INVPC": "an exception return with a wrong EXC_RETURN, stack or exception number",
    "NOCP": "a coprocessor or floating point instruction, which the core does not have or CPACR does not allow",
    "UNALIGNED": "an unaligned access",
    "DIVBYZERO": "a division by zero",
    "VECTTBL": "the vector table could not be read",
    "DEBUGEVT": "a breakpoint instruction without a debugger",
    "SVC": "a supervisor call where its priority does not allow one",
}


def exception_name(number: int) -> str:
    """Return the name of an exception number, such as ``BusFault`` or ``IRQ 28``."""
    if number >= Number.FIRST_IRQ:
        return f"IRQ {number - Number.FIRST_IRQ}"
    names = {
        0: "Thread mode",
        Number.RESET: "Reset",
        Number.NMI: "NMI",
        Number.HARD_FAULT: "HardFault",
        Number.MEM_MANAGE: "MemManage",
        Number.BUS_FAULT: "BusFault",
        Number.USAGE_FAULT: "UsageFault",
        Number.SVCALL: "SVCall",
        Number.DEBUG_MONITOR: "DebugMonitor",
        Number.PENDSV: "PendSV",
        Number.SYSTICK: "SysTick",
    }
    return names.get(number, f"exception {number}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """A fault, as the core saw it.

    Attributes:
        exception: the exception that it makes pending; 0 if it locks the core up instead.
        origin: the exception that it is by nature; differs from `exception` if it was escalated to HardFault.
        causes: what the fault status registers say, by bit name (``PRECISERR``), or ``SVC`` for an escalated call.
        address: what was accessed, from BFAR; None if that does not apply.
        refusal: who refused the access and why; empty where nothing is.
        pc: the instruction that faulted; for INVPC, the exception return.
        lr: LR at that moment.
        sp: the stack pointer in use at that moment.
        xpsr: program status at that moment.
        running: exception number of the code that faulted, 0 for Thread mode.
        cycle: HCLK cycle.
        ns: bench time in nanoseconds.
    """

    exception: int
    origin: int
    causes: tuple[str, ...]
    address: int | None
    refusal: str
    pc: int
    lr: int
    sp: int
    xpsr: int
    running: int
    cycle: int
    ns: int

    @property
    def escalated(self) -> bool:
        """True if a fault with a handler of its own became a HardFault."""
        return self.exception != self.origin

    def describe(self) -> str:
        """Return one line for people."""
        what = " and ".join(_MEANING.get(cause, cause) for cause in self.causes)
        if self.refusal:
            what = f"an access that was refused: {self.refusal}"
        where = "" if self.address is None else f" (0x{self.address:08X})"
        name = exception_name(self.origin)
        if self.escalated and self.exception:
            name = f"{name}, escalated to {exception_name(self.exception)}"
        return f"{name} [{' '.join(self.causes)}] in {exception_name(self.running)} at 0x{self.pc:08X}: {what}{where}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Lockup:
    """The core has stopped for good: a fault while it ran at the priority of HardFault or NMI.

    Attributes:
        cause: one line for people.
        pc: the instruction at which it stopped; silicon shows 0xFFFFFFFE from then on.
        faults: what led there: faults whose handlers had not returned, the oldest first, and the last.
        cycle: HCLK cycle.
        ns: bench time in nanoseconds.
    """

    cause: str
    pc: int
    faults: tuple[Fault, ...]
    cycle: int
    ns: int
