"""An EEPROM at two pins of an F103: a program that moves them by itself, and one that frees a bus with them."""

from __future__ import annotations

import contextlib

import pytest

from hilbench.benchfile.reader import open_bench
from hilbench.errors import UsageError
from hilbench.mcu.emulated import EmulatedBench
from hilbench.mcu.under_test import boards_under_test
from targets.firmware import image_path
from targets.mcu.i2c_bus import RELEASED
from targets.mcu.pins import PadMode

BENCH = """
version = 1
[targets.brain]
board = "bluepill"
firmware = "{}"
[parts.memory]
kind = "at24c02"
buses = {{ i2c = {} }}
"""
INTERFACE, PINS = '"brain.I2C1"', '{ scl = "brain.PB6", sda = "brain.PB7" }'


@pytest.fixture
def run(tmp_path):
    """Run an image on a bench whose memory is at that bus; return what it has said, and the bench."""
    with contextlib.ExitStack() as undo:

        def go(bus, image="style-soft-i2c"):
            file = tmp_path / "b.toml"
            file.write_text(BENCH.format(image_path(image), bus))
            emulated = EmulatedBench(open_bench(str(file)))
            undo.callback(emulated.close)
            board = boards_under_test(emulated)["brain"]
            board.run(0.06)
            return board.usart("usart1").text.splitlines(), emulated

        yield go


def test_a_slave_in_the_middle_of_a_byte_is_freed_by_clocks(run):
    said, emulated = run(INTERFACE)
    # It was left in the fourth bit: one clock for each of the bits 5 to 8, and the one that ends its own.
    assert said == ["bits: ok", "SDA is held low", "I2C1 is busy", "freed after 5 clocks", "I2C1: ok"]
    assert emulated.surroundings.parts.by_name["memory"].data[0x20:0x28] == bytes(range(0, 24, 3))
    assert not emulated.notes()


def test_at_its_pins_both_the_program_and_an_interface_find_it(run):
    said, emulated = run(PINS)
    assert said == ["bits: ok", "SDA is free", "I2C1 is free", "freed after 0 clocks", "I2C1: ok"]
    ended = [event for event in emulated.bench.journal.recent if event.get("name") == "I2cTransaction"]
    assert {event["source"] for event in ended} == {"brain.pb6.pb7", "brain.i2c1"}


def test_an_interface_finds_it_in_each_way_of_a_driver(run):
    said, _ = run(PINS, image="style-eeprom")
    assert said == ["polled: ok", "by interrupt: ok", "by dma: ok"]


@pytest.mark.parametrize(("scl", "sda"), [(False, False), (True, False), (False, True), (True, True)])
def test_an_interface_reaches_it_by_both_pins_or_not_at_all(tmp_path, scl, sda):
    file = tmp_path / "b.toml"
    file.write_text(BENCH.format(image_path("style-soft-i2c"), PINS))
    emulated = EmulatedBench(open_bench(str(file)))
    chip = emulated.machines["brain"].chip
    for pin, carries in (("PB6", scl), ("PB7", sda)):
        mode = PadMode.AF_OPEN_DRAIN if carries else PadMode.OPEN_DRAIN
        chip.pins[pin].configure(mode, latch=True, pull=None)
    bus = chip.i2cs["I2C1"].bus
    bus.start(0)
    assert bus.address(0x50, False, 0) is (scl and sda)
    if scl and sda:  # taken away in the middle
        assert bus.write(0x20, 0)
        chip.pins["PB6"].configure(PadMode.OPEN_DRAIN, latch=True, pull=None)
        assert not bus.write(0x21, 0)
        assert bus.read(0) == RELEASED
    emulated.close()


def test_at_other_pins_nobody_finds_it(run):
    said, _ = run('{ scl = "brain.PB6", sda = "brain.PB8" }')
    assert said[0] == "bits: failed"
    assert said[-1] == "I2C1: failed"


@pytest.mark.parametrize(
    ("bus", "words"),
    [
        ('{ scl = "brain.PB6", sda = "brain.PB6" }', "brain.PB6 and brain.PB6 are not two pins of one board"),
        ('{ scl = "brain.PB6" }', "the key 'sda' is missing"),
        ('{ scl = "other.PB6", sda = "brain.PB7" }', "'other.PB6' is not a pin of a board"),
        ('{ scl = "brain.PB6", sda = "brain.PB77" }', "'brain' has no pin 'PB77'"),
        ('{ scl = "brain.PB6", sda = "brain.PB7", miso = "brain.PB8" }', "miso"),
    ],
)
def test_wrong_pins_are_refused(run, bus, words):
    with pytest.raises(UsageError, match=words):
        run(bus)
