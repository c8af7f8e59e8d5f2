"""The timing diagrams of RM0008 chapters 14 and 15, as vectors: dead time, break, commutation."""

from __future__ import annotations

from targets.mcu.services import Watch
from targets.mcu.testing import peek, poke
from tests.each import each
from tests.targets.mcu.stm32.tim.ticks import setup

CEN = 1
DEAD_TIMES = {0x00: 0, 0x05: 5, 0x7F: 127, 0x80: 128, 0xBF: 254, 0xC0: 256, 0xDF: 504, 0xE0: 512, 0xFF: 1008}


@each("dtg", DEAD_TIMES)
@each("ckd", [0, 1, 2])
def test_dead_time(make_timer, dtg, ckd):
    chip, timer = make_timer("TIM1")
    dead = DEAD_TIMES[dtg] << ckd
    setup(timer, ARR=19_999, CCR1=10_000, CCMR1=0x68, CCER=5, EGR=1, BDTR=0x8000 | dtg, CR1=ckd << 8 | CEN)
    chip.advance(1 + 40_000)
    shift = [20_001, 30_001]
    main, complement = chip.output("TIM1_CH1").edges, chip.output("TIM1_CH1N").edges
    assert [edge for edge in main if 20_000 < edge[0] < 40_000] == [(shift[0] + dead, True), (shift[1], False)]
    assert [edge for edge in complement if 20_000 < edge[0] < 40_000] == [(shift[0], False), (shift[1] + dead, True)]


@each("watch", list(Watch))
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


@each("watch", list(Watch))
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
