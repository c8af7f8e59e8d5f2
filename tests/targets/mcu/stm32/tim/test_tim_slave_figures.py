"""The timing diagrams of RM0008 chapters 14 and 15, as vectors: one pulse, slaves, captures, timers together."""

from __future__ import annotations

import pytest

from targets.mcu.testing import peek, poke
from tests.targets.mcu.stm32.tim.ticks import counts, setup

CEN, DIR, OPM = 1, 0x10, 8


def test_one_pulse_after_a_trigger(tim):
    """Figure "example of one pulse mode": a pulse of a given length a given time after a rising edge of TI2."""
    chip, timer = tim
    setup(timer, ARR=30, CCR1=10, CCMR1=0x0170, CCER=1, SMCR=0x66, EGR=1, SR=0, CR1=OPM)
    chip.advance(100)
    chip.input("TIM2_CH2").drive(True)
    assert peek(timer, "CR1") & CEN
    chip.advance(100)
    assert chip.output("TIM2_CH1").edges == [(0, False), (100 + 1 + 10, True), (100 + 1 + 31, False)]
    assert not peek(timer, "CR1") & CEN
    assert peek(timer, "CNT") == 0
    assert peek(timer, "SR") & 0x41 == 0x41


def test_one_pulse_with_the_fast_output(tim):
    chip, timer = tim
    setup(timer, ARR=30, CCR1=0, CCMR1=0x0174, CCER=1, SMCR=0x66, EGR=1, CNT=0, CR1=OPM)
    poke(timer, "CCR1", 1)
    chip.advance(100)
    chip.input("TIM2_CH2").drive(True)
    chip.advance(100)
    assert chip.output("TIM2_CH1").edges[-2:] == [(100, True), (100 + 1 + 31, False)]


def test_reset_mode(tim):
    chip, timer = tim
    setup(timer, ARR=0x36, CCMR1=0x01, SMCR=0x54, CNT=0x30, CR1=CEN)
    chip.advance(1)
    assert counts(chip, timer, 8) == [0x30, 0x31, 0x32, 0x33, 0x34, 0x35, 0x36, 0, 1]
    chip.advance(2)
    chip.input("TIM2_CH1").drive(True)
    assert peek(timer, "SR") & 0x41 == 0x41
    assert counts(chip, timer, 3) == [0, 1, 2, 3]


def test_gated_mode(tim):
    chip, timer = tim
    setup(timer, CCMR1=0x01, CCER=0x02, SMCR=0x55, CNT=0x30, CR1=CEN)
    chip.advance(1)
    assert counts(chip, timer, 4) == [0x30, 0x31, 0x32, 0x33, 0x34]
    chip.input("TIM2_CH1").drive(True)
    assert peek(timer, "SR") & 0x40
    poke(timer, "SR", 0)
    assert counts(chip, timer, 3) == [0x34] * 4
    chip.input("TIM2_CH1").drive(False)
    assert peek(timer, "SR") & 0x40
    assert counts(chip, timer, 3) == [0x34, 0x35, 0x36, 0x37]


def test_trigger_mode(tim):
    chip, timer = tim
    setup(timer, CCMR1=0x0100, SMCR=0x66, CNT=0x34)
    chip.advance(5)
    assert counts(chip, timer, 3) == [0x34] * 4
    chip.input("TIM2_CH2").drive(True)
    chip.advance(1)
    assert counts(chip, timer, 3) == [0x34, 0x35, 0x36, 0x37]
    assert peek(timer, "SR") & 0x40


def test_external_clock_mode_1(tim):
    chip, timer = tim
    setup(timer, CCMR1=0x0100, SMCR=0x67, CNT=0x34, CR1=CEN)
    for _ in range(2):
        chip.advance(7)
        chip.input("TIM2_CH2").drive(True)
        assert peek(timer, "SR") & 0x40
        poke(timer, "SR", 0)
        chip.input("TIM2_CH2").drive(False)
    assert peek(timer, "CNT") == 0x36
    assert not timer.is_live(0x24)


