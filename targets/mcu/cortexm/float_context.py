"""What becomes of a floating-point context at exception entry and return (DDI0403 sections B1.5.6 to B1.5.8).

Choices: 9 cycles more where 17 words go to the stack or come from it at once, two in a cycle; none for room that is
only reserved. If CPACR denies floating point by the time a context is stacked at once, a UsageFault (NOCP) comes before
the handler, as in QEMU; that the context is in the frame all the same is a choice: QEMU leaves what was in memory.
"""

from __future__ import annotations

from collections.abc import Callable

from targets.mcu.cortexm import frame
from targets.mcu.cortexm.fpu import FPCA, Fpu
from targets.mcu.engine.api import CpuEngine, FloatAccess, Reg
from targets.mcu.services import BusMaster

__all__ = ["FLOAT_CYCLES", "FloatContext"]

FLOAT_CYCLES = 9

_IN_FRAME = 16  # S0 to S15
_FPSCR = 32
_NPRIV, _IPSR = 1 << 0, 0x1FF


class FloatContext:
    """Moves floating-point registers between the CPU and frames.

    Args:
        cpu: has the registers.
        bus: memory.
        fpu: the registers that a program sees.
        access: returns CPACR.CP10.
    """

    def __init__(self, cpu: CpuEngine, bus: BusMaster, fpu: Fpu, access: Callable[[], int]) -> None:
        self._cpu = cpu
        self._bus = bus
        self._fpu = fpu
        self._access = access
        self._fpscr = 0  # as it is when a context begins
        fpu.on_change = self.choose

    def reset(self) -> None:
        """Begin anew: FPSCR is zero, the registers keep what is in them, which silicon leaves unknown."""
        floats = self._cpu.get_floats()
        floats[_FPSCR] = self._fpscr = 0
        self._cpu.set_floats(floats)
        self.choose()

    def choose(self) -> None:
        """Tell the CPU how a context begins."""
        fpu = self._fpu
        self._cpu.set_float_context(automatic=fpu.automatic, fpscr=fpu.status_in_new_context(self._fpscr))

    def choose_access(self) -> None:
        """Tell the CPU who may use floating point: 2, which is reserved, is nobody (choice; QEMU too)."""
        access = self._access()
        self._cpu.set_float_access(FloatAccess.NOBODY if access == 2 else FloatAccess(access))

    def allowed(self) -> bool:
        """Say whether the code that runs may use floating point."""
        cpu, access = self._cpu, self._access()
        if access != FloatAccess.PRIVILEGED:
            return access == FloatAccess.EVERYBODY
        return bool(cpu.get(Reg.XPSR) & _IPSR) or not cpu.get(Reg.CONTROL) & _NPRIV

    # --- entry

    def to_stack(self) -> list[int] | None:
        """Return S0 to S15 and FPSCR if they belong into the frame, or None."""
        control = self._cpu.get(Reg.CONTROL)
        self._fpu.settle(control)
        if not control & FPCA:
            return None
        floats = self._cpu.get_floats()
        self._end(floats[_FPSCR])
        return [*floats[:_IN_FRAME], floats[_FPSCR]]

    def not_storable(self) -> bool:
        """Say whether registers are stacked at once, and the code that runs may not use them (``CheckVFPEnabled``)."""
        return not self._fpu.lazy and not self.allowed()

    def stacked(self, exc_return: int, ready: int) -> int:
        """They are in the frame that `exc_return` names; return the cycles that this has taken.

        Args:
            exc_return: of the exception that is entered.
            ready: see `Fpu.reserve`.
        """
        if not self._fpu.lazy:
            return FLOAT_CYCLES
        cpu = self._cpu
        thread = not cpu.get(Reg.XPSR) & _IPSR
        privileged = not thread or not cpu.get(Reg.CONTROL) & _NPRIV
        place = cpu.get(frame.bank_of(exc_return)) + frame.FLOATS_AT
        self._fpu.reserve(place, thread=thread, privileged=privileged, ready=ready)
        return 0

    # --- return

    def returning(self, exc_return: int) -> int:
        """A handler returns; return the cycles that its floating-point registers will take."""
        cpu = self._cpu
        control = cpu.get(Reg.CONTROL)
        self._fpu.settle(control)
        if control & FPCA:
            self._end(cpu.get_floats()[_FPSCR])
        return 0 if exc_return & frame.BASIC or self._fpu.preserving else FLOAT_CYCLES

    def denied(self, exc_return: int) -> bool:
        """Say whether registers would have to come from the frame, but nobody may use them (``CheckVFPEnabled``)."""
        return not exc_return & frame.BASIC and not self._fpu.preserving and not self._access()

    def restore(self, exc_return: int) -> None:
        """Take the registers back from the frame that `exc_return` names, if they are not what they were.

        Raises:
            BusFault: the stack cannot be read.
        """
        if exc_return & frame.BASIC:
            return
        if self._fpu.preserving:
            self._fpu.take_back()
            return
        *words, fpscr = frame.pull_floats(self._cpu, self._bus, exc_return)
        floats = self._cpu.get_floats()
        floats[:_IN_FRAME], floats[_FPSCR] = words, fpscr
        self._cpu.set_floats(floats)

    def _end(self, fpscr: int) -> None:
        """A context ends with this FPSCR: the next one begins with its flags."""
        if fpscr != self._fpscr:
            self._fpscr = fpscr
            self.choose()
