"""Periods as they are seen from outside: at pins, and at the entry of handlers, to the cycle."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from targets.boards import built_in_board
from targets.mcu.engine.api import Reg
from targets.mcu.machine import Machine
from tests.each import each
from tests.share import examples, matrix
from tests.targets.mcu.timing.assembly import (
    BX_LR,
    CLOCK_72_MHZ,
    GPIOA,
    HANG,
    RCC,
    SYSTICK,
    TIM2,
    TIM3,
    USART1,
    USART2,
    WFI,
    Code,
    program,
)

MS = 1_000_000
CYCLE_NS = 125
SYSTICK_NUMBER, TIM2_NUMBER = 15, 44
SLEEP = (WFI, 0xE7FD)  # wfi; b to it
AHB_DIVIDERS = {0: 1, 8: 2, 9: 4, 10: 8, 11: 16, 12: 64, 13: 128, 14: 256, 15: 512}
APB_DIVIDERS = {0: 1, 4: 2, 5: 4, 6: 8, 7: 16}


def differences(values):
    return {late - early for early, late in itertools.pairwise(values)}


@pytest.fixture
def entries(start):
    """The cycles at which handlers begin, of a program that sleeps between them."""

    def measure(setup, number, ns, handler=(BX_LR,), **options):
        machine = start(Code(*setup.halves).add(*SLEEP), {number: Code(*handler)}, **options)
        found = []
        machine.core.on_running = lambda running: found.append(machine.cycle) if running == number else None
        machine.run_to(ns)
        return found

    return measure


@pytest.fixture
def rises(start):
    """The cycles of the edges of a pin: those that rise and those that fall."""

    def measure(setup, pin, ns, **options):
        machine = start(Code(*setup.halves).hang(), **options)
        machine.chip.pins[pin].record()
        machine.run_to(ns)
        edges = machine.chip.pins[pin].edges
        return [edge.cycle for edge in edges if edge.level], [edge.cycle for edge in edges if edge.level is False]

    return measure


class TestSysTick:
    @pytest.mark.parametrize(
        ("reload", "control", "timing", "skip_idle"),
        matrix([199, 1000, 7999, 9999, 71_999], [7, 3], ["flat", "table"], [True, False]),
    )
    def test_the_period_is_the_reload_value_and_one(self, entries, timing, skip_idle, reload, control):
        divider = 1 if control & 4 else 8  # of HCLK
        setup = Code().poke((SYSTICK + 4, reload), (SYSTICK + 8, 0), (SYSTICK, control))
        period = (reload + 1) * divider
        found = entries(setup, SYSTICK_NUMBER, 10 * period * CYCLE_NS, timing=timing, skip_idle=skip_idle)
        assert len(found) >= 7
        assert differences(found) == {period}

    def test_a_millisecond_at_72_mhz_is_a_millisecond(self, start):
        setup = Code(*CLOCK_72_MHZ.halves).poke((SYSTICK + 4, 71_999), (SYSTICK + 8, 0), (SYSTICK, 7)).add(*SLEEP)
        machine = start(setup, {SYSTICK_NUMBER: Code(BX_LR)})
        found = []
        machine.core.on_running = lambda running: found.append(machine.now_ns) if running else None
        machine.run_to(1000 * MS)
        assert len(found) == pytest.approx(995, abs=5)
        assert (found[-1] - found[0]) == (len(found) - 1) * MS


class TestTimers:
    @pytest.mark.parametrize(
        ("factors", "timing", "skip_idle"),
        matrix([(0, 499), (7, 99), (71, 9), (799, 999)], ["flat", "table"], [True, False]),
    )
    def test_the_period_of_update_interrupts(self, entries, timing, skip_idle, factors):
        prescaler, reload = factors
        setup = Code().poke((RCC + 0x1C, 1), (TIM2 + 0x28, prescaler), (TIM2 + 0x2C, reload))
        setup.poke((TIM2 + 0x14, 1), (TIM2 + 0x10, 0), (TIM2 + 0xC, 1), (0xE000_E100, 1 << 28)).load(
            2, TIM2 + 0x10
        ).load(3, 0).poke((TIM2, 1))
        clears = (0x6013, BX_LR)  # str r3, [r2]
        period = (prescaler + 1) * (reload + 1)
        found = entries(setup, TIM2_NUMBER, 10 * period * CYCLE_NS, clears, timing=timing, skip_idle=skip_idle)
        assert len(found) >= 7
        assert differences(found) == {period}

    @settings(max_examples=examples(40))
    @given(
        prescaler=st.integers(0, 30),
        reload=st.integers(1, 400),
        compare=st.integers(0, 420),
        ahb=st.sampled_from(list(AHB_DIVIDERS)[:5]),
        apb=st.sampled_from(list(APB_DIVIDERS)),
    )
    @example(prescaler=0, reload=1, compare=1, ahb=0, apb=0)
    @example(prescaler=0, reload=399, compare=400, ahb=0, apb=4)
    def test_frequency_and_duty_of_pwm(self, prescaler, reload, compare, ahb, apb):
        setup = Code().poke((RCC + 4, ahb << 4 | apb << 8), (RCC + 0x18, 1 << 2), (RCC + 0x1C, 1), (GPIOA, 0x4444_444B))
        setup.poke((TIM2 + 0x28, prescaler), (TIM2 + 0x2C, reload), (TIM2 + 0x34, compare), (TIM2 + 0x18, 0x68))
        setup.poke((TIM2 + 0x14, 1), (TIM2 + 0x20, 1), (TIM2, 1))
        machine = Machine(built_in_board("bluepill"), program(setup.hang(), {}))
        pin = machine.chip.pins["PA0"]
        tick = (prescaler + 1) * max(1, APB_DIVIDERS[apb] // 2)
        period = tick * (reload + 1)
        machine.run_to(CYCLE_NS * AHB_DIVIDERS[ahb] * 5000)  # the program has ended, and the timer is running
        pin.record()
        machine.run_to(machine.now_ns + CYCLE_NS * AHB_DIVIDERS[ahb] * 6 * period)
        rising = [edge.cycle for edge in pin.edges if edge.level]
        falling = [edge.cycle for edge in pin.edges if edge.level is False]
        if compare in range(1, reload + 1):
            assert differences(rising) == differences(falling) == {period}
            assert {fall - max(rise for rise in rising if rise < fall) for fall in falling if fall > rising[0]} == {
                compare * tick
            }
        else:
            assert not pin.edges
            assert pin.level is bool(compare)


QUARTERS = ((True, False), (True, True), (False, True), (False, False))


class TestEncoder:
    def counted(self, start, steps, edge_ns, **options):
        setup = Code(*CLOCK_72_MHZ.halves)
        setup.poke((RCC + 0x18, 1 << 2), (RCC + 0x1C, 2), (GPIOA, 0x4444_4444))
        setup.poke((TIM3 + 8, 3), (TIM3 + 0x2C, 0xFFFF), (TIM3 + 0x18, 0x0101), (TIM3, 1))  # both edges of PA6 and PA7
        setup.load(4, TIM3 + 0x24).add(0x6825, 0xE7FD)  # ldr r5, [r4]; b to it
        machine = start(setup, **options)
        pins = machine.chip.pins
        pins["PA6"].drive(False)
        pins["PA7"].drive(False)
        at_ns = 5 * MS
        for count, step in enumerate(steps):
            levels = QUARTERS[(sum(steps[:count]) + step - 1) % 4]
            machine.at_ns(at_ns, lambda levels=levels: [pins[f"PA{6 + n}"].drive(levels[n]) for n in (0, 1)])
            at_ns += edge_ns
        machine.run_to(at_ns + 10_000)
        return machine.bus.read(TIM3 + 0x24, 4)

    @each("edge_ns", [2500, 1250, 10_000])
    def test_every_edge_at_100_khz_is_counted(self, start, edge_ns):
        # 100 kHz is four edges in 10 us
        assert self.counted(start, [1] * 400, edge_ns) == 400
        assert self.counted(start, [-1] * 400, edge_ns) == 0x10000 - 400

    def test_back_and_forth(self, start):
        steps = [1] * 50 + [-1] * 80 + [1, -1] * 30 + [1] * 40
        assert self.counted(start, steps, 2500) == 10


BAUDS = (9600, 19_200, 38_400, 57_600, 115_200, 230_400, 460_800, 921_600)


class TestUsart:
    @pytest.mark.parametrize("baud", BAUDS)
    @pytest.mark.parametrize(
        ("usart", "pin", "enable", "crl", "crh", "pclk", "divider"),
        [
            pytest.param(USART1, "PA9", ((RCC + 0x18, 1 << 14 | 1 << 2),), 4, 0xB0, 72_000_000, 1, id="USART1"),
            pytest.param(
                USART2, "PA2", ((RCC + 0x18, 1 << 2), (RCC + 0x1C, 1 << 17)), 0xB00, 4, 36_000_000, 2, id="USART2"
            ),
        ],
    )
    def test_bit_times_at_the_pin(self, rises, baud, usart, pin, enable, crl, crh, pclk, divider):
        brr = round(pclk / baud)
        setup = Code(*CLOCK_72_MHZ.halves).poke(*enable, (GPIOA, crl), (GPIOA + 4, crh), (usart + 8, brr))
        setup.poke((usart + 0xC, 1 << 13 | 1 << 3), (usart + 4, 0x55))
        setup.wait(usart, 1 << 7).poke((usart + 4, 0x0F))  # TXE: the next frame follows directly
        up, down = rises(setup, pin, 20 * MS)
        bit = brr * divider
        begin = down[0]
        # 0x55 after its start bit toggles at every bit; the frame is ten bits long
        assert down[:5] == [begin + 2 * index * bit for index in range(5)]
        assert [cycle for cycle in up if cycle > begin][:5] == [begin + (2 * index + 1) * bit for index in range(5)]
        second = begin + 10 * bit
        assert down[5:7] == [second, second + 5 * bit]
        assert up[-2:] == [second + bit, second + 9 * bit]
        assert bit * baud == pytest.approx(72_000_000, rel=0.01)


class TestCyclesPerInstruction:
    def count(self, start, halves, wait_states, timing):
        """Return cycles between two reads of DWT_CYCCNT around some code in a straight line."""
        setup = Code().poke((0xE000_EDFC, 1 << 24), (0xE000_1000, 1), (0x4002_2000, wait_states))
        setup.load(4, 0xE000_1004).load(7, 0x2000_0100).load(6, 3)
        machine = start(setup.add(0x6825, *halves, 0x6824, HANG), timing=timing)  # ldr r5, [r4]; ...; ldr r4, [r4]
        machine.run_to(5 * MS)
        return machine.engine.get(Reg.R4) - machine.engine.get(Reg.R5)

    @each(("wait_states", "cycles"), [(0, 1250), (1, 1375), (2, 1500)])
    @each("half", [0xBF00, 0x683B])
    def test_flat(self, start, wait_states, cycles, half):
        assert self.count(start, [half] * 999, wait_states, "flat") == cycles  # and the first read

    @pytest.mark.parametrize("wait_states", [0, 1, 2])
    @pytest.mark.parametrize(
        ("halves", "cycles", "refills"),
        [
            pytest.param((0xBF00,), 1, 0, id="nop"),
            pytest.param((0x683B,), 2, 0, id="ldr"),
            pytest.param((0x603B,), 2, 0, id="str"),
            pytest.param((0x4373,), 1, 0, id="muls"),
            pytest.param((0xFBB3, 0xF3F6), 7, 0, id="udiv"),
            pytest.param((0xE000, 0xBF00), 3, 1, id="b"),
            pytest.param((0xB40F, 0xBC0F), 10, 0, id="push-pop"),
            pytest.param((0x4B00,), 2, 1, id="ldr-literal"),
        ],
    )
    def test_table(self, start, wait_states, halves, cycles, refills):
        found = self.count(start, list(halves) * 100, wait_states, "table")
        assert found == 2 + 100 * (cycles + refills * wait_states)