@pytest.mark.parametrize("divider", [1, 2, 4, 8])
def test_external_clock_mode_2_counts_every_nth_edge(tim, divider):
    chip, timer = tim
    setup(timer, SMCR=0x4000 | {1: 0, 2: 1, 4: 2, 8: 3}[divider] << 12, CNT=0x34, CR1=CEN)
    for _ in range(16):
        chip.advance(3)
        chip.input("TIM2_ETR").drive(True)
        chip.advance(3)
        chip.input("TIM2_ETR").drive(False)
    assert peek(timer, "CNT") == 0x34 + 16 // divider


def test_external_clock_2_started_by_a_trigger(tim):
    chip, timer = tim
    setup(timer, CCMR1=0x01, SMCR=0x4056, CNT=0x34)
    chip.input("TIM2_ETR").drive(True)
    chip.input("TIM2_ETR").drive(False)
    assert peek(timer, "CNT") == 0x34
    chip.input("TIM2_CH1").drive(True)
    for expected in (0x35, 0x36):
        chip.advance(5)
        chip.input("TIM2_ETR").drive(True)
        chip.input("TIM2_ETR").drive(False)
        assert peek(timer, "CNT") == expected


def test_pwm_input(tim):
    """Figure "PWM input mode timing": CCR1 is the period and CCR2 the time the input is high."""
    chip, timer = tim
    setup(timer, CCMR1=0x0201, CCER=0x31, SMCR=0x54, CR1=CEN)
    for _ in range(3):
        chip.advance(300)
        chip.input("TIM2_CH1").drive(True)
        chip.advance(120)
        chip.input("TIM2_CH1").drive(False)
    assert (peek(timer, "CCR1"), peek(timer, "CCR2")) == (420, 120)


def test_overcapture_and_clearing_by_reading(tim):
    chip, timer = tim
    setup(timer, CCMR1=0x01, CCER=1, DIER=2, CR1=CEN)
    chip.advance(11)
    chip.input("TIM2_CH1").drive(True)
    assert peek(timer, "SR") == 0x0002
    assert chip.irq(28).level
    assert peek(timer, "CCR1") == 10
    assert peek(timer, "SR") == 0
    assert not chip.irq(28).level
    for _ in range(2):
        chip.input("TIM2_CH1").drive(False)
        chip.advance(5)
        chip.input("TIM2_CH1").drive(True)
    assert peek(timer, "SR") == 0x0202
    assert peek(timer, "CCR1") == 20
    assert peek(timer, "SR") == 0x0200
    poke(timer, "CCR1", 7)
    assert peek(timer, "CCR1") == 20


@pytest.mark.parametrize("every", [1, 2, 4, 8])
def test_capture_prescaler(tim, every):
    chip, timer = tim
    setup(timer, CCMR1=0x01 | {1: 0, 2: 1, 4: 2, 8: 3}[every] << 2, CCER=1)
    captures = 0
    for _ in range(16):
        chip.input("TIM2_CH1").drive(True)
        chip.input("TIM2_CH1").drive(False)
        captures += peek(timer, "SR") >> 1 & 1
        poke(timer, "SR", 0)
    assert captures == 16 // every


def test_encoder_figure(tim):
    """Figure "example of counter operation in encoder interface mode": forward, jitter, backward, jitter, forward."""
    chip, timer = tim
    setup(timer, CCMR1=0x0101, SMCR=3, ARR=0xFFFF, CR1=CEN)
    levels = {"1": False, "2": False}

    def turn(edges):
        for name in edges:
            chip.advance(10)
            levels[name] = not levels[name]
            chip.input(f"TIM2_CH{name}").drive(levels[name])
        return peek(timer, "CNT")

    assert turn("1212") == 4
    assert not peek(timer, "CR1") & DIR
    assert turn("1") == 5
    assert turn("11") == 5
    assert turn("1") == 4
    assert turn("2121") == 0
    assert peek(timer, "CR1") & DIR
    assert turn("2") == 0xFFFF
    assert peek(timer, "SR") & 1


@pytest.mark.exhaustive("timing/test_periods.py counts such edges in the gate")
def test_encoder_at_100_khz(tim):
    """A second of it: 70 000 edges forwards, beyond the end of the counter, and 30 000 backwards."""
    chip, timer = tim
    setup(timer, CCMR1=0x0101, SMCR=3, ARR=0xFFFF, CR1=CEN)
    levels = [False, False]

    def turn(edges, first):
        for edge in range(edges):
            chip.advance(720)
            number = (edge + first) % 2
            levels[number] = not levels[number]
            chip.input(f"TIM2_CH{number + 1}").drive(levels[number])

    turn(70_000, first=0)
    assert peek(timer, "CNT") == 70_000 % 65536
    assert peek(timer, "SR") & 1
    turn(30_000, first=1)
    assert peek(timer, "CNT") == 40_000
    assert peek(timer, "CR1") & DIR


