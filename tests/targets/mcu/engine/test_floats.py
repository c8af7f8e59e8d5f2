"""Floating point of a Cortex-M7: registers, contexts, access."""

from __future__ import annotations

import struct

import pytest

from targets.mcu.bus import Bus
from targets.mcu.cortexm.kinds import CORTEX_M7
from targets.mcu.engine.api import Access, FaultKind, FloatAccess, Reg, StopKind
from targets.mcu.engine.core_engine import CoreEngine
from targets.mcu.engine.follower import Follower, NotUnderstood
from targets.mcu.engine.follower_steps import step
from targets.mcu.engine.idle import IdleSkipper
from targets.mcu.engine.timing import make_timing
from targets.mcu.errors import BusFault
from targets.mcu.fidelity import Notes
from targets.mcu.timebase import Timebase

FLASH, RAM, REGISTERS = 0x0800_0000, 0x2000_0000, 0x4000_0000
CODE = FLASH + 0x100
NOP = 0xBF00
VADD = (0xEE30, 0x0A20)  # vadd.f32 s0, s0, s1
VADD_D = (0xEE30, 0x0B01)  # vadd.f64 d0, d0, d1
VMRS, VMSR = (0xEEF1, 0x0A10), (0xEEE1, 0x0A10)  # r0 from FPSCR, FPSCR from r0
MSR_CONTROL = (0xF380, 0x8814)  # from r0
CPSIE = 0xB662
ONE, TWO = 0x3F80_0000, 0x4000_0000
FPCA, NPRIV = 4, 1


class Machine:
    """An M7 with flash, RAM and a kilobyte of registers where nothing answers at offset 0x100."""

    def __init__(self):
        self.engine = CoreEngine(make_timing("flat", CORTEX_M7), CORTEX_M7)
        self.flash, self.ram = bytearray(b"\xff" * 0x1000), bytearray(0x1000)
        self.on_write = lambda: None
        self.engine.map_memory(FLASH, self.flash, writable=False)
        self.engine.map_memory(RAM, self.ram, writable=True)
        self.engine.map_registers(REGISTERS, 0x400, Access(self._read, self._write))
        self.engine.set(Reg.XPSR, 1 << 24)
        self.engine.set(Reg.SP, RAM + 0x1000)

    def _read(self, offset, _size):
        if offset == 0x100:
            raise BusFault(REGISTERS + offset, "nobody is there")
        return 0x4120_0000

    def _write(self, _offset, _size, _value):
        self.on_write()

    def load(self, *halves, at=CODE):
        code = struct.pack(f"<{len(halves)}H", *halves)
        memory, base = (self.flash, FLASH) if at < RAM else (self.ram, RAM)
        memory[at - base : at - base + len(code)] = code
        self.engine.forget(at, len(code))
        self.engine.set(Reg.PC, at)

    def run(self, instructions):
        return self.engine.run(1 << 40, instructions)

    def execute(self, *halves, instructions=1):
        self.load(*halves, NOP, NOP)
        return self.run(instructions)

    @property
    def floats(self):
        return self.engine.get_floats()

    @floats.setter
    def floats(self, words):
        self.engine.set_floats([*words, *[0] * (33 - len(words))])

    def begin_contexts(self, *, automatic=True, fpscr):
        kept = self.engine.exceptions
        kept.fpccr, kept.fpdscr = automatic << 31, fpscr

    @property
    def control(self):
        return self.engine.get(Reg.CONTROL)


@pytest.fixture
def m7():
    return Machine()


class TestRegisters:
    def test_what_is_set_is_what_instructions_see(self, m7):
        m7.floats = [ONE, TWO]
        assert m7.execute(*VADD).kind is StopKind.LIMIT
        assert m7.floats[:2] == [0x4040_0000, TWO]

    def test_doubles_are_pairs(self, m7):
        m7.floats = [*struct.unpack("<2I", struct.pack("<d", 1.5)), *struct.unpack("<2I", struct.pack("<d", 2.25))]
        m7.execute(*VADD_D)
        assert struct.unpack("<d", struct.pack("<2I", *m7.floats[:2])) == (3.75,)

    def test_all_of_them_come_back(self, m7):
        words = [0x0101_0101 * n for n in range(32)] + [0xF7C0_009F]
        m7.floats = words
        assert m7.floats == words

    def test_the_status_register_is_the_programs(self, m7):
        m7.engine.set(Reg.R0, 0x0300_0011)
        m7.execute(*VMSR, *VMRS, instructions=2)
        assert m7.floats[32] == m7.engine.get(Reg.R0) == 0x0300_0011

    def test_they_tell_states_apart(self, m7):
        before = m7.engine.fingerprint()
        for place in (0, 31, 32):
            words = [0] * 33
            words[place] = 1
            m7.floats = words
            assert m7.engine.fingerprint() != before

    @pytest.mark.parametrize("flags", [0x0, 0x5, 0xA, 0xF])
    def test_the_flags_of_dsp_instructions_come_back(self, m7, flags):
        """An exception that interrupts between SADD8 and SEL: xPSR is set from the frame."""
        m7.engine.set(Reg.XPSR, 1 << 24 | flags << 16)
        for register, value in ((Reg.R1, 0x1111_1111), (Reg.R2, 0x2222_2222)):
            m7.engine.set(register, value)
        m7.execute(0xFAA1, 0xF082)  # sel r0, r1, r2
        assert m7.engine.get(Reg.R0) == sum((0x11 if flags >> n & 1 else 0x22) << 8 * n for n in range(4))
        assert m7.engine.get(Reg.XPSR) >> 16 & 0xF == flags


