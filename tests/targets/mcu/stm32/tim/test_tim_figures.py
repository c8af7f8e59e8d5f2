"""The timing diagrams of RM0008 chapters 14 and 15, as vectors: counting, and what a compare makes of it."""

from __future__ import annotations

import pytest

from targets.mcu.services import Watch
from targets.mcu.testing import peek, poke
from tests.each import each
from tests.targets.mcu.stm32.tim.ticks import counts, flagged, setup

CEN, DIR, ARPE = 1, 0x10, 0x80


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


@each(
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
