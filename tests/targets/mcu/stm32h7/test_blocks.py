"""USARTs, DMA, ADCs and timers of the chip in their places: gates, pins, kernel clocks and requests, by bus alone."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import pytest

from targets.boards import built_in_board
from targets.mcu.chip_limits import limits_for
from targets.mcu.image import load_image
from targets.mcu.machine import Machine
from targets.mcu.pins import Source
from targets.mcu.serial_line import SerialFormat

RCC, GPIOA, GPIOB, GPIOD = 0x5802_4400, 0x5802_0000, 0x5802_0400, 0x5802_0C00
D2CCIP2R, D3CCIPR = RCC + 0x54, RCC + 0x58
AHB1ENR, AHB4ENR, APB1LENR, APB2ENR = RCC + 0xD8, RCC + 0xE0, RCC + 0xE8, RCC + 0xF0
DMA1, DMA2, DMAMUX1 = 0x4002_0000, 0x4002_0400, 0x4002_0800
USART2, USART3, ADC1, ADC3 = 0x4000_4400, 0x4000_4800, 0x4002_2000, 0x5802_6000
TIM6, TIM16 = 0x4000_1000, 0x4001_4400
CR1, CR3, BRR, ISR, RDR, TDR = 0x00, 0x08, 0x0C, 0x1C, 0x24, 0x28
UE, RE, TE, FIFOEN, DMAR, DMAT = 1 << 0, 1 << 2, 1 << 3, 1 << 29, 1 << 6, 1 << 7
EN, TO_PERIPHERAL, CIRC, MINC, WORDS, TRBUFF = 1, 1 << 6, 1 << 8, 1 << 10, 0x5000, 1 << 20
AXI_RAM, D2_RAM, DTCM = 0x2400_0000, 0x3000_0000, 0x2000_0000
LOOP = (0x2002_0000).to_bytes(4, "little") + (0x0800_0009).to_bytes(4, "little") + b"\xfe\xe7" * 4


class Board:
    """A Nucleo on HSI at 64 MHz whose CPU does not run: a test plays the program, over the bus."""

    def __init__(self, image):
        board = built_in_board("nucleo-h753zi")
        self.machine = Machine(board, load_image(image, limits_for(board.chip)))
        self.chip = self.machine.chip
        self.chip.reset("POR")
        self.time = self.machine.time
        self.write(AHB4ENR, 0x7FF | 1 << 24)
        self.write(AHB1ENR, 1 << 0 | 1 << 1 | 1 << 5)
        self.write(APB1LENR, 3 << 17 | 1 << 4)
        self.write(APB2ENR, 1 << 17)

    def read(self, address, size=4):
        return self.machine.bus.read(address, size)

    def write(self, address, value, size=4):
        self.machine.bus.write(address, size, value)

    def advance(self, cycles):
        self.time.run_due(self.time.now + cycles)

    def alternate(self, port, pin, number):
        """Give a pin an alternate function."""
        afr = port + 0x20 + 4 * (pin // 8)
        self.write(afr, self.read(afr) | number << 4 * (pin % 8))
        self.write(port, self.read(port) & ~(3 << 2 * pin) | 2 << 2 * pin)

    def stream(self, dma, number, request, control, count, peripheral, memory):
        self.write(DMAMUX1 + 4 * (number + (8 if dma == DMA2 else 0)), request)
        base = dma + 0x10 + 0x18 * number
        for offset, value in ((4, count), (8, peripheral), (12, memory), (0, control | EN)):
            self.write(base + offset, value)

    def open_usart(self, base, cr1=0):
        """921600 baud on USART2 at PA3 and PD5, or on USART3 at PD9 and PD8."""
        if base == USART2:
            self.alternate(GPIOA, 3, 7)
            self.alternate(GPIOD, 5, 7)
        else:
            self.alternate(GPIOD, 8, 7)
            self.alternate(GPIOD, 9, 7)
        self.write(base + BRR, 69)
        self.write(base + CR3, DMAR | DMAT)
        self.write(base + CR1, cr1 | UE | RE | TE)
        self.advance(2000)

    def hear(self, name, data):
        """Let bytes come in at 921600 baud."""
        for byte in data:
            frame = SerialFormat.parse("8N1").frame(byte, self.time.seconds(self.time.now), Fraction(1, 921_600))
            self.chip.usarts[name].receive(frame)
            self.advance(70 * 10)


@pytest.fixture
def board(tmp_path):
    image = tmp_path / "loop.bin"
    image.write_bytes(LOOP)
    return Board(image)


LINES = [  # USART, its name, controller, stream and request of RX, then of TX
    (USART2, "USART2", DMA2, 1, 43, 2, 44),
    (USART3, "USART3", DMA1, 0, 45, 1, 46),
]


@pytest.mark.parametrize(("usart", "name", "dma", "rx", "rx_request", "tx", "tx_request"), LINES)
@pytest.mark.parametrize("cr1", [0, FIFOEN])
@pytest.mark.parametrize("memory", [AXI_RAM, D2_RAM])
def test_dma_serves_both_lines(board, usart, name, dma, rx, rx_request, tx, tx_request, cr1, memory):
    board.open_usart(usart, cr1)
    board.stream(dma, rx, rx_request, CIRC | MINC | TRBUFF, 8, usart + RDR, memory)
    board.hear(name, b"0123456789")
    assert bytes(board.read(memory + index, 1) for index in range(8)) == b"89234567"
    assert board.read(dma + 0x14 + 0x18 * rx) == 6
    sent = []
    board.chip.usarts[name].on_frame = lambda frame: sent.append((frame.bits, board.time.now))
    board.stream(dma, tx, tx_request, TO_PERIPHERAL | MINC | TRBUFF, 8, usart + TDR, memory)
    board.advance(8 * 690 + 700)
    assert bytes(byte for byte, _ in sent) == b"89234567"
    assert {later - earlier for (_, earlier), (_, later) in pairwise(sent)} == {690}
    assert not [note for note in board.machine.notes.all if note.kind == "misuse"]


def test_the_kernel_clock_of_a_usart_is_what_rcc_says(board):
    for choice, baud in ((0, Fraction(64_000_000, 69)), (3, Fraction(64_000_000, 69)), (4, Fraction(4_000_000, 69))):
        board.write(RCC, board.read(RCC) | 1 << 7)  # CSION
        board.advance(100_000)
        board.write(D2CCIP2R, choice)
        board.open_usart(USART3)
        assert board.chip.usarts["USART3"].baud_hz == baud
        board.write(USART3 + CR1, 0)


def test_dma_does_not_reach_dtcm(board):
    board.open_usart(USART3)
    board.stream(DMA1, 0, 45, CIRC | MINC, 8, USART3 + RDR, DTCM)
    board.hear("USART3", b"0")
    assert board.read(DMA1) & 0x08  # TEIF0
    assert [note.where for note in board.machine.notes.all if note.kind == "misuse"] == ["DTCM"]


def open_adc(board, base, cfgr, channels, clock=2):
    """Wake a converter up on the clock of PER, 64 MHz, divided by 256 and by two."""
    board.write(D3CCIPR, clock << 16)
    board.write(base, 0xFFF)
    board.write(base + 0x308, 11 << 18)
    board.write(base + 0x08, 0)
    board.write(base + 0x08, 1 << 28)
    board.advance(64 * 10)
    board.write(base + 0x1C, sum(1 << channel for channel in channels))
    board.write(base + 0x14, 6 * 0o1111111111)
    board.write(base + 0x18, 6 * 0o1111111111)
    board.write(base + 0x30, len(channels) - 1 | sum(channel << 6 * rank for rank, channel in enumerate(channels, 1)))
    board.write(base + 0x0C, cfgr)
    board.write(base + 0x08, 1 << 28 | 1)
    board.advance(512 * 10)
    assert board.read(base) & 1


def test_the_joystick_is_scanned_into_memory(board):
    """ADC1 channels 6 and 2, PF12 and PF11, 387.5 clocks and 16 bits, without end, in words by stream 0 of DMA2."""
    board.chip.pins["PF12"].set_source("x", Source(1.5, 100.0))
    board.chip.pins["PF11"].set_source("y", Source(2.5, 100.0))
    open_adc(board, ADC1, 1 << 13 | 1 << 12 | 3, (6, 2))
    board.stream(DMA2, 0, 9, CIRC | MINC | WORDS, 2, ADC1 + 0x40, AXI_RAM)
    board.write(ADC1 + 0x08, 1 << 28 | 1 << 2)
    board.advance(512 * 396 * 2 + 20)
    assert board.read(AXI_RAM) == round(1.5 / 3.3 * 65536)
    assert board.read(AXI_RAM + 4) == round(2.5 / 3.3 * 65536)
    board.chip.pins["PF12"].set_source("x", Source(3.0, 100.0))
    board.advance(512 * 396 - 30)
    assert board.read(AXI_RAM) == round(1.5 / 3.3 * 65536)
    board.advance(50)
    assert board.read(AXI_RAM) == round(3.0 / 3.3 * 65536)
    assert not board.read(ADC1) & 1 << 4  # OVR
    assert not [note for note in board.machine.notes.all if note.kind == "misuse"]


def test_adc3_hears_the_sensor_inside(board):
    open_adc(board, ADC3, 0, (18,))
    board.write(ADC3 + 0x308, 11 << 18 | 1 << 23)
    board.write(ADC3 + 0x08, 1 << 28 | 1 << 2)
    board.advance(512 * 396 + 1)
    assert board.read(ADC3 + 0x40) == round((0.62 - 5 * 0.002) / 3.3 * 65536)


def test_each_adc_has_its_gate(board):
    board.write(AHB1ENR, 0)
    board.write(ADC1 + 0x1C, 7)
    board.write(ADC3 + 0x1C, 7)
    assert (board.read(ADC1 + 0x1C), board.read(ADC3 + 0x1C)) == (0, 7)
    assert {note.where for note in board.machine.notes.all if note.kind == "clock-off"} == {"ADC12"}


def test_timers_count_at_twice_the_clock_of_a_divided_bus(board):
    for d2cfgr, ticks in ((0, 1000), (4 << 4, 1000), (5 << 4, 500)):
        board.write(RCC + 0x1C, d2cfgr)
        board.write(TIM6 + 0x24, 0)
        board.write(TIM6, 1)
        before = board.read(TIM6 + 0x24)
        board.advance(1000)
        assert board.read(TIM6 + 0x24) - before == pytest.approx(ticks, abs=1)
        board.write(TIM6, 0)


def test_a_timer_with_a_break_reaches_its_pin(board):
    board.alternate(GPIOB, 8, 1)  # TIM16_CH1
    for offset, value in ((0x2C, 9), (0x34, 4), (0x18, 0x60), (0x20, 1), (0x44, 1 << 15), (0x00, 1)):
        board.write(TIM16 + offset, value)
    levels = []
    for _ in range(20):
        board.advance(1)
        levels.append(board.chip.pins["PB8"].level)
    assert sum(levels) == 8
