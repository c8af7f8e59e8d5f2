"""Timers as drivers use them, register by register: STM32 HAL, StdPeriph, libopencm3, Arduino core, motor control.

A real DMA controller and real pins stand round them; the CPU is the test, and takes no time.
"""

from __future__ import annotations

import dataclasses
import itertools

import pytest

from targets.mcu.stm32.tim import Timer
from targets.mcu.stm32f1.dma import Dma
from targets.mcu.testing import peek, poke
from tests.share import matrix

CEN, OPM, DIR, ARPE = 1, 8, 0x10, 0x80
RAM = 0x2000_0000
BASES = {"TIM1": 0x4001_2C00, "TIM2": 0x4000_0000, "TIM3": 0x4000_0400, "TIM4": 0x4000_0800}
CCR1, CCR2, DMAR = 0x34, 0x38, 0x4C


@pytest.fixture
def board(make_pinout):
    pinout = make_pinout()
    dma = pinout.dma = pinout.chip.add(Dma("DMA1", 0x4002_0000, pinout.chip.services))
    dma.reset()
    services = dataclasses.replace(pinout.services, dma=dma.request)
    for name, base in BASES.items():
        setattr(pinout, name.lower(), pinout.chip.add(Timer(name, base, services)))
    pinout.chip.bus.load(RAM, bytes(0x400))
    return pinout


def setup(timer, **registers):
    for name, value in registers.items():
        poke(timer, name, value)


def modify(timer, register, clear=0, put=0):
    poke(timer, register, peek(timer, register) & ~clear | put)


def edges_of(pin):
    return [(edge.cycle, edge.level) for edge in pin.take_edges()]


def hal_base_set_config(timer, *, psc, arr, rcr=None, cr1=0):
    """TIM_Base_SetConfig."""
    modify(timer, "CR1", 0x70 | 0x300 | ARPE, cr1)
    setup(timer, ARR=arr, PSC=psc)
    if rcr is not None:
        poke(timer, "RCR", rcr)
    poke(timer, "EGR", 1)


def hal_oc_config(timer, channel, *, ocm, ccr, ccer=0, cr2=0):
    """TIM_OCx_SetConfig with the preload that HAL_TIM_PWM_ConfigChannel adds; the channel is off meanwhile."""
    shift, half = 4 * (channel - 1), 8 * ((channel - 1) % 2)
    modes = "CCMR1" if channel < 3 else "CCMR2"
    modify(timer, "CCER", 1 << shift)
    ccmr = peek(timer, modes) & ~(0x73 << half) | ocm << 4 + half
    poke(timer, "CR2", peek(timer, "CR2") | cr2)
    poke(timer, modes, ccmr)
    poke(timer, f"CCR{channel}", ccr)
    modify(timer, "CCER", 0xF << shift, ccer << shift)
    modify(timer, modes, 0, 8 << half)


# --- time bases


@pytest.mark.parametrize("clears_uif", [False, True])
def test_the_tick_of_hal_on_a_timer(board, clears_uif):
    """stm32f1xx_hal_timebase_tim.c: 1 MHz, 1000 counts; older versions leave UIF of UG set, so a tick is early."""
    timer, irq = board.tim4, board.chip.irq(30)
    hal_base_set_config(timer, psc=71, arr=999)
    if clears_uif:
        poke(timer, "SR", ~1)
    modify(timer, "DIER", 0, 1)
    assert irq.level is not clears_uif
    poke(timer, "SR", ~1)
    modify(timer, "CR1", 0, CEN)
    ticks = []
    for _ in range(50):
        board.chip.advance(board.chip.time.next_cycle() - board.chip.time.now)
        ticks.append(irq.rises[-1])
        poke(timer, "SR", ~1)
    assert ticks == [1 + 72_000 * n for n in range(1, 51)]


