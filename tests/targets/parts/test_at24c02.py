"""A 24C02 by its data sheet: pages, the time in which it writes, reading round, WP, addresses."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.i2c_bus import I2cBus
from targets.parts.at24c02 import At24c02, At24c02Settings, EepromWritten
from targets.parts.testing import PartBench
from tests.each import each

MS = 1_000_000


class Rig:
    """An EEPROM and a master on a bus."""

    def __init__(self, **settings):
        self.bench = PartBench(At24c02, At24c02Settings(**settings))
        self.part = self.bench.part
        self.bus = I2cBus()
        self.bus.attach(self.part.slave("i2c"))
        self.now_ns = 0

    def send(self, *data, address=0x50):
        self.now_ns += 100_000
        self.bus.start(self.now_ns)
        if self.bus.address(address, False, self.now_ns):
            assert all(self.bus.write(byte, self.now_ns) for byte in data)
            self.bus.stop(self.now_ns)
            return True
        self.bus.stop(self.now_ns)
        return False

    def read(self, count, address=0x50):
        self.now_ns += 100_000
        self.bus.start(self.now_ns)
        assert self.bus.address(address, True, self.now_ns)
        found = bytes(self.bus.read(self.now_ns) for _ in range(count))
        self.bus.stop(self.now_ns)
        return found

    def wait_ms(self, ms):
        self.now_ns += ms * MS


def test_what_is_written_is_read():
    rig = Rig()
    assert rig.send(0x18, 1, 2, 3)
    rig.wait_ms(5)
    rig.send(0x18)
    assert rig.read(4) == b"\x01\x02\x03\xff"
    assert rig.bench.events[0][1] == EepromWritten(address=0x18, data=b"\x01\x02\x03", protected=False, at_ns=100_000)


def test_while_it_writes_it_acknowledges_nothing():
    rig = Rig()
    rig.send(0, 1)
    rig.wait_ms(4)
    assert not rig.send(0)
    rig.wait_ms(1)
    assert rig.send(0)


@given(place=st.integers(0, 255), data=st.binary(min_size=1, max_size=30))
def test_a_page_goes_on_at_its_beginning(place, data):
    rig = Rig()
    expected = bytearray(b"\xff" * 256)
    for number, byte in enumerate(data):
        expected[place & ~7 | (place + number) & 7] = byte
    rig.send(place, *data)
    assert rig.part.data == expected


def test_reading_goes_on_past_the_end():
    rig = Rig()
    rig.part.data[:] = bytes(range(256))
    rig.send(0xFE)
    assert rig.read(2) + rig.read(2) == b"\xfe\xff\x00\x01"


def test_wp_keeps_everything_and_answers_at_once():
    rig = Rig()
    rig.bench.wires["wp"].set(True, 0)
    assert rig.send(0, 1)
    assert rig.send(0)
    assert rig.read(1) == b"\xff"


@each("pins", [0, 5, 7])
def test_its_address(pins):
    rig = Rig(address_pins=pins)
    assert [address for address in range(0x48, 0x60) if rig.send(0, address=address)] == [0x50 | pins]


@given(messages=st.lists(st.tuples(st.booleans(), st.binary(max_size=20), st.integers(0, 9)), max_size=20))
def test_nothing_breaks_it(messages):
    rig = Rig()
    for reads, data, ms in messages:
        if reads and rig.now_ns >= rig.part._busy_until_ns - 100_000:
            assert len(rig.read(len(data))) == len(data)
        else:
            rig.send(*data)
        rig.wait_ms(ms)
