"""Interrupt latency of the whole machine, from an edge on a pin to an edge on a pin, to the cycle.

Entry takes 12 cycles from the end of the instruction in flight, tail-chaining 6 (Cortex-M3 Technical Reference Manual,
exceptions: latency). Return takes 12, and instructions in flight are completed: choices of the model.
"""

from __future__ import annotations

import pytest

from tests.each import each
from tests.targets.mcu.timing.assembly import (
    BX_LR,
    CPSID,
    DIV,
    EXTI,
    GPIOA,
    HANG,
    LDR,
    NOP,
    PUSH_POP,
    RCC,
    SCS,
    STR_R3_R2,
    WFI,
    Code,
)

CYCLE_NS = 125
ENTRY_CYCLES, TAIL_CHAIN_CYCLES, RETURN_CYCLES = 12, 6, 12
DIVIDE, REFILL = (
    7,
    2,
)  # of 2 to 12 and of 1 to 3 cycles (Technical Reference Manual r2p1, table 3-1): choices of the model
EXTI0, EXTI1 = 22, 23  # exception numbers of IRQ 6 and 7, on PA0 and PA1
A, B, C = 1 << 2, 1 << 3, 1 << 4  # outputs PA2 to PA4 that the programs raise
BSRR = GPIOA + 0x10
START_CYCLE = 1000

SETUP = (
    Code()
    .poke((RCC + 0x18, 1 << 2), (GPIOA, 0x4443_3388), (GPIOA + 0xC, 0))  # PA0, PA1 with pull-down; PA2 to PA4 outputs
    .poke((EXTI, 3), (EXTI + 8, 3), (SCS + 0x100, 3 << 6))
)


def raises(mask, then=(BX_LR,)):
    """Return a handler that raises an output first of all; it needs r2 and r3 and clears what is pending in EXTI."""
    return Code(STR_R3_R2).poke((EXTI + 0x14, 1)).add(*then)


def thread(*halves, mask=A):
    """Return a program with r2 and r3 such that a handler's first instruction can raise outputs."""
    code = Code(*SETUP.halves).load(4, 0x2000_0100).load(5, 1000).load(6, 7).load(2, BSRR).load(3, mask)
    return code.add(*halves)


@pytest.fixture
def latency(start):
    """Cycles from an edge at PA0 to the rise of PA2."""

    def measure(main, handlers, at_cycle, **options):
        machine = start(main, handlers, **options)
        pins = machine.chip.pins
        pins["PA2"].record()
        machine.at_ns(at_cycle * CYCLE_NS, lambda: pins["PA0"].drive(True))
        machine.run_to((at_cycle + 400) * CYCLE_NS)
        rises = [edge.cycle for edge in pins["PA2"].edges if edge.level]
        assert len(rises) == 1
        return rises[0] - at_cycle

    return measure


def test_from_sleep(latency, timing, skip_idle):
    main = thread(WFI, HANG)
    assert {
        latency(main, {EXTI0: raises(A)}, START_CYCLE + late, timing=timing, skip_idle=skip_idle) for late in range(5)
    } == {ENTRY_CYCLES}


@pytest.mark.parametrize(
    ("sled", "cycles"),
    [
        pytest.param((NOP,), (1,), id="nop"),
        pytest.param((LDR,), (2,), id="ldr"),
        pytest.param(DIV, (DIVIDE,), id="udiv"),
        pytest.param(PUSH_POP, (5, 5), id="push-pop"),
        pytest.param((0xE7FF,), (1,), id="branch-to-the-next"),
    ],
)
def test_the_instruction_in_flight_is_completed_first(latency, sled, cycles):
    # At each cycle of an instruction of n cycles, what is left of it, from 0 (it was about to begin) to n - 1.
    main = thread(*(sled * 1500), HANG)
    period = sum(cycles)
    found = sorted(
        latency(main, {EXTI0: raises(A)}, START_CYCLE + late, timing="table") - ENTRY_CYCLES for late in range(period)
    )
    assert found == sorted(left for length in cycles for left in range(length))


@each("skip_idle", [True, False])
def test_in_a_loop_that_is_passed_over(latency, skip_idle):
    found = [
        latency(thread(HANG), {EXTI0: raises(A)}, START_CYCLE + late, timing="table", skip_idle=skip_idle)
        for late in range(1 + REFILL)
    ]
    assert sorted(found) == [ENTRY_CYCLES + left for left in range(1 + REFILL)]


def test_flat_instructions_of_five_quarters(latency):
    # Four instructions in five cycles: at one cycle of five an instruction has a cycle left to go.
    found = [latency(thread(*[NOP] * 1500, HANG), {EXTI0: raises(A)}, START_CYCLE + late) for late in range(5)]
    assert sorted(found) == [ENTRY_CYCLES] * 4 + [ENTRY_CYCLES + 1]


