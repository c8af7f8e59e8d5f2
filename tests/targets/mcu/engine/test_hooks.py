"""Breakpoints, watchpoints, edges and the log of accesses tell what happens, and change nothing of it."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.cortexm.kinds import CORTEX_M7
from targets.mcu.engine.api import Access, Reg, StopKind
from targets.mcu.engine.core_engine import Skip
from targets.mcu.engine.hooks import Hit, HitKind, Watchpoint
from tests.targets.mcu.engine.conftest import CODE, FLASH, RAM, REGISTERS
from tests.targets.mcu.engine.thumb_code import BASE, BASE_REGISTER, stretches

NOP, HANG, ADDS_R0, CMP_R0_0 = 0xBF00, 0xE7FE, 0x3001, 0x2800
LDR_R1_R0, STR_R1_R0, STRB_R1_R0, LDRH_R1_R0 = 0x6801, 0x6001, 0x7001, 0x8801
PUSH, LDM_R0, STM_R0, LDRD_R1_R0 = 0xB40E, 0xC80E, 0xC00E, (0xE9D0, 0x1200)  # push, ldm, stm of r1 to r3
B_BACK = {halves: 0xE000 | -(halves + 2) & 0x7FF for halves in range(12)}


def run_through(machine, limit, *, skip=Skip.NOTHING, piece=None):
    """Run up to a cycle, or a fault, and go on after each stop; return all hits."""
    hits, engine = [], machine.engine
    while engine.cycle < limit or engine.hooks.in_block:
        end = limit if piece is None else min(engine.cycle + piece, limit)
        stop = engine.run(end, skip=skip)
        if stop.kind is StopKind.HIT:
            hits.append((engine.cycle, engine.instructions, engine.hooks.hit))
        else:
            assert engine.hooks.hit is None
            if stop.kind is StopKind.FAULT:
                break
    return hits


def stands(machine):
    return machine.engine.cycle, machine.engine.instructions, machine.regs(), bytes(machine.ram), machine.log


# --- where it stops


@pytest.mark.parametrize("timing", ["flat", "table"])
def test_it_stops_before_the_instruction_and_goes_on(make, timing):
    plain, stopped = make(timing), make(timing)
    for machine in (plain, stopped):
        machine.load(ADDS_R0, ADDS_R0, ADDS_R0, HANG)
    stopped.engine.hooks.breakpoints = {CODE + 2, CODE + 5}  # bit 0 is that of an address of a function
    hits = run_through(stopped, 200)
    plain.engine.run(200)
    assert [(instructions, hit) for _, instructions, hit in hits] == [
        (1, Hit(HitKind.BREAKPOINT, CODE + 2, CODE + 2)),
        (2, Hit(HitKind.BREAKPOINT, CODE + 4, CODE + 4)),
    ]
    assert stands(stopped) == stands(plain)


def test_it_stops_with_single_steps_too(machine):
    machine.load(ADDS_R0, ADDS_R0, HANG)
    machine.engine.hooks.breakpoints = {CODE}
    kinds = [machine.engine.run(1000, 1).kind for _ in range(3)]
    assert kinds == [StopKind.HIT, StopKind.LIMIT, StopKind.LIMIT]
    assert machine.engine.get(Reg.R0) == 2


def test_one_that_is_taken_away_is_passed(machine):
    machine.load(ADDS_R0, B_BACK[1])
    machine.engine.hooks.breakpoints = {CODE}
    assert machine.run(100).kind is StopKind.HIT
    machine.engine.hooks.breakpoints = ()
    assert machine.run(100).kind is StopKind.LIMIT


@pytest.mark.parametrize("skip", [Skip.NOTHING, Skip.LOOPS])
@pytest.mark.parametrize("piece", [None, 7, 450])
def test_it_stops_in_each_turn_of_a_loop_that_changes_nothing(make, skip, piece):
    machine = make()
    machine.load(NOP, NOP, B_BACK[2])
    machine.engine.run(3000, skip=Skip.LOOPS)
    assert machine.engine.loop is not None
    began = machine.engine.instructions
    machine.engine.hooks.breakpoints = {CODE + 2}
    hits = run_through(machine, 9000, skip=skip, piece=piece)
    turns = [instructions for _, instructions, _ in hits]
    assert turns[0] - began < 4
    assert turns == list(range(turns[0], machine.engine.instructions + (turns[0] - machine.engine.instructions) % 3, 3))


def test_what_an_it_block_passes_over_is_no_stop(machine):
    machine.load(CMP_R0_0, 0xBF0C, ADDS_R0, 0x3102, HANG)  # ite eq
    machine.engine.hooks.breakpoints = {CODE + 4, CODE + 6}
    hits = run_through(machine, 100)
    assert [(hit.pc, instructions) for _, instructions, hit in hits] == [(CODE + 4, 2)]
    assert (machine.engine.get(Reg.R0), machine.engine.get(Reg.R1)) == (1, 0)


def test_within_a_block_nothing_comes_in_between(machine):
    machine.load(CMP_R0_0, 0xBF04, ADDS_R0, ADDS_R0, HANG)  # itt eq
    machine.engine.hooks.breakpoints = {CODE + 4, CODE + 6}
    assert machine.engine.run(100).kind is StopKind.HIT
    assert machine.engine.hooks.in_block
    assert machine.engine.run(0).kind is StopKind.HIT
    assert machine.engine.hooks.in_block
    assert machine.engine.run(0).kind is StopKind.LIMIT
    assert (machine.engine.get(Reg.PC), machine.engine.hooks.in_block) == (CODE + 8, False)


def test_code_that_is_written_anew_keeps_its_breakpoints(machine):
    machine.engine.hooks.breakpoints = {RAM + 0x10}
    for code in (NOP, ADDS_R0):
        machine.load(NOP, code, HANG, at=RAM + 0xE)
        assert machine.run(20).kind is StopKind.HIT
        assert machine.engine.hooks.hit.pc == RAM + 0x10
        machine.run(20)
    machine.load(ADDS_R0, at=RAM + 0x10)
    machine.ram[0x10:0x12] = NOP.to_bytes(2, "little")  # as a program does it
    machine.engine.set(Reg.PC, RAM + 0x10)
    assert [machine.engine.run(1 << 40, 1).kind for _ in range(2)] == [StopKind.HIT, StopKind.LIMIT]
    assert machine.engine.get(Reg.R0) == 1


@given(code=stretches(), timing=st.sampled_from(("flat", "table")), skip=st.booleans(), seed=st.integers(0, 999))
def test_breakpoints_everywhere_change_nothing(make, code, timing, skip, seed):
    """Stops come at what was executed, in order; the state after each run is the same."""
    kind = CORTEX_M7 if seed % 2 else None
    halves = [half for stretch in code for one in stretch for half in one]
    plain, stopped = (make(timing, **({} if kind is None else {"kind": kind})) for _ in range(2))
    for machine in (plain, stopped):
        machine.load(*halves, HANG)
        machine.engine.set(Reg(BASE_REGISTER), BASE)
        machine.engine.cover()
    stopped.engine.hooks.breakpoints = range(CODE, CODE + 2 * len(halves), 2)
    stopped.engine.hooks.map_edges(256)
    rng = random.Random(seed)
    pieces = [rng.randrange(1, 30) for _ in range(12)]
    hits = []
    for limit in (sum(pieces[:n]) for n in range(1, 13)):
        if plain.engine.cycle >= limit:
            continue
        stop = plain.engine.run(limit)
        hits += run_through(stopped, limit, skip=Skip.LOOPS if skip else Skip.NOTHING)
        assert stands(plain) == stands(stopped)
        if stop.kind is StopKind.FAULT:
            break
    told = [hit.pc for _, _, hit in hits]
    assert sorted(told) == [address for address in sorted(plain.engine.executed()) if address < CODE + 2 * len(halves)]
    assert told == sorted(told)


WHOLE = {"address": 0, "size": 1 << 32}


def test_too_many_are_refused(machine):
    with pytest.raises(ValueError, match="257 breakpoints are too many: at most 256"):
        machine.engine.hooks.breakpoints = range(0, 514, 2)
    with pytest.raises(ValueError, match="65 watchpoints are too many: at most 64"):
        machine.engine.hooks.watchpoints = [Watchpoint(RAM)] * 65
    assert (machine.engine.hooks.breakpoints, machine.engine.hooks.watchpoints) == (frozenset(), ())
    for wrong in ({"size": 0}, {"writes": False}, {"address": 1 << 32}, {"address": (1 << 32) - 2}, WHOLE):
        with pytest.raises(ValueError, match="no bytes of the address space"):
            Watchpoint(**{"address": RAM, **wrong})


# --- watchpoints

WORD = RAM + 0x100
ACCESSES = {
    # code, r0, what is watched, what is told: kind, address, size, value
    "a word is read": ((LDR_R1_R0,), WORD, {"reads": True}, (HitKind.READ, WORD, 4, 0x04030201)),
    "of a half the upper byte": ((LDRH_R1_R0,), WORD, {"address": WORD + 1, "size": 1, "reads": True},
                                 (HitKind.READ, WORD, 2, 0x0201)),
    "a byte is written": ((STRB_R1_R0,), WORD + 3, {}, (HitKind.WRITE, WORD + 3, 1, 0x91)),
    "one beside it": ((STRB_R1_R0,), WORD + 4, {}, None),
    "a read where writes are watched": ((LDR_R1_R0,), WORD, {}, None),
    "a write where reads are watched": ((STR_R1_R0,), WORD, {"reads": True, "writes": False}, None),
    "unaligned": ((STR_R1_R0,), WORD - 3, {}, (HitKind.WRITE, WORD - 3, 4, 0x90919091)),
    "one of three": ((STM_R0,), WORD - 4, {}, (HitKind.WRITE, WORD, 4, 0x92)),
    "the last of three is read": ((LDM_R0,), WORD - 8, {"reads": True}, (HitKind.READ, WORD, 4, 0x04030201)),
    "two": (LDRD_R1_R0, WORD - 4, {"reads": True}, (HitKind.READ, WORD, 4, 0x04030201)),
    "flash is read": ((LDR_R1_R0,), CODE, {"address": CODE, "reads": True}, (HitKind.READ, CODE, 4, 0xE7FE6801)),
    "flash is written": ((STR_R1_R0,), FLASH, {"address": FLASH}, (HitKind.WRITE, FLASH, 4, 0x90919091)),
    "a register is read": ((LDR_R1_R0,), REGISTERS, {"address": REGISTERS, "reads": True},
                           (HitKind.READ, REGISTERS, 4, None)),
    "a register is written": ((STRB_R1_R0,), REGISTERS + 2, {"address": REGISTERS},
                              (HitKind.WRITE, REGISTERS + 2, 1, 0x91)),
    "registers are read by one instruction": ((LDM_R0,), REGISTERS, {"address": REGISTERS + 8, "reads": True},
                                              (HitKind.READ, REGISTERS + 8, 4, None)),
    "over the end of memory": ((STR_R1_R0,), RAM + 0xFFE, {"address": RAM + 0xFFC},
                           (HitKind.WRITE, RAM + 0xFFE, 4, 0x90919091)),
    "a literal": ((0x4900, HANG, 0x5678, 0x1234), 0, {"address": CODE + 4, "reads": True},
                  (HitKind.READ, CODE + 4, 4, 0x12345678)),
}  # fmt: skip


@pytest.mark.parametrize("timing", ["flat", "table"])
@pytest.mark.parametrize("name", ACCESSES)
def test_it_stops_before_an_access(make, name, timing):
    code, base, watched, told = ACCESSES[name]
    ends, hits = [], []
    for watches in (False, True):
        machine = make(timing)
        machine.load(*code, HANG)
        machine.ram[0x100:0x104] = bytes((1, 2, 3, 4))
        for register, value in ((Reg.R0, base), (Reg.R1, 0x90919091), (Reg.R2, 0x92), (Reg.R3, 0x93)):
            machine.engine.set(register, value)
        if watches:
            machine.engine.hooks.watchpoints = [Watchpoint(**{"address": WORD, **watched})]
        found = []
        for _ in range(4):
            stop = machine.engine.run(machine.engine.cycle + 3)
            if stop.kind is StopKind.HIT:
                assert not machine.log
                assert machine.engine.instructions == 0
                found.append(machine.engine.hooks.hit)
            elif stop.kind is StopKind.FAULT:
                break
        machine.engine.run(60)
        ends.append((stands(machine), stop, machine.stores))
        hits.append(found)
    assert hits == [[], [] if told is None else [Hit(told[0], CODE, *told[1:])]]
    assert ends[0][1:] == ends[1][1:]
    assert ends[0][0] == ends[1][0]


def test_a_breakpoint_and_a_watchpoint_of_one_instruction_stop_once_each(machine):
    machine.load(LDR_R1_R0, HANG)
    machine.engine.set(Reg.R0, RAM)
    machine.engine.hooks.breakpoints = {CODE}
    machine.engine.hooks.watchpoints = [Watchpoint(RAM, reads=True)]
    assert [hit.kind for _, _, hit in run_through(machine, 100)] == [HitKind.BREAKPOINT, HitKind.READ]


def test_a_store_that_fails_is_undone_where_it_is_watched(machine):
    machine.load(STM_R0, HANG)
    machine.engine.set(Reg.R0, RAM + 0xFF8)  # the third word is beyond
    machine.engine.set(Reg.R1, 1)
    machine.engine.hooks.watchpoints = [Watchpoint(RAM + 0xFF8, 8)]
    assert [machine.run(9).kind for _ in range(2)] == [StopKind.HIT, StopKind.FAULT]
    assert bytes(machine.ram[0xFF8:]) == bytes(8)


LOOPS = {
    "polls a register": (LDR_R1_R0, NOP, B_BACK[2]),
    "polls memory": (0x6811, NOP, B_BACK[2]),  # ldr r1, [r2]
    "calls": (PUSH, 0xF000, 0xF801, B_BACK[3], 0x6801, 0x4770),  # push; bl over; b; ldr r1, [r0]; bx lr
}


def still(make):
    return make(access=Access(lambda _offset, _size: 5, lambda *_words: None, lambda _offset: False))


@pytest.mark.parametrize("skip", [Skip.NOTHING, Skip.LOOPS])
@pytest.mark.parametrize("loop", ["polls a register", "polls memory"])
def test_each_access_in_a_loop_that_changes_nothing_stops(make, loop, skip):
    machine = still(make)
    machine.load(*LOOPS[loop])
    machine.engine.set(Reg.R0, REGISTERS)
    machine.engine.set(Reg.R2, RAM)
    machine.engine.run(3000, skip=Skip.LOOPS)
    began = machine.engine.instructions
    watched = {"polls a register": REGISTERS, "polls memory": RAM}[loop]
    machine.engine.hooks.watchpoints = [Watchpoint(watched, reads=True)]
    hits = run_through(machine, 6000, skip=skip)
    assert len(hits) in ((machine.engine.instructions - began) // 3, (machine.engine.instructions - began) // 3 + 1)


# --- edges and accesses


def spread(address):
    return (address // 2 * 2654435761) % 2**32 >> 8


def place(start, end, size=1 << 16):
    return (spread(start) >> 1 ^ spread(end)) % size


def test_edges_are_counted(machine):
    # movs r0, #3; subs r0, #1; bne to that; bl over one; nop; hang
    machine.load(0x2003, 0x3801, 0xD1FD, 0xF000, 0xF801, NOP, NOP, HANG)
    edges = machine.engine.hooks.map_edges(1 << 16)
    machine.engine.run(400)
    turns = machine.engine.instructions - 10
    expected = {
        place(CODE + 4, CODE + 2): 2,
        place(CODE + 4, CODE + 6): 1,
        place(CODE + 6, CODE + 12): 1,
        place(CODE + 14, CODE + 14): min(turns, 255),
    }
    assert {at: count for at, count in enumerate(edges) if count} == expected
    machine.engine.hooks.stop_mapping()
    machine.load(0xE000, NOP, HANG)
    machine.run(10)
    assert sum(map(bool, edges)) == 4


@pytest.mark.parametrize("size", [255, 128, 1 << 25, 0])
def test_a_map_of_another_size_is_refused(machine, size):
    with pytest.raises(ValueError, match=f"a map of {size} bytes"):
        machine.engine.hooks.map_edges(size)


@pytest.mark.parametrize("loop", LOOPS)
@pytest.mark.parametrize("timing", ["flat", "table"])
def test_what_is_written_down_does_not_depend_on_skipping_or_cuts(make, loop, timing):
    found = []
    for skip, piece in ((Skip.NOTHING, None), (Skip.LOOPS, None), (Skip.LOOPS, 13), (Skip.LOOPS, 450)):
        machine = make(timing, access=Access(lambda _o, _s: 5, lambda *_w: None, lambda _offset: False))
        machine.load(*LOOPS[loop])
        machine.engine.set(Reg.R0, REGISTERS)
        machine.engine.set(Reg.R2, RAM)
        edges = machine.engine.hooks.map_edges(256)
        machine.engine.hooks.log_accesses(10)
        for limit in (500, 40_000):
            run_through(machine, limit, skip=skip, piece=piece)
            found.append((limit, stands(machine), bytes(edges), machine.engine.hooks.accesses))
            if limit == 500:
                machine.engine.set(Reg.R0, REGISTERS + 4)
    assert found[0:2] == found[2:4] == found[4:6] == found[6:8]
    if loop != "polls memory":
        assert [access.address for access in found[1][3]] == [REGISTERS, REGISTERS + 4]
    assert max(found[0][2]) < max(found[1][2]) == 255


def test_loops_are_passed_over_when_there_is_nothing_new(machine):
    machine.load(HANG)
    machine.engine.hooks.map_edges(256)
    machine.engine.run(10**9, skip=Skip.LOOPS)
    assert machine.engine.cycle >= 10**9


def test_accesses_are_written_down(machine):
    machine.load(LDR_R1_R0, LDR_R1_R0, STRB_R1_R0, 0x3001, LDRH_R1_R0, HANG)
    machine.engine.set(Reg.R0, REGISTERS)
    machine.value = 0x1234
    machine.engine.hooks.log_accesses(3)
    machine.run(20)
    told = [(one.pc - CODE, one.address, one.size, one.value, one.writes) for one in machine.engine.hooks.accesses]
    assert told == [
        (0, REGISTERS, 4, 0x1234, False),
        (2, REGISTERS, 4, 0x1234, False),
        (4, REGISTERS, 1, 0x34, True),
    ]
    assert [one.cycle for one in machine.engine.hooks.accesses] == [entry[-1] for entry in machine.log[:3]]
    machine.engine.hooks.log_accesses(0)
    assert machine.engine.hooks.accesses == []


def test_a_read_that_is_the_same_again_is_left_out(machine):
    machine.load(LDR_R1_R0, 0x6842, B_BACK[2])  # and ldr r2, [r0, #4]
    machine.engine.set(Reg.R0, REGISTERS)
    machine.engine.hooks.log_accesses(100)
    machine.run(50)
    machine.value = 7
    machine.run(50)
    told = [(one.pc - CODE, one.value) for one in machine.engine.hooks.accesses]
    assert told in ([(0, 0), (2, 0), (0, 7), (2, 7)], [(0, 0), (2, 0), (2, 7), (0, 7)])
