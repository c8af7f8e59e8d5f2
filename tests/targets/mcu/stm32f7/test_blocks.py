"""I2C, DMA and ADC in their places: gates, pins, kernel clocks and requests of the chip, without a program."""

from __future__ import annotations

import pytest

from targets.boards import built_in_board
from targets.firmware import image_path
from targets.mcu.chip_limits import limits_for
from targets.mcu.image import load_image
from targets.mcu.machine import Machine
from targets.mcu.pins import Source

RCC, GPIOA, GPIOB = 0x4002_3800, 0x4002_0000, 0x4002_0400
I2C1, DMA1, ADC = 0x4000_5400, 0x4002_6000, 0x4001_2000
AHB1ENR, APB1ENR, APB2ENR = RCC + 0x30, RCC + 0x40, RCC + 0x44
MODER, OTYPER, AFRH = 0x00, 0x04, 0x24
CR1, CR2, TIMINGR, ISR, RXDR, TXDR = 0x00, 0x04, 0x10, 0x18, 0x24, 0x28
RAM = 0x2000_0000
NACKF, STOPF = 1 << 4, 1 << 5


class Board:
    """A Nucleo on HSI whose CPU does not run: a test plays the program, over the bus."""

    def __init__(self):
        board = built_in_board("nucleo-f767zi")
        self.machine = Machine(board, load_image(image_path("f767-demo"), limits_for(board.chip)))
        self.chip = self.machine.chip
        self.chip.reset("POR")

    def read(self, address):
        return self.machine.bus.read(address, 4)

    def write(self, address, value):
        self.machine.bus.write(address, 4, value)

    def advance(self, cycles):
        time = self.machine.time
        time.run_due(time.now + cycles)

    def open_i2c(self):
        """I2C1 on PB8 and PB9 at about 100 kHz from HSI."""
        self.write(AHB1ENR, self.read(AHB1ENR) | 1 << 1 | 1 << 21)
        self.write(APB1ENR, 1 << 21)
        self.write(GPIOB + OTYPER, 0x300)
        self.write(GPIOB + AFRH, 0x44)
        self.write(GPIOB + MODER, 0xA_0280)
        self.write(I2C1 + TIMINGR, 0x3042_0F13)
        self.write(I2C1 + CR1, 1)


@pytest.fixture
def board():
    return Board()


@pytest.fixture
def memory(board, make_memory):
    memory = make_memory()
    board.chip.i2cs["I2C1"].bus.attach(memory)
    return memory


def test_i2c_reaches_its_bus_through_its_pins(board, memory):
    board.open_i2c()
    board.write(I2C1 + CR2, 0xA0 | 1 << 13 | 1 << 25 | 2 << 16)
    for byte in (0x20, 0x99):
        while not board.read(I2C1 + ISR) & 2:
            board.advance(16)
        board.write(I2C1 + TXDR, byte)
    board.advance(16_000)
    assert board.read(I2C1 + ISR) == STOPF | 1
    assert memory.data[0x20] == 0x99


def test_it_runs_on_the_clock_that_is_selected(board, memory):
    """A byte takes nine times as long as SCL at 16 MHz, whatever APB1 is divided by, once HSI is its kernel clock."""
    spans = []
    for dckcfgr2, ppre1 in ((0, 0), (0, 5), (2 << 16, 5)):
        board.write(RCC + 0x90, dckcfgr2)
        board.write(RCC + 0x08, ppre1 << 10)
        board.open_i2c()
        memory.calls.clear()
        board.write(I2C1 + CR2, 0xA0 | 1 << 13 | 1 << 25 | 1 << 16)
        board.write(I2C1 + TXDR, 1)
        board.advance(100_000)
        address, write = (call[-1] for call in memory.calls if call[0] in ("address", "write"))
        spans.append(write - address)
        board.write(I2C1 + CR1, 0)
    assert spans[1] > 3 * spans[0]
    assert spans[2] == spans[0]


def test_i2c_without_its_pins_does_not_move(board, memory):
    board.open_i2c()
    board.write(GPIOB + MODER, 0x280)
    board.write(I2C1 + CR2, 0xA0 | 1 << 13)
    board.advance(100_000)
    assert memory.calls == []
    assert any(note.where == "I2C1_CR2.START" for note in board.machine.notes.all)


def test_i2c_at_push_pull_pins_hears_nobody(board, memory):
    board.open_i2c()
    board.write(GPIOB + OTYPER, 0)
    board.write(I2C1 + CR2, 0xA0 | 1 << 13)
    board.advance(100_000)
    assert board.read(I2C1 + ISR) == NACKF | STOPF | 1


def test_dma_serves_i2c(board, memory):
    """RM0410 table 27: I2C1_RX is channel 1 of stream 0 of DMA1."""
    board.open_i2c()
    board.write(DMA1 + 0x14, 4)
    board.write(DMA1 + 0x18, I2C1 + RXDR)
    board.write(DMA1 + 0x1C, RAM)
    board.write(DMA1 + 0x10, 1 << 25 | 1 << 10 | 1)
    board.write(I2C1 + CR1, 1 | 1 << 15)
    board.write(I2C1 + CR2, 0xA0 | 1 << 10 | 1 << 13 | 1 << 25 | 4 << 16)
    board.advance(32_000)
    assert board.read(RAM) == 0x0302_0100
    assert board.read(DMA1) == 0x30  # HTIF0, TCIF0
    assert board.read(I2C1 + ISR) == STOPF | 1


def test_adc_reads_a_pin(board):
    board.write(AHB1ENR, board.read(AHB1ENR) | 1)
    board.write(APB2ENR, 1 << 8)
    board.write(GPIOA + MODER, 0xA800_0000 | 3 << 6)
    board.chip.pins["PA3"].set_source("test", Source(1.1, 100.0))
    board.write(ADC + 0x34, 3)
    board.write(ADC + 0x08, 1)
    board.advance(1000)
    board.write(ADC + 0x08, 1 | 1 << 30)
    board.advance(2 * 15)  # ADCCLK is half of PCLK2
    assert board.read(ADC) == 0x12
    assert board.read(ADC + 0x4C) == round(1.1 / 3.3 * 4096)


def test_the_sensor_is_what_its_calibration_says(board):
    """RM0410 section 15.10: the temperature by TS_CAL1 (30 degrees) and TS_CAL2 (110 degrees); VDDA by VREFINT_CAL."""
    board.write(APB2ENR, 1 << 8)
    board.write(ADC + 0x304, 1 << 23)
    found = []
    for channel in (17, 18):
        board.write(ADC + 0x34, channel)
        board.write(ADC + 0x08, 1)
        board.advance(1000)
        board.write(ADC + 0x08, 1 | 1 << 30)
        board.advance(2 * 15)
        found.append(board.read(ADC + 0x4C))
    reference, first, second = (board.machine.bus.read(0x1FF0_F44A + 2 * index, 2) for index in range(3))
    assert found[0] == reference
    assert (found[1] - first) * 80 / (second - first) + 30 == pytest.approx(25, abs=0.5)


def test_each_adc_has_its_gate(board):
    board.write(APB2ENR, 1 << 9)
    board.write(ADC + 0x124, 7)
    board.write(ADC + 0x24, 7)
    assert (board.read(ADC + 0x124), board.read(ADC + 0x24)) == (7, 0)
    assert [note.where for note in board.machine.notes.all if note.kind == "clock-off"] == ["ADC1"]
    board.write(RCC + 0x24, 1 << 8)
    board.write(RCC + 0x24, 0)
    assert board.read(ADC + 0x124) == 0xFFF
