"""Images in five styles (Arduino core, libopencm3, HAL, LL, kernel with drivers): what they find at their buses."""

from __future__ import annotations

import contextlib
from itertools import product

import pytest

from hilbench.benchfile.reader import open_bench
from hilbench.mcu.emulated import EmulatedBench
from hilbench.mcu.under_test import boards_under_test
from targets.firmware import image_path

BENCH = """
version = 1
[targets.brain]
board = "bluepill"
firmware = "{image}"
"""
PARTS = {
    "memory": """
[parts.memory]
kind = "at24c02"
buses = { i2c = "brain.I2C1" }
""",
    "flash": """
[parts.flash]
kind = "w25q"
pins = { cs = "brain.PA4" }
buses = { spi = "brain.SPI1" }
""",
    "display": """
[parts.display]
kind = "ssd1306"
buses = { i2c = "brain.I2C1" }
""",
    "imu": """
[world]
vehicle = "rover-4wd"
[parts.imu]
kind = "mpu6050"
buses = { i2c = "brain.I2C1" }
[parts.imu.signals]
ax = "world.ax"
ay = "world.ay"
az = "world.az"
wx = "world.wx"
wy = "world.wy"
wz = "world.wz"
""",
}


@pytest.fixture
def run(tmp_path):
    """Run an image with these parts at 1.5 V and 0.5 V; return what it has said, its board, and the parts."""
    with contextlib.ExitStack() as undo:

        def go(image, *parts, seconds=0.06, before=lambda _parts: None):
            file = tmp_path / "b.toml"
            file.write_text(BENCH.format(image=image_path(image)) + "".join(PARTS[name] for name in parts))
            emulated = EmulatedBench(open_bench(str(file)))
            undo.callback(emulated.close)
            before(emulated.surroundings.parts.by_name)
            board = boards_under_test(emulated)["brain"]
            board.stimulate("PA0=1.5V")
            board.stimulate("PA1=0.5V")
            board.run(seconds)
            assert not emulated.notes()
            return board.usart("usart1").text.splitlines(), board, emulated.surroundings.parts.by_name

        yield go


def check_sketch(run, *more, seconds=0.06):
    said, board, parts = run("style-arduino", "memory", "flash", *more, seconds=seconds)
    assert said[:4] == ["style-arduino", "buffer: ok", "eeprom: ok", "flash: ok"]
    assert board.is_lit()
    assert parts["memory"].data[0x40:0x48] == bytes(0x31 + at * at for at in range(8))
    assert parts["flash"].array.data[0x1000:0x1028] == bytes(3 * at + 1 for at in range(40))
    return said[4:]


def test_an_arduino_core(run):
    imu, *volts = check_sketch(run)
    assert imu == "imu: wrong"
    assert len(volts) == 2
    assert set(volts) == {"1500 mV 500 mV"}


@pytest.mark.exhaustive("a world with physics; the gate has the same sketch without a sensor")
def test_an_arduino_core_and_an_inertial_sensor(run):
    imu, *said = check_sketch(run, "imu", seconds=0.12)
    assert imu == "imu: ok"
    assert said[0] == "1500 mV 500 mV, on its side"  # the accelerometer takes 30 ms to start
    assert said[-1] == "1500 mV 500 mV, flat"


def test_libopencm3(run):
    said, board, parts = run("style-opencm3", "memory", "flash")
    assert said == ["adc: PA0 1862 supply 3300 mV, sensor 1775 ok", "i2c: ok", "spi: 0xef4017 ok", "rtc: ok"]
    assert board.is_lit()
    assert parts["memory"].data[0x20:0x28] == bytes(0xC3 + 7 * at & 0xFF for at in range(8))
    assert parts["flash"].array.data[0x4000:0x4008] == bytes(0x5A ^ at for at in range(8))


def test_a_kernel_with_drivers(run):
    said, board, parts = run("style-drivers", "memory", "flash", "display")
    assert said == [*(f"{what}: ok" for what in ("eeprom", "display", "flash", "adc", "alarm")), "1500 mV, 500 mV"]
    assert board.is_lit()
    assert parts["memory"].data[0x60:0x70] == bytes(0x80 + 5 * at for at in range(16))
    assert parts["flash"].array.data[0x2000:0x2020] == bytes(11 * at & 0xFF for at in range(32))
    assert parts["display"].ram == bytes((at ^ at >> 7) & 0xFF for at in range(1024))


@pytest.mark.parametrize(
    ("image", "adc", "place", "first", "page", "byte"),
    [
        ("style-hal-buses", "adc 1862 1862 621 1489", 0x70, 0xA0, 0x3000, lambda at: at * 13 + 5),
        ("style-ll-buses", "adc 1862 621 1489", 0x88, 0xE0, 0x5000, lambda at: at << 4 | 15 - at),
    ],
    ids=["hal", "ll"],
)
def test_hal_and_ll(run, image, adc, place, first, page, byte):
    said, board, parts = run(image, "memory", "flash")
    assert said == [f"{what} ok" for what in (adc, "eeprom", "flash", "clock")]
    assert board.is_lit()
    assert parts["memory"].data[place : place + 8] == bytes(first + 3 * at for at in range(8))
    assert parts["flash"].array.data[page : page + 16] == bytes(byte(at) & 0xFF for at in range(16))


def forget(parts):
    parts["memory"].read = lambda _now_ns: 0x5A


def protect(parts):
    parts["flash"]._status[0] = 0x1C


WORDS = {
    "style-arduino": ("eeprom", "flash"),
    "style-drivers": ("eeprom", "flash"),
    "style-hal-buses": ("eeprom", "flash"),
    "style-ll-buses": ("eeprom", "flash"),
    "style-opencm3": ("i2c", "spi"),
}
WRONG = {"forget": (forget, 0), "protect": (protect, 1), "no memory": ("memory", 0), "no flash": ("flash", 1)}


@pytest.mark.parametrize(
    ("image", "wrong"),
    [
        pytest.param(
            image,
            wrong,
            marks=()
            if (image, wrong) == ("style-drivers", "no memory")
            else pytest.mark.exhaustive("another of the same"),
        )
        for image, wrong in product(WORDS, WRONG)
    ],
)
def test_what_is_wrong_is_said(run, image, wrong):
    what, which = WRONG[wrong]
    parts = [name for name in ("memory", "flash") if name != what]
    said, board, _parts = run(image, *parts, seconds=0.15, before=what if callable(what) else lambda _parts: None)
    lines = {word: next(line for line in said if line.startswith(word)) for word in WORDS[image]}
    assert [word for word, line in lines.items() if line.endswith("wrong")] == [WORDS[image][which]]
    assert not board.is_lit()