class TestContext:
    def test_the_first_instruction_begins_one(self, m7):
        m7.begin_contexts(fpscr=0x0340_0000)
        m7.execute(NOP)
        assert not m7.control & FPCA
        m7.execute(*VADD)
        assert m7.control & FPCA
        assert m7.floats[32] == 0x0340_0000

    def test_the_second_does_not(self, m7):
        m7.begin_contexts(fpscr=0x0340_0000)
        m7.engine.set(Reg.R0, 0x0080_0000)
        m7.execute(*VADD, *VMSR, *VADD, instructions=3)
        assert m7.floats[32] == 0x0080_0000

    def test_not_without_aspen(self, m7):
        m7.begin_contexts(automatic=False, fpscr=0x0340_0000)
        m7.execute(*VADD)
        assert not m7.control & FPCA
        assert m7.floats[32] == 0

    def test_in_a_handler_too(self, m7):
        m7.engine.set(Reg.XPSR, 1 << 24 | 16)
        m7.execute(*VADD)
        assert m7.control & FPCA
        m7.engine.set(Reg.CONTROL, 0)
        assert not m7.control & FPCA
        m7.engine.set(Reg.CONTROL, FPCA)
        m7.execute(NOP)
        assert m7.control & FPCA

    def test_the_program_ends_one(self, m7):
        m7.execute(*VADD, *MSR_CONTROL, instructions=2)
        assert not m7.control & FPCA

    def test_a_change_counts_from_the_next_instruction_on(self, m7):
        m7.on_write = lambda: m7.begin_contexts(fpscr=0x0040_0000)
        m7.engine.set(Reg.R1, REGISTERS)
        m7.execute(0x6008, *VADD, instructions=2)  # str r0, [r1]
        assert m7.floats[32] == 0x0040_0000


