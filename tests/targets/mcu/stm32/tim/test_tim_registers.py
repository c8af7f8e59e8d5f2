"""Reset values, reserved bits, flags, interrupts, requests, bursts, locks."""

from __future__ import annotations

from targets.mcu.testing import peek, poke
from tests.each import each

GENERAL = {
    # register: bits that can be written (RM0008 section 15.4)
    "CR1": 0x03FF,
    "CR2": 0x00F8,
    "SMCR": 0xFFF7,
    "DIER": 0x5F5F,
    "CCMR1": 0xFFFF,
    "CCMR2": 0xFFFF,
    "CCER": 0x3333,
    "PSC": 0xFFFF,
    "ARR": 0xFFFF,
    "CCR1": 0xFFFF,
    "CCR4": 0xFFFF,
    "DCR": 0x1F1F,
}
ADVANCED = GENERAL | {"CR2": 0x7FFD, "DIER": 0x7FFF, "CCER": 0x3FFF, "RCR": 0x00FF}


@each("name", ["TIM1", "TIM2", "TIM3", "TIM4"])
def test_reset_values_and_reserved_bits(make_timer, name):
    masks = ADVANCED if name == "TIM1" else GENERAL
    for register, mask in masks.items():
        _, timer = make_timer(name)
        assert peek(timer, register) == (0xFFFF if register == "ARR" else 0)
        poke(timer, register, 0xFFFF_FFFF & ~1 if register == "CR1" else 0xFFFF_FFFF)
        # a centre-aligned counter that stands at 0 turns up; a general CCMR with inputs keeps its CCRs
        assert peek(timer, register) == mask & ~(0x11 if register == "CR1" else 0)
        timer.reset()
        assert peek(timer, register) == (0xFFFF if register == "ARR" else 0)


def test_general_timers_lack_rcr_and_bdtr(make_timer):
    chip, timer = make_timer("TIM3")
    timer.write(0x30, 5)
    timer.write(0x44, 0x8000)
    assert timer.read(0x30) == timer.read(0x44) == 0
    assert set(chip.noted()) == {"TIM3_0x30", "TIM3_0x44"}


@each("name", ["TIM1", "TIM4"])
def test_flags_are_cleared_by_writing_0_and_not_set_by_writing_1(make_timer, name):
    _, timer = make_timer(name)
    poke(timer, "SR", 0xFFFF)
    assert peek(timer, "SR") == 0
    poke(timer, "EGR", 0x5F)
    assert peek(timer, "SR") == 0x5F
    poke(timer, "SR", 0xFFFF & ~4)
    assert peek(timer, "SR") == 0x5B
    poke(timer, "SR", 0)
    assert peek(timer, "SR") == 0
    assert peek(timer, "EGR") == 0


LINES = {
    "TIM1": {0x01: 25, 0x02: 27, 0x04: 27, 0x08: 27, 0x10: 27, 0x20: 26, 0x40: 26, 0x80: 24},
    "TIM2": dict.fromkeys((0x01, 0x02, 0x04, 0x08, 0x10, 0x40), 28),
    "TIM3": dict.fromkeys((0x01, 0x40), 29),
    "TIM4": dict.fromkeys((0x01, 0x40), 30),
}


@each(("name", "flag"), [(name, flag) for name, flags in LINES.items() for flag in flags])
def test_interrupt_lines(make_timer, name, flag):
    chip, timer = make_timer(name)
    line = chip.irq(LINES[name][flag])
    poke(timer, "EGR", flag)
    assert not line.level
    poke(timer, "DIER", flag)
    assert line.level
    assert not any(chip.irq(number).level for number in range(24, 31) if chip.irq(number) is not line)
    poke(timer, "SR", ~flag)
    assert not line.level
    poke(timer, "EGR", flag)
    assert line.level
    poke(timer, "DIER", 0)
    assert not line.level
    poke(timer, "DIER", flag)
    timer.reset()
    assert not line.level


def test_urs_keeps_ug_from_setting_uif_and_udis_keeps_the_shadows(make_timer):
    _, timer = make_timer("TIM2")
    poke(timer, "CR1", 0x84)
    poke(timer, "ARR", 5)
    poke(timer, "EGR", 1)
    assert peek(timer, "SR") == 0
    poke(timer, "CR1", 0x82)
    poke(timer, "ARR", 9)
    poke(timer, "CNT", 3)
    poke(timer, "EGR", 1)
    assert (peek(timer, "SR"), peek(timer, "CNT")) == (0, 0)
    assert timer._counting.arr == 5


@each("ccds", [False, True])
def test_requests(make_timer, ccds):
    chip, timer = make_timer("TIM2")
    poke(timer, "CR2", 8 * ccds)
    poke(timer, "ARR", 9)
    poke(timer, "CCR3", 4)
    poke(timer, "EGR", 1)
    poke(timer, "DIER", 0x0900)
    poke(timer, "CR1", 1)
    chip.advance(1 + 30)
    assert chip.dma("TIM2_UP").pulses == [11, 21, 31]
    assert chip.dma("TIM2_CH3").pulses == ([11, 21, 31] if ccds else [5, 15, 25])
    assert not chip.dma("TIM2_CH1").pulses


