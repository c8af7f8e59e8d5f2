"""Which I2C interfaces are on the same two wires: by their pins, their modes, and the nets of the bench."""

from __future__ import annotations

from types import SimpleNamespace

from targets.mcu.i2c_bus import I2cBus
from targets.mcu.nets import Nets
from targets.mcu.pins import PadMode, Pins
from targets.mcu.signals import Signals
from targets.mcu.stm32f1.i2c_joined import join
from targets.mcu.testing import FakeChip
from tests.each import each

NAMES = ("PB6", "PB7", "PB8", "PB9", "PB10", "PB11")


class Chip:
    """Two interfaces at their pins, which carry them, and no wires."""

    def __init__(self):
        fake = FakeChip()
        self.notes = fake.notes
        self.pins = Pins(NAMES, fake.time, fake.notes)
        self.signals, self.nets = Signals(self.pins), Nets()
        self.one, self.other = (SimpleNamespace(name=name, bus=I2cBus(), held_low=None) for name in ("I2C1", "I2C2"))
        join([self.one, self.other], self.signals)
        self.route("I2C1", "PB6", "PB7")
        self.route("I2C2", "PB10", "PB11")
        for name in NAMES:
            self.configure(name, PadMode.AF_OPEN_DRAIN)

    def route(self, name, scl, sda):
        self.signals.route(f"{name}_SCL", scl)
        self.signals.route(f"{name}_SDA", sda)

    def configure(self, name, mode):
        self.pins[name].configure(mode, latch=True, pull=None)

    def wire(self, *names):
        self.nets.wire("-".join(names), *(self.pins[name] for name in names))
        return self

    @property
    def joined(self):
        found = (self.one.bus.joined(), self.other.bus.joined())
        assert found in (((self.other.bus,), (self.one.bus,)), ((), ())), "each sees the other, or neither does"
        return bool(found[0])


@each(
    ("wires", "joined"),
    [
        ((), False),
        ((("PB6", "PB10"),), False),
        ((("PB7", "PB11"),), False),
        ((("PB6", "PB10"), ("PB7", "PB11")), True),
        ((("PB6", "PB8", "PB10"), ("PB7", "PB11")), True),
        ((("PB6", "PB11"), ("PB7", "PB10")), False),  # crossed
        ((("PB6", "PB8"), ("PB7", "PB9")), False),
    ],
)
def test_by_both_wires_or_not_at_all(wires, joined):
    chip = Chip()
    for names in wires:
        chip.wire(*names)
    assert chip.joined is joined


@each("pin", ["PB6", "PB7", "PB10", "PB11"])
def test_a_pin_that_the_program_moves_itself_carries_no_signal(pin):
    chip = Chip().wire("PB6", "PB10").wire("PB7", "PB11")
    chip.configure(pin, PadMode.OPEN_DRAIN)
    assert not chip.joined
    chip.configure(pin, PadMode.AF_OPEN_DRAIN)
    assert chip.joined


def test_a_wire_to_another_chip_is_noted():
    chip, far = Chip(), Chip()
    chip.nets.wire("SCL", chip.pins["PB6"], far.pins["PB6"])
    assert not chip.joined
    assert not chip.notes.all
    chip.nets.wire("SDA", chip.pins["PB7"], far.pins["PB7"])
    assert not chip.joined
    assert [(note.kind, note.where) for note in chip.notes.all] == [("unmodelled", "I2C1_SCL")]


def test_remapped_pins_have_other_wires():
    chip = Chip().wire("PB8", "PB10").wire("PB9", "PB11")
    assert not chip.joined
    chip.route("I2C1", "PB8", "PB9")
    assert chip.joined


@each(
    ("pin", "level", "low"),
    [("PB6", False, "I2C1_SCL"), ("PB7", False, "I2C1_SDA"), ("PB7", True, ""), ("PB7", None, "")],
)
def test_a_line_that_is_held_low_outside_is_told(pin, level, low):
    chip = Chip()
    chip.pins[pin].drive(level)
    assert chip.one.held_low() == low
    assert chip.other.held_low() == ""
