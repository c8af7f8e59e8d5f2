"""What an engine that executes Thumb-2 instructions gives to the machine around it, and what it may not do.

Semantics are the same for every engine, whatever its speed:

1. Time is counted in HCLK cycles by the timing model, from instructions retired; never by the host.
2. An access to a register sees `cycle` at which its instruction began.
3. A slice ends at the first instruction boundary at or after its limit. The instructions of an IT block are one
   instruction in this sense: a slice never ends inside one.
4. A limit lowered while the slice runs (`stop_by`) counts from the instruction in flight on.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

__all__ = ["FLOAT_WORDS", "Access", "CpuEngine", "FaultKind", "FloatAccess", "Reg", "Stop", "StopKind"]

FLOAT_WORDS = 33
"""S0 to S31, of which D0 to D15 are pairs, and FPSCR."""


class Reg(enum.IntEnum):
    """Core registers. SP is the one in use; MSP and PSP name the banks."""

    R0 = 0
    R1 = 1
    R2 = 2
    R3 = 3
    R4 = 4
    R5 = 5
    R6 = 6
    R7 = 7
    R8 = 8
    R9 = 9
    R10 = 10
    R11 = 11
    R12 = 12
    SP = 13
    LR = 14
    PC = 15
    XPSR = 16
    MSP = 17
    PSP = 18
    PRIMASK = 19
    BASEPRI = 20
    FAULTMASK = 21
    CONTROL = 22


class FloatAccess(enum.IntEnum):
    """Who may execute floating-point instructions: the values of CPACR.CP10 (DDI0403 section B3.2.20)."""

    NOBODY = 0
    PRIVILEGED = 1
    EVERYBODY = 3


class StopKind(enum.Enum):
    """Why a slice ended."""

    LIMIT = "limit"
    WFI = "wfi"
    WFE = "wfe"
    SEV = "sev"
    SVC = "svc"
    BREAKPOINT = "breakpoint"
    EXCEPTION_RETURN = "exception-return"
    FAULT = "fault"
    TROUBLE = "trouble"
    STEP = "step"
    HIT = "hit"


class FaultKind(enum.Enum):
    """What an instruction could not do."""

    READ = "read"
    WRITE = "write"
    FETCH = "fetch"
    UNDEFINED = "undefined"
    STATE = "state"
    DIVISION = "division"
    UNALIGNED = "unaligned"


@dataclass(frozen=True, slots=True)
class Stop:
    """How a slice ended.

    Attributes:
        kind: why.
        value: the immediate of SVC and BKPT, EXC_RETURN of an exception return.
        fault: for `StopKind.FAULT`; PC is then the instruction that faulted and has not retired.
        address: what was accessed, for a fault of READ, WRITE, FETCH or UNALIGNED.
        refusal: who refused a READ or WRITE and why, as `BusFault` says.
    """

    kind: StopKind
    value: int = 0
    fault: FaultKind | None = None
    address: int = 0
    refusal: str = ""


@dataclass(frozen=True, slots=True)
class Access:
    """The two sides of a region of registers: called with the offset and 1, 2 or 4 bytes.

    Attributes:
        read: read them.
        write: write them.
        is_live: says whether what is at an offset may change with time alone, or by being read.
    """

    read: Callable[[int, int], int]
    write: Callable[[int, int, int], None]
    is_live: Callable[[int], bool] = lambda _offset: True


class CpuEngine(Protocol):
    """A CPU core without interrupts, exceptions or a system control space: those are the machine's."""

    @property
    def cycle(self) -> int:
        """The present HCLK cycle; within a register access, the one at which its instruction began."""

    def add_cycles(self, cycles: int) -> None:
        """Let cycles pass without an instruction: exception entry, sleep, a skipped loop. Not while running."""

    def set_wait_states(self, wait_states: int) -> None:
        """Change the flash wait states, from the instruction in flight on."""

    def skip_periods(self, cycle: int, instructions: int, cycles: int) -> None:
        """Account for loops that change nothing, as many whole ones as end before `cycle`. Not while running."""

    @property
    def instructions(self) -> int:
        """Instructions retired since the engine was made, counted as the engine counts them."""

    def get(self, register: Reg) -> int:
        """Return a core register, 32 bits."""

    def set(self, register: Reg, value: int) -> None:
        """Set a core register."""

    def get_many(self, registers: Sequence[Reg]) -> list[int]:
        """Return several core registers, without SP."""

    def set_many(self, registers: Sequence[Reg], values: Sequence[int]) -> None:
        """Set several of R0 to R12, LR and PC."""

    def map_memory(self, base: int, data: bytearray, *, writable: bool) -> None:
        """Put memory at `base`; `data` is shared with the caller, whose writes are seen at once (but see `forget`)."""

    def map_registers(self, base: int, size: int, access: Access) -> None:
        """Put registers at `base`; whole kilobytes."""

    def forget(self, base: int, size: int) -> None:
        """Memory that may hold code was changed by somebody else than the CPU: drop what was translated."""

    def set_traps(self, *, division: bool, unaligned: bool) -> None:
        """Let divisions by zero and unaligned accesses be faults, from the next slice on; end the running one."""

    def get_floats(self) -> list[int]:
        """Return S0 to S31 and FPSCR; only of a core that has them, as the next three."""

    def set_floats(self, words: Sequence[int]) -> None:
        """Set S0 to S31 and FPSCR. Not while running."""

    def set_float_access(self, access: FloatAccess) -> None:
        """Let floating-point instructions of others be UNDEFINED, from the next slice on; end the running one."""

    def run(self, limit_cycle: int, limit_instructions: int | None = None) -> Stop:
        """Execute up to `limit_cycle`, and no more than `limit_instructions`. At least one instruction is executed."""

    def stop_by(self, limit_cycle: int) -> None:
        """Lower the limit of the running slice, from within a register access; the past means: after this instruction.

        Outside of a run it has no effect.
        """
