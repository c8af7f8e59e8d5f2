"""The ADCs of an F767 on a chip in a test tube: HCLK 216 MHz, APB2 108 MHz, ADCCLK 27 MHz, 8 cycles a clock."""

from __future__ import annotations

import pytest

from targets.mcu.stm32.adc import Adc
from targets.mcu.stm32f7.adc_inputs import INJECTED_TRIGGERS, REGULAR_TRIGGERS
from tests.targets.mcu.stm32.adc_rig import ConvertersRig

CYCLES = 8
FLAGS = ("AWD", "EOC", "JEOC", "JSTRT", "STRT", "OVR")


class Rig(ConvertersRig):
    """The converters; see `ConvertersRig` for what stands at their channels."""

    def __init__(self):
        super().__init__(216_000_000, {"APB1": 4, "APB2": 2})
        self.enabled = {0, 1, 2}
        self.adc = self.chip.add(
            Adc(
                0x4001_2000,
                self.services,
                requests=self.requests,
                irq=18,
                bus="APB2",
                most_hz=36_000_000,
                volts=self.volts_at,
                reference_volts=3.3,
                triggers=REGULAR_TRIGGERS,
                injected_triggers=INJECTED_TRIGGERS,
                enabled=self.enabled.__contains__,
            )
        )
        self.adc.reset()
        self.poke("CCR", 1 << 16)

    def flags(self, unit=1):
        word = self.peek(f"ADC{unit}_SR")
        return {name for bit, name in enumerate(FLAGS) if word >> bit & 1}

    def clear(self):
        self.poke("SR", 0)

    def on(self, cr1=0, cr2=0, settle=True):
        """Switch on and wait for the supply of the converter."""
        self.poke("CR1", cr1)
        self.poke("CR2", cr2 | 1)
        if settle:
            self.chip.advance(1000)

    def sequence(self, *channels):
        words = [0, 0, 0]
        for rank, channel in enumerate(channels):
            words[rank // 6] |= channel << 5 * (rank % 6)
        self.poke("SQR3", words[0])
        self.poke("SQR2", words[1])
        self.poke("SQR1", words[2] | len(channels) - 1 << 20)

    def injected(self, *channels):
        word = len(channels) - 1 << 20
        for rank, channel in enumerate(channels):
            word |= channel << 5 * (4 - len(channels) + rank)
        self.poke("JSQR", word)

    def start(self, bit=30):
        self.poke("CR2", self.peek("CR2") | 1 << bit)

    def clocks(self, count):
        self.chip.advance(CYCLES * count)

    def drain(self):
        """Have a DMA controller read each value as it comes; return the list that grows."""
        request, found = self.requests.line("ADC1"), []
        drive = request.set

        def driven(level):
            drive(level)
            if level:
                self.chip.time.after(1, lambda: found.append(self.peek("DR")))

        request.set = driven
        return found


def code(channel):
    """What channel n gives with n times 100 mV, in 12 bits."""
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
