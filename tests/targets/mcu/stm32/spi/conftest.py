"""An SPI interface of an F767 on a chip in a test tube: HCLK 216 MHz, APB2 half of it."""

from __future__ import annotations

import pytest

from targets.mcu.services import Watch
from targets.mcu.stm32.spi_fifo import FifoSpi
from targets.mcu.testing import FakeChip, peek, poke
from tests.targets.mcu.stm32.spi.packet_rig import PacketRig
from tests.targets.mcu.stm32.spi.slave import Slave

FLAGS = {0: "RXNE", 1: "TXE", 4: "CRCERR", 5: "MODF", 6: "OVR", 7: "BSY", 8: "FRE"}
MSTR, SPE, SSI, SSM = 1 << 2, 1 << 6, 1 << 8, 1 << 9
MASTER = MSTR | SPE | SSI | SSM
DR, FRXTH = 0x0C, 1 << 12
DIVIDER = 2


class Rig:
    """The interface with nobody at its pins, unless a test says otherwise."""

    def __init__(self):
        self.chip = FakeChip(216_000_000, {"APB2": DIVIDER})
        self.left = {"tx": 0, "rx": 0}
        self.spi = self.chip.add(
            FifoSpi(
                "SPI1",
                0x4001_3000,
                self.chip.services,
                bus="APB2",
                irq=35,
                has_i2s=True,
                tx_left=lambda: self.left["tx"],
                rx_left=lambda: self.left["rx"],
            )
        )
        for signal in ("SCK", "MOSI"):
            self.chip.output(f"SPI1_{signal}").set_watch(Watch.NOBODY)
        self.chip.input("SPI1_NSS").drive(True)

    def slave(self, *answers, **about):
        slave = Slave(*answers, **about)
        self.spi.bus.attach(slave)
        return slave

    def peek(self, register):
        return peek(self.spi, register)

    def poke(self, register, value):
        poke(self.spi, register, value)

    def write(self, value, size=1):
        """Write DR by so many bytes."""
        self.spi.write_part(DR, size, value)

    def read(self, size=1):
        return self.spi.read_part(DR, size)

    def master(self, more=0, *, bits=8, cr2=FRXTH, br=0):
        self.poke("CR1", 0)
        self.poke("CR2", cr2 | (bits - 1) << 8)
        self.poke("CR1", (MASTER | more | br << 3) & ~SPE)
        self.poke("CR1", MASTER | more | br << 3)

    def flags(self):
        word = self.peek("SR")
        return {name for bit, name in FLAGS.items() if word >> bit & 1}

    def levels(self):
        """FTLVL and FRLVL."""
        word = self.peek("SR")
        return word >> 11 & 3, word >> 9 & 3

    def clocks(self, count, br=0):
        self.chip.advance(count * DIVIDER * (2 << br))

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


@pytest.fixture
def packets():
    """An interface of an H753."""
    return PacketRig()


@pytest.fixture(scope="session")
def make_packets():
    """The class."""
    return PacketRig
