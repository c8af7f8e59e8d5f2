"""A Cortex-M7 with its engine: programs that use floating point, interrupted where it hurts."""

from __future__ import annotations

import dataclasses
import random
import struct

import pytest

from targets.mcu.bus import Bus
from targets.mcu.cortexm.core import Core
from targets.mcu.cortexm.exceptions import Number
from targets.mcu.cortexm.kinds import CORTEX_M7
from targets.mcu.engine.api import Reg, StopKind
from targets.mcu.engine.core_engine import CoreEngine
from targets.mcu.engine.timing import make_timing
from targets.mcu.testing import FakeChip

FLASH, RAM, PPB = 0x0800_0000, 0x2000_0000, 0xE000_0000
MAIN, HANDLERS = FLASH + 0x400, FLASH + 0x800
STACK = RAM + 0x1000
CPACR, FPCCR, ICSR = 0xE000_ED88, 0xE000_EF34, 0xE000_ED04
BX_LR, HANG = 0x4770, 0xE7FE
ONE = 0x3F80_0000
LSPACT = 1


def constant(register, value):
    """movw, movt"""
    halves = []
    for opcode, half in ((0xF240, value & 0xFFFF), (0xF2C0, value >> 16)):
        halves += [opcode | (half >> 11 & 1) << 10 | half >> 12, (half >> 8 & 7) << 12 | register << 8 | half & 0xFF]
    return halves


ENABLE = [*constant(0, 0xF << 20), *constant(1, CPACR), 0x6008, 0xF3BF, 0x8F4F, 0xF3BF, 0x8F6F]  # str; dsb; isb
UNPRIVILEGED = [  # msr psp, r0; movs r0, #3; msr control, r0; isb
    *(*constant(0, RAM + 0x800), 0xF380, 0x8809, 0x2003, 0xF380, 0x8814, 0xF3BF, 0x8F6F),
    0xBF00,
]
SUMS = [
    *(*constant(5, 0), *constant(6, ONE), *constant(4, 300)),
    *(0xEE00, 0x5A10, 0xEE00, 0x6A90),  # vmov s0, r5; vmov s1, r6
    *(0xEEB7, 0x2AE0, 0xEEB7, 0x3AE0),  # vcvt.f64.f32 d2, s1; vcvt.f64.f32 d3, s1
    *(0xEE30, 0x0A20, 0xEE32, 0x2B03),  # loop: vadd.f32 s0, s0, s1; vadd.f64 d2, d2, d3
    *(0xEEB4, 0x0A60, 0xEEF1, 0xFA10),  # vcmp.f32 s0, s1; vmrs apsr_nzcv, fpscr
    *(0xBFBC, 0x3701, 0x3702),  # itt lt; addlt r7, #1; addlt r7, #2
    *(0x3C01, 0xD1F2),  # subs r4, #1; bne loop
    *(0xEE10, 0x0A10, 0xEC52, 0x1B12),  # vmov r0, s0; vmov r1, r2, d2
    HANG,
]
SPOILS = [  # vadd.f32 s1, s1, s1; vadd.f64 d2, d2, d2; round to zero, flush; vcmp.f32 s0, #0; bx lr
    *(0xEE70, 0x0AA0, 0xEE32, 0x2B02),
    *(*constant(0, 0x01C0_0000), 0xEEE1, 0x0A10, 0xEEB5, 0x0A40, BX_LR),
]
SPARES = [BX_LR]
SAVES = [0xED2D, 0x8A02, 0xEE38, 0x8A28, 0xECBD, 0x8A02, BX_LR]  # vpush {s16, s17}; vadd s16, s16, s17; vpop; bx lr


class Bench:
    """A core, its engine, flash, RAM and the loop around them."""

    def __init__(self, main, handlers):
        chip = FakeChip(hclk_hz=216_000_000)
        self.time = chip.time
        self.engine = engine = CoreEngine(make_timing("flat", CORTEX_M7), CORTEX_M7)
        self.bus = bus = Bus(chip.notes)
        self.flash, self.ram = bytearray(0x1000), bytearray(0x1000)
        self.core = core = Core(engine, dataclasses.replace(chip.services, bus=bus), CORTEX_M7)
        for base, data, writable in ((FLASH, self.flash, False), (RAM, self.ram, True)):
            engine.map_memory(base, data, writable=writable)
            bus.add_memory(base, data, writable=writable)
        for peripheral in core.peripherals:
            bus.add(peripheral)
        engine.map_registers(PPB, 0x10_0000, bus.window(PPB))
        engine.live_in(self.time)
        self.put(0, struct.pack("<126I", STACK, MAIN | 1, *[HANDLERS | 1] * 124))
        self.put(MAIN - FLASH, struct.pack(f"<{len(main)}H", *main))
        for place, (number, code) in enumerate(handlers.items()):
            at = HANDLERS + 0x100 * place
            self.put(at - FLASH, struct.pack(f"<{len(code)}H", *code))
            self.put(4 * number, struct.pack("<I", at | 1))
        self.engine.forget(FLASH, len(self.flash))
        core.reset(FLASH, power_on=True)

    def put(self, at, data):
        self.flash[at : at + len(data)] = data

    def step(self, instructions):
        """Take what can be taken, or execute; return how that stopped."""
        self.time.run_due(self.engine.cycle)
        if self.core.can_take():
            self.core.take()
            return StopKind.LIMIT
        stop = self.engine.run(1 << 40, instructions)
        if stop.kind is not StopKind.LIMIT:
            self.core.handle(stop)
        return stop.kind

    def run_to(self, pc):
        for _ in range(100_000):
            if self.engine.get(Reg.PC) == pc:
                return
            self.step(1)
        raise AssertionError("it does not come there")

    def interrupt(self, number):
        line = self.core.irq(number)
        line.set(True)
        line.set(False)

    @property
    def state(self):
        get, floats = self.engine.get, self.engine.get_floats()
        return [get(register) for register in Reg if register is not Reg.XPSR], floats[:16], floats[32]


