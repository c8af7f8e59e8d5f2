"""Real ports, AFIO, EXTI and signals on a chip in a test tube."""

from __future__ import annotations

import dataclasses

import pytest

from targets.mcu.pins import Pins
from targets.mcu.signals import Signals
from targets.mcu.stm32.exti import STM32F1, Exti
from targets.mcu.stm32f1.afio import Afio
from targets.mcu.stm32f1.gpio import PADS, Gpio
from targets.mcu.stm32f1.variants import VARIANTS
from targets.mcu.testing import FakeChip


class Pinout:
    """An LQFP48 part without a CPU: its pins are real, the rest is `FakeChip`."""

    def __init__(self, dividers=None, hclk_hz=72_000_000):
        self.chip = FakeChip(hclk_hz, dividers)
        self.time = self.chip.time
        self.pins = Pins(PADS, self.chip.time, self.chip.notes, bonded=VARIANTS["STM32F103C8"].pins)
        self.signals = Signals(self.pins)
        self.services = dataclasses.replace(self.chip.services, output=self.signals.output, input=self.signals.input)
        self.ports = {
            letter: self.chip.add(Gpio(f"GPIO{letter}", 0x4001_0800 + 0x400 * index, self.services, self.pins))
            for index, letter in enumerate("ABCDE")
        }
        self.afio = self.chip.add(Afio("AFIO", 0x4001_0000, self.services, self.pins, self.signals))
        self.exti = self.chip.add(Exti("EXTI", 0x4001_0400, self.services, STM32F1))

    def mode(self, pin, nibble):
        """Write CNF and MODE of one pin."""
        port, number = self.ports[pin[1]], int(pin[2:])
        offset = 4 if number >= 8 else 0
        shift = 4 * (number & 7)
        port.write(offset, (port.read(offset) & ~(0xF << shift)) | nibble << shift)


@pytest.fixture
def pinout():
    return Pinout()


@pytest.fixture(scope="session")
def make_pinout():
    return Pinout
