"""What the engine says was executed: each instruction that was, and no other."""

from __future__ import annotations

import random

from targets.mcu.engine.api import Reg, StopKind
from tests.targets.mcu.engine.conftest import CODE, RAM

NOP, HANG, ADDS_R0, ADDS_R1, MOVW_R2 = 0xBF00, 0xE7FE, 0x3001, 0x3101, (0xF240, 0x0201)
CMP_R0_0, BEQ_OVER_ONE, UNDEFINED = 0x2800, 0xD000, 0xDE00


def executed(machine, base=CODE):
    return [address - base for address in machine.engine.executed() if address >= base]


def test_what_a_branch_passes_over_was_not_executed(machine):
    machine.engine.cover()
    machine.load(CMP_R0_0, BEQ_OVER_ONE, ADDS_R1, *MOVW_R2, NOP, HANG, NOP)
    machine.run(8)
    assert executed(machine) == [0, 2, 6, 10, 12]


def test_what_an_it_block_passes_over_was_not_executed(machine):
    machine.engine.cover()
    machine.load(CMP_R0_0, 0xBF0C, ADDS_R0, ADDS_R1, HANG)  # ite eq
    machine.run(8)
    assert executed(machine) == [0, 2, 4, 8]


def test_what_faults_was_executed(machine):
    machine.engine.cover()
    machine.load(NOP, UNDEFINED, NOP)
    assert machine.run(8).kind is StopKind.FAULT
    assert executed(machine) == [0, 2]


def test_what_is_written_over_has_been_executed_all_the_same(machine):
    machine.engine.cover()
    machine.load(*[NOP] * 40, HANG)
    machine.run(50)
    machine.load(HANG)
    machine.load(HANG, at=RAM)
    machine.run(2)
    machine.load(*[NOP] * 0x7FF, HANG, at=RAM)
    assert executed(machine) == [*range(0, 82, 2), RAM - CODE]


def test_nothing_is_said_that_nobody_asked_for(machine):
    machine.load(NOP, HANG)
    machine.run(2)
    assert executed(machine) == []


def test_it_is_what_single_steps_come_by(make):
    for seed in range(8):
        rng = random.Random(seed)
        code = [rng.choice((ADDS_R0, ADDS_R1, CMP_R0_0, BEQ_OVER_ONE, 0xD100, 0xBF08)) for _ in range(200)]
        code += [*[NOP] * 4, HANG]
        whole, steps = make(), make()
        for machine in (whole, steps):
            machine.load(*code)
        whole.engine.cover()
        whole.run(400)
        end = 2 * len(code) - 2
        reached = {end}
        while steps.engine.get(Reg.PC) != CODE + end:
            reached.add(steps.engine.get(Reg.PC) - CODE)
            steps.run(1)
        more = set(executed(whole)) - reached
        assert reached <= set(executed(whole)), seed
        assert all(code[at // 2 - 1] == 0xBF08 for at in more), seed  # an IT block is one step
