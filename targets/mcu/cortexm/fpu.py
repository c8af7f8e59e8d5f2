"""Floating point as the system control space shows it (DDI0403 sections B3.2.20 to B3.2.23, B4.7), and its contexts.

A context begins with the first floating-point instruction (CONTROL.FPCA), and an exception that interrupts one reserves
room for it in its frame. With FPCCR.LSPEN the registers go there only when the handler uses floating point itself
(``PreserveFPState``); until then FPCCR.LSPACT is set.

Here they are written into the frame at once, and LSPACT is what it would be: it goes away with the first floating-point
instruction, which is seen in CONTROL.FPCA. So a program can tell the difference only by reading the reserved words
before that instruction: it finds the registers where silicon leaves what was on the stack before.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from targets.mcu.cortexm.kinds import FpuKind
from targets.mcu.cortexm.ppb import LaneBlock
from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.services import Services

__all__ = ["FPCA", "Fpu"]

FPCA = 1 << 2
"""CONTROL.FPCA: there is a floating-point context."""

_FPCCR, _FPCAR, _FPDSCR, _MVFR = 0xF34, 0xF38, 0xF3C, 0xF40
_ASPEN, _LSPEN, _LSPACT = 1 << 31, 1 << 30, 1 << 0
_STATUS = 0x16B  # MONRDY, BFRDY, MMRDY, THREAD, USER, LSPACT; and HFRDY:
_HFRDY = 1 << 4
_DEFAULTS = 0x07C0_0000  # AHP, DN, FZ, RMode


class Fpu(LaneBlock):
    """FPCCR, FPCAR, FPDSCR, MVFR0 to MVFR2.

    Args:
        kind: what floating point there is.
        control: returns CONTROL.

    Attributes:
        on_change: called when ASPEN or FPDSCR changes.
    """

    def __init__(self, base: int, services: Services, kind: FpuKind, control: Callable[[], int]) -> None:
        self._kind = kind
        self._control = control
        self.on_change: Callable[[], None] = lambda: None
        super().__init__("FPU", base, services)

    def registers_of(self) -> Iterable[Register]:
        """Return the registers, with the features that there are."""
        at_once = "the registers are in the frame before LSPACT goes away; an access that fails is STKERR, not LSPERR"
        return (
            Register(
                "FPCCR",
                _FPCCR,
                _ASPEN | _LSPEN,
                _ASPEN | _LSPEN | _STATUS | _HFRDY,
                fidelity=Fidelity.PARTLY,
                note=at_once,
            ),
            Register("FPCAR", _FPCAR, 0, 0xFFFF_FFF8),
            Register("FPDSCR", _FPDSCR, 0, _DEFAULTS),
            *(Register(f"MVFR{index}", _MVFR + 4 * index, value, 0) for index, value in enumerate(self._kind.mvfr)),
        )

    # --- what the core asks

    @property
    def automatic(self) -> bool:
        """FPCCR.ASPEN: the first floating-point instruction sets CONTROL.FPCA."""
        return bool(self[_FPCCR] & _ASPEN)

    @property
    def lazy(self) -> bool:
        """FPCCR.LSPEN."""
        return bool(self[_FPCCR] & _LSPEN)

    def status_in_new_context(self, fpscr: int) -> int:
        """Return FPSCR at the beginning of a context, from what it is: FPDSCR gives modes, the flags stay."""
        return fpscr & ~_DEFAULTS | self[_FPDSCR]

    def settle(self, control: int) -> None:
        """Take notice of CONTROL: if there is a context, what was to be preserved has been."""
        if control & FPCA:
            self[_FPCCR] &= ~_LSPACT

    def reserve(self, frame: int, *, thread: bool, privileged: bool, ready: int) -> None:
        """Note the room for a context in a frame that is not filled yet (``UpdateFPCCR``).

        Args:
            frame: address of the room.
            thread: it is that of Thread mode.
            privileged: it is that of privileged software.
            ready: HFRDY, BFRDY, MMRDY and MONRDY, in their places.
        """
        kept = self[_FPCCR] & (_ASPEN | _LSPEN)
        self[_FPCCR] = kept | ready | thread << 3 | (not privileged) << 1 | _LSPACT
        self[_FPCAR] = frame & ~7

    @property
    def preserving(self) -> bool:
        """FPCCR.LSPACT, if `settle` has been called: the registers are still those of the frame with the room."""
        return bool(self[_FPCCR] & _LSPACT)

    def take_back(self) -> None:
        """The frame with the room is taken off."""
        self[_FPCCR] &= ~_LSPACT

    # --- registers

    def read_FPCCR(self) -> int:
        """Return modes and state."""
        self.settle(self._control())
        return self[_FPCCR]

    def write_FPCCR(self, value: int) -> None:
        """Choose how contexts are kept."""
        self[_FPCCR] = value
        self.on_change()

    def write_FPDSCR(self, value: int) -> None:
        """Set the modes of new contexts."""
        self[_FPDSCR] = value
        self.on_change()