def test_libopencm3_compare_interrupts(board):
    """The example timer_interrupt: CNT runs free, each interrupt puts CCR1 further ahead. PSC waits for an update."""
    timer, irq = board.tim2, board.chip.irq(28)
    setup(timer, CR1=0, PSC=1440, CR2=0)
    modify(timer, "CR1", ARPE)
    modify(timer, "CR1", OPM)
    setup(timer, ARR=65535, CCR1=1000)
    modify(timer, "CR1", 0, CEN)
    modify(timer, "DIER", 0, 2)
    board.chip.advance(1 + 999)
    assert not irq.level
    board.chip.advance(1)
    assert irq.level
    poke(timer, "SR", ~2)
    poke(timer, "CCR1", peek(timer, "CNT") + 50_000)
    board.chip.advance(50_000)
    assert irq.rises == [1001, 51_001]
    poke(timer, "SR", ~2)
    poke(timer, "CCR1", (peek(timer, "CNT") + 20_000) & 0xFFFF)
    board.chip.advance(1 + 65_536 - board.chip.time.now)
    board.chip.advance((51_000 + 20_000 - 65_536) * 1441)
    assert irq.rises[2:] == [1 + 65_536 + (51_000 + 20_000 - 65_536) * 1441]


@pytest.mark.parametrize(("low", "high", "itr"), [("tim2", "tim3", 1), ("tim3", "tim2", 2), ("tim1", "tim4", 0)])
def test_two_timers_are_one_of_32_bits(board, low, high, itr):
    """The update of the lower half is the clock of the upper (RM0008 section 15.3.15)."""
    low, high = getattr(board, low), getattr(board, high)
    setup(high, SMCR=itr << 4 | 7, ARR=0xFFFF, CR1=CEN)
    setup(low, CR2=0x20, ARR=0xFFFF, CR1=CEN)
    for cycles in (1, 65_535, 1, 123_456, 65_536 * 7, 10_000_000):
        board.chip.advance(cycles)
        count = board.chip.time.now - 1
        assert peek(high, "CNT") << 16 | peek(low, "CNT") == count
    assert peek(high, "SR") & 0x41 == 0x40


def test_one_master_starts_two_slaves_at_once(board):
    """Trigger mode of TIM3 and TIM4 by the enable of TIM2; what other timers are set up to does not matter to them."""
    setup(board.tim3, SMCR=0x16, ARR=0xFFFF)
    setup(board.tim4, SMCR=0x16, ARR=0xFFFF)
    setup(board.tim1, SMCR=0x10, CR2=0)
    setup(board.tim2, CR2=0x10, ARR=0xFFFF)
    board.chip.advance(100)
    poke(board.tim2, "CR1", CEN)
    board.chip.advance(1_000)
    assert [peek(timer, "CNT") for timer in (board.tim2, board.tim3, board.tim4)] == [999] * 3


def test_three_timers_in_a_chain(board):
    setup(board.tim4, SMCR=0x27, ARR=0xFFFF, CR1=CEN)  # by TIM3
    setup(board.tim3, SMCR=0x17, ARR=9, CR2=0x20, CR1=CEN)  # by TIM2
    setup(board.tim2, PSC=1, ARR=4, CR2=0x20, EGR=1, CR1=CEN)
    poke(board.tim3, "CNT", 0)  # the UG of TIM2 was a pulse as well
    board.chip.advance(1 + 100 * 23 + 30)
    assert (peek(board.tim4, "CNT"), peek(board.tim3, "CNT")) == (23, 3)


def test_one_shot_delay_by_one_pulse_mode(board):
    """Started again by CEN each time; no update comes while it stands."""
    timer, irq = board.tim3, board.chip.irq(29)
    setup(timer, PSC=71, ARR=99, CR1=OPM | 4, EGR=1, DIER=1)
    assert not irq.level
    for _ in range(3):
        begin = board.chip.time.now
        modify(timer, "CR1", 0, CEN)
        board.chip.advance(7_200)
        assert peek(timer, "CR1") & CEN
        board.chip.advance(1)
        assert irq.rises[-1] == begin + 1 + 7_200
        assert not peek(timer, "CR1") & CEN
        assert peek(timer, "CNT") == 0
        poke(timer, "SR", 0)
        board.chip.advance(100_000)
        assert not irq.level


# --- PWM


