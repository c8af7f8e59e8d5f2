"""SPI1 to SPI6 in their places: gates, interrupts, clocks and requests of the chip, without a program."""

from __future__ import annotations

import pytest

from targets.boards import built_in_board
from targets.firmware import image_path
from targets.mcu.chip_limits import limits_for
from targets.mcu.image import load_image
from targets.mcu.machine import Machine
from targets.mcu.stm32h7.dma_map import DMAMUX1
from targets.mcu.testing import peek, poke
from tests.each import each
from tests.targets.mcu.stm32.spi.slave import Slave

SPE, CSTART, SSI = 1 << 0, 1 << 9, 1 << 12
MASTER = 1 << 22 | 1 << 26
RXDMAEN, TXDMAEN = 1 << 14, 1 << 15
TXDR, RXDR = 0x20, 0x30
AXI_RAM, D2_RAM = 0x2400_0000, 0x3000_0000
# RM0433: base, interrupt (19.1.2), gate (8.7), the field that chooses the clock and its value for HSI (8.7.20, 8.7.22);
# of the first three it is per_ck, which is HSI after a reset.
PLACES = {
    "SPI1": (0x4001_3000, 35, "APB2ENR", 12, "D2CCIP1R", 4 << 12),
    "SPI2": (0x4000_3800, 36, "APB1LENR", 14, "D2CCIP1R", 4 << 12),
    "SPI3": (0x4000_3C00, 51, "APB1LENR", 15, "D2CCIP1R", 4 << 12),
    "SPI4": (0x4001_3400, 84, "APB2ENR", 13, "D2CCIP1R", 3 << 16),
    "SPI5": (0x4001_5000, 85, "APB2ENR", 20, "D2CCIP1R", 3 << 16),
    "SPI6": (0x5800_1400, 86, "APB4ENR", 5, "D3CCIPR", 3 << 28),
}


class Board:
    """A Nucleo on HSI at 64 MHz whose CPU does not run."""

    def __init__(self):
        board = built_in_board("nucleo-h753zi")
        self.machine = Machine(board, load_image(image_path("h753-demo"), limits_for(board.chip)))
        self.chip, self.bus = self.machine.chip, self.machine.bus
        self.chip.reset("POR")
        poke(self.chip.rcc, "AHB1ENR", 3)

    def open(self, name):
        _, _, register, bit, choice, value = PLACES[name]
        poke(self.chip.rcc, register, peek(self.chip.rcc, register) | 1 << bit)
        poke(self.chip.rcc, choice, value)
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
    base, irq, *_ = PLACES[name]
    spi, slave = board.open(name), Slave(0x5A)
    spi.bus.attach(slave)
    for offset, value in ((0x00, SSI), (0x0C, MASTER), (0x04, 1), (0x10, 1 << 3), (0x00, SSI | SPE)):
        board.bus.write(base + offset, 4, value)
    board.bus.write(base, 4, SSI | SPE | CSTART)
    board.bus.write(base + TXDR, 1, 0xA7)
    board.advance(8 * 2 - 1)
    assert not board.chip.core.exceptions.lines[irq].level
    board.advance(1)
    assert board.chip.core.exceptions.lines[irq].level
    assert slave.bytes == b"\xa7"
    assert board.bus.read(base + RXDR, 1) == 0x5A
    assert not board.machine.notes.all


def test_the_clock_after_a_reset_stands_still(board):
    """PLL1 Q is what SPI1 to SPI3 begin with (RM0433 section 8.7.20)."""
    spi = board.open("SPI1")
    poke(board.chip.rcc, "D2CCIP1R", 0)
    for register, value in (("CR1", SSI), ("CFG2", MASTER), ("CR1", SSI | SPE), ("CR1", SSI | SPE | CSTART)):
        poke(spi, register, value)
    assert [note.where for note in board.machine.notes.all] == ["SPI1_CR1.CSTART"]


@each("name", [name for name in PLACES if name != "SPI6"])
def test_dma_moves_a_transfer_both_ways(make_board, name):
    """Through DMAMUX1, with packets of three words, which ten are no multiple of."""
    board = make_board()
    base = PLACES[name][0]
    numbers = {request: number for number, request in DMAMUX1.items()}
    spi, slave = board.open(name), Slave(*range(50, 60))
    spi.bus.attach(slave)
    for index in range(10):
        board.bus.write(AXI_RAM + index, 1, index + 1)
    mux, dma = board.chip.peripherals["DMAMUX1"], board.chip.peripherals["DMA1"]
    streams = ((0, "RX", base + RXDR, D2_RAM, 0), (1, "TX", base + TXDR, AXI_RAM, 1 << 6))
    for stream, way, peripheral, memory, direction in streams:
        poke(mux, f"C{stream}CR", numbers[f"{name}_{way}"])
        poke(dma, f"S{stream}PAR", peripheral)
        poke(dma, f"S{stream}M0AR", memory)
        poke(dma, f"S{stream}NDTR", 10)
        poke(dma, f"S{stream}CR", direction | 1 << 10 | 1)
    for register, value in (
        ("CR1", SSI), ("CFG1", 0x7_0007 | 2 << 5 | RXDMAEN | TXDMAEN), ("CFG2", MASTER), ("CR2", 10),
        ("CR1", SSI | SPE), ("CR1", SSI | SPE | CSTART),
    ):  # fmt: skip
        poke(spi, register, value)
    board.advance(1000)
    assert slave.bytes == bytes(range(1, 11))
    assert bytes(board.bus.read(D2_RAM + index, 1) for index in range(10)) == bytes(range(50, 60))
    assert peek(dma, "S0NDTR") == peek(dma, "S1NDTR") == 0


def test_the_request_of_spi6_leads_nowhere(board):
    """It goes to BDMA (RM0433 section 17.3), which is absent."""
    assert not [name for name in DMAMUX1.values() if name.startswith("SPI6")]
