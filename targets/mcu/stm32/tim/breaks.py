"""Break input, main output enable, dead time and locks of TIM1 (RM0008 sections 14.3.11, 14.3.12 and 14.4.18)."""

from __future__ import annotations

from collections.abc import Callable

from targets.mcu.services import InputSignal
from targets.mcu.stm32.tim.registers import AOE, BKE, BKP, MOE, OSSI, OSSR

__all__ = ["Breaks"]

_DTG, _LOCK = 0x00FF, 0x0300
_FROZEN_BY_LEVEL = (
    0,
    _DTG | BKE | BKP | AOE,
    _DTG | BKE | BKP | AOE | OSSI | OSSR,
    _DTG | BKE | BKP | AOE | OSSI | OSSR,
)


class Breaks:
    """What BDTR says.

    Args:
        signal: the break input.
        on_change: called with its new level while BKE is set; it is for the timer to count up to this cycle, and then
            to put it into `level`.

    Attributes:
        level: of the break input, while BKE is set.
        lock_level: LOCK, as written first after reset.
    """

    def __init__(self, signal: InputSignal, on_change: Callable[[bool], None]) -> None:
        self._signal = signal
        self._on_change = on_change
        self._bits = 0
        self.level = False
        self.lock_level = 0
        self._written = False

    @property
    def active(self) -> bool:
        """True while the enabled break input has its active level."""
        return bool(self._bits & BKE) and self.level is bool(self._bits & BKP)

    @property
    def waits_for_update(self) -> bool:
        """True if the next update event sets MOE."""
        return self._bits & (AOE | MOE) == AOE and not self.active

    def reset(self) -> None:
        """Go to the state after reset: unlocked, the break input off."""
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
        """Listen to the break input if BKE says so."""
        self._bits = bits
        listener = self._on_change if bits & BKE else None
        if self._signal.on_change != listener:
            self._signal.on_change = listener
            self.level = self._signal.level()

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
