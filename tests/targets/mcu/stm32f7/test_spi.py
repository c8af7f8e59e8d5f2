"""SPI1 to SPI6 in their places: gates, interrupts, clocks, pins and requests of the chip, without a program."""

from __future__ import annotations

import pytest

from targets.boards import built_in_board
from targets.firmware import image_path
from targets.mcu.chip_limits import limits_for
from targets.mcu.image import load_image
from targets.mcu.machine import Machine
from targets.mcu.stm32f7.dma_map import DMA1, DMA2
from targets.mcu.testing import peek, poke
from tests.each import each
from tests.targets.mcu.stm32.spi.slave import Slave

MASTER = 1 << 2 | 1 << 6 | 1 << 8 | 1 << 9
RXNEIE, RXDMAEN, TXDMAEN, FRXTH = 1 << 6, 1 << 0, 1 << 1, 1 << 12
RAM = 0x2000_0000
# RM0410 tables 1 and 46, sections 5.3.13 and 5.3.14: base, interrupt, register and bit of the gate, APB's divider.
PLACES = {
    "SPI1": (0x4001_3000, 35, "APB2ENR", 12, 2),
    "SPI2": (0x4000_3800, 36, "APB1ENR", 14, 4),
    "SPI3": (0x4000_3C00, 51, "APB1ENR", 15, 4),
    "SPI4": (0x4001_3400, 84, "APB2ENR", 13, 2),
    "SPI5": (0x4001_5000, 85, "APB2ENR", 20, 2),
    "SPI6": (0x4001_5400, 86, "APB2ENR", 21, 2),
}
# Tables 27 and 28: by interface, controller, stream and channel of what is received, then of what is sent.
STREAMS = [
    ("SPI1", 2, 0, 3, 3, 3), ("SPI1", 2, 2, 3, 5, 3), ("SPI2", 1, 3, 0, 4, 0), ("SPI2", 1, 1, 9, 6, 9),
    ("SPI3", 1, 0, 0, 5, 0), ("SPI3", 1, 2, 0, 7, 0), ("SPI4", 2, 0, 4, 1, 4), ("SPI4", 2, 3, 5, 4, 5),
    ("SPI5", 2, 3, 2, 4, 2), ("SPI5", 2, 5, 7, 6, 7), ("SPI6", 2, 6, 1, 5, 1),
]  # fmt: skip


class Board:
    """A Nucleo on HSI whose CPU does not run, with APB1 at a quarter and APB2 at half of HCLK."""

    def __init__(self):
        board = built_in_board("nucleo-f767zi")
        self.machine = Machine(board, load_image(image_path("f767-demo"), limits_for(board.chip)))
        self.chip, self.bus = self.machine.chip, self.machine.bus
        self.chip.reset("POR")
        poke(self.chip.rcc, "CFGR", 5 << 10 | 4 << 13)
        poke(self.chip.rcc, "AHB1ENR", 3 << 21)

    def open(self, name):
        _, _, register, bit, _ = PLACES[name]
        poke(self.chip.rcc, register, peek(self.chip.rcc, register) | 1 << bit)
        return self.chip.spis[name]

    def advance(self, cycles):
        time = self.machine.time
        time.run_due(time.now + cycles)


@pytest.fixture
def board():
    return Board()


@pytest.fixture(scope="module")
def make_board():
    return Board


def test_there_are_six(board):
    assert set(board.chip.spis) == set(PLACES) == set(board.machine.board.variant.spis)


@each("name", PLACES)
def test_a_byte_by_the_bus(make_board, name):
    board = make_board()
    base, irq, _, _, divider = PLACES[name]
    spi, slave = board.open(name), Slave(0x5A)
    spi.bus.attach(slave)
    board.bus.write(base + 4, 4, 0x700 | FRXTH | RXNEIE)
    board.bus.write(base, 4, MASTER)
    board.bus.write(base + 0xC, 1, 0xA7)
    board.advance(8 * 2 * divider - 1)
    assert not board.chip.core.exceptions.lines[irq].level
    board.advance(1)
    assert board.chip.core.exceptions.lines[irq].level
    assert slave.bytes == b"\xa7"
    assert board.bus.read(base + 0xC, 1) == 0x5A


@each("place", STREAMS)
def test_streams_move_words_both_ways(make_board, place):
    board = make_board()
    name, controller, rx, rx_channel, tx, tx_channel = place
    requests = (DMA1, DMA2)[controller - 1]
    assert requests[rx, rx_channel] == (f"{name}_RX",)
    assert requests[tx, tx_channel] == (f"{name}_TX",)
    base, dma = PLACES[name][0], board.chip.peripherals[f"DMA{controller}"]
    spi, slave = board.open(name), Slave(9, 8, 7, 6, 5)
    spi.bus.attach(slave)
    for index in range(6):
        board.bus.write(RAM + index, 1, index + 1)
    poke(spi, "CR2", 0x700 | RXDMAEN | TXDMAEN | 3 << 13)
    for stream, channel, memory, way in ((rx, rx_channel, RAM + 32, 0), (tx, tx_channel, RAM, 1 << 6)):
        poke(dma, f"S{stream}PAR", base + 0xC)
        poke(dma, f"S{stream}M0AR", memory)
        poke(dma, f"S{stream}NDTR", 3)
        poke(dma, f"S{stream}CR", channel << 25 | way | 1 << 10 | 1 << 11 | 1)
    poke(spi, "CR1", MASTER)
    board.advance(2000)
    assert slave.bytes == bytes(range(1, 6)), "an odd number by LDMA_TX"
    assert bytes(board.bus.read(RAM + 32 + index, 1) for index in range(6)) == bytes((9, 8, 7, 6, 5, 0))
    assert peek(dma, f"S{rx}NDTR") == peek(dma, f"S{tx}NDTR") == 0
    assert peek(spi, "SR") == 2


def test_a_wire_from_mosi_to_miso(board):
    """Its pins work bit by bit: PA5 to PA7."""
    spi = board.open("SPI1")
    poke(board.chip.rcc, "AHB1ENR", 3 << 21 | 1)
    for register, value in (("AFRL", 0x5550_0000), ("MODER", 0xA800_A800)):
        poke(board.chip.peripherals["GPIOA"], register, value)
    pins = board.chip.pins
    pins["PA7"].on_edge(lambda _cycle, _ns, level: pins["PA6"].drive(level))
    poke(spi, "CR2", 0xB00)
    poke(spi, "CR1", MASTER)
    spi.write_part(0xC, 2, 0xA53)
    board.advance(200)
    assert spi.read_part(0xC, 2) == 0xA53