def hal_pwm(board, timer, pin, *, period, duty):
    board.mode(pin, 0b1011)
    board.pins[pin].record()
    hal_base_set_config(timer, psc=0, arr=period - 1, cr1=ARPE)
    hal_oc_config(timer, 1, ocm=6, ccr=duty)
    modify(timer, "CCER", 1, 1)
    modify(timer, "CR1", 0, CEN)


def test_hal_pwm_changes_duty_and_frequency_without_a_glitch(board):
    """CCR1 and ARR are preloaded: the period under way ends as it began."""
    hal_pwm(board, board.tim2, "PA0", period=1000, duty=250)
    board.chip.advance(1 + 1000 + 600)
    setup(board.tim2, CCR1=900, ARR=1999)
    board.chip.advance(5000 - 600)
    # CCR1 was written while its preload was off and the counter stood: high at once
    assert edges_of(board.pins["PA0"])[1:] == [
        (251, False), (1001, True), (1251, False), (2001, True), (2901, False), (4001, True), (4901, False),
        (6001, True),
    ]  # fmt: skip


def test_servo_pulses(board):
    """Arduino Servo: 50 Hz, 1500 us and then 2000 us, from the APB1 timers at 72 MHz."""
    hal_pwm(board, board.tim2, "PA0", period=20_000, duty=1_500)
    poke(board.tim2, "CR1", 0)
    setup(board.tim2, PSC=71, EGR=1, CR1=ARPE)
    board.pins["PA0"].take_edges()
    begin = board.chip.time.now
    poke(board.tim2, "CR1", ARPE | CEN)
    board.chip.advance(1 + 1_440_000 + 7)
    poke(board.tim2, "CCR1", 2_000)
    board.chip.advance(3 * 1_440_000 - 7)
    edges = [(cycle - begin - 1, level) for cycle, level in edges_of(board.pins["PA0"])]
    assert edges == [
        (108_000, False), (1_440_000, True), (1_548_000, False), (2_880_000, True), (3_024_000, False),
        (4_320_000, True), (4_464_000, False), (5_760_000, True),
    ]  # fmt: skip


