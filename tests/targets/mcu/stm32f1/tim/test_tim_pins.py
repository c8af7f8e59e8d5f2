"""Timers at real pins, through GPIO and AFIO."""

from __future__ import annotations

import pytest

from targets.mcu.nets import Nets
from targets.mcu.stm32.tim import Timer
from targets.mcu.testing import peek, poke


@pytest.fixture
def board(make_pinout):
    pinout = make_pinout()
    for index, name in enumerate(("TIM1", "TIM2", "TIM3", "TIM4")):
        setattr(pinout, name.lower(), pinout.chip.add(Timer(name, 0x4000_0000 + 0x400 * index, pinout.services)))
    return pinout


def setup(timer, **registers):
    for name, value in registers.items():
        poke(timer, name, value)


def pwm(timer, period, high):
    setup(timer, ARR=period - 1, CCR1=high, CCMR1=0x68, CCER=1, EGR=1, CR1=0x81)


def test_pwm_reaches_the_pin_only_in_alternate_function(board):
    board.pins["PA0"].record()
    pwm(board.tim2, 100, 30)
    board.chip.advance(1000)
    assert board.pins["PA0"].take_edges() == []
    board.mode("PA0", 0b1011)
    board.chip.advance(1 + 200)
    edges = [(edge.cycle, edge.level) for edge in board.pins["PA0"].take_edges()]
    assert edges == [(1000, False), (1001, True), (1031, False), (1101, True), (1131, False), (1201, True)]
    board.mode("PA0", 0b0100)
    assert board.pins["PA0"].level is None


def test_idr_sees_a_waveform_that_nobody_watches(board):
    board.mode("PA0", 0b1011)
    pwm(board.tim2, 100, 30)
    for cycle in range(1, 400):
        board.chip.advance(1)
        assert peek(board.ports["A"], "IDR") & 1 == ((cycle - 1) % 100 < 30)
    assert board.ports["A"].is_live(0x08)


def test_a_pin_of_a_timer_that_drives_nothing_does_not_make_idr_live(board):
    """PA9 belongs to USART1_TX in most programs, and to TIM1_CH2 as well."""
    port = board.ports["A"]
    for name in ("PA0", "PA9"):
        board.mode(name, 0b1011)
    assert not port.is_live(0x08)
    setup(board.tim1, ARR=99, CCR2=30, CCMR1=0x6800, CCER=0x10, EGR=1, CR1=0x81)
    assert not port.is_live(0x08)
    poke(board.tim1, "BDTR", 0x8000)
    assert port.is_live(0x08)
    board.chip.advance(11)
    assert peek(port, "IDR") & 1 << 9
    poke(board.tim1, "BDTR", 0)
    assert not port.is_live(0x08)
    assert not peek(port, "IDR") & 1 << 9
    assert board.pins["PA9"].level is None
    setup(board.tim1, CR2=0x0400, BDTR=0x0400)  # OSSI: the idle level, after the dead time
    assert board.pins["PA9"].level is True
    board.tim1.reset()
    assert board.pins["PA9"].level is None
    assert not port.is_live(0x08)


def test_remapping_moves_the_waveform(board):
    for name in ("PA0", "PA15"):
        board.mode(name, 0b1011)
        board.pins[name].record()
    pwm(board.tim2, 100, 30)
    board.chip.advance(50)
    poke(board.afio, "MAPR", 1 << 8 | 0b010 << 24)
    board.chip.advance(100)
    assert [(edge.cycle, edge.level) for edge in board.pins["PA0"].take_edges()] == [
        (0, True),
        (31, False),
        (50, None),
    ]
    assert [(edge.cycle, edge.level) for edge in board.pins["PA15"].take_edges()] == [
        (50, False),
        (101, True),
        (131, False),
    ]


def test_a_wire_carries_pwm_to_a_capture_of_another_timer(board):
    board.mode("PA0", 0b1011)
    Nets().wire("loop", board.pins["PA0"], board.pins["PA6"])
    setup(board.tim3, CCMR1=0x0201, CCER=0x11 | 0x20, SMCR=0x54, CR1=1)
    pwm(board.tim2, 1000, 321)
    board.chip.advance(5000)
    assert (peek(board.tim3, "CCR1"), peek(board.tim3, "CCR2")) == (1000, 321)


def test_a_timer_captures_the_waveform_of_another_on_the_same_pin_through_exti(board):
    board.mode("PA0", 0b1011)
    pwm(board.tim2, 100, 30)
    setup(board.exti, IMR=1, RTSR=1)
    board.chip.advance(1 + 99)
    assert not board.chip.irq(6).level
    board.chip.advance(1)
    assert board.chip.irq(6).rises == [1 + 100]


def test_waveforms_are_recorded_across_a_change_of_the_clock(board):
    board.mode("PA0", 0b1011)
    board.pins["PA0"].record()
    pwm(board.tim2, 72, 36)
    board.chip.advance(1 + 72 + 1)
    board.chip.change_clock(hclk_hz=8_000_000)
    board.chip.advance(71)
    assert [edge.ns for edge in board.pins["PA0"].edges] == [
        0,
        37_000 // 72,
        73_000 // 72,
        1027 + 35 * 125,
        1027 + 71 * 125,
    ]


def test_listening_can_begin_and_end_at_any_time(board):
    board.mode("PA0", 0b1011)
    pwm(board.tim2, 100, 30)
    heard = []

    def listen(cycle, _ns, level):
        assert cycle == board.chip.time.now
        heard.append((cycle, level))

    board.chip.advance(1 + 1010)
    board.pins["PA0"].on_edge(listen)
    board.chip.advance(100)
    board.pins["PA0"].off_edge(listen)
    board.chip.advance(1000)
    assert heard == [(1031, False), (1101, True)]


def test_complementary_outputs_on_their_pins(board):
    for name in ("PA8", "PB13"):
        board.mode(name, 0b1011)
        board.pins[name].record()
    setup(board.tim1, ARR=99, CCR1=40, CCMR1=0x68, CCER=5, EGR=1, BDTR=0x8000 | 7, CR1=0x81)
    board.chip.advance(1 + 200)
    high = [(e.cycle, e.level) for e in board.pins["PA8"].edges if e.cycle > 60]
    low = [(e.cycle, e.level) for e in board.pins["PB13"].edges if e.cycle > 60]
    assert high == [(108, True), (141, False)]
    assert low == [(101, False), (148, True), (201, False)]


def test_an_encoder_on_pins_with_pulls(board):
    for name in ("PB6", "PB7"):
        board.mode(name, 0b1000)
    poke(board.ports["B"], "ODR", 0xC0)
    setup(board.tim4, CCMR1=0x0101, SMCR=3, ARR=0xFFFF, CR1=1)
    for edge in range(40):
        board.chip.advance(720)
        board.pins["PB6" if edge % 2 else "PB7"].drive(edge % 4 > 1)
    assert peek(board.tim4, "CNT") in (40, 0x10000 - 40)
