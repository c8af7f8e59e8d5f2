"""ADC1 and ADC2 of an H753 on a chip in a test tube: CPU 480 MHz, AHB 240 MHz, and a kernel clock of 60 MHz.

With PRESC at its reset value a clock of the converter takes 16 cycles: 480 MHz / 60 MHz, and 2 for revision V.
"""

from __future__ import annotations

from fractions import Fraction

import pytest

from targets.mcu.stm32.adc16 import Adc16
from tests.targets.mcu.stm32.adc_rig import ConvertersRig

CYCLES = 16
FLAGS = ["ADRDY", "EOSMP", "EOC", "EOS", "OVR", "JEOC", "JEOS", "AWD1", "AWD2", "AWD3", "JQOVF", "-", "LDORDY"]
ADEN, ADSTART, JADSTART, ADVREGEN = 1 << 0, 1 << 2, 1 << 3, 1 << 28
RESOLUTIONS = {16: 0, 14: 5, 12: 6, 10: 3, 8: 7}
OVRMOD, CONT = 1 << 12, 1 << 13


class Rig(ConvertersRig):
    """The converters; see `ConvertersRig` for what stands at their channels."""

    def __init__(self, kernel_hz=60_000_000, hclk_hz=480_000_000):
        super().__init__(hclk_hz, {"AHB": 2, "APB1": 4, "APB2": 4})
        self.kernel_hz = Fraction(kernel_hz)
        self.adc = self.chip.add(
            Adc16(
                "ADC12",
                0x4002_2000,
                self.services,
                units=("ADC1", "ADC2"),
                requests=self.requests,
                irq=18,
                kernel_hz=lambda: self.kernel_hz,
                volts=self.volts_at,
                inside={"ADC2": {17: "VBAT", 18: "SENSE", 19: "VREFINT"}},
                reference_volts=3.3,
                triggers={9: "TIM1_TRGO", 13: "TIM6_TRGO"},
                injected_triggers={0: "TIM1_TRGO", 14: "TIM6_TRGO"},
            )
        )
        self.adc.reset()

    def set(self, register, bits):
        self.poke(register, self.peek(register) | bits)

    def flags(self, unit=1):
        word = self.peek(f"ADC{unit}_ISR")
        return {name for bit, name in enumerate(FLAGS) if word >> bit & 1} - {"LDORDY", "ADRDY"}

    def clear(self, names="EOSMP EOC EOS OVR JEOC JEOS AWD1 AWD2 AWD3"):
        self.poke("ISR", sum(1 << FLAGS.index(name) for name in names.split()))

    def on(self, cfgr=0, cfgr2=0, unit=1, bits=16, boost=3):
        """Switch on, with every channel preselected, and wait until it is ready."""
        name = f"ADC{unit}"
        self.poke(f"{name}_CR", 0)
        self.poke(f"{name}_CR", ADVREGEN | boost << 8)
        self.chip.advance_s(Fraction(10, 1_000_000))
        self.poke(f"{name}_PCSEL", 0xF_FFFF)
        self.poke(f"{name}_CFGR", 1 << 31 | RESOLUTIONS[bits] << 2 | cfgr)
        self.poke(f"{name}_CFGR2", cfgr2)
        self.poke(f"{name}_CR", ADVREGEN | boost << 8 | ADEN)
        self.clocks(10)
        return self

    def sequence(self, *channels, unit=1):
        words = [len(channels) - 1, 0, 0, 0]
        for rank, channel in enumerate(channels, 1):
            words[rank // 5] |= channel << 6 * (rank % 5)
        for number, word in enumerate(words, 1):
            self.poke(f"ADC{unit}_SQR{number}", word)

    def injected(self, *channels, trigger=0):
        word = len(channels) - 1 | trigger
        for rank, channel in enumerate(channels):
            word |= channel << 9 + 6 * rank
        self.poke("JSQR", word)

    def sampling(self, smp, *channels):
        """Choose a sampling time of some channels, or of all."""
        for register, first, count in (("SMPR1", 0, 10), ("SMPR2", 10, 10)):
            word = self.peek(register)
            for channel in channels or range(20):
                if first <= channel < first + count:
                    shift = 3 * (channel - first)
                    word = word & ~(7 << shift) | smp << shift
            self.poke(register, word)

    def start(self, bits=ADSTART):
        self.set("CR", bits)

    def clocks(self, count):
        self.chip.advance(int(CYCLES * count))

    def drain(self, delay=1):
        """Have a DMA controller read each value as it comes; return the list that grows, with cycles."""
        request, found = self.requests.line("ADC1"), []
        drive = request.set

        def serve():
            found.append((self.chip.time.now, self.peek("DR")))

        def driven(level):
            drive(level)
            if level:
                self.chip.time.after(delay, serve)

        request.set = driven
        return found


def code(volts, bits=16):
    """What an ideal converter gives for a voltage."""
    return min(round(volts / 3.3 * (1 << bits)), (1 << bits) - 1)


@pytest.fixture
def rig():
    return Rig()


@pytest.fixture(scope="session")
def make_rig():
    """The class: ``make_rig(kernel_hz, hclk_hz)``."""
    return Rig


@pytest.fixture(scope="session")
def expected():
    """``expected(volts, bits)``: the code of a voltage."""
    return code
