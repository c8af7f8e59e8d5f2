"""The I2C bus: who is addressed, what is read, what is told."""

from __future__ import annotations

import pytest

from targets.mcu.i2c_bus import I2cBus, I2cMessage, I2cTransaction


@pytest.fixture
def bus():
    return I2cBus()


@pytest.fixture
def told(bus):
    told = []
    bus.taps.append(told.append)
    return told


def message(address, read, data, at_ns, **fields):
    rest = {"acknowledged": True, "refused": False, **fields}
    return I2cMessage(address=address, read=read, data=data, at_ns=at_ns, **rest)


def test_a_register_read_is_one_transaction(bus, told, make_memory):
    memory = make_memory(0x50)
    bus.attach(memory)
    bus.start(100)
    assert bus.address(0x50, False, 200)
    assert bus.write(7, 300)
    bus.start(400)
    assert bus.address(0x50, True, 500)
    assert [bus.read(500), bus.read(600)] == [7, 8]
    assert told == []
    bus.stop(800)
    both = (message(0x50, False, b"\7", 100), message(0x50, True, b"\7\x08", 400))
    assert told == [I2cTransaction(messages=both, begin_ns=100, end_ns=800, complete=True)]
    assert memory.calls == [
        ("address", 0x50, False, 200),
        ("write", 7, 300),
        ("end", 400),
        ("address", 0x50, True, 500),
        ("read", 500),
        ("read", 600),
        ("end", 800),
    ]


def test_only_who_acknowledges_takes_part(bus, make_memory):
    near, far = make_memory(0x50), make_memory(0x51)
    bus.attach(near)
    bus.attach(far)
    bus.start(0)
    assert bus.address(0x51, False, 1)
    assert bus.write(3, 2)
    bus.stop(3)
    assert [call[0] for call in near.calls] == ["address"]
    assert [call[0] for call in far.calls] == ["address", "write", "end"]


def test_an_address_of_nobody(bus, told, make_memory):
    bus.attach(make_memory(0x50))
    bus.start(0)
    assert not bus.address(0x22, True, 1)
    assert bus.read(1) == 0xFF
    bus.stop(2)
    assert told[0].messages == (message(0x22, True, b"\xff", 0, acknowledged=False),)


def test_what_any_pulls_low_is_low(bus, make_memory):
    bus.attach(make_memory(0x50, bytes([0b1100]) * 256))
    bus.attach(make_memory(0x50, bytes([0b1010]) * 256))
    bus.start(0)
    assert bus.address(0x50, True, 1)
    assert bus.read(1) == 0b1000


def test_a_byte_that_is_refused(bus, told, make_memory):
    memory = make_memory()
    memory.write = lambda _byte, _ns: False
    bus.attach(memory)
    bus.start(0)
    assert bus.address(0x50, False, 1)
    assert not bus.write(1, 2)
    bus.stop(3)
    assert told[0].messages == (message(0x50, False, b"\1", 0, refused=True),)


def test_general_call_is_for_who_takes_it(bus, make_memory):
    bus.attach(make_memory(0x50))
    bus.start(0)
    assert not bus.address(0, False, 1)
    bus.stop(2)
    bus.attach(make_memory(0))
    bus.start(3)
    assert bus.address(0, False, 4)


def test_deaf(bus, make_memory):
    memory = make_memory(0x50)
    bus.attach(memory)
    bus.deaf.add(0x50)
    bus.start(0)
    assert not bus.address(0x50, False, 1)
    assert memory.calls == []


def test_stuck_is_all_low(bus, make_memory):
    changes = []
    bus.on_stuck.append(lambda: changes.append(bus.stuck))
    bus.attach(make_memory(0x50))
    bus.stick()
    bus.stick()
    bus.start(0)
    assert bus.address(0x11, True, 1)
    assert bus.read(1) == 0
    assert bus.write(1, 2)
    bus.unstick()
    assert changes == [True, False]


def test_released_in_the_middle(bus, told, make_memory):
    memory = make_memory(0x50)
    bus.attach(memory)
    bus.start(0)
    bus.address(0x50, False, 10)
    bus.release(15)
    (only,) = told
    assert not only.complete
    assert only.end_ns == 15
    assert ("end", 15) not in memory.calls
    bus.release(16)
    assert told == [only]
    bus.start(20)
    assert memory.calls[-1] == ("end", 20)


class TestJoined:
    """Two buses on the same wires."""

    @pytest.fixture
    def other(self, bus):
        other = I2cBus()
        bus.joined, other.joined = lambda: (other,), lambda: (bus,)
        return other

    def test_the_slaves_of_both_are_reached_from_either(self, bus, other, told, make_memory):
        bus.attach(make_memory(0x50, b"\x0c" * 256))
        other.attach(make_memory(0x50, b"\x0a" * 256))
        for master in (bus, other):
            master.start(0)
            assert master.address(0x50, True, 1)
            assert master.read(1) == 0x08
            master.stop(2)
        assert len(told) == 1  # a bus tells what its own master does

    def test_what_breaks_one_breaks_both(self, bus, other, make_memory):
        changes = []
        bus.on_stuck.append(lambda: changes.append("bus"))
        other.on_stuck.append(lambda: changes.append("other"))
        bus.attach(make_memory(0x50))
        other.stick()
        assert bus.stuck
        assert changes == ["other", "bus"]
        bus.start(0)
        assert bus.address(0x11, True, 1)
        assert bus.read(1) == 0
        bus.stop(2)
        other.unstick()
        other.deaf.add(0x50)
        other.stretch_ns[0x50] = 700
        bus.start(3)
        assert not bus.address(0x50, False, 4)
        other.deaf.clear()
        assert bus.address(0x50, False, 5)
        assert bus.stretched_ns == 700

    def test_a_start_ends_what_a_slave_of_the_other_was_left_in(self, bus, other, make_memory):
        other.clocked_by_pins = True
        other.attach(make_memory(0x50, b"\0" * 256))
        other.start(0)
        other.address(0x50, True, 1)
        other.read(1)
        other.release(2, 3)
        assert bus.stuck
        bus.start(3)
        assert not bus.stuck
        assert other.left is None


def test_stretch_belongs_to_the_slave_that_is_addressed(bus, make_memory):
    bus.attach(make_memory(0x50))
    bus.attach(make_memory(0x51))
    bus.stretch_ns[0x50] = 700
    assert bus.stretched_ns == 0
    bus.start(0)
    assert bus.stretched_ns == 0
    bus.address(0x50, False, 1)
    assert bus.stretched_ns == 700
    bus.start(2)
    bus.address(0x51, False, 3)
    assert bus.stretched_ns == 0
