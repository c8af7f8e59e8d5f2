"""The timing diagrams of RM0008 chapters 14 and 15, as vectors."""

from __future__ import annotations

import pytest

from targets.mcu.services import Watch
from targets.mcu.testing import peek, poke

CEN, DIR, ARPE, OPM = 1, 0x10, 0x80, 8


@pytest.fixture
def tim(make_timer):
    return make_timer("TIM2")


def setup(timer, **registers):
    for name, value in registers.items():
        poke(timer, name, value)


def counts(chip, timer, ticks):
    """The counter now and after each of so many ticks."""
    seen = [peek(timer, "CNT")]
    for _ in range(ticks):
        chip.advance(1)
        seen.append(peek(timer, "CNT"))
    return seen


def flagged(chip, timer, ticks, flag):
    """The ticks, of so many, at which a flag is set, if it is cleared each time."""
    seen = []
    for _ in range(ticks):
        chip.advance(1)
        if peek(timer, "SR") & flag:
            seen.append(chip.time.now)
            poke(timer, "SR", ~flag & 0xFFFF)
    return seen


def test_upcounting(tim):
    chip, timer = tim
    setup(timer, ARR=0x36, CNT=0x31, CR1=CEN)
    chip.advance(1)  # the counter starts one clock after CEN
    assert counts(chip, timer, 7) == [0x31, 0x32, 0x33, 0x34, 0x35, 0x36, 0, 1]
    assert peek(timer, "SR") & 1


@pytest.mark.parametrize("divider", [1, 2, 4, 1000, 65536])
def test_the_prescaler_divides_by_any_factor(tim, divider):
    chip, timer = tim
    setup(timer, PSC=divider - 1, ARR=2, EGR=1, SR=0, CR1=CEN)
    chip.advance(1 + 3 * divider - 1)
    assert (peek(timer, "CNT"), peek(timer, "SR") & 1) == (2, 0)
    chip.advance(1)
    assert (peek(timer, "CNT"), peek(timer, "SR") & 1) == (0, 1)
    assert chip.irq(28).changes == []


def test_prescaler_division_change_from_1_to_2(tim):
    chip, timer = tim
    setup(timer, ARR=0xFC, CNT=0xF7, CR1=CEN)
    chip.advance(1)
    poke(timer, "PSC", 1)
    assert counts(chip, timer, 12) == [0xF7, 0xF8, 0xF9, 0xFA, 0xFB, 0xFC, 0, 0, 1, 1, 2, 2, 3]


def test_prescaler_division_change_from_1_to_4(tim):
    chip, timer = tim
    setup(timer, ARR=0xFC, CNT=0xFB, CR1=CEN)
    chip.advance(1)
    poke(timer, "PSC", 3)
    assert counts(chip, timer, 11) == [0xFB, 0xFC, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2]


def test_update_event_when_arpe_is_0(tim):
    chip, timer = tim
    setup(timer, ARR=0xFF, CNT=0x31, CR1=CEN)
    chip.advance(1)
    poke(timer, "ARR", 0x36)
    assert counts(chip, timer, 7) == [0x31, 0x32, 0x33, 0x34, 0x35, 0x36, 0, 1]


def test_update_event_when_arpe_is_1(tim):
    chip, timer = tim
    setup(timer, ARR=0xF5, CR1=ARPE, EGR=1, CNT=0xF0)
    poke(timer, "CR1", ARPE | CEN)
    chip.advance(1)
    poke(timer, "ARR", 0x36)
    assert counts(chip, timer, 7) == [0xF0, 0xF1, 0xF2, 0xF3, 0xF4, 0xF5, 0, 1]
    chip.advance(0x35)
    assert counts(chip, timer, 1) == [0x36, 0]


def test_a_counter_above_a_lowered_arr_wraps_at_ffff_without_an_update(tim):
    chip, timer = tim
    setup(timer, ARR=0xFFFF, CNT=0xFFFD, CR1=CEN)
    chip.advance(1)
    poke(timer, "ARR", 0x10)
    assert counts(chip, timer, 4) == [0xFFFD, 0xFFFE, 0xFFFF, 0, 1]
    assert not peek(timer, "SR") & 1
    chip.advance(0x10)
    assert peek(timer, "SR") & 1


