"""USARTs at the pins of an STM32F767: which pin must be configured, and wires between two of them."""

from __future__ import annotations

from fractions import Fraction

import pytest

from targets.mcu.nets import Nets
from targets.mcu.serial_line import SerialFormat
from targets.mcu.stm32.usart import Usart
from targets.mcu.testing import peek, poke

UE_TE_RE, SWAP, HDSEL = 0xD, 1 << 15, 1 << 3


@pytest.fixture
def board(make_pinout):
    pinout = make_pinout()
    for index, name in enumerate(("USART2", "USART3")):
        usart = Usart(
            name, 0x4000_4400 + 0x400 * index, pinout.services, irq=38 + index, kernel_hz=lambda: Fraction(54_000_000)
        )
        pinout.chip.add(usart).reset()
        setattr(pinout, name.lower(), usart)
    return pinout


def start(usart, cr2=0, cr3=0):
    poke(usart, "BRR", 54)
    poke(usart, "CR2", cr2)
    poke(usart, "CR3", cr3)
    poke(usart, "CR1", UE_TE_RE)


def frame_now(board, value):
    return SerialFormat().frame(value, board.time.seconds(board.time.now), Fraction(1, 1_000_000))


def test_tx_needs_a_pin_with_its_function(board):
    sent = []
    board.usart3.on_frame = sent.append
    start(board.usart3)
    board.chip.advance(20 * 216)
    poke(board.usart3, "TDR", 1)
    assert board.chip.noted("misuse") == ["USART3_TX"]
    board.chip.advance(20 * 216)
    board.alternate("PD8", 7)
    assert board.pins["PD8"].level is True
    poke(board.usart3, "TDR", 2)
    assert [frame.bits for frame in sent] == [2]


def test_rx_needs_a_pin_with_its_function(board):
    start(board.usart2)
    board.usart2.receive(frame_now(board, 0x41))
    assert board.chip.noted("misuse") == ["USART2_RX"]
    board.alternate("PD6", 7)
    board.usart2.receive(frame_now(board, 0x42))
    board.chip.advance(20 * 216)
    assert peek(board.usart2, "RDR") == 0x42


def test_a_pin_that_is_given_to_the_receiver_later_is_no_start_bit(board):
    start(board.usart2)
    board.chip.advance(20 * 216)
    board.pins["PD6"].drive(True)
    board.alternate("PD6", 7)
    board.field("PD6", "MODER", 0)
    board.chip.advance(40 * 216)
    assert peek(board.usart2, "ISR") & 0xFF == 0xC0


def test_a_pin_without_a_wire_is_no_start_bit_either(board):
    """A far end that sends frames drives no pin; the line is high all the same."""
    start(board.usart2)
    board.chip.advance(20 * 216)
    board.alternate("PD6", 7)
    board.chip.advance(40 * 216)
    assert peek(board.usart2, "ISR") & 0xFF == 0xC0
    board.usart2.receive(frame_now(board, 0x42))
    board.chip.advance(11 * 216)
    assert peek(board.usart2, "ISR") & 0xFF == 0xE0
    assert peek(board.usart2, "RDR") == 0x42


@pytest.mark.parametrize("swapped", [False, True])
def test_a_wire_carries_bytes(board, swapped):
    for pin in ("PD5", "PD6", "PD8", "PD9"):
        board.alternate(pin, 7)
    Nets().wire("there", board.pins["PD5"], board.pins["PD8" if swapped else "PD9"])
    start(board.usart2)
    start(board.usart3, cr2=SWAP if swapped else 0)
    board.chip.advance(20 * 216)
    poke(board.usart2, "TDR", 0x5A)
    board.chip.advance(20 * 216)
    assert peek(board.usart3, "RDR") == 0x5A
    assert peek(board.usart3, "ISR") & 0xF == 0


def test_half_duplex_on_one_wire(board):
    for pin in ("PD5", "PD8"):
        board.field(pin, "OTYPER", 1, width=1)
        board.field(pin, "PUPDR", 1)
        board.alternate(pin, 7)
    Nets().wire("bus", board.pins["PD5"], board.pins["PD8"])
    start(board.usart2, cr3=HDSEL)
    start(board.usart3, cr3=HDSEL)
    board.chip.advance(20 * 216)
    poke(board.usart2, "TDR", 0x5A)
    board.chip.advance(20 * 216)
    assert peek(board.usart3, "RDR") == 0x5A
    poke(board.usart3, "TDR", 0x33)
    board.chip.advance(20 * 216)
    assert peek(board.usart2, "RDR") == 0x5A
    assert peek(board.usart2, "ISR") & 8
