"""An SPI interface of an F103 on a chip in a test tube: HCLK 72 MHz, APB2 the same."""

from __future__ import annotations

import pytest

from targets.mcu.services import Watch
from targets.mcu.stm32f1.spi import Spi
from targets.mcu.testing import FakeChip, peek, poke
from tests.targets.mcu.stm32.spi.slave import Slave

FLAGS = {0: "RXNE", 1: "TXE", 4: "CRCERR", 5: "MODF", 6: "OVR", 7: "BSY"}
MSTR, SPE, SSI, SSM = 1 << 2, 1 << 6, 1 << 8, 1 << 9
MASTER = MSTR | SPE | SSI | SSM


class Rig:
    """The interface with nobody at its pins, unless a test says otherwise."""

    def __init__(self, *, has_i2s=False, **dividers):
        self.chip = FakeChip(72_000_000, dividers)
        self.tx_left = 1
        self.spi = self.chip.add(
            Spi(
                "SPI1",
                0x4001_3000,
                self.chip.services,
                bus="APB2",
                irq=35,
                has_i2s=has_i2s,
                tx_left=lambda: self.tx_left,
            )
        )
        self.watch(Watch.NOBODY)
        self.chip.input("SPI1_NSS").drive(True)

    def watch(self, watch):
        for signal in ("SCK", "MOSI"):
            self.chip.output(f"SPI1_{signal}").set_watch(watch)

    def slave(self, *answers, kind=Slave, **about):
        slave = kind(*answers, **about)
        self.spi.bus.attach(slave)
        return slave

    def peek(self, register):
        return peek(self.spi, register)

    def poke(self, register, value):
        poke(self.spi, register, value)

    def master(self, more=0, *, br=0):
        self.poke("CR1", (MASTER | more | br << 3) & ~SPE)
        self.poke("CR1", MASTER | more | br << 3)

    def flags(self):
        word = self.peek("SR")
        return {name for bit, name in FLAGS.items() if word >> bit & 1}

    def clocks(self, count, br=0):
        self.chip.advance(count * (2 << br))

    def transfer(self, *words, bits=8, br=0):
        """Send words one by one, as a polling driver does; return what came in."""
        found = []
        for word in words:
            self.poke("DR", word)
            self.clocks(bits, br)
            found.append(self.peek("DR"))
        return found

    @property
    def irq(self):
        return self.chip.irq(35)


@pytest.fixture
def rig():
    return Rig()


@pytest.fixture(scope="session")
def make_rig():
    """The class."""
    return Rig