def test_downcounting(tim):
    chip, timer = tim
    setup(timer, ARR=0x36, CNT=5, CR1=CEN | DIR)
    chip.advance(1)
    assert counts(chip, timer, 7) == [5, 4, 3, 2, 1, 0, 0x36, 0x35]
    assert peek(timer, "SR") & 1
    poke(timer, "EGR", 1)
    assert peek(timer, "CNT") == 0x36


def test_centre_aligned_counting(tim):
    chip, timer = tim
    setup(timer, ARR=6, CNT=4, CR1=DIR)
    setup(timer, CR1=CEN | 1 << 5)
    chip.advance(1)
    assert counts(chip, timer, 13) == [4, 3, 2, 1, 0, 1, 2, 3, 4, 5, 6, 5, 4, 3]


def test_centre_aligned_updates_at_both_ends(tim):
    chip, timer = tim
    setup(timer, ARR=6, CNT=4, CR1=DIR)
    setup(timer, CR1=CEN | 1 << 5)
    chip.advance(1)
    start = chip.time.now
    assert [tick - start for tick in flagged(chip, timer, 24, 1)] == [4, 10, 16, 22]


def test_centre_aligned_overflow_loads_the_new_arr_into_the_counter(tim):
    chip, timer = tim
    setup(timer, ARR=0xFD, CR1=ARPE, EGR=1, CNT=0xF7)
    poke(timer, "CR1", CEN | ARPE | 1 << 5)
    chip.advance(1)
    poke(timer, "ARR", 0x36)
    assert counts(chip, timer, 9) == [0xF7, 0xF8, 0xF9, 0xFA, 0xFB, 0xFC, 0x36, 0x35, 0x34, 0x33]


@pytest.mark.parametrize("preset", [0, 0xFFFF])
def test_arr_0_blocks_the_counter(tim, preset):
    chip, timer = tim
    setup(timer, ARR=0, CNT=preset, CR1=CEN)
    chip.advance(1000)
    assert (peek(timer, "CNT"), peek(timer, "SR")) == (preset, 0)


@pytest.mark.parametrize(
    ("rcr", "alignment", "updates"),
    [
        (0, 0, [1, 2, 3, 4, 5, 6, 7, 8]),
        (1, 0, [2, 4, 6, 8]),
        (2, 0, [3, 6]),
        (3, 0, [4, 8]),
        (1, 1, [2, 4, 6, 8]),
        (3, 1, [4, 8]),
    ],
)
def test_repetition_counter(make_timer, rcr, alignment, updates):
    chip, timer = make_timer("TIM1")
    setup(timer, ARR=9 if alignment == 0 else 10, RCR=rcr, EGR=1, SR=0, CR1=CEN | alignment << 5)
    chip.advance(1)
    seen = flagged(chip, timer, 85, 1)
    assert [round((tick - 1) / 10) for tick in seen] == updates


# --- compare and PWM

EDGE_ALIGNED = {
    # figure "edge-aligned PWM waveforms (ARR=8)": CCRx, OCxREF while the counter is 0 to 8, counts at which CCxIF rises
    4: ("111100000", [4]),
    8: ("111111110", [8]),
    9: ("111111111", [0]),
    0: ("000000000", [0]),
}


@pytest.mark.parametrize("ccr", EDGE_ALIGNED)
@pytest.mark.parametrize("mode", [6, 7])
def test_edge_aligned_pwm(tim, ccr, mode):
    chip, timer = tim
    wave, flags = EDGE_ALIGNED[ccr]
    setup(timer, ARR=8, CCR1=ccr, CCMR1=mode << 4, CCER=1, EGR=1, CR1=CEN)
    chip.advance(1)
    chip.advance(9)
    poke(timer, "SR", 0)
    levels, seen = "", []
    for _ in range(18):
        levels += str(int(chip.output("TIM2_CH1").level is (mode == 6)))
        chip.advance(1)
        if peek(timer, "SR") & 2:
            seen.append(peek(timer, "CNT"))
            poke(timer, "SR", 0)
    assert levels == wave * 2
    assert seen == flags * 2


