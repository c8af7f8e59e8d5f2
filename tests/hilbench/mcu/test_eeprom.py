"""An EEPROM on the I2C of an F103: a driver in three ways, and each error that the part or the bus can make."""

from __future__ import annotations

import contextlib

import pytest

from hilbench.benchfile.reader import open_bench
from hilbench.mcu.emulated import EmulatedBench
from hilbench.mcu.under_test import boards_under_test
from targets.firmware import image_path

BENCH = f"""
version = 1
[targets.brain]
board = "bluepill"
firmware = "{image_path("style-eeprom")}"
"""
MEMORY = """
[parts.memory]
kind = "at24c02"
buses = { i2c = "brain.I2C1" }
"""


@pytest.fixture
def run(tmp_path):
    """Run the driver on a bench with these lines more; return what it has said, and the bench."""
    with contextlib.ExitStack() as undo:

        def go(more="", seconds=0.05, before=lambda _bus, _part: None):
            file = tmp_path / "b.toml"
            file.write_text(BENCH + more)
            emulated = EmulatedBench(open_bench(str(file)))
            undo.callback(emulated.close)
            board = boards_under_test(emulated)["brain"]
            before(board.i2c("I2C1"), emulated.surroundings.parts.by_name.get("memory"))
            board.run(seconds)
            return board.usart("usart1").text.splitlines(), emulated

        yield go


def test_it_is_written_and_read_in_three_ways(run):
    said, emulated = run(MEMORY)
    assert said == ["polled: ok", "by interrupt: ok", "by dma: ok"]
    data = emulated.surroundings.parts.by_name["memory"].data
    for way in range(3):
        assert data[16 * way + 8 : 16 * way + 16] == bytes(0x11 * (at + 1) + way for at in range(8))
    assert not emulated.notes()
    told = [event for event in emulated.bench.journal.recent if event.get("name") == "EepromWritten"]
    assert len(told) == 3


def test_without_one_nobody_acknowledges(run):
    assert run(seconds=0.01)[0] == ["polled: no acknowledge"]


def refuse(_bus, part):
    part.write = lambda _byte, _now_ns: False


def stick(bus, _part):
    bus.stick()


def forget(_bus, part):
    part.read = lambda _now_ns: 0x5A


def stretch(bus, _part):
    bus.stretch_ns[0x50] = 20_000_000


@pytest.mark.parametrize(
    ("more", "before", "said"),
    [
        (MEMORY, refuse, "no acknowledge"),
        (MEMORY, stick, "bus busy"),
        (MEMORY, forget, "differs"),
        (MEMORY, stretch, "no event"),
        (MEMORY + "settings = { write_ms = 60.0 }\n", lambda _bus, _part: None, "stays busy"),
        (MEMORY + "settings = { address_pins = 3 }\n", lambda _bus, _part: None, "no acknowledge"),
    ],
)  # fmt: skip
def test_each_error_is_seen_by_the_driver(run, more, before, said):
    assert run(more, before=before)[0] == [f"polled: {said}"]


def test_write_protection_is_seen_as_a_difference(run):
    wire = '[[wires]]\nends = ["memory.wp", "3v3"]\n'
    assert run(MEMORY + wire)[0] == ["polled: differs"]
