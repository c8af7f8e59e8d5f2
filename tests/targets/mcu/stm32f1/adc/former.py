"""A converter of an F103 as it was in Python, without triggers and dual modes: what that in C is held against."""

from __future__ import annotations

from functools import partial

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

__all__ = ["Former"]

CAL, RSTCAL, JSWSTART, SWSTART = 1 << 2, 1 << 3, 1 << 21, 1 << 22
BY_SOFTWARE, INJECTED_BY_SOFTWARE = 7 << 17 | 1 << 20, 7 << 12 | 1 << 15
SAMPLING_HALVES = (3, 15, 27, 57, 83, 111, 143, 479)


class Former(Unit):
    """See the module."""

    def __init__(self, name, time, ends):
        super().__init__(name, time, ends)
        self._calibrations = {}

    def write(self, offset, value):
        before = self.values[offset]
        super().write(offset, value)
        if value != before and offset in (SQR1, SQR2, SQR3):
            self._begin_anew(self._regular, super()._start_regular)
        elif value != before and offset == JSQR:
            self._begin_anew(self._injected, super()._start_injected)

    def _begin_anew(self, group, start):
        if not group.active:
            return
        group.reset()
        if self._converting is group:
            self._time.cancel(self._event)
            self._converting = None
        start()
        self._update()

    def _write_control(self, value):
        before = self.values[CR2]
        self.values[CR2] = before & (CAL | RSTCAL) | value & ~(CAL | RSTCAL | SWSTART | JSWSTART)
        if not value & ADON:
            self._power_off()
        if not value & DMA:
            self._unread = False
        for bit, clocks in ((RSTCAL, 2), (CAL, 83)):
            if value & ~before & bit:
                self.values[CR2] |= bit
                self._calibrations[bit] = self._time.after(
                    clocks * max(self.clock_cycles, 1), partial(self._calibrated, bit)
                )
        if not value & before & ADON:
            return
        if value == before:
            self._start_regular()
        if value & JSWSTART and value & INJECTED_BY_SOFTWARE == INJECTED_BY_SOFTWARE:
            self._start_injected()
        if value & SWSTART and value & BY_SOFTWARE == BY_SOFTWARE:
            self._start_regular()

    def _calibrated(self, bit):
        self.values[CR2] &= ~bit
        if bit == CAL:
            self.values[DR] = 0
        del self._calibrations[bit]

    def _check_start(self):
        pass

    def _start_regular(self):
        if self.values[CR2] & ADON and not self._calibrations:
            super()._start_regular()

    def _start_injected(self):
        if self.values[CR2] & ADON and not self._calibrations:
            super()._start_injected()

    def _after(self, halves, action):
        sampling = SAMPLING_HALVES[self._sampling(self._converting.channel)]
        super()._after(sampling if action == self._sample else 25, action)

    def _keep_injected(self):
        super()._keep_injected()
        if not self._injected.active and self._injected.over:
            self.values[SR] |= EOC

    def _keep_regular(self):
        cr1, cr2 = self.values[CR1], self.values[CR2]
        self.values[DR] = self._sampled << (4 if cr2 & ALIGN else 0)
        self._unread = bool(cr2 & DMA)
        self._regular.advance()
        ended = not self._regular.active
        if ended or cr1 & DISCEN:
            self.values[SR] |= EOC
        if ended and self._regular.over:
            if cr1 & JAUTO:
                super()._start_injected()
            if cr2 & CONT and not cr1 & DISCEN:
                super()._start_regular()