CENTRE_ALIGNED = {
    # figure "center-aligned PWM waveforms (ARR=8)": OCxREF for the counter 0 1 2 3 4 5 6 7 8 7 6 5 4 3 2 1
    4: "1111000000001111",
    7: "1111111001111111",
    8: "1111111111111111",
    9: "1111111111111111",
    0: "0000000000000000",
}
FLAGS = {  # ticks after the counter was 0, by CMS
    4: {1: [12], 2: [4], 3: [4, 12]},
    7: {1: [9], 2: [7], 3: [7, 9]},
    8: {1: [8], 2: [8], 3: [8]},
    9: {1: [8], 2: [8], 3: [8]},
    0: {1: [16], 2: [16], 3: [16]},
}


@pytest.mark.parametrize("ccr", CENTRE_ALIGNED)
@pytest.mark.parametrize("cms", [1, 2, 3])
def test_centre_aligned_pwm(tim, ccr, cms):
    chip, timer = tim
    setup(timer, ARR=8, CCR1=ccr, CCMR1=0x60, CCER=1, EGR=1, CR1=CEN | cms << 5)
    chip.advance(1 + 16)
    assert peek(timer, "CNT") == 0
    poke(timer, "SR", 0)
    start, levels, seen = chip.time.now, "", []
    for _ in range(16):
        levels += str(int(chip.output("TIM2_CH1").level))
        chip.advance(1)
        if peek(timer, "SR") & 2:
            seen.append(chip.time.now - start)
            poke(timer, "SR", 0)
    assert levels == CENTRE_ALIGNED[ccr]
    assert seen == FLAGS[ccr][cms]


def test_output_compare_toggle(tim):
    chip, timer = tim
    setup(timer, CCR1=0x3A, CCMR1=0x30, CCER=1, CNT=0x38, CR1=CEN)
    chip.advance(1 + 2)
    assert (peek(timer, "CNT"), peek(timer, "SR") & 2) == (0x3A, 2)
    assert chip.output("TIM2_CH1").edges == [(0, False), (3, True)]
    poke(timer, "CCR1", 0x40)
    chip.advance(6)
    assert chip.output("TIM2_CH1").edges[2:] == [(9, False)]


def test_forced_levels_and_polarity(tim):
    chip, timer = tim
    out = chip.output("TIM2_CH1")
    setup(timer, CCMR1=0x50, CCER=1)
    assert out.level is True
    poke(timer, "CCER", 3)
    assert out.level is False
    setup(timer, CCMR1=0x40)
    assert out.level is True
    poke(timer, "CCER", 0)
    assert out.level is None


def test_pwm_after_a_forced_level_begins_with_the_next_change_of_the_comparison(tim):
    chip, timer = tim
    out = chip.output("TIM2_CH1")
    setup(timer, ARR=9, CCR1=5, CCMR1=0x40, CCER=1, CR1=CEN)
    chip.advance(1 + 2)
    poke(timer, "CCMR1", 0x60)
    chip.advance(10)
    assert out.edges == [(0, False), (11, True)]


