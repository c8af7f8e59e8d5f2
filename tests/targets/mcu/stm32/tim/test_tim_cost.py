"""What a timer costs: events only for what somebody can see, and the same whatever the slices."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from targets.mcu.services import Watch
from targets.mcu.testing import peek, poke
from tests.each import each
from tests.share import examples


def setup(timer, **registers):
    for name, value in registers.items():
        poke(timer, name, value)


def events_of(chip):
    """Count what the queue lets happen."""
    counter = [0]
    at = chip.time.at

    def counting(cycle, action, **keywords):
        def counted():
            counter[0] += 1
            action()

        return at(cycle, counted, **keywords)

    chip.time.at = counting
    return counter


PWM = {"ARR": 3599, "CCR1": 100, "CCR2": 1000, "CCR3": 1800, "CCR4": 3599, "CCMR1": 0x6868, "CCMR2": 0x6868}


@each("alignment", [0, 0x20, 0x60])
def test_pwm_that_nobody_watches_costs_a_few_events_at_the_start(make_timer, alignment):
    chip, timer = make_timer("TIM2")
    for number in range(1, 5):
        chip.output(f"TIM2_CH{number}").set_watch(Watch.NOBODY)
    counter = events_of(chip)
    setup(timer, **PWM, CCER=0x1111, EGR=1, CR1=0x81 | alignment)
    chip.advance(10 * 72_000_000)
    assert counter[0] <= 10
    assert chip.time.next_cycle() is None
    length = 2 * 3599 if alignment else 3600
    phase = (10 * 72_000_000 - 1) % length
    if alignment and phase > 3599:
        phase = length - phase
    assert peek(timer, "CNT") == phase
    chip.output("TIM2_CH3").look()
    assert chip.output("TIM2_CH3").level is (peek(timer, "CNT") < 1800)


def test_pwm_that_is_recorded_costs_no_events(make_timer):
    chip, timer = make_timer("TIM2")
    for number in range(1, 5):
        chip.output(f"TIM2_CH{number}").set_watch(Watch.RECORD)
    counter = events_of(chip)
    setup(timer, **PWM, CCER=0x1111, EGR=1, CR1=0x81)
    chip.advance(1 + 3600 * 1000)
    assert counter[0] <= 10
    for number, ccr in ((1, 100), (2, 1000), (3, 1800), (4, 3599)):
        chip.output(f"TIM2_CH{number}").look()
        edges = chip.output(f"TIM2_CH{number}").edges
        periods = [(1 + 3600 * n + offset, level) for n in range(1001) for offset, level in ((0, True), (ccr, False))]
        assert edges == [(0, True), *periods[1:2001]]


def test_a_free_running_timer_with_all_flags_set_costs_nothing(make_timer):
    chip, timer = make_timer("TIM2")
    setup(timer, ARR=1, EGR=0x1F, CR1=1)
    counter = events_of(chip)
    chip.advance(72_000_000)
    assert counter[0] <= 1
    poke(timer, "SR", 0xFFFE)
    now = chip.time.now
    assert chip.time.next_cycle() == now + 2 - (now + 1) % 2  # updates come at odd cycles: CNT_EN follows CEN by one


@each("ccmr", [0x0000, 0x4050, 0x6868])
@each("watch", [Watch.RECORD, Watch.LIVE])
def test_outputs_without_edges_cost_nothing_whoever_looks(make_timer, ccmr, watch):
    """Frozen and forced channels, those that are off, and PWM of 0 and 100 per cent."""
    chip, timer = make_timer("TIM2")
    for number in range(1, 5):
        chip.output(f"TIM2_CH{number}").set_watch(watch)
    setup(timer, ARR=1, CCR1=0, CCR2=2, CCR3=1, CCMR1=ccmr, CCMR2=0x0060, CCER=0x1011, EGR=0x1F)
    poke(timer, "CCER", 0x1011 & ~0x100)
    poke(timer, "CR1", 1)
    counter = events_of(chip)
    chip.advance(72_000_000)
    assert counter[0] <= 1
    assert peek(timer, "SR") == 0x1F
    assert peek(timer, "CNT") == (72_000_000 - 1) % 2
    assert chip.output("TIM2_CH3").level is None


def test_one_event_for_each_interrupt(make_timer):
    chip, timer = make_timer("TIM3")
    counter = events_of(chip)
    setup(timer, ARR=71, EGR=0x1F, SR=0xFFFE, DIER=1, CR1=1)
    for _ in range(100):
        chip.advance(72)
        poke(timer, "SR", 0xFFFE)
    assert counter[0] == 99
    assert len(chip.irq(29).rises) == 99


def test_a_timer_that_does_not_run_has_no_event(make_timer):
    chip, timer = make_timer("TIM2")
    setup(timer, ARR=10, CR1=1)
    assert chip.time.next_cycle() == 1 + 11  # CNT_EN follows CEN by one; the reload matches CCRx = 0
    poke(timer, "CR1", 0)
    assert chip.time.next_cycle() is None


@settings(max_examples=examples(50))
@given(
    cuts=st.lists(st.integers(1, 50), max_size=60),
    reads=st.lists(st.sampled_from(["CNT", "SR", "CR1", "DIER"]), min_size=60, max_size=60),
)
def test_reading_and_slicing_change_nothing(make_timer, cuts, reads):
    results = []
    for sliced in (False, True):
        chip, timer = make_timer("TIM1")
        setup(timer, ARR=13, CCR1=5, CCR2=14, CCMR1=0x3068, CCER=0x15, RCR=2, EGR=1, SR=0, DIER=0x307, BDTR=0x8003)
        poke(timer, "CR1", 0x61)
        for cut, register in zip(cuts, reads, strict=False):
            if sliced:
                chip.advance(cut)
                peek(timer, register)
        chip.advance_to(4000)
        results.append(
            (
                [chip.output(f"TIM1_CH{name}").edges for name in ("1", "1N", "2")],
                [chip.dma(f"TIM1_{name}").pulses for name in ("UP", "CH1")],
                [chip.irq(number).changes for number in range(24, 28)],
                [peek(timer, register) for register in ("CNT", "SR", "CR1")],
            )
        )
    assert results[0] == results[1]


# --- clocks


def test_a_divided_bus_gives_the_timers_twice_its_rate(make_timer):
    chip, timer = make_timer("TIM2", APB1=4)
    setup(timer, ARR=99, EGR=1, SR=0, CR1=1)
    chip.advance(2 * 101 - 1)
    assert peek(timer, "SR") == 0
    chip.advance(1)
    assert peek(timer, "SR") == 0x1F  # CCRx is 0, and the reload is what matches it


@each("watch", [Watch.RECORD, Watch.LIVE])
def test_what_is_written_between_two_ticks_is_seen_at_its_own_cycle(make_timer, watch):
    chip, timer = make_timer("TIM2", APB1=8)
    chip.output("TIM2_CH1").set_watch(watch)
    setup(timer, ARR=9, CCR1=5, CCMR1=0x60, CCER=1, EGR=1, CR1=1)
    chip.advance(4 * 3 + 2)
    poke(timer, "CCER", 3)
    chip.advance(4 * 10)
    chip.output("TIM2_CH1").look()
    # a tick is four cycles; the counter is at 5 after six, and at 0 again after eleven
    assert chip.output("TIM2_CH1").edges == [(0, True), (14, False), (24, True), (44, False)]


def test_a_change_of_the_clock_keeps_what_was_counted(make_timer):
    chip, timer = make_timer("TIM2")
    setup(timer, ARR=99, EGR=1, SR=0, CCMR1=0x60, CCR1=50, CCER=1, CR1=1)
    chip.output("TIM2_CH1").set_watch(Watch.RECORD)
    chip.advance(1 + 60)
    chip.change_clock(hclk_hz=8_000_000, APB1=4)
    assert peek(timer, "CNT") == 60
    chip.advance(2 * 40 - 1)
    assert not peek(timer, "SR") & 1
    chip.advance(1)
    assert peek(timer, "SR") & 1
    chip.output("TIM2_CH1").look()
    assert chip.output("TIM2_CH1").edges == [(0, True), (51, False), (141, True)]


def test_a_timer_without_clock_stands_still(make_timer):
    chip, timer = make_timer("TIM2")
    setup(timer, ARR=99, EGR=1, SR=0, CR1=1)
    chip.advance(1 + 60)
    timer.before_clock_change()
    timer.clocked = False
    timer.after_clock_change()
    assert chip.time.next_cycle() is None
    chip.advance(1000)
    timer.before_clock_change()
    timer.clocked = True
    timer.after_clock_change()
    assert peek(timer, "CNT") == 60
    chip.advance(39)
    assert peek(timer, "CNT") == 99


def gate(timer, open_):
    timer.before_clock_change()
    timer.clocked = open_
    timer.after_clock_change()


def test_a_timer_without_clock_does_not_count_what_comes_from_outside(make_timer):
    """Its synchronisers stand; when they go on, an input that has another level than before is an edge."""
    chip, timer = make_timer("TIM3")
    setup(timer, CCMR1=0x0101, SMCR=3, ARR=0xFFFF, CCER=0x11, CR1=1)
    chip.advance(10)
    gate(timer, open_=False)
    for number, level in ((1, True), (2, True), (1, False), (2, False), (1, True)):
        chip.advance(10)
        chip.input(f"TIM3_CH{number}").drive(level)
    assert (peek(timer, "CNT"), peek(timer, "SR")) == (0, 0)
    gate(timer, open_=True)
    assert (peek(timer, "CNT"), peek(timer, "SR")) == (1, 2)


def test_a_timer_without_clock_is_not_triggered(make_timers):
    chip, master, slave = make_timers("TIM1", "TIM2")
    setup(slave, SMCR=0x07, CR1=1)
    setup(master, CR2=0x20, ARR=99, CR1=1)
    chip.advance(1 + 250)
    gate(slave, open_=False)
    chip.advance(1000)
    gate(slave, open_=True)
    chip.advance(100)
    assert peek(slave, "CNT") == 3


def test_a_gate_that_opened_while_the_clock_stood_is_open(make_timer):
    chip, timer = make_timer("TIM2")
    setup(timer, CCMR1=0x01, SMCR=0x55, CR1=1)
    gate(timer, open_=False)
    chip.input("TIM2_CH1").drive(True)
    chip.advance(1000)
    assert peek(timer, "CNT") == 0
    gate(timer, open_=True)
    chip.advance(30)
    assert peek(timer, "CNT") == 30


def test_reset_stops_the_timer_and_releases_its_pins(make_timer):
    chip, timer = make_timer("TIM1")
    setup(timer, ARR=9, CCR1=5, CCMR1=0x60, CCER=5, BDTR=0x8000, DIER=1, EGR=1, CR1=1)
    chip.advance(7)
    timer.reset()
    assert chip.time.next_cycle() is None
    assert chip.output("TIM1_CH1").level is None
    assert chip.output("TIM1_CH1N").level is None
    assert not chip.irq(25).level
    assert peek(timer, "CNT") == 0
    assert chip.input("TIM1_CH1").on_change is None
