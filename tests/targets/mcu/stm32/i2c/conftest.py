"""I2C1 of an F767 on a chip in a test tube: HCLK 216 MHz, kernel clock 54 MHz, a 24C02 on the bus."""

from __future__ import annotations

from fractions import Fraction

import pytest

from targets.mcu.stm32.i2c import I2c
from targets.mcu.testing import FakeChip, peek, poke

HCLK = 216_000_000
KERNEL = 54_000_000
CYCLES = HCLK // KERNEL
ANFOFF = 1 << 12
TIMINGR = 0x0030_1C34  # PRESC 0, SCLDEL 3, SDADEL 0, SCLH 28, SCLL 52


class Rig:
    """The interface, its bus with what is told of it, and time in clocks of the kernel."""

    def __init__(self, *slaves, hclk=HCLK):
        self.chip = FakeChip(hclk, {"APB1": 4})
        self.kernel = Fraction(KERNEL)
        self.i2c = self.chip.add(
            I2c(
                "I2C1",
                0x4000_5400,
                self.chip.services,
                irq_event=31,
                irq_error=32,
                kernel_hz=lambda: self.kernel,
            )
        )
        self.i2c.reset()
        self.bus = self.i2c.bus
        self.told = []
        self.bus.taps.append(self.told.append)
        for slave in slaves:
            self.bus.attach(slave)
        self.event, self.error = self.chip.irq(31), self.chip.irq(32)

    def peek(self, register):
        return peek(self.i2c, register)

    def poke(self, register, value):
        poke(self.i2c, register, value)

    def isr(self, *names):
        """Whether each of these flags is set."""
        bits = {name: 1 << number for number, name in enumerate(NAMES)}
        return [bool(self.peek("ISR") & bits[name]) for name in names]

    def flags(self):
        """The flags that are set, but for TXE."""
        return {name for number, name in enumerate(NAMES) if self.peek("ISR") >> number & 1} - {"TXE"}

    def enable(self, cr1=0, timingr=TIMINGR):
        """Without the analog filter, so that everything is whole clocks of the kernel."""
        self.poke("CR1", 0)
        self.poke("TIMINGR", timingr)
        self.poke("CR1", ANFOFF | cr1 | 1)

    def clocks(self, count):
        self.chip.advance(CYCLES * count)

    def until(self, flag, limit=400_000):
        """Let time pass until a flag is set; return how many clocks."""
        begun = self.chip.time.now
        while not self.isr(flag)[0]:
            due = self.chip.time.next_cycle()
            if due is None or due > begun + limit * CYCLES:
                raise AssertionError(f"{flag} will not be set within {limit} clocks: {self.flags()}")
            self.chip.advance_to(due)
        return Fraction(self.chip.time.now - begun, CYCLES)

    def begin(self, address=0x50, count=1, *, read=False, more=0):
        self.poke("CR2", address << 1 | read << 10 | 1 << 13 | count << 16 | more)

    def send(self, *data, address=0x50, more=1 << 25):
        """Write a message by polling, up to what ends it."""
        self.begin(address, len(data), more=more)
        for byte in data:
            self.until("TXIS")
            self.poke("TXDR", byte)

    def fetch(self, count, address=0x50, more=1 << 25):
        """Read a message by polling."""
        self.begin(address, count, read=True, more=more)
        found = []
        for _ in range(count):
            self.until("RXNE")
            found.append(self.peek("RXDR"))
        return bytes(found)


NAMES = ["TXE", "TXIS", "RXNE", "ADDR", "NACKF", "STOPF", "TC", "TCR"]
NAMES += ["BERR", "ARLO", "OVR", "PECERR", "TIMEOUT", "ALERT", "-", "BUSY"]


@pytest.fixture(scope="session")
def make_rig():
    """The class: ``make_rig(slave, ...)``."""
    return Rig


@pytest.fixture
def memory(make_memory):
    return make_memory()


@pytest.fixture
def rig(memory):
    rig = Rig(memory)
    rig.enable()
    return rig
