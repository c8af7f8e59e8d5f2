"""Drivers that read each part at I2C1 and SPI1 polled, by interrupts and by DMA: what they find, and each error.

An error that a part or the wires can make reaches the error path of all three, and when it is gone they work again:
the image does everything twice, 50 ms apart.
"""

from __future__ import annotations

import struct

import pytest

from targets.parts.at24c02 import At24c02
from targets.parts.mpu6050 import Mpu6050
from targets.parts.mpu9250 import Mpu9250
from targets.parts.part import Ports
from targets.parts.ssd1306 import Ssd1306
from targets.parts.testing import PartBench, Wire
from targets.parts.w25q.w25q import W25q
from tests.share import few

MS = 1_000_000
REST = {"ax": 0.0, "ay": 0.0, "az": 9.80665, "wx": 0.0, "wy": 0.0, "wz": 0.0}
# By the part: address, first register, what four bytes from there on are; the sensors begin with WHO_AM_I.
SLAVES = {
    At24c02: (0x50, 0x20, "ffffffff"),
    Mpu6050: (0x68, 0x75, "68000000"),
    Mpu9250: (0x68, 0x75, "7100"),  # then offsets, which are seeded
    Ssd1306: (0x3C, 0x80, "40404040"),  # its status: the display is off
}
WAYS = ("polled", "by interrupt", "by dma")
IDENTITY = "ffef4017"


class Rig:
    """A board with the image, a slave on I2C1 and a flash on SPI1.

    Attributes:
        bus: the bus of I2C1.
        i2c: the interface.
        nss: the pin NSS of SPI1.
    """

    def __init__(self, start, kind, spi_mode=0):
        self.run = start("style-bus-ways")
        machine = self.run.machine
        address, first, _ = SLAVES[kind]
        settings = struct.pack("<I4B", 0x5E77_196E, address, first, spi_mode, 0)
        self._at(0.1, lambda: machine.ram.__setitem__(slice(len(settings)), settings))
        self.i2c, self.nss = machine.chip.i2cs["I2C1"], machine.chip.pins["PA4"]
        self.bus = self.i2c.bus
        self.bus.attach(PartBench(kind, kind.Settings(), quantities=lambda _ns: REST).part.slave("i2c"))
        select = Wire()
        machine.chip.pins["PB0"].on_edge(lambda _cycle, ns, level: select.set(level, ns))
        flash = W25q(W25q.Settings(), Ports(inputs={"cs": select}), seed=1)
        machine.chip.spis["SPI1"].bus.attach(flash.spi_slave("spi"))

    def _at(self, ms, action):
        self.run.machine.at_ns(int(ms * MS), action)

    def during_the_first_round(self, begin, end):
        """Let something begin before the first round, and end after it."""
        self._at(0.1, begin)
        self._at(50, end)

    def said(self, bus):
        """Run to the end; return what was said of a bus in each round, by the ways."""
        lines = [line.split(": ") for line in self.run.to(100).sent["USART1"].decode().splitlines()]
        found = [(way.removeprefix(f"{bus} "), what) for way, what in lines if way.startswith(bus)]
        assert [way for way, _ in found] == [*WAYS, *WAYS]
        return [what for _, what in found[:3]], [what for _, what in found[3:]]


def all_ways(what):
    return [what] * len(WAYS)


@pytest.mark.parametrize("kind", few([*SLAVES], 1, "the gate has one of the parts"))
def test_each_part_is_read(start, kind):
    """The sensors do not acknowledge before they are ready, 20 and 35 ms after power-on."""
    rig, content = Rig(start, kind), SLAVES[kind][2]
    first, second = rig.said("i2c")
    assert first == all_ways("no acknowledge") if kind in (Mpu6050, Mpu9250) else second
    assert [what[: len(content)] for what in second] == all_ways(content)
    assert rig.said("spi") == (all_ways(IDENTITY), all_ways(IDENTITY))


FAULTS = {
    "nobody": (lambda rig: rig.bus.deaf.add(0x50), lambda rig: rig.bus.deaf.clear(), "no acknowledge"),
    "SDA low": (lambda rig: rig.bus.stick(), lambda rig: rig.bus.unstick(), "bus busy"),
    "SCL low for 6 ms": (
        lambda rig: rig.bus.stretch_ns.update({0x50: 6 * MS}),
        lambda rig: rig.bus.stretch_ns.clear(),
        "no event",
    ),
    "SCL low for 0.3 ms": (
        lambda rig: rig.bus.stretch_ns.update({0x50: 3 * MS // 10}),
        lambda rig: rig.bus.stretch_ns.clear(),
        "ffffffff",
    ),
}


@pytest.mark.parametrize("fault", few([*FAULTS], 1, "the gate has one of the faults"))
def test_a_fault_reaches_each_way_and_goes(start, fault):
    """Each on I2C, and another master at NSS on SPI."""
    begin, end, says = FAULTS[fault]
    rig = Rig(start, At24c02)
    rig.during_the_first_round(lambda: begin(rig), lambda: end(rig))
    rig.during_the_first_round(lambda: rig.nss.drive(False), lambda: rig.nss.drive(None))
    assert rig.said("i2c") == (all_ways(says), all_ways("ffffffff"))
    assert rig.said("spi") == (all_ways("mode fault"), all_ways(IDENTITY))


@pytest.mark.exhaustive("two more errors; the gate has the faults")
@pytest.mark.parametrize(("error", "says"), [("ARLO", "arbitration lost"), ("BERR", "bus error")])
def test_an_error_in_the_middle_of_a_message_reaches_each_way(start, error, says):
    rig, written = Rig(start, At24c02), []
    write = rig.bus.write

    def write_and_disturb(byte, now_ns):
        written.append(byte)
        if len(written) <= len(WAYS):
            rig.run.machine.at_ns(now_ns + 5000, lambda: rig.i2c.disturb(error))
        return write(byte, now_ns)

    rig.bus.write = write_and_disturb
    assert rig.said("i2c") == (all_ways(says), all_ways("ffffffff"))


@pytest.mark.exhaustive("three more modes; the gate has mode 0")
@pytest.mark.parametrize(("mode", "identity"), [(1, "ffffffff"), (2, "ffffffff"), (3, IDENTITY)])
def test_a_flash_is_identified_in_its_modes_alone(start, mode, identity):
    """W25Q64JV section 6.1.1: modes 0 and 3."""
    assert Rig(start, At24c02, spi_mode=mode).said("spi") == (all_ways(identity), all_ways(identity))
