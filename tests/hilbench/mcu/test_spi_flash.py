"""A flash on the SPI of an emulated board: a bench file, a driver in three ways, and each error that it can make."""

from __future__ import annotations

import contextlib

import pytest

from hilbench.benchfile.reader import open_bench
from hilbench.errors import UsageError
from hilbench.mcu.emulated import EmulatedBench
from hilbench.mcu.under_test import boards_under_test
from targets.firmware import image_path
from targets.parts.w25q.w25q import W25q, _Slave

BENCH = f"""
version = 1
[targets.brain]
board = "bluepill"
firmware = "{image_path("style-flash")}"
"""
FLASH = """
[parts.flash]
kind = "w25q"
pins = { cs = "brain.PA4" }
buses = { spi = "brain.SPI1" }
"""


NUCLEO_FLASH = FLASH.replace("PA4", "PD14")


def nucleo(chip):
    return BENCH.replace("bluepill", f"nucleo-{chip}zi").replace("style-flash", f"{chip}-flash")


@pytest.fixture
def run(tmp_path):
    """Run the driver on a bench with these lines more; return what it has said, and the bench."""
    with contextlib.ExitStack() as undo:

        def go(more="", seconds=0.1, before=lambda _emulated: None, bench=BENCH, usart="usart1"):
            file = tmp_path / "b.toml"
            file.write_text(bench + more)
            emulated = EmulatedBench(open_bench(str(file)))
            undo.callback(emulated.close)
            before(emulated)
            board = boards_under_test(emulated)["brain"]
            board.run(seconds)
            return board.usart(usart).text.splitlines(), emulated

        yield go


def test_it_is_identified_erased_programmed_and_read_in_three_ways(run):
    said, emulated = run(FLASH)
    assert said == ["identity 0xef4017", "polled: ok", "by interrupt: ok", "by dma: ok"]
    assert boards_under_test(emulated)["brain"].is_lit()
    flash = emulated.surroundings.parts.by_name["flash"]
    for way in range(3):
        begin = 0x12000 + 256 * way
        assert flash.array.data[begin : begin + 256] == bytes((at * 7 + way) & 0xFF for at in range(256))
    told = [event["value"] for event in emulated.bench.journal.recent if event.get("name") == "FlashChanged"]
    assert [(one["what"], one["address"]) for one in told] == [
        ("erase", 0x12000), ("program", 0x12000), ("program", 0x12100), ("program", 0x12200),
    ]  # fmt: skip
    assert not emulated.notes()


@pytest.mark.exhaustive("the flash alone is held against itself in parts/test_w25q.py")
def test_what_the_flash_promises_changes_nothing(run, monkeypatch):
    ways = []
    for promise in (W25q.promise, lambda _flash, _most: None):
        monkeypatch.setattr(W25q, "promise", promise)
        said, emulated = run(FLASH)
        ways.append((said, list(emulated.bench.journal.recent)))
    assert ways[0] == ways[1]


@pytest.mark.parametrize("chip", ["f767", "h753"])
def test_on_a_nucleo(run, chip):
    """By the manuals' own procedures: several words with each access, and by DMA no multiple of them."""
    said, emulated = run(NUCLEO_FLASH, bench=nucleo(chip), usart="usart3")
    assert said == ["identity 0xef4017", "polled: ok", "by interrupt: ok", "by dma: ok"]
    flash = emulated.surroundings.parts.by_name["flash"]
    for way, count in enumerate((256, 256, 255)):
        begin = 0x12000 + 256 * way
        assert flash.array.data[begin : begin + count] == bytes((at * 7 + way) & 0xFF for at in range(count))
    assert not emulated.notes()


def test_another_size(run):
    assert run(FLASH + "settings = { megabits = 128 }\n", 0.01)[0][0] == "identity 0xef4018"


def test_without_one_the_driver_finds_none(run):
    assert run(seconds=0.01)[0] == ["identity 0xffffff", "no flash"]


@pytest.mark.exhaustive("a driver polls for half a second; the gate has a busy chip in parts/test_w25q")
def test_one_that_stays_busy(run):
    assert run(FLASH + "settings = { sector_erase_ms = 900.0 }\n", 0.6)[0] == ["identity 0xef4017", "stays busy"]


def test_a_part_whose_slave_is_none(run, monkeypatch):
    """A kind of part that somebody wrote when slaves had fewer members."""
    monkeypatch.delattr(_Slave, "releases")
    with pytest.raises(UsageError, match=r"^part 'flash': _Slave is no SpiSlave: it has no releases$"):
        run(FLASH)


def test_one_whose_cells_are_worn(run):
    def wear(emulated):
        flash = emulated.surroundings.parts.by_name["flash"]
        flash.array.erase = lambda _address, _size: None
        flash.array.data[0x12003] = 0

    assert run(FLASH, before=wear)[0][-1] == "polled: not empty"


def test_one_that_is_protected(run):
    def protect(emulated):
        emulated.surroundings.parts.by_name["flash"]._status[0] = 0x1C

    assert run(FLASH, before=protect)[0][-1] == "polled: differs"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("brain.SPI1", "brain.SPI9", "'brain' has no SPI interface 'SPI9'; did you mean"),
        ("brain.SPI1", "nobody.SPI1", "'nobody.SPI1' is no SPI interface of a board"),
        ("brain.SPI1", "brain.I2C1", "'brain' has no SPI interface 'I2C1'"),
        ('buses = { spi = "brain.SPI1" }', "", "its bus 'spi' leads nowhere; add buses = { spi = \"brain.SPI1\" }"),
        ('pins = { cs = "brain.PA4" }', "", "its terminal 'cs'"),
        ("spi =", "sip =", "a w25q has no bus 'sip'; did you mean 'spi'?"),
    ],
)
def test_what_is_wrong_in_the_bench_file_is_said(run, old, new, message):
    with pytest.raises(UsageError) as raised:
        run(FLASH.replace(old, new))
    assert message in str(raised.value)
