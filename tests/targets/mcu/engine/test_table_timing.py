"""Cycles of instructions against the table of the Cortex-M3 Technical Reference Manual (r2p1, table 3-1).

Where the manual gives a range, the number is the one chosen: a refill P of 1 to 3 cycles is 2, a division of 2 to 12 is
7, UMULL and SMULL of 3 to 5 are 4, UMLAL and SMLAL of 4 to 7 are 6, MSR and CPS of 1 to 2 are 2.
"""

from __future__ import annotations

import pytest

from targets.mcu.engine.api import Reg

NOP, HANG = 0xBF00, 0xE7FE
REFILL = 2


@pytest.fixture
def table(make):
    return make("table")


def cycles_of(machine, at, halves, *, instructions=1, before=(), **registers):
    machine.engine.set(Reg.R1, at.ram + 0x40)
    machine.engine.set(Reg.R0, at.ram + 0x80)
    for name, value in registers.items():
        machine.engine.set(Reg[name], value)
    machine.load(*before, *halves, NOP, NOP, NOP, HANG)
    for _ in before:
        machine.engine.run(1 << 40, 1)
    began = machine.engine.cycle
    machine.engine.run(1 << 40, instructions)
    return machine.engine.cycle - began


@pytest.mark.parametrize(
    ("halves", "cycles"),
    [
        ((NOP,), 1),
        ((0x3001,), 1),  # adds r0, #1
        ((0x4348,), 1),  # muls r0, r1
        ((0x6808,), 2),  # ldr r0, [r1]
        ((0x7008,), 2),  # strb r0, [r1]
        ((0x5C08,), 2),  # ldrb r0, [r1, r0] with r0 as below
        ((0x4800,), 2),  # ldr r0, [pc]
        ((0xB40F,), 5),  # push {r0-r3}
        ((0xC90C,), 3),  # ldmia r1!, {r2, r3}
        ((0xE891, 0x003C), 5),  # ldmia.w r1, {r2-r5}
        ((0xE9D1, 0x2300), 3),  # ldrd r2, r3, [r1]
        ((0xE9C1, 0x2300), 3),  # strd
        ((0xE851, 0x2F00), 2),  # ldrex r2, [r1]
        ((0xF8D1, 0x2004), 2),  # ldr.w r2, [r1, #4]
        ((0xFB02, 0xF203), 1),  # mul
        ((0xFB02, 0x4203), 2),  # mla
        ((0xFB02, 0x4213), 2),  # mls
        ((0xFB82, 0x2304), 4),  # smull
        ((0xFBA2, 0x2304), 4),  # umull
        ((0xFBC2, 0x2304), 6),  # smlal
        ((0xFBE2, 0x2304), 6),  # umlal
        ((0xFB92, 0xF2F3), 7),  # sdiv
        ((0xFBB2, 0xF2F3), 7),  # udiv
        ((0xB672,), 2),  # cpsid i
        ((0xF380, 0x8811), 2),  # msr basepri, r0
        ((0xF3EF, 0x8211), 2),  # mrs r2, basepri
        ((0xF3BF, 0x8F4F), 1),  # dsb
        ((0xF102, 0x0201), 1),  # add.w
        ((0xF3C2, 0x0207), 1),  # ubfx
        ((0xE000,), 1 + REFILL),  # b
        ((0xF000, 0xB800), 1),  # b.w to the next instruction looks like no branch
        ((0xF000, 0xB801), 1 + REFILL),
        ((0xF000, 0xF801), 1 + REFILL),  # bl
    ],
    ids=lambda value: "-".join(f"{half:04X}" for half in value) if isinstance(value, tuple) else "",
)
def test_cycles(table, at, halves, cycles):
    registers = {"R0": 4} if halves == (0x5C08,) else {}
    assert cycles_of(table, at, halves, **registers) == cycles


@pytest.mark.parametrize(("zero", "cycles"), [(True, 1 + REFILL), (False, 1)])
def test_a_branch_not_taken_costs_no_refill(table, at, zero, cycles):
    # cmp r2, #0 sets the flags; beq over one instruction
    assert cycles_of(table, at, (0xD000,), before=(0x2A00,), R2=0 if zero else 1) == cycles


def test_wait_states_come_with_refills_and_literals(table, at):
    table.engine.set_wait_states(2)
    assert cycles_of(table, at, (0xE000,)) == 1 + REFILL + 2
    assert cycles_of(table, at, (0x4800,)) == 2 + 2
    assert cycles_of(table, at, (0x6808,)) == 2


@pytest.mark.parametrize(("zero", "instructions"), [(True, 4), (False, 2)])
def test_an_it_block_takes_a_cycle_for_each_instruction_passed_over_or_not(table, at, zero, instructions):
    # itt eq; addeq; addeq; nop
    found = cycles_of(
        table, at, (0xBF04, 0x3001, 0x3001, NOP), before=(0x2A00,), R2=0 if zero else 1, instructions=instructions
    )
    assert found == 4


LOOP = (0x3001, 0x6808, 0x4288, 0xBF08, 0x3101, 0xFBB2, 0xF3F4, 0xB403, 0xBC03, 0xE7F5)
# adds r0, #1; ldr r0, [r1]; cmp r0, r1; it eq; addeq r1, #1; udiv; push; pop; b to the start


@pytest.mark.parametrize("timing", ["flat", "table"])
@pytest.mark.parametrize("step", [1, 2, 3, 7, 50])
def test_slicing_changes_neither_count_nor_cycles(make, at, timing, step):
    def ends(step):
        machine = make(timing)
        machine.engine.set(Reg.R1, at.ram)
        machine.load(*LOOP)
        found = {}
        while machine.engine.cycle < 500:
            machine.engine.run(machine.engine.cycle + step)
            found[machine.engine.instructions] = (machine.engine.cycle, machine.engine.fingerprint())
        return found

    single, cut = ends(1), ends(step)
    shared = single.keys() & cut.keys()
    assert len(shared) >= len(cut) - 1 > 5
    assert all(single[count] == cut[count] for count in shared)


@pytest.mark.parametrize("timing", ["flat", "table"])
def test_a_register_access_sees_the_cycle_at_which_its_instruction_began(make, at, timing):
    single, whole = make(timing), make(timing)
    for machine in (single, whole):
        machine.engine.set(Reg.R1, at.registers)
        machine.load(NOP, 0x4800, 0x6848, NOP, 0x6088, 0xE7FA)
    for _ in range(60):
        single.engine.run(1 << 40, 1)
    whole.engine.run(1 << 40, 60)
    assert single.log == whole.log
    assert single.engine.cycle == whole.engine.cycle


@pytest.mark.parametrize("timing", ["flat", "table"])
def test_a_limit_lowered_in_a_register_access(make, at, timing):
    machine = make(timing)
    engine = machine.engine
    machine.on_access = lambda _kind, _offset: engine.stop_by(engine.cycle + 20)
    engine.set(Reg.R1, at.registers)
    machine.load(0x6008, *[NOP] * 60, HANG)
    engine.run(1000)
    assert 20 <= engine.cycle < 22
