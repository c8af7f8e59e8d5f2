"""ADC1 and ADC2 of an STM32F103 together: what a start of ADC1 means in the dual modes (RM0008 section 11.9).

ADC1 is the master: its triggers start both. What ADC2 has converted stands in the upper half of ADC1_DR.

Choices where the manual is silent:

* ADC2 takes part if it is on and triggers are enabled there (EXTTRIG, JEXTTRIG), as the manual demands; else ADC1 goes
  alone, which is noted. A trigger of its own starts ADC2 as ever; the manual calls it spurious.
* In simultaneous modes each converter goes through its group at its own pace: with the same sampling times, which the
  manual demands, they go together.
* Interleaved modes that an injected group has broken off go on as each converter does by itself, so that their distance
  is not what it was; the first time that this may happen is noted.
* The turn of alternate triggers begins with ADC1 when the mode is chosen.
"""

from __future__ import annotations

from collections.abc import Callable

from targets.mcu.stm32.adc_unit import CR1, CR2
from targets.mcu.stm32f1.adc_unit import EXTTRIG, JEXTTRIG, F1Unit
from targets.mcu.timebase import Event, Timebase

__all__ = ["Dual"]

_SIMULTANEOUS, _FAST, _SLOW = frozenset({1, 2, 6}), frozenset({3, 7}), frozenset({4, 8})
_INJECTED_TOO, _ALTERNATE, _BROKEN_OFF = frozenset({1, 3, 4, 5}), frozenset({2, 9}), frozenset({3, 4})
_LAST_MODE = 9
_FAST_CLOCKS, _SLOW_CLOCKS = 7, 14


class Dual:
    """See the module.

    Args:
        master: ADC1.
        slave: ADC2.
        time: of the chip.
        note: notes something about a register of ADC1.
    """

    def __init__(self, master: F1Unit, slave: F1Unit, time: Timebase, note: Callable[[str, str, str], None]) -> None:
        self._master, self._slave = master, slave
        self._time = time
        self._note = note
        self._turn = False
        self._later: Event | None = None
        master.on_regular = self._regular
        master.on_injected = self._injected

    @property
    def mode(self) -> int:
        """DUALMOD of ADC1; 0 where both are independent."""
        return self._master.values[CR1] >> 16 & 0xF

    def mode_changed(self) -> None:
        """DUALMOD was written with another value."""
        self._time.cancel(self._later)
        self._later = None
        self._turn = False
        for unit in (self._master, self._slave):
            unit.hold(False)
        if self.mode > _LAST_MODE:
            self._note("reserved", "CR1.DUALMOD", f"the mode {self.mode:#06b} is reserved: ADC1 works alone")
        if self.mode in _BROKEN_OFF:
            text = "an interleaved mode that an injected group breaks off goes on with another distance"
            self._note("unmodelled", "CR1.DUALMOD", text)

    def second_half(self, value: int) -> int:
        """Return ADC1_DR with what ADC2 has converted."""
        return value & 0xFFFF | (self._slave.values[0x4C] << 16 if self.mode else 0)

    # --- regular groups

    def _regular(self, start: Callable[[], None]) -> None:
        mode = self.mode
        if mode in _SLOW and self._later is None:
            self._interleave(slave=self._takes_part(EXTTRIG, "EXTTRIG"))
        elif mode in _FAST and self._takes_part(EXTTRIG, "EXTTRIG"):
            self._slave.start_regular()
            self._later = self._time.after(_FAST_CLOCKS * self._master.clock_cycles, self._master.start_regular)
        elif mode not in _SLOW:
            if mode in _SIMULTANEOUS and self._takes_part(EXTTRIG, "EXTTRIG"):
                self._slave.start_regular()
            start()

    def _interleave(self, *, slave: bool) -> None:
        """Let the one convert, and the other 14 clocks later, until one is switched off."""
        self._later = None
        if not (self._master.on and self._slave.on and self._master.clock_cycles):
            return
        (self._slave if slave else self._master).start_regular()
        again = self._time.after(_SLOW_CLOCKS * self._master.clock_cycles, lambda: self._interleave(slave=not slave))
        self._later = again

    # --- injected groups

    def _injected(self, start: Callable[[], None]) -> None:
        mode = self.mode
        if mode in _ALTERNATE and self._takes_part(JEXTTRIG, "JEXTTRIG"):
            self._alternate(start)
            return
        if mode in _INJECTED_TOO and self._takes_part(JEXTTRIG, "JEXTTRIG"):
            self._slave.start_injected()
        start()

    def _alternate(self, start: Callable[[], None]) -> None:
        unit, other = (self._slave, self._master) if self._turn else (self._master, self._slave)
        if unit.injecting:
            return
        self._turn = not self._turn
        if self.mode == 2:  # the regular groups, which go together, stop together
            other.hold(True)
            unit.on_injected_end = lambda: other.hold(False)
        if unit is self._master:
            start()
        else:
            unit.start_injected()

    def _takes_part(self, enable: int, bit: str) -> bool:
        if self._slave.on and self._slave.values[CR2] & enable:
            return True
        self._note("misuse", "CR1.DUALMOD", f"ADC2 takes no part: it is off, or its {bit} is not set")
        return False