@pytest.mark.parametrize("frequency", [1, 50, 1_000, 20_000, 100_000])
@pytest.mark.parametrize("percent", [0, 25, 50, 99, 100])
def test_frequency_and_duty_are_exact(tim, frequency, percent):
    chip, timer = tim
    ticks = 72_000_000 // frequency
    prescaler = -(-ticks // 65536)
    while ticks % prescaler:
        prescaler += 1
    period = ticks // prescaler
    setup(timer, PSC=prescaler - 1, ARR=period - 1, CCR1=period * percent // 100, CCMR1=0x68, CCER=1, EGR=1, CR1=CEN)
    out = chip.output("TIM2_CH1")
    out.set_watch(Watch.RECORD)
    chip.advance(1 + 3 * ticks)
    out.look()
    high = period * percent // 100 * prescaler
    if percent in (0, 100):
        assert [level for _, level in out.edges] == [percent == 100]
    else:
        rises = [0] + [1 + ticks * n for n in (1, 2, 3)]
        falls = [1 + high + ticks * n for n in (0, 1, 2)]
        assert out.edges == sorted([(c, True) for c in rises] + [(c, False) for c in falls])


# --- one pulse, slaves, captures


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


# --- dead time and break

DEAD_TIMES = {0x00: 0, 0x05: 5, 0x7F: 127, 0x80: 128, 0xBF: 254, 0xC0: 256, 0xDF: 504, 0xE0: 512, 0xFF: 1008}


@pytest.mark.parametrize("dtg", DEAD_TIMES)
@pytest.mark.parametrize("ckd", [0, 1, 2])
def test_dead_time(make_timer, dtg, ckd):
    chip, timer = make_timer("TIM1")
    dead = DEAD_TIMES[dtg] << ckd
    setup(timer, ARR=19_999, CCR1=10_000, CCMR1=0x68, CCER=5, EGR=1, BDTR=0x8000 | dtg, CR1=ckd << 8 | CEN)
    chip.advance(1 + 40_000)
    shift = [20_001, 30_001]
    main, complement = chip.output("TIM1_CH1").edges, chip.output("TIM1_CH1N").edges
    assert [edge for edge in main if 20_000 < edge[0] < 40_000] == [(shift[0] + dead, True), (shift[1], False)]
    assert [edge for edge in complement if 20_000 < edge[0] < 40_000] == [(shift[0], False), (shift[1] + dead, True)]


@pytest.mark.parametrize("watch", list(Watch))
def test_a_write_while_the_counter_waits_for_its_first_clock_counts_from_that_write(make_timer, watch):
    chip, timer = make_timer("TIM1")
    out = chip.output("TIM1_CH1")
    out.set_watch(watch)
    setup(timer, ARR=99, CCMR1=0x60, CCER=5, EGR=1, BDTR=0x8005)
    chip.advance(20)
    setup(timer, CR1=CEN, CCR1=50)
    chip.advance(4)
    out.look()
    assert out.level is False
    chip.advance(1)
    out.look()
    assert out.level is True
    assert watch is Watch.NOBODY or out.edges[-1] == (25, True)


def test_a_dead_time_that_is_shortened_under_way_ends_earlier(make_timer):
    """CKD is the unit of DTG."""
    chip, timer = make_timer("TIM1")
    setup(timer, CCER=5, CCMR1=0x40, CR1=0x200, BDTR=0x8008)
    chip.advance(100)
    poke(timer, "CCMR1", 0x50)
    chip.advance(1)
    poke(timer, "CR1", 0)
    chip.advance(100)
    assert chip.output("TIM1_CH1").edges[-1] == (108, True)


def test_a_pulse_shorter_than_the_dead_time_is_not_made(make_timer):
    chip, timer = make_timer("TIM1")
    setup(timer, ARR=99, CCR1=5, CCMR1=0x68, CCER=5, EGR=1, BDTR=0x8000 | 10, CR1=CEN)
    chip.advance(1000)
    assert [level for _, level in chip.output("TIM1_CH1").edges] == [False]
    assert [cycle for cycle, level in chip.output("TIM1_CH1N").edges if not level][1:4] == [101, 201, 301]
    assert (1 + 100 + 5 + 10, True) in chip.output("TIM1_CH1N").edges


def test_break_puts_the_outputs_into_their_idle_states_after_the_dead_time(make_timer):
    chip, timer = make_timer("TIM1")
    setup(timer, ARR=99, CCR1=50, CCMR1=0x68, CCER=5, CR2=0x0200, EGR=1, DIER=0x80)
    setup(timer, BDTR=0xB400 | 10, CR1=CEN)  # MOE, BKE, BKP active high, OSSI
    chip.advance(1 + 120)
    assert (chip.output("TIM1_CH1").level, chip.output("TIM1_CH1N").level) == (True, False)
    chip.input("TIM1_BKIN").drive(True)
    assert (chip.output("TIM1_CH1").level, chip.output("TIM1_CH1N").level) == (False, False)
    assert chip.irq(24).level
    chip.advance(9)
    assert chip.output("TIM1_CH1N").level is False
    chip.advance(1)
    assert chip.output("TIM1_CH1N").level is True
    poke(timer, "SR", 0)
    assert peek(timer, "SR") & 0x80  # held by the level
    poke(timer, "BDTR", 0xB400 | 10)
    assert not peek(timer, "BDTR") & 0x8000
    chip.input("TIM1_BKIN").drive(False)
    poke(timer, "SR", 0)
    assert not peek(timer, "SR") & 0x80
    assert not chip.irq(24).level
    poke(timer, "BDTR", 0xB400 | 10)
    assert peek(timer, "BDTR") & 0x8000


def test_aoe_enables_the_outputs_with_the_next_update(make_timer):
    chip, timer = make_timer("TIM1")
    setup(timer, ARR=99, CCR1=50, CCMR1=0x68, CCER=1, EGR=1, SR=0, BDTR=0x4000 | 1 << 13 | 1 << 12, CR1=CEN)
    chip.advance(100)
    assert chip.output("TIM1_CH1").level is None
    chip.advance(1)
    assert chip.output("TIM1_CH1").level is True
    assert peek(timer, "BDTR") & 0x8000


def test_aoe_waits_for_an_update_after_the_break_is_released(make_timer):
    chip, timer = make_timer("TIM1")
    chip.output("TIM1_CH1").set_watch(Watch.NOBODY)
    chip.input("TIM1_BKIN").drive(True)
    setup(timer, ARR=99, CCR1=50, CCMR1=0x68, CCER=1, EGR=0x1F, BDTR=0x7000, CR1=CEN)
    chip.advance(350)
    assert chip.time.next_cycle() is None
    chip.input("TIM1_BKIN").drive(False)
    chip.advance(50)
    assert not peek(timer, "BDTR") & 0x8000
    chip.advance(1)
    assert peek(timer, "BDTR") & 0x8000
    chip.output("TIM1_CH1").look()
    assert chip.output("TIM1_CH1").level is True


@pytest.mark.parametrize("watch", list(Watch))
def test_an_idle_time_that_ends_before_aoe_sets_moe_changes_nothing(make_timer, watch):
    chip, timer = make_timer("TIM1")
    out = chip.output("TIM1_CH1")
    for name in ("1", "1N", "2", "2N", "3", "3N", "4"):
        chip.output(f"TIM1_CH{name}").set_watch(watch)
    setup(timer, ARR=9, CCER=1, EGR=1, BDTR=0x4003, CR1=CEN)
    chip.advance(11)
    poke(timer, "EGR", 0x80)
    chip.advance(10)
    out.look()
    assert out.level is False
    assert watch is Watch.NOBODY or out.edges == [(11, False), (11, None), (21, False)]


def test_commutation(make_timer):
    """CCPC: a six-step drive prepares the next step, and COM puts it into effect on all channels at once."""
    chip, timer = make_timer("TIM1")
    setup(timer, CR2=1, BDTR=0x8000, DIER=0x20)
    setup(timer, CCMR1=0x5050, CCER=0x0011)
    assert [chip.output(f"TIM1_CH{n}").level for n in (1, 2)] == [None, None]
    poke(timer, "EGR", 0x20)
    assert [chip.output(f"TIM1_CH{n}").level for n in (1, 2)] == [True, True]
    assert peek(timer, "SR") & 0x20
    assert chip.irq(26).level
    setup(timer, CCMR1=0x4050, CCER=0x0110)
    assert [chip.output(f"TIM1_CH{n}").level for n in (1, 2, 3)] == [True, True, None]
    poke(timer, "EGR", 0x20)
    assert [chip.output(f"TIM1_CH{n}").level for n in (1, 2, 3)] == [None, False, False]


def test_com_by_trigger(make_timers):
    chip, advanced, hall = make_timers("TIM1", "TIM2")
    setup(advanced, CR2=5, SMCR=0x10, BDTR=0x8000)
    setup(advanced, CCMR1=0x50, CCER=1)
    setup(hall, CR2=0x30)
    poke(hall, "EGR", 2)
    assert chip.output("TIM1_CH1").level is True
    assert peek(advanced, "SR") == 0x20