def test_an_interrupt_held_back_wakes_at_once_and_is_not_taken(start, timing):
    machine = start(thread(CPSID, WFI, STR_R3_R2, HANG), {EXTI0: raises(A)}, timing=timing)
    pins = machine.chip.pins
    pins["PA2"].record()
    machine.at_ns(START_CYCLE * CYCLE_NS, lambda: pins["PA0"].drive(True))
    machine.run_to(2 * START_CYCLE * CYCLE_NS)
    assert [edge.cycle for edge in pins["PA2"].edges if edge.level] == [START_CYCLE]
    assert machine.core.running == 0


@pytest.fixture
def runs(start):
    """(exception number, cycle after the first edge) of each entry and return; PA0 rises, then PA1 so much later."""

    def measure(main, handlers, later, **options):
        machine = start(main, handlers, **options)
        pins, found = machine.chip.pins, []
        machine.core.on_running = lambda number: found.append((number, machine.cycle - START_CYCLE))
        machine.at_ns(START_CYCLE * CYCLE_NS, lambda: pins["PA0"].drive(True))
        machine.at_ns((START_CYCLE + later) * CYCLE_NS, lambda: pins["PA1"].drive(True))
        machine.run_to(2 * START_CYCLE * CYCLE_NS)
        return found

    return measure


CLEARS = Code().load(1, EXTI + 0x14).load(0, 3).add(0x6008, BX_LR)  # str r0, [r1]: both lines
CLEARS_OWN = {
    EXTI0: Code().load(1, EXTI + 0x14).load(0, 1).add(0x6008, BX_LR),
    EXTI1: Code().load(1, EXTI + 0x14).load(0, 2).add(0x6008, BX_LR),
}
HANDLER_CYCLES = 4 * 1 + 2 + 1
"""Of such a handler: four moves, a store, and the BX, whose target is not fetched."""

FIRST_IS_URGENT = Code(*SETUP.halves).poke((SCS + 0x404, 0x80 << 24))  # IPR of IRQ 7
SECOND_IS_URGENT = Code(*SETUP.halves).poke((SCS + 0x404, 0x80 << 16))  # IPR of IRQ 6


def test_return(runs):
    found = runs(Code(*SETUP.halves).add(WFI, WFI, HANG), {EXTI0: CLEARS}, 500, timing="table")
    assert found[:2] == [(EXTI0, ENTRY_CYCLES), (0, ENTRY_CYCLES + HANDLER_CYCLES + RETURN_CYCLES)]


@each("later", [0, 1, 12, 13, ENTRY_CYCLES + HANDLER_CYCLES - 1])
def test_tail_chaining(runs, later):
    found = runs(Code(*FIRST_IS_URGENT.halves).add(WFI, HANG), CLEARS_OWN, later, timing="table")
    second = ENTRY_CYCLES + HANDLER_CYCLES + TAIL_CHAIN_CYCLES
    assert found == [(EXTI0, ENTRY_CYCLES), (EXTI1, second), (0, second + HANDLER_CYCLES + RETURN_CYCLES)]


@each("into_return", [0, 1, 5, RETURN_CYCLES])
def test_a_return_is_abandoned_for_what_comes_in_meanwhile(runs, into_return):
    later = ENTRY_CYCLES + HANDLER_CYCLES + into_return
    found = runs(Code(*FIRST_IS_URGENT.halves).add(WFI, HANG), CLEARS_OWN, later, timing="table")
    over = ENTRY_CYCLES + HANDLER_CYCLES + RETURN_CYCLES
    assert found[:2] == [(EXTI0, ENTRY_CYCLES), (EXTI1, over + TAIL_CHAIN_CYCLES)]


@each("later", [1, 6, ENTRY_CYCLES])
def test_late_arrival(runs, later):
    # What is more urgent and comes while the frame is stacked has its handler begin when the other's would have.
    found = runs(Code(*SECOND_IS_URGENT.halves).add(WFI, HANG), CLEARS_OWN, later, timing="table")
    second = ENTRY_CYCLES + HANDLER_CYCLES + TAIL_CHAIN_CYCLES
    assert found == [(EXTI1, ENTRY_CYCLES), (EXTI0, second), (0, second + HANDLER_CYCLES + RETURN_CYCLES)]


def test_too_late_to_arrive_late(runs):
    found = runs(Code(*SECOND_IS_URGENT.halves).add(WFI, HANG), CLEARS_OWN, ENTRY_CYCLES + 1, timing="table")
    nested = ENTRY_CYCLES + 1 + ENTRY_CYCLES
    assert found[:2] == [(EXTI0, ENTRY_CYCLES), (EXTI1, nested)]
    assert found[2] == (EXTI0, nested + HANDLER_CYCLES + RETURN_CYCLES)
