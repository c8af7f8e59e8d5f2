"""ADC1 to ADC3 of an F103 on a chip in a test tube: HCLK 56 MHz, ADCCLK 14 MHz, 4 cycles a clock."""

from __future__ import annotations

import dataclasses
from fractions import Fraction

import pytest

from targets.mcu.fidelity import Notes
from targets.mcu.pins import Pins
from targets.mcu.stm32f1.adc import CHANNELS, Adc
from targets.mcu.stm32f1.gpio import PADS_OF_HIGH_DENSITY
from targets.mcu.testing import FakeChip, FakeInput, peek, poke

CYCLES = 4
FLAGS = ("AWD", "EOC", "JEOC", "JSTRT", "STRT")
EXTTRIG, JEXTTRIG = 1 << 20, 1 << 15
SOFTWARE = 7 << 17 | EXTTRIG
SOFTWARE_INJECTED = 7 << 12 | JEXTTRIG


class Rig:
    """Three converters, with 100 mV at channel 1, 200 mV at channel 2 and so on, unless a test sets something else."""

    def __init__(self):
        self.chip = FakeChip(56_000_000)
        self.chip.clocks.kernels["ADC"] = Fraction(CYCLES)
        self.listeners = {}
        self.moved = set()
        self.pins = Pins(PADS_OF_HIGH_DENSITY, self.chip.time, Notes(lambda: (0, 0), lambda: None))
        for channel in range(16):
            self.volts(channel, channel / 10)
        self.services = dataclasses.replace(self.chip.services, input=self._listener)
        self.irq, self.irq3 = self.chip.irq(18), self.chip.irq(47)
        self.adcs = []
        for number, base, irq in ((1, 0x4001_2400, 18), (2, 0x4001_2800, 18), (3, 0x4001_3C00, 47)):
            master = self.adcs[0] if number == 2 else None
            moved = self.moved.__contains__
            adc = Adc(f"ADC{number}", base, self.services, pins=self.pins, irq=irq, master=master, remapped=moved)
            self.adcs.append(self.chip.add(adc))
        for adc in self.adcs:
            adc.reset()

    def _listener(self, name):
        """Each listener to a signal is one of its own, as in a chip."""
        self.listeners.setdefault(name, []).append(FakeInput())
        return self.listeners[name][-1]

    def trigger(self, name):
        for level in (True, False):
            for listener in self.listeners[name]:
                listener.drive(level)

    def volts(self, channel, volts, unit=1):
        self.pins[CHANNELS[f"ADC{unit}"][channel]].drive_volts(volts)

    def peek(self, register, unit=1):
        return peek(self.adcs[unit - 1], register)

    def poke(self, register, value, unit=1):
        poke(self.adcs[unit - 1], register, value)

    def flags(self, unit=1):
        word = self.peek("SR", unit)
        return {name for bit, name in enumerate(FLAGS) if word >> bit & 1}

    def on(self, cr1=0, cr2=0, *, unit=1, settle=True):
        """Switch on, with software as the trigger of both groups unless `cr2` chooses another, and wait for t_STAB."""
        if not cr2 & EXTTRIG:
            cr2 |= SOFTWARE
        if not cr2 & JEXTTRIG:
            cr2 |= SOFTWARE_INJECTED
        self.poke("CR1", cr1, unit)
        self.poke("CR2", cr2 | 1, unit)
        if settle:
            self.chip.advance(56)

    def sequence(self, *channels, unit=1):
        words = [0, 0, 0]
        for rank, channel in enumerate(channels):
            words[rank // 6] |= channel << 5 * (rank % 6)
        self.poke("SQR3", words[0], unit)
        self.poke("SQR2", words[1], unit)
        self.poke("SQR1", words[2] | len(channels) - 1 << 20, unit)

    def injected(self, *channels, unit=1):
        word = len(channels) - 1 << 20
        for rank, channel in enumerate(channels):
            word |= channel << 5 * (4 - len(channels) + rank)
        self.poke("JSQR", word, unit)

    def start(self, unit=1):
        self.poke("CR2", self.peek("CR2", unit) | 1 << 22, unit)

    def start_injected(self, unit=1):
        self.poke("CR2", self.peek("CR2", unit) | 1 << 21, unit)

    def clocks(self, count):
        self.chip.advance(int(CYCLES * count))

    def drain(self, unit=1):
        """Have a DMA controller read each value as it comes; return the list of (clock, value) that grows."""
        request, found, begin = self.chip.dma(f"ADC{unit}"), [], self.chip.time.now

        def changed(level):
            if level:
                now = self.chip.time.now
                self.chip.time.after(1, lambda: found.append(((now - begin) / CYCLES, self.peek("DR", unit))))

        request.on_set = changed
        return found


def code(channel):
    """What channel n gives with n times 100 mV."""
    return round(channel / 10 / 3.3 * 4096)


@pytest.fixture
def rig():
    return Rig()


@pytest.fixture(scope="session")
def make_rig():
    """The class."""
    return Rig


@pytest.fixture(scope="session")
def expected():
    """``expected(channel)``: the code of the rig's voltage at a channel."""
    return code
