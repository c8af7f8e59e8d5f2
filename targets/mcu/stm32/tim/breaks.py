"""Break inputs, main output enable, dead time and locks of the advanced timers.

RM0008 sections 14.3.11, 14.3.12 and 14.4.18; RM0410 section 25.3.16 (two inputs). The second input acts as the first
does; that it has a lower priority shows only in what the outputs become, which is the same here (choice).
"""

from __future__ import annotations

from collections.abc import Callable

from targets.mcu.services import InputSignal
from targets.mcu.stm32.tim.registers import AOE, B2IF, BIF, BK2E, BK2F, BK2P, BKE, BKF, BKP, MOE, OSSI, OSSR

__all__ = ["BreakInput", "Breaks"]

_DTG, _LOCK = 0x00FF, 0x0300
_INPUTS = BKE | BKP | AOE | BKF | BK2F | BK2E | BK2P
_FROZEN_BY_LEVEL = (0, _DTG | _INPUTS, _DTG | _INPUTS | OSSI | OSSR, _DTG | _INPUTS | OSSI | OSSR)


class BreakInput:
    """One break input.

    Args:
        signal: the input.
        on_change: called with it and its new level while it is enabled; it is for the timer to count up to this cycle,
            and then to put it into `level`.
        second: it is BRK2.

    Attributes:
        level: of the input, while it is enabled.
        flag: of SR.
    """

    def __init__(
        self, signal: InputSignal, on_change: Callable[[BreakInput, bool], None], *, second: bool = False
    ) -> None:
        self._signal = signal
        self._listener: Callable[[bool], None] = lambda level: on_change(self, level)
        self._enable, self._polarity, self.flag = (BK2E, BK2P, B2IF) if second else (BKE, BKP, BIF)
        self._bits = 0
        self.level = False

    @property
    def active(self) -> bool:
        """True while the input is enabled and has its active level."""
        return bool(self._bits & self._enable) and self.level is bool(self._bits & self._polarity)

    def configure(self, bits: int) -> None:
        """Listen to the input if BDTR says so."""
        self._bits = bits
        listener = self._listener if bits & self._enable else None
        if self._signal.on_change is not listener:
            self._signal.on_change = listener
            self.level = self._signal.level()


class Breaks:
    """What BDTR says.

    Args:
        inputs: the break inputs.

    Attributes:
        lock_level: LOCK, as written first after reset.
    """

    def __init__(self, *inputs: BreakInput) -> None:
        self._inputs = inputs
        self._bits = 0
        self.lock_level = 0
        self._written = False

    @property
    def active(self) -> int:
        """The flags of the inputs that are active; 0 for none."""
        return sum(one.flag for one in self._inputs if one.active)

    @property
    def waits_for_update(self) -> bool:
        """True if the next update event sets MOE."""
        return self._bits & (AOE | MOE) == AOE and not self.active

    def reset(self) -> None:
        """Go to the state after reset: unlocked, the break inputs off."""
        self._written = False
        self.lock_level = 0
        self.configure(0)

    def permitted(self, old: int, value: int) -> int:
        """Return what a write of `value` over `old` leaves: LOCK is written once, and freezes other bits.

        The bits of a write that sets LOCK are taken with it.
        """
        frozen = _FROZEN_BY_LEVEL[self.lock_level]
        if self._written:
            frozen |= _LOCK
        self._written = True
        value = value & ~frozen | old & frozen
        self.lock_level = value >> 8 & 3
        return value

    def configure(self, bits: int) -> None:
        """Take the inputs as BDTR has them."""
        self._bits = bits
        for one in self._inputs:
            one.configure(bits)

    def disable(self, bits: int) -> int:
        """Return BDTR after a break."""
        self._bits = bits & ~MOE
        return self._bits

    def enable(self) -> int:
        """Set MOE by hardware and return the bit."""
        self._bits |= MOE
        return MOE

    def enabled(self, bits: int) -> bool:
        """Return MOE."""
        return bool(bits & MOE)

    def off_states(self, bits: int) -> tuple[bool, bool]:
        """Return OSSR and OSSI."""
        return bool(bits & OSSR), bool(bits & OSSI)

    def dead_time(self, bits: int) -> int:
        """Return the dead time in tDTS, by DTG."""
        dtg = bits & _DTG
        if dtg < 0x80:
            return dtg
        if dtg < 0xC0:
            return (64 + (dtg & 0x3F)) * 2
        return (32 + (dtg & 0x1F)) * (8 if dtg < 0xE0 else 16)
