"""A USART on a chip in a test tube, and the far end of its line."""

from __future__ import annotations

import pytest

from targets.mcu.stm32f1.usart import Usart
from targets.mcu.testing import FakeChip
from tests.targets.mcu.stm32.usart.port import BasicPort

SITES = {"USART1": (0x4001_3800, "APB2", 37), "USART2": (0x4000_4400, "APB1", 38), "USART3": (0x4000_4800, "APB1", 39)}


class Port(BasicPort):
    """A USART, what it has sent as (cycle, frame), and its lines."""

    def __init__(self, hclk_hz=72_000_000, dividers=None, name="USART1", chip=None):
        base, bus, irq = SITES[name]
        chip = chip or FakeChip(hclk_hz, dividers)
        super().__init__(chip, Usart(name, base, chip.services, bus=bus, irq=irq), irq)
        self.divider = chip.clocks.dividers[bus]

    @property
    def flags(self):
        """SR without the side effect of reading it."""
        return self.usart[0x00]

    def open(self, brr=16, cr1=0x200C, cr2=0, cr3=0, *, past_preamble=True):
        """Enable it (8N1 and both directions unless said otherwise), and let the preamble pass."""
        self.poke("BRR", brr)
        self.poke("CR2", cr2)
        self.poke("CR3", cr3)
        self.poke("CR1", cr1)
        if past_preamble:
            self.bits(15)
        return self

    @property
    def bit(self):
        """HCLK cycles of a bit."""
        return self.peek("BRR") * self.divider


@pytest.fixture(scope="session")
def make_port():
    """The class: ``make_port(hclk_hz, dividers, name)``."""
    return Port


@pytest.fixture
def port():
    """USART1 at 72 MHz, just out of reset."""
    return Port()


@pytest.fixture
def open_port():
    """USART1 at 72 MHz, 4.5 MBaud, 8N1, past its preamble."""
    return Port().open()
