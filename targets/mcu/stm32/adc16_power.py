"""How a 16-bit ADC wakes up: deep power-down, regulator, calibration, and ADRDY (RM0433 sections 25.4.6 to 25.4.9).

CR has bits that software sets and hardware clears. Choices where the manual is silent:

* ADSTP, JADSTP and ADDIS take effect at once, so nobody ever reads them as set; ADDIS clears ADRDY.
* ADEN and ADCAL in deep power-down, and ADCAL while ADEN is set, have no effect; that is noted.
* Both parts of a calibration follow each other, and its factors are 0: the converter is ideal.
* LDORDY follows ADVREGEN after the typical time.
"""

from __future__ import annotations

from collections.abc import Callable, MutableMapping
from fractions import Fraction

from targets.mcu.stm32.adc16_registers import (
    ADCAL,
    ADCALLIN,
    ADEN,
    ADRDY,
    ADVREGEN,
    CALFACT,
    CALFACT2,
    CR,
    DEEPPWD,
    ISR,
    LDORDY,
    LINCALRDYW,
)
from targets.mcu.stm32.clocked_wait import ClockedWait
from targets.mcu.stm32.converters import Note
from targets.mcu.timebase import Event, Timebase

__all__ = ["CALIBRATION_CLOCKS", "LINEARITY_CLOCKS", "REGULATOR_S", "STABILISATION_CLOCKS", "Power"]

REGULATOR_S = Fraction(5, 1_000_000)
"""t_ADCVREG_STUP, typical (DS12117, ADC characteristics); 10 us at most."""
CALIBRATION_CLOCKS = 1_280
"""t_OFF_CAL, the offset alone (DS12117, ADC characteristics)."""
LINEARITY_CLOCKS = 165_010
"""t_CAL, offset and linearity, with ADCALLIN."""
STABILISATION_CLOCKS = 10
"""t_STAB: one conversion (DS12117); the shortest of 16 bits is meant here (choice)."""

_WORDS = 6  # of the linearity factor
_FIRST_WORD = 22  # the bit LINCALRDYW1 of CR


class Power:
    """See the module.

    Args:
        time: the chip's cycles and events.
        values: the registers of the converter, by offset.
        note: notes something about a register.

    Attributes:
        on_flags: called when ADRDY was set.
        wait: what counts clocks of the converter for this.
    """

    def __init__(self, time: Timebase, values: MutableMapping[int, int], note: Note) -> None:
        self.on_flags: Callable[[], None] = lambda: None
        self.wait = ClockedWait(time)
        self._time = time
        self._values = values
        self._note = note
        self._regulator: Event | None = None
        self._linearity = [0] * _WORDS

    def reset(self) -> None:
        """Go to the state after reset."""
        self._time.cancel(self._regulator)
        self.wait.stop()
        self._linearity = [0] * _WORDS

    def set_supply(self, value: int) -> None:
        """Take DEEPPWD and ADVREGEN from a word for CR."""
        before = self._values[CR]
        if value & DEEPPWD:
            value &= ~ADVREGEN
        self._values[CR] = before & ~(DEEPPWD | ADVREGEN) | value & (DEEPPWD | ADVREGEN)
        if value & ~before & ADVREGEN:
            self._regulator = self._time.at_time(self._time.seconds(self._time.now) + REGULATOR_S, self._supplied)
        elif before & ~value & ADVREGEN:
            self._time.cancel(self._regulator)
            self._values[ISR] &= ~LDORDY
            if before & (ADEN | ADCAL):
                self._note("misuse", "CR.ADVREGEN", "the supply was switched off while the converter needs it")
            self.switch_off()

    def _supplied(self) -> None:
        self._values[ISR] |= LDORDY

    def _is_supplied(self, field: str) -> bool:
        if not self._values[CR] & ADVREGEN:
            self._note("misuse", f"CR.{field}", "without its voltage regulator (ADVREGEN) the converter does nothing")
            return False
        if not self._values[ISR] & LDORDY:
            self._note("misuse", f"CR.{field}", "set before the voltage regulator was ready (LDORDY, 10 us at most)")
        return True

    def switch_on(self) -> None:
        """ADEN was written."""
        if self._values[CR] & ADCAL:
            self._note("misuse", "CR.ADEN", "written during a calibration: it has no effect")
        elif not self._values[CR] & ADEN and self._is_supplied("ADEN"):
            self._values[CR] |= ADEN
            self.wait.start(STABILISATION_CLOCKS, self._ready)

    def _ready(self) -> None:
        self._values[ISR] |= ADRDY
        self.on_flags()

    def switch_off(self) -> None:
        """ADDIS was written, or the supply has gone."""
        self.wait.stop()
        self._values[CR] &= ~(ADEN | ADCAL)
        self._values[ISR] &= ~ADRDY

    def calibrate(self) -> None:
        """ADCAL was written."""
        if self._values[CR] & ADEN:
            self._note("misuse", "CR.ADCAL", "written while ADEN is set: no calibration begins")
        elif not self._values[CR] & ADCAL and self._is_supplied("ADCAL"):
            linear = self._values[CR] & ADCALLIN
            self._values[CR] |= ADCAL
            self.wait.start(LINEARITY_CLOCKS if linear else CALIBRATION_CLOCKS, self._calibrated)

    def _calibrated(self) -> None:
        self._values[CR] &= ~ADCAL
        self._values[CALFACT] = 0
        if self._values[CR] & ADCALLIN:
            self._linearity = [0] * _WORDS
            self._values[CR] |= LINCALRDYW

    def move_linearity(self, value: int) -> None:
        """Let LINCALRDYW1 to 6 of a word for CR move words of the factor: set writes one, cleared reads it."""
        before = self._values[CR]
        for word in range(_WORDS):
            bit = 1 << _FIRST_WORD + word
            if value & ~before & bit:
                self._linearity[word] = self._values[CALFACT2]
            elif before & ~value & bit:
                self._values[CALFACT2] = self._linearity[word]
        self._values[CR] = before & ~LINCALRDYW | value & LINCALRDYW
