"""An SPI interface of an H753 on a chip in a test tube: the CPU at 480 MHz, words on HSI at 64 MHz."""

from __future__ import annotations

from fractions import Fraction

from targets.mcu.services import Watch
from targets.mcu.stm32.spi_packets import PacketSpi
from targets.mcu.testing import FakeChip, peek, poke
from tests.targets.mcu.stm32.spi.slave import Slave

TXDR, RXDR = 0x20, 0x30
FLAGS = ("RXP", "TXP", "DXP", "EOT", "TXTF", "UDR", "OVR", "CRCE", "TIFRE", "MODF", "TSERF", "SUSP", "TXC")
SPE, CSTART, CSUSP, SSI = 1 << 0, 1 << 9, 1 << 10, 1 << 12
MASTER, SSM, COMM = 1 << 22, 1 << 26, 17
FULL, TRANSMIT, RECEIVE, HALF = (mode << COMM for mode in range(4))


class PacketRig:
    """The interface with nobody at its pins, unless a test says otherwise."""

    def __init__(self, *, wide=True):
        self.chip = FakeChip(480_000_000)
        self.chip.clocks.kernels["SPI1"] = Fraction(480, 64)
        self.spi = self.chip.add(PacketSpi("SPI1", 0x4001_3000, self.chip.services, irq=35, wide=wide))
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
        """Write TXDR by so many bytes."""
        if size == 4:
            self.spi.write(TXDR, value)
        else:
            self.spi.write_part(TXDR, size, value)

    def read(self, size=1):
        return self.spi.read(RXDR) if size == 4 else self.spi.read_part(RXDR, size)

    def master(self, *, bits=8, packet=1, size=0, cfg1=0, cfg2=FULL, cr1=0, mbr=0, start=True):
        """Set up, switch on and start, in the order of section 50.4.9 and 50.4.10."""
        self.poke("CR1", 0)
        self.poke("IFCR", 0xFF8)
        self.poke("CR1", SSI | cr1)
        self.poke("CFG1", cfg1 | mbr << 28 | (bits - 1) | (packet - 1) << 5 | (0 if cfg1 >> 16 & 0x1F else 7 << 16))
        self.poke("CFG2", MASTER | SSM | cfg2)
        self.poke("CR2", size)
        self.poke("CR1", SSI | cr1 | SPE)
        if start:
            self.start()

    def start(self):
        self.poke("CR1", self.peek("CR1") | CSTART)

    def flags(self):
        word = self.peek("SR")
        return {name for bit, name in enumerate(FLAGS) if word >> bit & 1}

    @property
    def left(self):
        """CTSIZE."""
        return self.peek("SR") >> 16

    def clocks(self, count, mbr=0):
        """Let so many clocks pass, from a cycle at which a word begins."""
        self.chip.advance_to(self.chip.time.now + -(-Fraction(480, 64) * count * (2 << mbr) // 1))

    @property
    def irq(self):
        return self.chip.irq(35)
