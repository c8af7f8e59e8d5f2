"""DMA1 on a chip in a test tube, with memory."""

from __future__ import annotations

import dataclasses

import pytest

from targets.mcu.stm32f1.dma import Dma
from targets.mcu.testing import FakeChip, peek, poke

RAM = 0x2000_0000
PORT = 0x4001_0000
"""A stretch of memory that plays a peripheral without side effects."""


class Rig:
    """DMA1, and requests that come from nowhere but the test."""

    def __init__(self, hclk_hz=72_000_000, dividers=None):
        self.chip = FakeChip(hclk_hz, dividers)
        self.dma = Dma("DMA1", 0x4002_0000, self.chip.services)
        self.chip.add(self.dma)
        self.dma.reset()
        self.services = dataclasses.replace(self.chip.services, dma=self.dma.request)
        self.bus = self.chip.bus
        self.bus.load(RAM, bytes(0x1000))
        self.bus.load(PORT, bytes(0x100))

    def peek(self, register):
        return peek(self.dma, register)

    def poke(self, register, value):
        poke(self.dma, register, value)

    def channel(self, number, control, count, peripheral=PORT, memory=RAM):
        """Set up and, with bit 0 of `control`, enable a channel, in the order that drivers use."""
        self.poke(f"CCR{number}", 0)
        self.poke(f"CNDTR{number}", count)
        self.poke(f"CPAR{number}", peripheral)
        self.poke(f"CMAR{number}", memory)
        self.poke(f"CCR{number}", control)

    def flags(self, number):
        """GIF, TCIF, HTIF and TEIF of a channel."""
        return self.peek("ISR") >> 4 * (number - 1) & 0xF

    def irq(self, number):
        return self.chip.irq(10 + number)

    def fill(self, address, size):
        """Fill memory with 0x01, 0x02, ... and return that."""
        data = bytes(n % 255 + 1 for n in range(size))
        self.bus.load(address, data)
        return data


@pytest.fixture(scope="session")
def make_rig():
    """The class: ``make_rig(hclk_hz, dividers)``."""
    return Rig


@pytest.fixture
def rig():
    return Rig()