@pytest.mark.parametrize("rcr", [0, 1, 3])
def test_motor_pwm_centre_aligned_with_dead_time(board, rcr):
    """Three half bridges at 20 kHz; duties are written at any time and taken at the update, each (RCR + 1) / 2 periods.

    UG has loaded RCR before the start, so an odd RCR has its updates at the underflow, where the counter begins.
    """
    timer, irq, half, dead = board.tim1, board.chip.irq(25), 1800, 36
    names = (("PA8", "PB13"), ("PA9", "PB14"), ("PA10", "PB15"))
    for name in [name for pair in names for name in pair]:
        board.mode(name, 0b1011)
        board.pins[name].record()
    hal_base_set_config(timer, psc=0, arr=half, rcr=rcr, cr1=1 << 5 | ARPE)
    poke(timer, "SR", ~1)
    for channel, ccr in ((1, 600), (2, 900), (3, 1200)):
        hal_oc_config(timer, channel, ocm=6, ccr=ccr)
    poke(timer, "BDTR", 1 << 11 | 1 << 10 | dead)
    modify(timer, "CCER", 0, 0x555)
    modify(timer, "BDTR", 0, 0x8000)
    modify(timer, "DIER", 0, 1)
    modify(timer, "CR1", 0, CEN)
    begin = 1
    board.chip.advance(1 + 100)
    setup(timer, CCR1=300)
    updates = []
    for _ in range(8 * half):
        board.chip.advance(1)
        if peek(timer, "SR") & 1:
            updates.append((board.chip.time.now - begin) // half)
            poke(timer, "SR", ~1)
    assert updates == [n for n in range(1, 9) if n % (rcr + 1) == 0]
    assert irq.rises == [begin + half * n for n in updates]
    taken = begin + half * updates[0]
    for (high, low), ccr, later in zip(names, (600, 900, 1200), (300, 900, 1200), strict=True):
        falls = []  # of OCxREF and its rises, about the middle of each period
        for middle in (begin + half, begin + 3 * half, begin + 5 * half, begin + 7 * half):
            duty = {True: later, False: ccr}
            falls.append((middle - half + duty[middle - half >= taken], middle + half - duty[middle + half > taken]))
        if updates[0] % 2:
            # at the overflow: the way down already has the new duty
            falls[0] = (begin + ccr, begin + 2 * half - later)
        main = [edge for fall, rise in falls for edge in ((fall, False), (rise + dead + 0, True))]
        complement = [edge for fall, rise in falls for edge in ((fall + dead, True), (rise, False))]
        got = [edge for edge in edges_of(board.pins[high]) if edge[0] > begin + 50]
        got_low = [edge for edge in edges_of(board.pins[low]) if edge[0] > begin + 50]
        end = board.chip.time.now
        assert got == [edge for edge in main if edge[0] <= end]
        assert got_low == [edge for edge in complement if edge[0] <= end]


def test_break_stops_a_motor_at_once_and_a_program_can_go_on(board):
    timer, irq = board.tim1, board.chip.irq(24)
    for name in ("PA8", "PB13"):
        board.mode(name, 0b1011)
    board.mode("PB12", 0b1000)
    poke(board.ports["B"], "BSRR", 1 << 12)  # pulled up; the driver's fault output pulls it down
    hal_base_set_config(timer, psc=0, arr=999, rcr=0)
    hal_oc_config(timer, 1, ocm=6, ccr=500)
    poke(timer, "BDTR", 1 << 12 | 1 << 11 | 1 << 10 | 20)
    modify(timer, "CCER", 0, 5)
    modify(timer, "BDTR", 0, 0x8000)
    poke(timer, "SR", 0)
    modify(timer, "DIER", 0, 0x80)
    modify(timer, "CR1", 0, CEN)
    board.chip.advance(1 + 1000 + 100)
    assert (board.pins["PA8"].level, board.pins["PB13"].level) == (True, False)
    board.pins["PB12"].drive(False)
    assert (board.pins["PA8"].level, board.pins["PB13"].level) == (False, False)
    assert irq.level
    assert not peek(timer, "BDTR") & 0x8000
    board.chip.advance(5000)
    poke(timer, "SR", ~0x80)
    assert irq.level
    board.pins["PB12"].drive(None)
    poke(timer, "SR", ~0x80)
    assert not irq.level
    modify(timer, "BDTR", 0, 0x8000)
    board.chip.advance(1000)
    board.pins["PA8"].record()
    board.chip.advance(1000)
    assert len(edges_of(board.pins["PA8"])) == 2


# --- measuring


def test_hal_measures_frequency_and_duty_by_pwm_input(board):
    """HAL_TIM_IC with reset mode: TI1FP1 resets and captures the period, TI2 (indirect) the time it is high."""
    board.mode("PA6", 0b0100)
    timer = board.tim3
    hal_base_set_config(timer, psc=0, arr=0xFFFF)
    setup(timer, CCMR1=0x0201, CCER=0x0020, SMCR=0x50)
    modify(timer, "SMCR", 7, 4)
    modify(timer, "DIER", 0, 2)
    modify(timer, "CCER", 0, 0x11)
    modify(timer, "CR1", 0, CEN)
    poke(timer, "SR", 0)
    for _ in range(3):
        board.pins["PA6"].drive(True)
        board.chip.advance(12_345)
        board.pins["PA6"].drive(False)
        board.chip.advance(40_000 - 12_345)
    board.pins["PA6"].drive(True)
    assert board.chip.irq(29).level
    assert (peek(timer, "CCR1"), peek(timer, "CCR2")) == (40_000, 12_345)
    assert peek(timer, "SR") & 0x206 == 0x200  # the program was late: overcaptures of CH1


def test_captures_by_dma_lose_nothing(board):
    """HAL_TIM_IC_Start_DMA on TIM2_CH1: each read of CCR1 clears CC1IF, so there is no overcapture."""
    board.mode("PA0", 0b0100)
    timer = board.tim2
    poke(board.dma, "CNDTR5", 20)
    poke(board.dma, "CPAR5", BASES["TIM2"] + CCR1)
    poke(board.dma, "CMAR5", RAM)
    poke(board.dma, "CCR5", 0x0581)  # halfwords, increment memory, EN
    setup(timer, CCMR1=0x01, DIER=0x200, CCER=1, CR1=CEN)
    board.chip.advance(1)
    for number in range(20):
        board.chip.advance(500 + 10 * number)
        board.pins["PA0"].drive(True)
        board.chip.advance(100)
        board.pins["PA0"].drive(False)
    data = board.chip.bus.dump(RAM, 40)
    stamps = [int.from_bytes(data[at : at + 2], "little") for at in range(0, 40, 2)]
    assert [late - early for early, late in itertools.pairwise(stamps)] == [
        600 + 10 * number for number in range(1, 20)
    ]
    assert stamps[0] == 500
    assert peek(timer, "SR") & 0x202 == 0
    assert peek(board.dma, "ISR") >> 16 & 2


def test_a_waveform_by_dma(board):
    """HAL_TIM_PWM_Start_DMA, as for WS2812: the next duty is written into the preload at each update."""
    duties = [29, 58, 29, 29, 58, 58, 29, 0]
    board.chip.bus.load(RAM, b"".join(duty.to_bytes(2, "little") for duty in duties))
    board.mode("PA0", 0b1011)
    board.pins["PA0"].record()
    timer = board.tim2
    hal_base_set_config(timer, psc=0, arr=89, cr1=ARPE)
    hal_oc_config(timer, 1, ocm=6, ccr=0)
    poke(board.dma, "CNDTR2", len(duties))
    poke(board.dma, "CPAR2", BASES["TIM2"] + CCR1)
    poke(board.dma, "CMAR2", RAM)
    poke(board.dma, "CCR2", 0x0591)
    setup(timer, DIER=0x100, CCER=1, CR1=ARPE | CEN)
    board.chip.advance(1 + 90 * 12)
    edges = edges_of(board.pins["PA0"])[1:]
    rises = [cycle for cycle, level in edges if level]
    widths = [fall - rise for (rise, _), (fall, _) in zip(edges[::2], edges[1::2], strict=True)]
    # the first update only fetches the first duty, the second puts it into effect
    assert rises == [1 + 90 * (2 + number) for number in range(7)]
    assert widths == duties[:7]


def test_a_dma_burst_sets_three_duties_at_each_update(board):
    """HAL_TIM_DMABurst_WriteStart: TIM1_UP on channel 5, three transfers from CCR1 on."""
    steps = [(100, 200, 300), (400, 500, 600), (700, 800, 900)]
    board.chip.bus.load(RAM, b"".join(duty.to_bytes(2, "little") for step in steps for duty in step))
    timer = board.tim1
    hal_base_set_config(timer, psc=0, arr=999, rcr=0)
    poke(board.dma, "CNDTR5", 9)
    poke(board.dma, "CPAR5", BASES["TIM1"] + DMAR)
    poke(board.dma, "CMAR5", RAM)
    poke(board.dma, "CCR5", 0x05B1)  # circular
    setup(timer, DCR=2 << 8 | 13, DIER=0x100, CR1=CEN)
    expected = (0, 0, 0)
    for number in range(7):
        update = 1 + 1000 * (number + 1)
        board.chip.advance_to(update - 1)
        assert tuple(peek(timer, f"CCR{n}") for n in (1, 2, 3)) == expected
        board.chip.advance_to(update + 50)  # a transfer takes a few cycles
        expected = steps[number % 3]
        assert tuple(peek(timer, f"CCR{n}") for n in (1, 2, 3)) == expected


ENCODER = {
    # mode: edges that count, of four in a period of the encoder
    1: 2,
    2: 2,
    3: 4,
}


@pytest.mark.parametrize(("mode", "ic_filter"), matrix(list(ENCODER), [0, 3, 15]))
@pytest.mark.parametrize("polarity", [0x00, 0x02, 0x20])
def test_an_encoder_at_100_khz_in_both_directions(board, mode, ic_filter, polarity):
    """HAL_TIM_Encoder_Start on TIM4 at PB6 and PB7: 100 000 edges a second for up to 0.1 s, and half of that back."""
    edges = 10_000 if mode == 3 and not polarity else 1_000
    timer, pins = board.tim4, (board.pins["PB6"], board.pins["PB7"])
    hal_base_set_config(timer, psc=0, arr=0xFFFF)
    setup(timer, SMCR=mode, CCMR1=0x0101 | ic_filter << 4 | ic_filter << 12, CCER=polarity)
    modify(timer, "CCER", 0, 0x11)
    modify(timer, "CR1", 0, CEN)
    for pin in pins:
        pin.drive(False)
    board.chip.advance(720)
    sign = -1 if polarity else 1
    levels = [False, False]
    for edge in range(edges):
        which = edge % 2
        levels[which] = not levels[which]
        pins[which].drive(levels[which])
        board.chip.advance(720)
    counts = edges * ENCODER[mode] // 4
    assert peek(timer, "CNT") == sign * counts % 0x10000
    assert bool(peek(timer, "CR1") & DIR) is (sign < 0)
    for edge in range(edges // 2):
        which = (edge + 1) % 2
        levels[which] = not levels[which]
        pins[which].drive(levels[which])
        board.chip.advance(720)
    assert peek(timer, "CNT") == sign * counts // 2 % 0x10000
    assert bool(peek(timer, "CR1") & DIR) is (sign > 0)
    assert peek(timer, "SR") & 6 == 6  # both channels capture as well


def test_an_encoder_goes_below_zero_and_back(board):
    timer = board.tim3
    setup(timer, CCMR1=0x0101, SMCR=3, ARR=99, CNT=2, CCER=0x11, CR1=CEN)
    a, b = board.pins["PA6"], board.pins["PA7"]
    back = [(b, True), (a, True), (b, False), (a, False)]
    seen = []
    for pin, level in back:
        board.chip.advance(720)
        pin.drive(level)
        seen.append(peek(timer, "CNT"))
    assert seen == [1, 0, 99, 98]
    assert peek(timer, "SR") & 1
    poke(timer, "SR", 0)
    for pin, level in ((a, True), (b, True), (a, False), (b, False)):
        board.chip.advance(720)
        pin.drive(level)
        seen.append(peek(timer, "CNT"))
    assert seen[4:] == [99, 0, 1, 2]
    assert peek(timer, "SR") & 1


def test_hall_sensors_commutate_a_motor(board):
    """HAL_TIMEx_HallSensor on TIM2: TI1S, reset by TI1F_ED, capture by TRC; OC2REF, after a delay, is COM of TIM1."""
    hall, motor = board.tim2, board.tim1
    setup(hall, PSC=0, ARR=0xFFFF, CR2=0x80 | 5 << 4, CCMR1=0x7003, CCER=1, CCR2=720, SMCR=0x44, EGR=1, CR1=CEN)
    setup(motor, CR2=5, SMCR=1 << 4, DIER=0x20)
    poke(motor, "BDTR", 0x8000)
    board.chip.advance(100)
    poke(hall, "SR", 0)
    poke(motor, "SR", 0)
    pins, levels = [board.pins[name] for name in ("PA0", "PA1", "PA2")], [False] * 3
    for step in range(6):
        number = step % 3
        levels[number] = not levels[number]
        begin = board.chip.time.now
        pins[number].drive(levels[number])
        if step:
            assert peek(hall, "CCR1") == 36_000
        board.chip.advance(719)
        assert not board.chip.irq(26).level
        board.chip.advance(1)
        assert board.chip.irq(26).rises[-1] == begin + 720
        poke(motor, "SR", 0)
        board.chip.advance(36_000 - 720)


def test_pulses_from_outside_are_counted_by_ti2_and_by_etr(board):
    """External clock modes 1 (SMS) and 2 (ECE) at 1 MHz; ETR with the divider counts every fourth."""
    setup(board.tim3, CCMR1=0x0100, SMCR=0x67, CR1=CEN)  # PA7
    setup(board.tim2, SMCR=0x4000 | 2 << 12, CR1=CEN)  # PA0
    for _ in range(4_000):
        for level in (True, False):
            for name in ("PA7", "PA0"):
                board.pins[name].drive(level)
            board.chip.advance(36)
    assert (peek(board.tim3, "CNT"), peek(board.tim2, "CNT")) == (4_000, 1_000)