def test_a_counter_at_its_end_turns_when_encoder_mode_gives_way_to_centre_alignment(tim):
    chip, timer = tim
    setup(timer, ARR=4, SMCR=3, CNT=4, CR1=CEN | 3 << 5)
    chip.advance(10)
    poke(timer, "SMCR", 0)
    chip.advance(2)
    assert (peek(timer, "CNT"), peek(timer, "CR1") & DIR) == (2, DIR)


def test_clearing_ocxref(tim):
    """Figure "clearing TIMx OCxREF": low from a high ETRF on, until the next update event after it is low again."""
    chip, timer = tim
    setup(timer, ARR=9, CCR1=10, CCMR1=0xE0, CCER=1, EGR=1, CR1=CEN)
    chip.advance(1 + 4)
    chip.input("TIM2_ETR").drive(True)
    chip.advance(8)
    chip.input("TIM2_ETR").drive(False)
    chip.advance(20)
    assert chip.output("TIM2_CH1").edges == [(0, True), (5, False), (21, True)]


# --- timers together


@pytest.fixture
def pair(make_timers):
    return make_timers("TIM1", "TIM2")


def test_one_timer_as_prescaler_of_another(pair):
    chip, master, slave = pair
    setup(slave, SMCR=0x07, CR1=CEN)
    setup(master, CR2=0x20, ARR=99, CR1=CEN)
    chip.advance(1 + 100 * 57 - 1)
    assert peek(slave, "CNT") == 56
    chip.advance(1)
    assert peek(slave, "CNT") == 57


def test_one_timer_enables_another_by_its_oc1ref(pair):
    chip, master, slave = pair
    setup(slave, SMCR=0x05, CR1=CEN)
    setup(master, CR2=0x40, ARR=9, CCR1=3, CCMR1=0x60, CR1=CEN)
    chip.advance(1 + 1000)
    assert peek(slave, "CNT") == 300 + 1  # OCxREF is high already while the counter waits for its first clock


def test_two_timers_start_together_by_an_external_trigger(pair):
    chip, master, slave = pair
    setup(slave, SMCR=0x06)
    setup(master, CCMR1=0x01, SMCR=0xD6, CR2=0x10)
    chip.advance(50)
    chip.input("TIM1_CH1").drive(True)
    chip.advance(1234)
    assert peek(master, "CNT") == peek(slave, "CNT") == 1233


def test_ug_of_a_master_resets_its_slave(pair):
    chip, master, slave = pair
    setup(slave, SMCR=0x04, CNT=500, CR1=CEN)
    chip.advance(20)
    poke(master, "EGR", 1)
    assert peek(slave, "CNT") == 0


@pytest.mark.parametrize("by_reset", [False, True])
def test_a_master_that_was_high_triggers_again_in_another_mode(pair, by_reset):
    """RM0008 section 15.4.2: TRGO was OC1REF, and high; then it is a pulse at each update, or at UG after a reset."""
    _chip, master, slave = pair
    setup(slave, SMCR=0x06)
    setup(master, CR2=0x40, CCMR1=0x50)
    poke(slave, "CR1", 0)
    if by_reset:
        master.reset()
    else:
        poke(master, "CR2", 0x20)
    poke(master, "EGR", 1)
    assert peek(slave, "CR1") & CEN
    assert peek(slave, "SR") & 1 << 6


def test_hall_sensor_interface(make_timers):
    """TIM2 measures the time between commutations (TI1S, reset by TI1F_ED, captures TRC)."""
    chip, timer = make_timers("TIM2")
    setup(timer, CR2=0x80, CCMR1=0x03, CCER=1, SMCR=0x44, CR1=CEN)
    for name in ("CH1", "CH2", "CH3", "CH1", "CH2", "CH3"):
        chip.advance(777)
        chip.input(f"TIM2_{name}").drive(not chip.input(f"TIM2_{name}").level())
        captured = peek(timer, "CCR1")
        assert peek(timer, "CNT") == 0
    assert captured == 777