PREPARATIONS = {"privileged": [], "unprivileged": UNPRIVILEGED}


def end_of(prepare="privileged"):
    return MAIN + 2 * (len(ENABLE) + len(PREPARATIONS[prepare]) + len(SUMS)) - 2


def make(*, lazy=True, prepare="privileged"):
    """A bench with three interrupts: 0 spoils the registers, 1 spares them, 2 saves what it uses; 2 over 1 over 0."""
    bench = Bench([*ENABLE, *PREPARATIONS[prepare], *SUMS], {16: SPOILS, 17: SPARES, 18: SAVES})
    for irq, priority in ((0, 0xC0), (1, 0x80), (2, 0x40)):
        bench.core.exceptions.set_priority(Number.FIRST_IRQ + irq, priority)
        bench.core.exceptions.enable(Number.FIRST_IRQ + irq)
    if not lazy:
        bench.bus.write(FPCCR, 4, 1 << 31)
    return bench


@pytest.fixture(scope="module", params=PREPARATIONS)
def undisturbed(request):
    bench = make(prepare=request.param)
    bench.run_to(end_of(request.param))
    assert bench.engine.get(Reg.R0) == struct.unpack("<I", struct.pack("<f", 300))[0]
    low, high = bench.engine.get(Reg.R1), bench.engine.get(Reg.R2)
    assert struct.pack("<2I", low, high) == struct.pack("<d", 301)
    return request.param, bench.state


@pytest.mark.parametrize("lazy", [True, False])
@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(n, marks=pytest.mark.exhaustive("more of the random kind")) for n in range(1, 4))]
)
def test_interrupts_leave_no_trace(undisturbed, lazy, seed):
    """Nested, tail-chained, late, between any two instructions: main computes what it does alone."""
    prepare, state = undisturbed
    bench, rng = make(lazy=lazy, prepare=prepare), random.Random(seed)
    entered = []
    bench.core.on_running = entered.append
    while bench.engine.get(Reg.PC) != end_of(prepare):
        bench.step(rng.randint(1, 6))
        if bench.core.scb.float_access and rng.random() < 0.3:
            bench.interrupt(rng.randrange(3))
    while bench.core.running or bench.core.can_take():
        bench.step(1)
    assert bench.state == state
    assert {entered.count(number) > 20 for number in (16, 17, 18)} == {True}
    assert any(entered[at] and entered[at - 1] > entered[at] for at in range(len(entered)))  # nested
    assert bench.core.last_fault is None


def test_lspact_while_a_handler_runs():
    bench = make()
    bench.run_to(MAIN + 2 * len(ENABLE) + 2 * 24)
    bench.interrupt(0)
    while bench.core.running != 16:
        bench.step(1)
    assert bench.bus.read(FPCCR, 4) & LSPACT
    assert bench.engine.get(Reg.LR) == 0xFFFF_FFE9
    assert bench.engine.get(Reg.MSP) == STACK - 104
    bench.step(1)
    assert not bench.bus.read(FPCCR, 4) & LSPACT
    assert bench.engine.get(Reg.CONTROL) == 4


def test_floating_point_before_it_is_allowed():
    bench = Bench([0xBF00, *SUMS], {6: [HANG], 3: [HANG]})
    bench.bus.write(0xE000_ED24, 4, 1 << 18)  # USGFAULTENA
    while bench.core.running != Number.USAGE_FAULT:
        bench.step(100)
    fault = bench.core.last_fault
    assert (fault.causes, fault.pc) == (("NOCP",), MAIN + 2 + 24)
    assert bench.bus.read(0xE000_ED28, 4) == 1 << 19
    assert bench.bus.read(STACK - 32 + 24, 4) == fault.pc


def test_a_fault_handler_that_allows_it_goes_on():
    """As a kernel does that gives floating point to tasks that use it."""
    bench = Bench([0xBF00, *SUMS], {3: [*ENABLE, BX_LR]})
    bench.run_to(end_of() - 2 * len(ENABLE) + 2)
    assert bench.engine.get(Reg.R0) == struct.unpack("<I", struct.pack("<f", 300))[0]
    assert bench.core.last_fault.causes == ("NOCP",)
    assert bench.core.last_fault.exception == Number.HARD_FAULT


def test_an_exception_return_in_thread_mode_is_a_jump_to_nowhere():
    bench = Bench([BX_LR], {Number.HARD_FAULT: [HANG]})  # LR is 0xFFFFFFFF after a reset
    bench.run_to(HANDLERS)
    assert bench.core.last_fault.causes == ("IACCVIOL",)