class TestAccess:
    @pytest.mark.parametrize("code", [VADD, VADD_D, VMRS, (0xED9F, 0x0A01), (0xEC51, 0x0B10), (0xFEB8, 0x0A40)])
    @pytest.mark.parametrize("before", [[], [CPSIE], [NOP, *MSR_CONTROL], [0xF3BF, 0x8F6F]])
    def test_denied(self, m7, code, before):
        m7.engine.set_float_access(FloatAccess.NOBODY)
        stop = m7.execute(*before, *code, instructions=5)
        assert (stop.kind, stop.fault) == (StopKind.FAULT, FaultKind.UNDEFINED)
        assert m7.engine.get(Reg.PC) == CODE + 2 * len(before)
        assert not m7.control & FPCA
        assert m7.engine.instructions == len(before) - before.count(0xF380) - before.count(0xF3BF)

    @pytest.mark.parametrize("holds", [True, False])
    def test_denied_under_a_condition(self, m7, holds):
        m7.engine.set_float_access(FloatAccess.NOBODY)
        m7.engine.set(Reg.XPSR, 1 << 24 | holds << 30)
        stop = m7.execute(0xBF04, 0x3001, *VADD, instructions=3)  # itt eq; addeq r0, #1
        assert (stop.kind is StopKind.FAULT) is holds
        assert m7.engine.get(Reg.R0) == holds
        if holds:
            assert m7.engine.get(Reg.PC) == CODE + 4
            m7.engine.set_float_access(FloatAccess.EVERYBODY)
            m7.floats = [ONE, ONE]
            assert m7.run(1).kind is StopKind.LIMIT
            assert m7.floats[0] == TWO

    def test_code_in_ram(self, m7):
        m7.engine.set_float_access(FloatAccess.NOBODY)
        m7.load(NOP, *VADD, NOP, at=RAM + 0x100)
        stop = m7.run(5)
        assert (stop.fault, m7.engine.get(Reg.PC)) == (FaultKind.UNDEFINED, RAM + 0x102)

    def test_code_that_was_programmed_since(self, m7):
        m7.engine.set_float_access(FloatAccess.NOBODY)
        m7.execute(NOP)
        assert m7.execute(*VADD).fault is FaultKind.UNDEFINED

    def test_allowed_by_the_program(self, m7):
        """STR to CPACR: what follows may."""
        m7.on_write = lambda: m7.engine.set_float_access(FloatAccess.EVERYBODY)
        m7.engine.set_float_access(FloatAccess.NOBODY)
        m7.engine.set(Reg.R1, REGISTERS)
        m7.load(0x6008, *VADD, NOP)
        assert m7.run(2).kind is StopKind.LIMIT
        assert m7.run(1).kind is StopKind.LIMIT
        assert m7.engine.get(Reg.PC) == CODE + 6

    def test_denied_by_the_program(self, m7):
        m7.on_write = lambda: m7.engine.set_float_access(FloatAccess.NOBODY)
        m7.engine.set(Reg.R1, REGISTERS)
        m7.load(*VADD, 0x6008, *VADD, NOP)
        m7.run(2)
        assert m7.run(1).fault is FaultKind.UNDEFINED
        assert m7.engine.get(Reg.PC) == CODE + 6

    @pytest.mark.parametrize(("control", "ipsr", "allowed"), [(0, 0, True), (NPRIV, 0, False), (NPRIV, 16, True)])
    def test_privileged_only(self, m7, control, ipsr, allowed):
        m7.engine.set_float_access(FloatAccess.PRIVILEGED)
        m7.engine.set(Reg.CONTROL, control)
        m7.engine.set(Reg.XPSR, 1 << 24 | ipsr)
        assert (m7.execute(*VADD).kind is StopKind.LIMIT) is allowed

    def test_what_is_none_is_none_anyway(self, m7):
        for halves in ((0xEE30, 0x0920), (0xEF30, 0x0A20), (0xEC20, 0x0A10)):  # another coprocessor, NEON, VLSTM
            stop = m7.execute(*halves)
            assert (stop.fault, m7.engine.get(Reg.PC)) == (FaultKind.UNDEFINED, CODE)


class TestAccessesThatFail:
    def test_nothing_is_loaded_and_nothing_after_it_happens(self, m7):
        """ITT EQ; VLDREQ s0 from where nobody is; VADDEQ."""
        m7.engine.set(Reg.XPSR, 1 << 24 | 1 << 30)
        m7.engine.set(Reg.R1, REGISTERS + 0x100)
        m7.floats = [ONE, TWO]
        stop = m7.execute(0xBF04, 0xED91, 0x0A00, *VADD, instructions=3)
        assert (stop.fault, stop.address) == (FaultKind.READ, REGISTERS + 0x100)
        assert m7.engine.get(Reg.PC) == CODE + 2
        assert m7.floats[:2] == [ONE, TWO]

    def test_registers_can_be_loaded_from_peripherals(self, m7):
        m7.engine.set(Reg.R1, REGISTERS)
        m7.execute(0xED91, 0x0A00)  # vldr s0, [r1]
        assert m7.floats[0] == 0x4120_0000


class TestLoops:
    def test_a_loop_that_changes_floats_alone_is_executed(self, m7):
        """VADD in a loop whose flags stay the same until its last turn: nothing of it may be passed over."""
        time = Timebase(216_000_000)
        bus = Bus(Notes(lambda: (0, 0), lambda: None))
        idle = IdleSkipper(m7.engine, bus, time, m7.ram)
        m7.floats = [0, ONE, struct.unpack("<I", struct.pack("<f", 5000))[0]]
        # vadd.f32 s0, s0, s1; vcmp.f32 s0, s2; vmrs apsr_nzcv, fpscr; blt to the start; b to itself
        m7.load(*VADD, 0xEEB4, 0x0A41, 0xEEF1, 0xFA10, 0xDBF8, 0xE7FE)
        while m7.engine.cycle < 1_000_000:
            idle.run(1_000_000)
        assert m7.floats[0] == m7.floats[2]
        assert m7.engine.get(Reg.PC) == CODE + 14
        assert idle.found is not None

    def test_a_loop_that_waits_for_a_counter_with_floats_is_not_understood(self):
        class Nothing:
            def core_register(self, _number):
                return 0

            def half(self, address):
                return VADD[address >> 1 & 1]

        with pytest.raises(NotUnderstood):
            step(Follower(Nothing(), 0))