def test_a_request_that_is_disabled_is_dropped(make_timer):
    chip, timer = make_timer("TIM2")
    poke(timer, "DIER", 0x0100)
    request = chip.dma("TIM2_UP")
    heard = []
    request.on_set = heard.append
    poke(timer, "DIER", 0)
    assert heard == [False]


def test_a_burst_moves_several_registers_for_one_request(make_timer):
    chip, timer = make_timer("TIM2")
    data = iter([0x1111, 0x2222, 0x3333, 0x4444, 0x5555, 0x6666])
    request = chip.dma("TIM2_UP")
    request.on_pulse = lambda: poke(timer, "DMAR", next(data))
    poke(timer, "CCMR1", 0x0808)
    poke(timer, "DCR", 2 << 8 | 13)  # three registers from CCR1 on
    poke(timer, "DIER", 0x0100)
    poke(timer, "ARR", 9)
    poke(timer, "EGR", 1)
    assert [peek(timer, f"CCR{n}") for n in (1, 2, 3, 4)] == [0x1111, 0x2222, 0x3333, 0]
    assert request.pulses == [0, 0, 0]
    poke(timer, "CR1", 1)
    chip.advance(11)
    assert [peek(timer, f"CCR{n}") for n in (1, 2, 3, 4)] == [0x4444, 0x5555, 0x6666, 0]
    assert request.pulses == [0, 0, 0, 11, 11, 11]


def test_a_burst_can_read(make_timer):
    _, timer = make_timer("TIM2")
    for number in (1, 2):
        poke(timer, f"CCR{number}", number)
    poke(timer, "DCR", 1 << 8 | 13)
    assert [peek(timer, "DMAR") for _ in range(4)] == [1, 2, 1, 2]


def test_dma_may_write_the_timer_from_within_a_request(make_timer):
    chip, timer = make_timer("TIM2")
    values = iter(range(3, 9))
    chip.dma("TIM2_UP").on_pulse = lambda: poke(timer, "CCR1", next(values))
    for register, value in (("ARR", 9), ("CCMR1", 0x60), ("CCER", 1), ("DIER", 0x100), ("EGR", 1), ("CR1", 1)):
        poke(timer, register, value)
    chip.advance(1 + 40)
    edges = chip.output("TIM2_CH1").edges
    assert [cycle for cycle, level in edges if level] == [0, 11, 21, 31, 41]
    assert [cycle for cycle, level in edges[1:] if not level] == [4, 15, 26, 37]  # edges[0] is CCER's


def test_ccxs_can_only_be_changed_while_the_channel_is_off(make_timer):
    _, timer = make_timer("TIM2")
    poke(timer, "CCER", 1)
    poke(timer, "CCMR1", 0x0101)
    assert peek(timer, "CCMR1") == 0x0100
    poke(timer, "CCER", 0)
    poke(timer, "CCMR1", 0x0101)
    assert peek(timer, "CCMR1") == 0x0101


LOCKED = {
    # bits that stay 0 by lock level: BDTR, CR2, CCER, CCMR1
    1: (0x70FF, 0x7F00, 0x0000, 0x0000),
    2: (0x7CFF, 0x7F00, 0x2AAA, 0x0000),
    3: (0x7CFF, 0x7F00, 0x2AAA, 0x7878),
}


@each("level", LOCKED)
def test_locks(make_timer, level):
    _, timer = make_timer("TIM1")
    poke(timer, "BDTR", level << 8)
    for register, value in (("CR2", 0x7F00), ("CCER", 0x3FFF), ("CCMR1", 0x7C7C), ("BDTR", 0xFCFF)):
        poke(timer, register, value)
    bdtr, cr2, ccer, ccmr1 = LOCKED[level]
    assert peek(timer, "CR2") == 0x7F00 & ~cr2
    assert peek(timer, "CCER") == 0x3FFF & ~ccer
    assert peek(timer, "CCMR1") == 0x7C7C & ~ccmr1
    # with BKE, BKP = 0 and a low input, an unlocked break input would have cleared MOE
    assert peek(timer, "BDTR") == 0xFCFF & ~bdtr | level << 8
    timer.reset()
    poke(timer, "BDTR", 0x00FF)
    assert peek(timer, "BDTR") == 0x00FF


def test_lock_is_written_once_with_the_bits_of_that_write(make_timer):
    _, timer = make_timer("TIM1")
    poke(timer, "BDTR", 0x03AB)
    poke(timer, "BDTR", 0x8000)
    assert peek(timer, "BDTR") == 0x83AB


def test_a_write_without_lock_keeps_it_off(make_timer):
    _, timer = make_timer("TIM1")
    poke(timer, "BDTR", 0x8000)
    poke(timer, "BDTR", 0x8312)
    assert peek(timer, "BDTR") == 0x8012


def test_msm_has_no_note_but_the_ledger_names_it(make_timer):
    chip, timer = make_timer("TIM2")
    poke(timer, "SMCR", 0x80)
    assert not chip.notes.all
    assert "MSM" in timer.registers[0x08].note
