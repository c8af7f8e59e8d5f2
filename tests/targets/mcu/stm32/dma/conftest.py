"""DMA2 of an F767 on a chip in a test tube, with memory and requests that come from nowhere but the test."""

from __future__ import annotations

import pytest

from targets.mcu.stm32.dma import Dma
from targets.mcu.stm32.dma_requests import Channels, Requests
from targets.mcu.testing import FakeChip, peek, poke

RAM = 0x2000_0000
PORT, NOWHERE = 0x4001_0000, 0x6000_0000
EN = 1 << 0
IRQS = (56, 57, 58, 59, 60, 68, 69, 70)
SHIFTS = (0, 6, 16, 22)
NAMES = {0: "FE", 2: "DME", 3: "TE", 4: "HT", 5: "TC"}


class Rig:
    """Stream n listens to the requests ``S<n>`` on channel 3, and ``X`` and ``Y`` on channel 4."""

    def __init__(self, *, between_memories=True):
        self.chip = FakeChip(216_000_000)
        self.requests = Requests()
        channels = {(n, 3): (f"S{n}",) for n in range(8)} | {(n, 4): ("X", "Y") for n in range(8)}
        self.dma = self.chip.add(
            Dma(
                "DMA2",
                0x4002_6400,
                self.chip.services,
                sources=Channels(self.requests, channels),
                irqs=IRQS,
                between_memories=between_memories,
            )
        )
        self.dma.reset()
        self.bus = self.chip.bus
        self.bus.load(RAM, bytes(0x1000))
        self.bus.load(PORT, bytes(0x400))

    def peek(self, register):
        return peek(self.dma, register)

    def poke(self, register, value):
        poke(self.dma, register, value)

    def stream(self, number, control, count, peripheral=PORT, memory=RAM, memory1=RAM + 0x800, fcr=0x21, channel=3):
        """Set up and, with bit 0 of `control`, enable a stream, in the order that drivers use."""
        self.poke(f"S{number}CR", 0)
        self.poke(f"S{number}NDTR", count)
        self.poke(f"S{number}PAR", peripheral)
        self.poke(f"S{number}M0AR", memory)
        self.poke(f"S{number}M1AR", memory1)
        self.poke(f"S{number}FCR", fcr)
        self.poke(f"S{number}CR", control | channel << 25)

    def flags(self, number):
        """The flags of a stream, by name."""
        word = self.peek("LISR" if number < 4 else "HISR") >> SHIFTS[number & 3]
        return {name for bit, name in NAMES.items() if word >> bit & 1}

    def clear(self, number, bits=0x3D):
        self.poke("LIFCR" if number < 4 else "HIFCR", bits << SHIFTS[number & 3])

    def raise_flags(self, number, wanted):
        """Have a stream set each of its flags, and clear those that are not wanted; others may be set elsewhere."""
        other = (number + 1) % 8
        self.stream(number, EN | 1 << 23, 4, fcr=0x24)  # FE: a burst of four bytes does not fit...
        self.stream(number, EN | 3 << 23, 4, fcr=0x24)  # ... or one of sixteen
        self.stream(number, EN, 4, NOWHERE)
        self.serve(number)
        self.stream(number, EN | 1 << 10, 2)
        self.serve(number, 2)
        self.stream(number, EN, 10)
        self.stream(other, EN | 3 << 16 | 2 << 6 | 3 << 9 | 2 << 11, 64, PORT + 0x100, RAM + 0x100, fcr=0x27)
        self.line(number).set(True)
        self.chip.advance(1000)
        self.line(number).set(False)
        self.chip.advance(1000)
        for each in (number, other):
            self.poke(f"S{each}CR", 0)
        assert self.flags(number) == set(NAMES.values())
        self.clear(number, 0x3D & ~wanted)

    def gate(self, clocked):
        """Open or shut the gate of its clock, as RCC does."""
        self.dma.before_clock_change()
        self.dma.clocked = clocked
        self.dma.after_clock_change()

    def irq(self, number):
        return self.chip.irq(IRQS[number])

    def line(self, number):
        return self.requests.line(f"S{number}")

    def serve(self, number, times=1, gap=40):
        """Have a peripheral ask so often, with pauses."""
        for _ in range(times):
            self.line(number).pulse()
            self.chip.advance(gap)

    def fill(self, address, size):
        """Fill memory with 0x01, 0x02, ... and return that."""
        data = bytes(n % 255 + 1 for n in range(size))
        self.bus.load(address, data)
        return data

    def accesses(self, kind, at=None):
        """Addresses of reads or writes, perhaps only those within 0x400 of `at`."""
        return [
            address
            for what, address, _, _ in self.bus.accesses
            if what == kind and (at is None or at <= address < at + 0x400)
        ]


@pytest.fixture(scope="session")
def make_rig():
    """The class: ``make_rig(between_memories=True)``."""
    return Rig


@pytest.fixture
def rig():
    return Rig()
