"""``--part``: a part at a board that has no bench file."""

from __future__ import annotations

import argparse

import pytest

from hilbench.benchfile.bench_file import BusEnd, BusPins, PinEnd
from hilbench.benchfile.part_options import with_parts
from hilbench.benchfile.reader import open_bench
from hilbench.cli import main
from hilbench.errors import UsageError
from hilbench.mcu.command_line import open_target
from targets.firmware import image_path
from targets.parts.at24c02 import At24c02
from tests.each import each


@pytest.fixture(scope="module")
def bench():
    return open_target(f"bluepill:{image_path('style-flash')}")


@pytest.fixture
def solder(bench):
    return lambda *texts: with_parts(argparse.Namespace(part=list(texts)), bench)


def test_nothing_changes_nothing(solder, bench):
    assert solder() is bench


def test_a_bus_a_terminal_and_a_setting(solder):
    made = solder("flash=w25q@spi1,cs=PA4,megabits=32")
    plan = made.parts["flash"]
    assert plan.buses == {"spi": BusEnd(board="bluepill", interface="SPI1")}
    assert plan.settings.megabits == 32
    (net,) = made.nets
    assert net.pins == (PinEnd(board="bluepill", pin="PA4"),)


def test_pins_take_the_place_of_an_interface(solder):
    plan = solder("memory=at24c02@PB6/PB7,wp=3v3,write_ms=2.5").parts["memory"]
    assert plan.buses == {"i2c": BusPins(board="bluepill", scl="PB6", sda="PB7")}
    assert plan.settings.write_ms == 2.5


def test_pins_may_be_written_small(solder):
    made = solder("memory=at24c02@pb6/pb7,wp=pa4")
    assert made.parts["memory"].buses == {"i2c": BusPins(board="bluepill", scl="PB6", sda="PB7")}
    assert made.nets[0].pins == (PinEnd(board="bluepill", pin="PA4"),)


def test_a_bus_may_be_named(solder):
    assert solder("a=ssd1306,i2c=I2C2,sa0=true").parts["a"].settings.sa0


def test_two_parts_share_a_bus(solder):
    assert list(solder("a=at24c02@I2C1", "b=at24c02@I2C1,address_pins=1").parts) == ["a", "b"]


@each(
    ("text", "words"),
    [
        ("display", "'display' is no part; write NAME=KIND@BUS"),
        ("=ssd1306@I2C1", "is no part"),
        ("a=ssd1307@I2C1", "no kind of part 'ssd1307'; did you mean 'ssd1306'?"),
        ("a=ssd1306", "a: its bus 'i2c' leads nowhere"),
        ("a=ssd1306@I2C7", "'bluepill' has no I2C interface 'I2C7'"),
        ("a=ssd1306@PB6/PX1", "'bluepill' has no pin 'PX1'"),
        ("a=ssd1306@PB6/", "'PB6/' is not two pins; write SCL/SDA, such as PB6/PB7"),
        ("a=ssd1306@/PB7", "'/PB7' is not two pins"),
        ("a=ssd1306@PB6/PB7/PB8", "'PB6/PB7/PB8' is not two pins"),
        ("a=ssd1306@I2C1,rows", "'rows' is not KEY=VALUE"),
        ("a=ssd1306@I2C1,row=32", "a ssd1306 has no 'row'; did you mean 'rows'?"),
        ("a=ssd1306@I2C1,rows=33", "33 is not a value it takes; it takes: 32, 64"),
        ("a=battery@I2C1", "a battery has no bus"),
        ("a=mpu6050@I2C1", "a mpu6050 takes physical values, and there is no world; in a bench file: [world]"),
        ("a=w25q@SPI1", "'a': its terminal 'cs' (chip select, active low) is open; add ,cs=PIN to it"),
        ("a=w25q@SPI1,CS=PA4", "a w25q has no 'CS'; did you mean 'cs'?"),
        ("a.b=at24c02@I2C1", "'a.b': a name of a part has no dot; write a_b=at24c02"),
        ("a=ssd1306@I2C1,rows=32,rows=64", "a: 'rows' is given twice; say it once"),
        ("a=ssd1306@I2C1,i2c=I2C2", "a: 'i2c' is given twice; say it once"),
        ("a=ssd1306@I2C1,rows=32\nsa0=true", "has a line break"),
        ("a=ssd1306@I2C1,rows=32#64", "'32#64' is not a value it takes"),
        ("a=ssd1306@I2C1,rows=32 # of 64", "'32 # of 64' is not a value it takes"),
        ("a=ssd1306@I2C1,rows=32]#", "'32]#' is not a value it takes"),
        ("a=w25q@SPI1,cs=PA4#5", "'bluepill' has no pin 'PA4#5'"),
        ("bluepill=at24c02@I2C1", "'bluepill' is the name of a target already"),
    ],
)
def test_what_is_wrong_is_said(solder, text, words):
    with pytest.raises(UsageError) as caught:
        solder(text)
    assert str(caught.value).startswith("--part: ")
    assert words in str(caught.value)


@each(
    ("first", "second", "address", "setting"),
    [
        ("a=at24c02@I2C1,address_pins=1", "b=at24c02@i2c1,address_pins=1", "0x51", "address_pins"),
        ("a=ssd1306@PB6/PB7", "b=ssd1306@pb6/pb7", "0x3C", "sa0"),
    ],
)
def test_two_parts_at_one_address_of_a_bus_are_refused(solder, first, second, address, setting):
    words = f"'b' answers at {address} of the same bus as 'a': a real one would have both answer; set {setting} of one"
    with pytest.raises(UsageError, match=f"^--part: {words}$"):
        solder(first, second)


def test_two_parts_that_have_but_one_address_need_two_buses(solder, monkeypatch):
    monkeypatch.setattr(At24c02, "ADDRESSED_BY", "")
    with pytest.raises(UsageError, match="both answer; put one on another bus"):
        solder("a=at24c02@I2C1", "b=at24c02@I2C1")


def test_one_address_on_two_buses_is_none_of_these(solder):
    assert len(solder("a=at24c02@I2C1", "b=at24c02@I2C2", "c=at24c02@PB6/PB7", "d=ssd1306@I2C1").parts) == 4


def test_a_name_is_given_once(solder):
    with pytest.raises(UsageError, match="two parts called a"):
        solder("a=at24c02@I2C1", "a=at24c02@I2C2")


def test_a_bench_file_has_its_own(tmp_path):
    file = tmp_path / "b.toml"
    file.write_text(f'version = 1\n[targets.brain]\nboard = "bluepill"\nfirmware = "{image_path("style-flash")}"\n')
    with pytest.raises(UsageError, match="is for one board with an image; in a bench file"):
        with_parts(argparse.Namespace(part=["a=at24c02@I2C1"]), open_bench(str(file)))


def test_it_answers(tmp_path):
    file = tmp_path / "shown.png"
    words = ["run", f"bluepill:{image_path('style-display')}", "--for", "30ms"]
    assert main([*words, "--part", "display=ssd1306@PB8/PB9", "--picture", f"display={file}"]) == 0
    assert file.read_bytes().startswith(b"\x89PNG")
