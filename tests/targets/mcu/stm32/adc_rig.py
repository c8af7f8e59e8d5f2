"""ADCs on a chip in a test tube: what is the same for those of all families."""

from __future__ import annotations

import dataclasses

from targets.mcu.stm32.dma_requests import Requests
from targets.mcu.testing import FakeChip, FakeInput, peek, poke

__all__ = ["ConvertersRig"]


class ConvertersRig:
    """Around converters, with 100 mV at channel 1, 200 mV at channel 2 and so on, unless a test sets something else.

    Who derives from it puts them into `adc`; a register without the name of a converter is one of ADC1.
    """

    def __init__(self, hclk_hz, dividers):
        self.chip = FakeChip(hclk_hz, dividers)
        self.requests = Requests()
        self.volts = {channel: channel / 10 for channel in range(16)}
        self.listeners = {}
        self.services = dataclasses.replace(self.chip.services, input=self._listener)
        self.irq = self.chip.irq(18)

    def _listener(self, name):
        """Each listener to a signal is one of its own, as in a chip."""
        self.listeners.setdefault(name, []).append(FakeInput())
        return self.listeners[name][-1]

    def trigger(self, name, level):
        for listener in self.listeners[name]:
            listener.drive(level)

    def volts_at(self, _unit, channel):
        return self.volts.get(channel)

    def _full(self, register):
        return register if register in ("CSR", "CCR", "CDR") or register.startswith("ADC") else f"ADC1_{register}"

    def peek(self, register):
        return peek(self.adc, self._full(register))

    def poke(self, register, value):
        poke(self.adc, self._full(register), value)
