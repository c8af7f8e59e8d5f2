"""The wires of an I2C bus, bit by bit: what a program that moves them finds is what an interface finds (UM10204)."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.i2c_bus import I2cBus
from targets.mcu.i2c_pins import I2cPins
from targets.mcu.nets import Nets
from targets.mcu.pins import PadMode, Pins
from targets.mcu.signals import Signals
from targets.mcu.testing import FakeChip
from tests.each import each

HERE = 0x42
QUARTER = 20  # cycles


class Memory:
    """A slave that acknowledges so many bytes, sends what it is given, and keeps what happens."""

    def __init__(self, sends=(), takes=100):
        self.sends, self.takes, self.happened = list(sends), takes, []

    def address(self, address, read, now_ns):
        self.happened.append(("address", address, read))
        return address == HERE

    def write(self, byte, now_ns):
        self.takes -= 1
        self.happened.append(("write", byte))
        return self.takes >= 0

    def read(self, now_ns):
        byte = self.sends.pop(0) if self.sends else 0xFF
        self.happened.append(("read", byte))
        return byte

    def end(self, now_ns):
        self.happened.append(("end",))


class Program:
    """A master of two open-drain pins."""

    def __init__(self, slave):
        self.chip = FakeChip(72_000_000)
        self.pins = Pins(("PB6", "PB7", "PB8", "PB9", "PB10"), self.chip.time, self.chip.notes)
        self.scl, self.sda = self.pins["PB6"], self.pins["PB7"]
        for pin in (self.scl, self.sda):
            pin.configure(PadMode.OPEN_DRAIN, latch=True, pull=None)
        self.bus, self.ended = I2cBus(), []
        self.bus.taps.append(self.ended.append)
        self.bus.attach(slave)
        self.wires = I2cPins(self.bus)
        self.wires.put_at(self.scl, self.sda)

    def put(self, pin, level):
        pin.set_latch(level)
        self.chip.advance(QUARTER)

    def clock_up(self):
        self.put(self.scl, True)
        while self.scl.level is not True:
            self.chip.advance(QUARTER)

    def bit(self, out=True):
        self.put(self.sda, out)
        self.clock_up()
        found = self.sda.level is True
        self.put(self.scl, False)
        return found

    def start(self):
        self.put(self.sda, True)
        self.clock_up()
        self.put(self.sda, False)
        self.put(self.scl, False)

    def stop(self):
        self.put(self.sda, False)
        self.clock_up()
        self.put(self.sda, True)

    def send(self, byte):
        for at in range(7, -1, -1):
            self.bit(bool(byte >> at & 1))
        return not self.bit()

    def receive(self, acknowledge):
        byte = 0
        for _ in range(8):
            byte = byte << 1 | self.bit()
        self.bit(not acknowledge)
        return byte


def messages(program, parts):
    """Send and read these messages, divided by repeated STARTs; return what was acknowledged and what came."""
    found = []
    for address, read, data in parts:
        program.start()
        acknowledged = program.send(address << 1 | read)
        found.append(acknowledged)
        if acknowledged and read:
            found += [program.receive(number + 1 < len(data)) for number in range(len(data))]
        elif acknowledged:
            for byte in data:
                found.append(program.send(byte))
                if not found[-1]:
                    break
    program.stop()
    return found


def messages_by_interface(bus, parts):
    """Do the same byte by byte."""
    found = []
    for address, read, data in parts:
        bus.start(0)
        found.append(bus.address(address, read, 0))
        if found[-1] and read:
            found += [bus.read(0) for _ in data]
        elif found[-1]:
            for byte in data:
                found.append(bus.write(byte, 0))
                if not found[-1]:
                    break
    bus.stop(0)
    return found


_PART = st.tuples(
    st.sampled_from([HERE, HERE, 0x21]), st.booleans(), st.lists(st.integers(0, 255), min_size=1, max_size=3)
)


@given(st.lists(_PART, min_size=1, max_size=3), st.lists(st.integers(0, 255), max_size=9), st.integers(0, 4))
def test_bits_are_what_bytes_are(parts, sends, takes):
    by_bits, by_bytes = Memory(sends, takes), Memory(sends, takes)
    program, bus, ended = Program(by_bits), I2cBus(), []
    bus.attach(by_bytes)
    bus.taps.append(ended.append)
    assert messages(program, parts) == messages_by_interface(bus, parts)
    assert by_bits.happened == by_bytes.happened
    (mine,), (theirs,) = program.ended, ended
    assert [(m.address, m.read, m.data, m.refused) for m in mine.messages] == [
        (m.address, m.read, m.data, m.refused) for m in theirs.messages
    ]
    assert program.sda.level is program.scl.level is True
    assert not program.chip.notes.all


@given(st.integers(0, 255), st.integers(1, 8))
def test_a_slave_that_was_left_in_a_byte_goes_on_with_it(byte, clock):
    program = Program(Memory([byte]))
    program.bus.start(0)
    program.bus.address(HERE, True, 0)
    program.bus.read(0)
    program.bus.release(0, clock)
    assert program.bus.stuck is (program.sda.level is False) is not bool(byte >> 8 - clock & 1)
    bits = [program.sda.level is True]
    program.put(program.scl, False)
    bits += [program.bit() for _ in range(8 - clock)]
    assert bits == [bool(byte >> at & 1) for at in range(8 - clock, -1, -1)]
    assert program.bit()
    assert [program.bit() for _ in range(9)] == [True] * 9
    assert not program.bus.stuck


def test_a_start_ends_what_a_slave_was_left_in():
    program = Program(Memory([0xFF, 0x00]))
    program.bus.start(0)
    program.bus.address(HERE, True, 0)
    program.bus.read(0)
    program.bus.release(0, 3)
    assert messages(program, [(HERE, False, [7])]) == [True, True]


def test_it_stretches_the_clock():
    program = Program(Memory())
    program.bus.stretch_ns[HERE] = 1_000_000
    program.start()
    assert program.send(HERE << 1)
    begin_ns = program.scl.now_ns()
    program.send(5)
    assert program.scl.now_ns() - begin_ns > 900_000


def test_a_slave_that_holds_sda_holds_the_pin():
    program = Program(Memory())
    program.bus.stick()
    assert program.sda.level is False
    program.bus.unstick()
    assert program.sda.level is True


def test_it_goes_with_the_signals_of_an_interface():
    program = Program(Memory([0x5A]))
    signals = Signals(program.pins)
    program.wires.follow(signals.input("I2C1_SCL"), signals.input("I2C1_SDA"))
    assert program.scl.level is None
    signals.route("I2C1_SCL", "PB8")
    signals.route("I2C1_SDA", "PB9")
    program.scl, program.sda = program.pins["PB8"], program.pins["PB9"]
    for pin in (program.scl, program.sda):
        pin.configure(PadMode.OPEN_DRAIN, latch=True, pull=None)
    assert messages(program, [(HERE, True, [0])]) == [True, 0x5A]


@each("wired", ["PB7", "PB6"])
def test_who_is_wired_to_a_pin_hears_it(wired):
    program = Program(Memory())
    Nets().wire("tap", program.pins[wired], program.pins["PB10"])
    program.pins["PB10"].record()
    assert messages(program, [(HERE, False, [0])]) == [True, True]
    # SCL rises for START, 18 bits and STOP; SDA falls at START, rises with address and its end, is 0 up to the STOP.
    assert len(program.pins["PB10"].take_edges()) >= (38 if wired == "PB6" else 4)
