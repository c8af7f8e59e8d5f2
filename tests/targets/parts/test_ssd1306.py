"""An SSD1306 by its data sheet: where bytes go, what is seen of them, and what keeps the panel dark."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.i2c_bus import I2cBus
from targets.parts.ssd1306 import COLUMNS, DisplayNote, DisplaySwitched, Ssd1306, Ssd1306Settings
from targets.parts.testing import PartBench
from tests.each import each

UPRIGHT = (0xA1, 0xC8)
ON = (0x8D, 0x14, 0xAF)


class Rig:
    """A display and a master on a bus."""

    def __init__(self, *commands, **settings):
        self.bench = PartBench(Ssd1306, Ssd1306Settings(**settings))
        self.part = self.bench.part
        self.bus = I2cBus()
        self.bus.attach(self.part.slave("i2c"))
        self.commands(*commands)

    def send(self, *message, address=0x3C):
        self.bus.start(0)
        there = self.bus.address(address, False, 0)
        if there:
            assert all(self.bus.write(byte, 0) for byte in message)
        self.bus.stop(0)
        return there

    def commands(self, *commands):
        self.send(0x00, *commands)

    def data(self, *data):
        self.send(0x40, *data)

    def lit(self):
        shown = self.part.picture()
        return {(at % shown.width, at // shown.width) for at, grey in enumerate(shown.grey) if grey}

    @property
    def told(self):
        return [event for _, event in self.bench.events]


def test_a_byte_is_a_column_of_eight_rows():
    rig = Rig(*UPRIGHT, *ON)
    rig.commands(0xB2, 0x05, 0x13)
    rig.data(0b1000_0001, 0x02)
    assert rig.lit() == {(0x35, 16), (0x35, 23), (0x36, 17)}


def test_page_mode_stays_in_its_page():
    rig = Rig(*UPRIGHT, *ON, 0xB7, 0x0E, 0x17)
    rig.data(*([1] * 4))
    assert rig.lit() == {(x, 56) for x in (126, 127, 0, 1)}


def test_horizontal_mode_goes_through_a_window():
    rig = Rig(*UPRIGHT, *ON, 0x20, 0, 0x21, 10, 12, 0x22, 1, 2)
    rig.data(*([1] * 7))
    assert rig.lit() == {(x, y) for x in (10, 11, 12) for y in (8, 16)}
    assert rig.part.ram[COLUMNS + 10 : COLUMNS + 13] == b"\1\1\1"


def test_vertical_mode_goes_through_a_window():
    rig = Rig(*UPRIGHT, *ON, 0x20, 1, 0x21, 10, 12, 0x22, 1, 2)
    rig.data(1, 2, 1)
    assert rig.lit() == {(10, 8), (10, 17), (11, 8)}


def test_a_window_that_is_set_in_page_mode_is_none():
    rig = Rig(*UPRIGHT, *ON, 0xB1, 0x05, 0x21, 10, 12, 0x22, 2, 3)
    rig.data(1)
    assert rig.lit() == {(5, 8)}
    rig.commands(0x20, 0)
    rig.data(*([1] * 128))  # from where it stands, through all columns
    assert rig.lit() >= {(5, 8), (6, 8), (127, 8), (0, 16)}


def test_commands_may_come_one_by_one_and_with_data_behind_them():
    rig = Rig()
    rig.send(0x80, 0x8D, 0x80, 0x14, 0x80, 0xAF, 0x80, 0xA1, 0x80, 0xC8, 0xC0, 1, 0x40, 2, 4)
    assert rig.lit() == {(0, 0), (1, 1), (2, 2)}


def test_operands_may_come_in_the_next_message():
    rig = Rig(*UPRIGHT, *ON)
    rig.commands(0x81)
    rig.commands(0x12)
    assert rig.part.contrast == 0x12


@each(
    ("commands", "at"),
    [
        ((0xA1, 0xC8), (0, 0)),
        ((0xA0, 0xC8), (127, 0)),
        ((0xA1, 0xC0), (0, 63)),
        ((0xA1, 0xC8, 0x48), (0, 56)),  # the line 8 is the first: line 0 stands 8 from the end
        ((0xA1, 0xC0, 0xD3, 8), (0, 7)),  # table 10-2: row 0 at COM 56
        ((0xA1, 0xC8, 0xD3, 8), (0, 56)),  # table 10-3: row 0 at COM 7
        ((0xA1, 0xC8, 0xA8, 47), (0, 16)),  # row 0 at COM 47
    ],
)
def test_where_the_first_pixel_is_seen(commands, at):
    rig = Rig(*ON, *commands)
    rig.data(1)
    assert rig.lit() == {at}


def test_the_direction_of_columns_counts_when_data_come():
    rig = Rig(*UPRIGHT, *ON)
    rig.data(1)
    rig.commands(0xA0)
    assert rig.lit() == {(0, 0)}


def test_inverse_and_all_lit():
    rig = Rig(*UPRIGHT, *ON, 0xA7)
    rig.data(1)
    assert (0, 0) not in rig.lit()
    assert len(rig.lit()) == 128 * 64 - 1
    rig.commands(0xA6, 0xA5)
    assert len(rig.lit()) == 128 * 64
    rig.commands(0xA4, 0xA8, 31)
    assert rig.lit() == {(0, 32)}


def test_what_keeps_it_dark_is_told():
    rig = Rig(0xAF, 0xA5)
    assert not rig.lit()
    assert rig.told == [
        DisplayNote(
            command=0xAF, why="the display is on and dark: the panel has no voltage: the charge pump is off (8D)"
        )
    ]
    rig.commands(0x8D, 0x14)
    assert rig.told[1:] == [DisplaySwitched(lit=True, at_ns=0)]
    assert len(rig.lit()) == 128 * 64
    rig.commands(0xAE)
    assert rig.told[2:] == [DisplaySwitched(lit=False, at_ns=0)]
    assert not rig.lit()


def test_a_supply_of_its_own_needs_no_pump():
    assert Rig(0xAF, 0xA5, vcc=True).lit()


def test_a_panel_of_32_rows_has_another_wiring():
    rig = Rig(*UPRIGHT, 0xA8, 31, *ON, rows=32)
    assert not rig.lit()
    assert "DA" in rig.told[0].why
    rig.commands(0xDA, 0x02)
    rig.data(0x81)
    assert rig.lit() == {(0, 0), (0, 7)}


@each(
    ("commands", "words"),
    [
        ((0x2F,), "scrolling: not modelled"),
        ((0x29, 0, 0, 0, 0, 1), "scrolling: not modelled"),
        ((0x3F,), "no such command"),
        ((0x20, 3), "reserved"),
        ((0xA8, 3), "reserved"),
        ((0x21, 0, 127), "the columns of a window are set in page mode: no effect"),
        ((0x22, 0, 7), "the pages of a window are set in page mode: no effect"),
        ((0x20, 0, 0xB1), "no effect"),
        ((0x20, 0, 0x11), "no effect"),
    ],
)
def test_what_it_does_not_do_is_told_once(commands, words):
    rig = Rig(*commands, *commands)
    assert len(rig.told) == 1
    assert words in rig.told[0].why


def test_a_read_says_whether_it_is_off():
    rig = Rig()
    rig.bus.start(0)
    assert rig.bus.address(0x3C, True, 0)
    assert rig.bus.read(0) == 0x40
    rig.commands(*ON)
    rig.bus.start(0)
    rig.bus.address(0x3C, True, 0)
    assert rig.bus.read(0) == 0


def test_it_has_two_addresses():
    assert not Rig().send(0, address=0x3D)
    assert Rig(sa0=True).send(0, address=0x3D)


@given(st.lists(st.binary(max_size=40), max_size=8))
def test_any_bytes_are_taken(messages):
    rig = Rig(*ON)
    for message in messages:
        rig.send(*message)
    shown = rig.part.picture()
    assert len(shown.grey) == shown.width * shown.height
