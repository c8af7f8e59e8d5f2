"""Ports of an STM32F767 on a chip in a test tube."""

from __future__ import annotations

import dataclasses

import pytest

from targets.mcu.pins import Pins
from targets.mcu.signals import Signals
from targets.mcu.stm32.gpio import Gpio, thresholds
from targets.mcu.stm32.pin_functions import PinFunctions
from targets.mcu.stm32f7.af_table import ALTERNATE_FUNCTIONS, PADS
from targets.mcu.stm32f7.variants import VARIANTS
from targets.mcu.testing import FakeChip


class Pinout:
    """An STM32F767ZI without a CPU: its pins are real, the rest is `FakeChip`."""

    def __init__(self, dividers=None, hclk_hz=216_000_000):
        self.chip = FakeChip(hclk_hz, dividers)
        self.time = self.chip.time
        bonded = VARIANTS["STM32F767ZI"].pins
        self.pins = Pins(PADS, self.chip.time, self.chip.notes, bonded=bonded, thresholds=thresholds(3.3))
        self.signals = Signals(self.pins)
        self.services = dataclasses.replace(self.chip.services, output=self.signals.output, input=self.signals.input)
        self.functions = PinFunctions(ALTERNATE_FUNCTIONS, self.signals, self.time, self.chip.notes)
        self.ports = {
            letter: self.chip.add(
                Gpio(f"GPIO{letter}", 0x4002_0000 + 0x400 * index, self.services, self.pins, self.functions)
            )
            for index, letter in enumerate("ABCDEFGHIJK")
        }

    def field(self, pin, register, value, width=2):
        """Write the field of one pin; of AFRL and AFRH too, as ``AFR``."""
        port, number = self.ports[pin[1]], int(pin[2:])
        if register == "AFR":
            register, width = ("AFRH" if number >= 8 else "AFRL"), 4
            number &= 7
        offset = next(offset for offset, entry in port.registers.items() if entry.name == register)
        mask = (1 << width) - 1 << width * number
        port.write(offset, (port.read(offset) & ~mask) | value << width * number)

    def alternate(self, pin, function):
        """Give the pin an alternate function."""
        self.field(pin, "AFR", function)
        self.field(pin, "MODER", 2)


@pytest.fixture
def pinout():
    return Pinout()


@pytest.fixture(scope="session")
def make_pinout():
    return Pinout
