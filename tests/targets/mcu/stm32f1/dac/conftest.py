"""The DAC on a chip in a test tube, with pins, triggers and APB1 at half of HCLK."""

from __future__ import annotations

import dataclasses

import pytest

from targets.mcu.pins import PadMode, Pins
from targets.mcu.signals import Signals
from targets.mcu.stm32f1.dac import Dac
from targets.mcu.stm32f1.gpio import PADS_OF_HIGH_DENSITY
from targets.mcu.testing import FakeChip, peek, poke

APB1 = 2


class Rig:
    """The DAC, and the hands to trigger it."""

    def __init__(self):
        self.chip = FakeChip(72_000_000, {"APB1": APB1})
        self.pins = Pins(PADS_OF_HIGH_DENSITY, self.chip.time, self.chip.notes)
        for name in ("PA4", "PA5"):
            self.pins[name].configure(PadMode.ANALOG, latch=False, pull=None)
        self.signals = Signals(self.pins)
        services = dataclasses.replace(self.chip.services, input=self.signals.input)
        self.dac = self.chip.add(Dac(0x4000_7400, services, self.pins))

    def peek(self, register):
        return peek(self.dac, register)

    def poke(self, register, value):
        poke(self.dac, register, value)

    def ticks(self, count):
        """Let so many cycles of APB1 pass."""
        self.chip.advance(APB1 * count)

    def trigger(self, signal):
        """A pulse on a signal inside the chip."""
        self.signals.output(signal).set(True)
        self.signals.output(signal).set(False)

    def triggered(self, signal="TIM6_TRGO"):
        """A pulse, and the time until DOR follows."""
        self.trigger(signal)
        self.ticks(3)

    def requests(self, channel=1):
        """At which cycles DMA was asked for."""
        return self.chip.dma(f"DAC_CH{channel}").pulses

    def volts(self, pin="PA4"):
        return self.pins[pin].volts


@pytest.fixture(scope="session")
def make_rig():
    return Rig


@pytest.fixture
def rig():
    return Rig()
