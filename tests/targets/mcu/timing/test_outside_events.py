"""What comes from outside happens at its bench time, whatever the chip does with its clock."""

from __future__ import annotations

import pytest

from targets.mcu.engine.api import Reg
from tests.each import each
from tests.targets.mcu.timing.assembly import BX_LR, CLOCK_72_MHZ, CYCCNT, EXTI, NOP, RCC, SCS, SYSTICK, WFI, Code

MS = 1_000_000
USART1 = 0x4001_3800
HALF_CLOCK = Code().poke((RCC + 4, 8 << 4)).hang()
STOP = (
    Code(*CLOCK_72_MHZ.halves)
    .poke((RCC + 0x18, 1), (EXTI, 1), (EXTI + 8, 1), (SCS + 0x100, 1 << 6))  # EXTI0 on PA0, rising; IRQ 6
    .poke((RCC + 0x1C, 1 << 28), (SCS + 0xD10, 4))  # PWREN; SLEEPDEEP
    .add(WFI)
    .load(7, 77)
    .hang()
)
CLEARS = Code().load(1, EXTI + 0x14).load(0, 1).add(0x6008, BX_LR)  # str r0, [r1]


@pytest.mark.parametrize("main", [HALF_CLOCK, Code(*CLOCK_72_MHZ.halves).hang()], ids=["4 MHz", "72 MHz"])
@pytest.mark.parametrize("at_ns", [5 * MS, 5 * MS + 1, 7_654_321])
def test_a_change_of_the_clock_does_not_move_it(start, skip_idle, main, at_ns):
    machine = start(main, skip_idle=skip_idle)
    seen = []
    machine.at_ns(at_ns, lambda: seen.append(machine.now_ns))
    machine.run_to(10 * MS)
    assert at_ns <= seen[0] < at_ns + 250
    assert len(seen) == 1


@each("entered_early", [True, False])
def test_it_comes_after_what_the_chip_does_at_the_same_cycle(start, entered_early):
    machine = start(Code(NOP).hang())
    order = []
    if entered_early:
        machine.at_ns(125_000, lambda: order.append("outside"))
    machine.run_to(1000)
    machine.time.at(1000, lambda: order.append("inside"))
    if not entered_early:
        machine.at_ns(125_000, lambda: order.append("outside"))
    machine.run_to(MS)
    assert order == ["inside", "outside"]


def test_a_run_that_enters_stop_mode_ends_at_its_limit(start, skip_idle):
    machine = start(STOP, skip_idle=skip_idle)
    machine.run_to(50 * MS)
    assert machine.core.sleeping
    assert machine.time.hclk_hz == 8_000_000
    assert 50 * MS <= machine.now_ns < 50 * MS + 125


def test_a_frame_that_is_being_sent_when_stop_begins_does_not_hold_up_the_run(start, skip_idle):
    sends = Code().poke((RCC + 0x18, 1 << 14 | 1 << 2), (USART1 + 0x08, 0xFFFF), (USART1 + 0x0C, 1 << 13 | 1 << 3))
    machine = start(Code(*sends.halves, *STOP.halves), skip_idle=skip_idle)
    machine.run_to(20 * MS)
    assert machine.core.sleeping
    assert machine.time.ns(machine.time.next_cycle()) < 120 * MS  # of its preamble, in C
    machine.run_to(120 * MS)
    assert machine.core.sleeping
    assert 120 * MS <= machine.now_ns < 120 * MS + 125


@each("entered_early", [True, False])
def test_waking_from_stop_takes_the_regulators_time(start, entered_early):
    # 3.6 us with the regulator on (DS5319 section 5.3.6), as whole cycles of HSI, then the entry of the exception.
    machine = start(STOP, {22: CLEARS})
    running = []
    machine.core.on_running = lambda number: running.append((number, machine.cycle))
    if entered_early:
        machine.at_ns(40 * MS, lambda: machine.chip.pins["PA0"].drive(True))
    machine.run_to(40 * MS)
    woken_cycle = machine.cycle
    if not entered_early:
        machine.chip.pins["PA0"].drive(True)
    machine.run_to(41 * MS)
    assert running[0] == (22, woken_cycle + 28 + 12)
    assert not machine.core.sleeping


def test_the_clocks_of_the_core_stand_still_in_stop_mode(start, skip_idle):
    # RM0008 section 4.3.4: HCLK and FCLK stop, so SysTick wakes nobody and the cycle counter keeps its value.
    setup = Code().poke((RCC + 0x18, 1), (RCC + 0x1C, 1 << 28), (EXTI, 1), (EXTI + 8, 1), (SCS + 0x100, 1 << 6))
    setup.poke((SCS + 0xDFC, 1 << 24), (CYCCNT - 4, 1), (SCS + 0xD10, 4))
    setup.poke((SYSTICK + 4, 79_999), (SYSTICK + 8, 0), (SYSTICK, 7))
    setup.load(4, CYCCNT).add(0x6825, WFI, 0x6826).hang()  # ldr r5, [r4]; wfi; ldr r6, [r4]
    machine = start(setup, {15: Code(BX_LR), 22: CLEARS}, skip_idle=skip_idle)
    running = []
    machine.core.on_running = lambda number: running.append((number, machine.now_ns)) if number else None
    machine.at_ns(55 * MS, lambda: machine.chip.pins["PA0"].drive(True))
    machine.run_to(56 * MS)
    assert [number for number, _ns in running] == [22]
    counted = machine.engine.get(Reg.R6) - machine.engine.get(Reg.R5)
    assert counted < 200
    machine.run_to(75 * MS)
    systick_ns = running[1][1]
    assert running[1][0] == 15
    assert systick_ns == pytest.approx(65 * MS, abs=10_000)  # the rest of its 10 ms, from the end of Stop mode on
