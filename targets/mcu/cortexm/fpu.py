"""Floating point as the system control space shows it (DDI0403 sections B3.2.20 to B3.2.23, B4.7).

How its contexts are kept is in ``entry.c``, which has FPCCR, FPCAR and FPDSCR too. There the registers are written into
the frame at once: so a program can tell the difference to silicon only by reading the reserved words before the first
floating-point instruction of a handler.
"""

from __future__ import annotations

from collections.abc import Iterable

from targets.mcu.cortexm.kinds import FpuKind
from targets.mcu.cortexm.ppb import LaneBlock
from targets.mcu.engine.core_engine import CoreEngine
from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.services import Services

__all__ = ["FPSCR", "Fpu"]

FPSCR = 32
"""Its place among the words of `CpuEngine.get_floats`."""

_FPCCR, _FPCAR, _FPDSCR, _MVFR = 0xF34, 0xF38, 0xF3C, 0xF40
_ASPEN, _LSPEN = 1 << 31, 1 << 30
_STATUS = 0x16B  # MONRDY, BFRDY, MMRDY, THREAD, USER, LSPACT; and HFRDY:
_HFRDY = 1 << 4
_DEFAULTS = 0x07C0_0000  # AHP, DN, FZ, RMode


class Fpu(LaneBlock):
    """FPCCR, FPCAR, FPDSCR, MVFR0 to MVFR2.

    Args:
        kind: what floating point there is.
        engine: keeps the contexts.
    """

    def __init__(self, base: int, services: Services, kind: FpuKind, engine: CoreEngine) -> None:
        self._kind = kind
        self._engine = engine
        self._kept = engine.exceptions
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

    def reset(self) -> None:
        """Go to the state after reset, with FPSCR; S0 to S31 keep what is in them, which silicon leaves unknown."""
        super().reset()
        self._kept.fpccr = _ASPEN | _LSPEN
        self._kept.fpcar = self._kept.fpdscr = self._kept.last_fpscr = 0
        floats = self._engine.get_floats()
        floats[FPSCR] = 0
        self._engine.set_floats(floats)

    def other_lanes(self, offset: int) -> int:
        """Return the word that a narrow write to `offset` is merged into."""
        return self.read(offset)

    # --- registers

    def read_FPCCR(self) -> int:
        """Return modes and state; if there is a context by now, what was to be preserved has been."""
        self._engine.ask("hil_settle_floats")
        return int(self._kept.fpccr)

    def write_FPCCR(self, value: int) -> None:
        """Choose how contexts are kept."""
        self._kept.fpccr = value

    def read_FPCAR(self) -> int:
        """Return where the room for a context is."""
        return int(self._kept.fpcar)

    def write_FPCAR(self, value: int) -> None:
        """Keep an address; the next reserved room puts its own there."""
        self._kept.fpcar = value

    def read_FPDSCR(self) -> int:
        """Return the modes of new contexts."""
        return int(self._kept.fpdscr)

    def write_FPDSCR(self, value: int) -> None:
        """Set them."""
        self._kept.fpdscr = value
