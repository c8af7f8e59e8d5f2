"""Loops that are passed over end as they do when they are executed; what is told of them does not depend on cuts."""

from __future__ import annotations

import sys
from types import SimpleNamespace

import pytest

from targets.mcu.engine.api import Access, Reg
from targets.mcu.engine.core_engine import Skip

STORES = [half for place in range(70) for half in (0xF881, 0x2000 | place)]  # strb.w r2, [r1, #place]
LOOPS = {
    # ldrb r2, [r1]; adds r2, #1; strb r2, [r1]; movs r2, #0; cmp r2, r2; b to the start: memory alone counts
    "memory": (0x780A, 0x3201, 0x700A, 0x2200, 0x4292, 0xE7F9),
    "a register": (0x6002, 0xE7FD),  # str r2, [r0]; b
    # strex r3, r2, [r1]; cbz r3 over: ldrex r4, [r1]; movs r3, #0; b: every other turn is longer, by the monitor alone
    "the monitor": (0xE841, 0x2300, 0xB10B, 0xE851, 0x4F00, 0x2300, 0xE7F8),
    # the byte that counts is stored behind more than are kept
    "many stores": (
        *STORES,
        *(0xF891, 0x3050, 0x3301, 0xF881, 0x3050, 0x2300, 0x429B),
        0xE000 | -(len(STORES) + 9) & 0x7FF,
    ),
}


@pytest.mark.parametrize("loop", LOOPS)
def test_it_ends_as_executed(make, at, loop):
    ends = []
    for skip in (Skip.NOTHING, Skip.LOOPS):
        machine = make()
        machine.engine.set(Reg.R0, at.registers)
        machine.engine.set(Reg.R1, at.ram + 0x100)
        machine.load(*LOOPS[loop])
        machine.engine.run(100_000, skip=skip)
        ends.append((machine.engine.cycle, machine.regs(), bytes(machine.ram), len(machine.log)))
    assert ends[0] == ends[1]


@pytest.mark.parametrize("skip", [Skip.NOTHING, Skip.LOOPS])
def test_a_lowered_limit_outlives_a_pause(make, at, skip):
    """Every five million instructions a run looks whether Ctrl-C was pressed."""
    machine = make()
    machine.on_access = lambda _kind, _offset: machine.engine.stop_by(20_000_000)
    machine.engine.set(Reg.R0, at.registers)
    machine.load(0x6001, 0x3101, 0xE7FD)  # str r1, [r0]; then adds r1, #1; b to it
    machine.engine.run(100_000_000, skip=skip)
    assert machine.engine.cycle in (20_000_000, 20_000_001)


@pytest.mark.parametrize("raised", [KeyboardInterrupt, SystemExit])
@pytest.mark.parametrize("known", [True, False], ids=["until 3.12", "from 3.13 on"])
def test_what_a_signal_raises_where_a_callback_begins_ends_the_run(make, at, raised, known):
    machine = make()
    engine = machine.engine

    def interrupt(_kind, _offset):
        frame = SimpleNamespace(tb_frame=SimpleNamespace(f_locals={"self": engine}))
        what = SimpleNamespace(object=engine._read if known else None, exc_value=raised(), exc_traceback=frame)
        sys.unraisablehook(what)

    machine.on_access = interrupt
    engine.set(Reg.R0, at.registers)
    machine.load(0x6801, 0xE7FD)  # ldr r1, [r0]; b
    with pytest.raises(raised):
        engine.run(1_000_000)
    assert engine.instructions == 1


def test_what_it_polls_does_not_depend_on_where_a_look_begins_or_ends(make, at):
    machine = make(access=Access(lambda _offset, _size: 0, lambda *_words: None, lambda _offset: False))
    engine = machine.engine
    engine.set(Reg.R0, at.registers)
    machine.load(0x6801, 0x6902, 0xBF00, 0xBF00, 0xE7FA)  # ldr r1, [r0]; ldr r2, [r0, #16]; nop; nop; b
    seen = set()
    for piece in range(400):
        engine.run(engine.cycle + 195 + piece % 13, skip=Skip.LOOPS)
        if engine.loop is not None:
            seen.add(engine.loop.polled)
    assert seen == {(at.registers, at.registers + 16)}


def test_one_that_polls_nothing_is_not_told_with_what_another_polled(make, at):
    machine = make(access=Access(lambda _offset, _size: 0, lambda *_words: None, lambda _offset: False))
    engine = machine.engine
    engine.set(Reg.R0, at.registers)
    machine.load(0x6801, 0xE7FD, 0xE7FE)  # ldr r1, [r0]; b to it; b to itself
    engine.run(10_000, skip=Skip.LOOPS)
    assert engine.loop.polled == (at.registers,)
    engine.forget_loop()
    engine.set(Reg.PC, at.code + 4)
    engine.run(20_000, skip=Skip.LOOPS)
    assert engine.loop.polled == ()
