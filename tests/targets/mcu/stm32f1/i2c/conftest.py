"""I2C1 of an F103 on a chip in a test tube: HCLK 72 MHz, PCLK1 36 MHz, 100 kHz, a 24C02 on the bus."""

from __future__ import annotations

import pytest

from targets.mcu.stm32f1.i2c import I2c
from targets.mcu.testing import FakeChip, peek, poke
from targets.parts import Ports
from targets.parts.at24c02 import At24c02, At24c02Settings

SR1 = {
    0: "SB",
    1: "ADDR",
    2: "BTF",
    3: "ADD10",
    4: "STOPF",
    6: "RXNE",
    7: "TXE",
    8: "BERR",
    9: "ARLO",
    10: "AF",
    11: "OVR",
    12: "PECERR",
    14: "TIMEOUT",
    15: "SMBALERT",
}
BITS = {name: 1 << bit for bit, name in SR1.items()}
SR2 = {0: "MSL", 1: "BUSY", 2: "TRA", 4: "GENCALL", 5: "SMBDEFAULT", 6: "SMBHOST", 7: "DUALF"}
PE, START, STOP, ACK, POS = 1, 1 << 8, 1 << 9, 1 << 10, 1 << 11
BIT = 720  # HCLK cycles at 100 kHz


class Rig:
    """The interface as a driver sees it."""

    def __init__(self, chip=None, number=1):
        self.chip = chip or FakeChip(72_000_000, {"APB1": 2})
        self.left = self.tx_left = 0
        self.i2c = self.chip.add(
            I2c(
                f"I2C{number}",
                0x4000_5000 + 0x400 * number,
                self.chip.services,
                irq=29 + 2 * number,
                rx_left=lambda: self.left,
                tx_left=lambda: self.tx_left,
            )
        )
        self.eeprom = At24c02(At24c02Settings(), Ports(), seed=0)
        self.bus = self.i2c.bus
        self.bus.attach(self.eeprom)
        self.told = []
        self.bus.taps.append(self.told.append)
        self.event, self.error = (self.chip.irq(29 + 2 * number + which) for which in (0, 1))

    def peek(self, register):
        return peek(self.i2c, register)

    def poke(self, register, value):
        poke(self.i2c, register, value)

    def enable(self, ccr=180, cr2=0):
        self.poke("CR2", 36 | cr2)
        self.poke("CCR", ccr)
        self.poke("TRISE", 37)
        self.poke("CR1", PE)
        return self

    def ask(self, bits):
        self.poke("CR1", self.peek("CR1") | bits)

    def drop(self, bits):
        self.poke("CR1", self.peek("CR1") & ~bits)

    def flags(self):
        """Those of SR1, which is not read as a driver does: that would clear some."""
        return {name for bit, name in SR1.items() if self.i2c[0x14] >> bit & 1}

    def state(self):
        return {name for bit, name in SR2.items() if self.i2c[0x18] >> bit & 1}

    def until(self, *flags, limit=100_000):
        """Let time pass until SR1 has these flags, as a driver polls; return the cycles."""
        begin, wanted = self.chip.time.now, sum(BITS[name] for name in set(flags))
        while ~self.i2c[0x14] & wanted:
            assert self.chip.time.now < begin + limit, f"no {flags}: {self.flags()}, {self.state()}"
            self.chip.advance(4)
        self.peek("SR1")
        return self.chip.time.now - begin

    def until_free(self):
        while self.state():
            self.chip.advance(4)
        return self

    def start(self, address, *, read=False, acknowledge=False):
        """EV5 and the address; up to EV6, which is left set."""
        if acknowledge:
            self.ask(ACK)
        self.ask(START)
        self.until("SB")
        self.poke("DR", address << 1 | read)
        self.until("ADDR")

    def clear_addr(self):
        self.peek("SR1")
        self.peek("SR2")

    def write(self, *data, address=0x50, stop=True):
        """As a polling driver writes."""
        self.start(address)
        self.clear_addr()
        for byte in data:
            self.until("TXE")
            self.poke("DR", byte)
        self.until("BTF")
        if stop:
            self.ask(STOP)
            self.until_free()

    def read(self, count, address=0x50):
        """As RM0008 section 26.3.3 asks a driver that polls to read, for 1, 2 and more bytes."""
        found = []
        if count == 2:
            self.ask(POS)
        self.start(address, read=True, acknowledge=count > 1)
        if count == 1:
            self.drop(ACK)
            self.clear_addr()
            self.ask(STOP)
            self.until("RXNE")
            found.append(self.peek("DR"))
        elif count == 2:
            self.clear_addr()
            self.drop(ACK)
            self.until("BTF")
            self.ask(STOP)
            found += [self.peek("DR"), self.peek("DR")]
        else:
            self.clear_addr()
            while len(found) < count - 3:
                self.until("RXNE")
                found.append(self.peek("DR"))
            self.until("BTF")
            self.drop(ACK)
            found.append(self.peek("DR"))
            self.until("BTF")
            self.ask(STOP)
            found += [self.peek("DR")]
            self.until("RXNE")
            found.append(self.peek("DR"))
        self.drop(POS)
        self.until_free()
        return bytes(found)

    def settle_eeprom(self):
        self.chip.advance(72_000 * 6)


@pytest.fixture
def rig():
    return Rig().enable()


@pytest.fixture(scope="session")
def make_rig():
    """The class."""
    return Rig


class Pair:
    """I2C1 and I2C2 of one chip on the same two wires; the second is to be a slave with address 0x21."""

    OWN = 0x21

    def __init__(self, *, control=0, cr2=0, slave_cr2=0, oar1=0x4000 | OWN << 1, oar2=0):
        self.master = Rig().enable(cr2=cr2)
        self.chip = self.master.chip
        self.slave = Rig(self.chip, 2)
        self.master.bus.joined = lambda: (self.slave.bus,)
        self.slave.bus.joined = lambda: (self.master.bus,)
        self.slave.enable(cr2=slave_cr2)
        self.slave.poke("OAR1", oar1)
        self.slave.poke("OAR2", oar2)
        self.slave.ask(ACK | control)

    def begin(self, byte):
        """START and this byte, an address with its direction or a header; up to its ninth clock."""
        self.master.ask(START)
        self.master.until("SB")
        self.master.poke("DR", byte)
        while not self.master.flags() & {"ADDR", "ADD10", "AF"}:
            self.chip.advance(4)
        self.master.peek("SR1")

    def address(self, *, read=False, acknowledge=True, address=OWN):
        """Up to ADDR of both, EV6 and EV1."""
        if read and acknowledge:
            self.master.ask(ACK)
        self.begin(address << 1 | read)

    def clear_both(self):
        self.master.clear_addr()
        self.slave.clear_addr()

    def wait(self, bits):
        self.chip.advance(BIT * bits)

    def stop(self):
        self.master.ask(STOP)
        self.master.until_free()


@pytest.fixture
def pair():
    return Pair()


@pytest.fixture(scope="session")
def make_pair():
    """The class."""
    return Pair
