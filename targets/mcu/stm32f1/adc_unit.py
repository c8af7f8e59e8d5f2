"""One converter of an STM32F103 (RM0008 section 11), on what its family has in common with the later ones.

What is peculiar to it: a conversion takes the sampling time and 12.5 clocks; nothing remembers an overrun, the new
value stands in DR; ADON that is written as 1 again starts the regular group; software starts a group by SWSTART or
JSWSTART, one of the eight sources of EXTSEL and JEXTSEL, of whose edges the rising one counts; it is calibrated; and
ADC1 and ADC2 work together in the dual modes, which stand in `adc_dual`.

Choices, besides those of `targets.mcu.stm32.adc_unit`:

* The converter is ideal, calibrated or not: a calibration takes the 83 clocks of DS5319 and finds the code 0. RSTCAL
  takes 2 clocks. A calibration of a converter that is off takes as long, and is noted. A group that is to be started
  while one is under way is not, which is noted.
* A request is made at the end of a conversion alone: DMA that is set later asks for none of those before.
* EOC rises at the end of an injected group as well: its description in ADC_SR says "regular or injected".
* Without ADON a start has no effect; a start within 1 us of ADON (t_STAB) is noted.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial
from typing import ClassVar

from targets.mcu.registers import Register
from targets.mcu.services import DmaRequest
from targets.mcu.stm32.adc_format import BITS, aligned
from targets.mcu.stm32.adc_sequences import Group
from targets.mcu.stm32.adc_unit import (
    ADON,
    ALIGN,
    CONT,
    CR1,
    CR2,
    DISCEN,
    DMA,
    DR,
    EOC,
    JAUTO,
    JSQR,
    SQR1,
    SQR2,
    SQR3,
    SR,
    Unit,
)
from targets.mcu.stm32.converters import Ends
from targets.mcu.timebase import Event, Timebase

__all__ = ["EXTTRIG", "JEXTTRIG", "REGISTERS", "F1Unit", "RequestLine"]

CAL, RSTCAL = 1 << 2, 1 << 3
JEXTTRIG, EXTTRIG, JSWSTART, SWSTART, TSVREFE = 1 << 15, 1 << 20, 1 << 21, 1 << 22, 1 << 23
SOFTWARE = 7
"""Of EXTSEL and JEXTSEL."""
CALIBRATION_CLOCKS, RESET_CLOCKS = 83, 2

REGISTERS = (
    Register("SR", 0x00, 0, 0x1F),
    Register("CR1", 0x04, 0, 0x00CF_FFFF),
    Register("CR2", 0x08, 0, 0x00FE_F90F),
    Register("SMPR1", 0x0C, 0, 0x00FF_FFFF),
    Register("SMPR2", 0x10, 0, 0x3FFF_FFFF),
    *(Register(f"JOFR{number}", 0x10 + 4 * number, 0, 0xFFF) for number in range(1, 5)),
    Register("HTR", 0x24, 0xFFF, 0xFFF),
    Register("LTR", 0x28, 0, 0xFFF),
    Register("SQR1", 0x2C, 0, 0x00FF_FFFF),
    Register("SQR2", 0x30, 0, 0x3FFF_FFFF),
    Register("SQR3", 0x34, 0, 0x3FFF_FFFF),
    Register("JSQR", 0x38, 0, 0x003F_FFFF),
    *(Register(f"JDR{number}", 0x38 + 4 * number, 0, 0) for number in range(1, 5)),
    Register("DR", DR, 0, 0),
)


class RequestLine:
    """A DMA request that is kept as a level; that of ADC2, which has none, leads nowhere.

    Attributes:
        level: as last set.
        on_last: nobody calls it: no controller of this chip says which transfer was its last.
    """

    def __init__(self, line: DmaRequest | None) -> None:
        self.level = False
        self.on_last: Callable[[], None] | None = None
        self._line = line

    def set(self, level: bool) -> None:
        """Drive the request."""
        self.level = level
        if self._line is not None:
            self._line.set(level)


class F1Unit(Unit):
    """See the module, and `Unit`.

    Attributes:
        on_regular: called when the regular group was started, with what starts it here; another may start it otherwise.
        on_injected: the same for the injected group.
        on_injected_end: called when a trigger's share of the injected group is through.
        held: nothing new is begun: another converter has the turn.
    """

    REGISTERS = REGISTERS
    SAMPLING_HALVES: ClassVar[Sequence[int]] = (3, 15, 27, 57, 83, 111, 143, 479)
    STABILISATION_S = Fraction(1, 1_000_000)

    on_regular: Callable[[Callable[[], None]], None] = staticmethod(lambda start: start())
    on_injected: Callable[[Callable[[], None]], None] = staticmethod(lambda start: start())
    on_injected_end: Callable[[], None] = staticmethod(lambda: None)
    held = False

    def __init__(self, name: str, time: Timebase, ends: Ends) -> None:
        super().__init__(name, time, ends)
        self._calibrations: dict[int, Event] = {}

    def reset(self) -> None:
        """Go to the state after reset."""
        for event in self._calibrations.values():
            self._time.cancel(event)
        self._calibrations.clear()
        self.held = False
        super().reset()

    # --- what it is asked for

    def write(self, offset: int, value: int) -> None:
        """Write a register; another sequence begins the group under way anew (RM0008 section 11.3.3)."""
        before = self.values[offset]
        super().write(offset, value)
        if value == before:
            return
        if offset in (SQR1, SQR2, SQR3):
            self._begin_anew(self._regular, super()._start_regular)
        elif offset == JSQR:
            self._begin_anew(self._injected, super()._start_injected)

    def _begin_anew(self, group: Group, start: Callable[[], None]) -> None:
        if not group.active:
            return
        group.reset()
        if self._converting is group:
            self._time.cancel(self._event)
            self._converting = None
        start()
        self._update()

    def start_regular(self) -> None:
        """Start the regular group, if it is not under way."""
        self._start_regular()
        self._update()

    def start_injected(self) -> None:
        """Start the injected group, if it is not under way."""
        self._start_injected()
        self._update()

    def hold(self, held: bool) -> None:
        """Break off a regular conversion and begin nothing, or go on."""
        if held is self.held:
            return
        self.held = held
        if not held:
            self._proceed()
        elif self._converting is self._regular:
            self._time.cancel(self._event)
            self._converting = None

    @property
    def on(self) -> bool:
        """Whether it is powered."""
        return bool(self.values[CR2] & ADON)

    @property
    def injecting(self) -> bool:
        """Whether an injected group is under way."""
        return self._injected.active

    def _conversion_halves(self, bits: int) -> int:
        return 2 * bits + 1

    # --- ADC_CR2

    def _write_control(self, value: int) -> None:
        before = self.values[CR2]
        self.values[CR2] = before & (CAL | RSTCAL) | value & ~(CAL | RSTCAL | SWSTART | JSWSTART)
        if not value & ADON:
            self._power_off()
        elif not before & ADON:
            self._switched_on()
        if not value & DMA:
            self._unread = False
        self._calibrate(value & ~before)
        self._listen()
        starts = value & before & ADON
        if value & (SWSTART | JSWSTART) and not starts:
            self._note("misuse", "CR2.SWSTART", "a start together with ADON, or without, has no effect")
        if starts and value == before:
            self.on_regular(self._start_regular)
        if starts and value & JSWSTART:
            self._by_software(value & JEXTTRIG, value >> 12, "JSWSTART", self.on_injected, self._start_injected)
        if starts and value & SWSTART:
            self._by_software(value & EXTTRIG, value >> 17, "SWSTART", self.on_regular, self._start_regular)

    def _by_software(
        self,
        enabled: int,
        source: int,
        bit: str,
        tell: Callable[[Callable[[], None]], None],
        start: Callable[[], None],
    ) -> None:
        if enabled and source & 7 == SOFTWARE:
            tell(start)
        else:
            text = f"{bit} starts nothing: it has to be the trigger that is chosen, and triggers have to be enabled"
            self._note("misuse", f"CR2.{bit}", text)

    def _calibrate(self, rising: int) -> None:
        for bit, clocks in ((RSTCAL, RESET_CLOCKS), (CAL, CALIBRATION_CLOCKS)):
            if rising & bit:
                if not self.on:
                    self._note("misuse", "CR2.CAL", "a converter has to be on for two of its clocks to be calibrated")
                self.values[CR2] |= bit
                end = self._time.after(clocks * max(self.clock_cycles, 1), partial(self._calibrated, bit))
                self._calibrations[bit] = end

    def _calibrated(self, bit: int) -> None:
        self.values[CR2] &= ~bit
        if bit == CAL:
            self.values[DR] = 0
        self._calibrations.pop(bit)

    # --- triggers

    def _listen(self) -> None:
        control = self.values[CR2]
        for shift, enable, signals, hear in (
            (17, EXTTRIG, self._ends.triggers, self._regular_edge),
            (12, JEXTTRIG, self._ends.injected_triggers, self._edge),
        ):
            source = control >> shift & 7
            wanted = control & ADON and control & enable
            for number, signal in signals.items():
                callback = hear if wanted and number == source else None
                if signal.on_change != callback:
                    signal.on_change = callback
            if wanted and source != SOFTWARE and source not in signals:
                where = "CR2.EXTSEL" if shift == 17 else "CR2.JEXTSEL"
                self._note("unmodelled", where, f"trigger {source} is not modelled: it never comes")

    def _regular_edge(self, level: bool) -> None:
        if level:
            self.on_regular(self._start_regular)
            self._update()

    def _edge(self, level: bool) -> None:
        if level:
            self.on_injected(self._start_injected)
            self._update()

    def _may_start(self) -> bool:
        if self._calibrations:
            self._note("misuse", "CR2.CAL", "a conversion was started during the calibration: it is not made")
        return self.on and not self._calibrations

    def _start_regular(self) -> None:
        if self._may_start():
            super()._start_regular()

    def _start_injected(self) -> None:
        if self._may_start():
            super()._start_injected()

    # --- conversions

    def _proceed(self) -> None:
        if not self.held:
            super()._proceed()

    def _keep_injected(self) -> None:
        super()._keep_injected()
        if not self._injected.active:
            if self._injected.over:
                self.values[SR] |= EOC
            self.on_injected_end()

    def _keep_regular(self) -> None:
        cr1, cr2 = self.values[CR1], self.values[CR2]
        self.values[DR] = aligned(self._sampled, BITS[0], left=bool(cr2 & ALIGN))
        self._unread = bool(cr2 & DMA)
        self._regular.advance()
        ended = not self._regular.active
        if ended or cr1 & DISCEN:
            self.values[SR] |= EOC
        if ended and self._regular.over:
            self._sequence_over(cr1, cr2)

    def _sequence_over(self, cr1: int, cr2: int) -> None:
        if cr1 & JAUTO:
            super()._start_injected()
        if cr2 & CONT and not cr1 & DISCEN:
            super()._start_regular()
