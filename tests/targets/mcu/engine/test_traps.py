"""Divisions by zero and unaligned accesses as faults, on request or always; stores that fail half way."""

from __future__ import annotations

import pytest

from targets.mcu.cortexm.kinds import CORTEX_M7
from targets.mcu.engine.api import FaultKind, Reg, Stop, StopKind

NOP, HANG = 0xBF00, 0xE7FE
SDIV, UDIV = (0xFB91, 0xF2F0), (0xFBB1, 0xF2F0)  # r2 = r1 / r0
DIVISION = Stop(StopKind.FAULT, fault=FaultKind.DIVISION)


@pytest.fixture
def trapping(machine):
    machine.engine.set_traps(division=True, unaligned=True)
    machine.engine.set(Reg.R1, 100)
    return machine


@pytest.fixture(params=["flat", "table"])
def any_timing(request, make):
    machine = make(request.param)
    machine.engine.set_traps(division=True, unaligned=True)
    return machine


class TestDivision:
    @pytest.mark.parametrize("divide", [SDIV, UDIV], ids=["sdiv", "udiv"])
    def test_by_zero_is_a_fault_of_the_instruction(self, any_timing, at, divide):
        engine = any_timing.engine
        engine.set(Reg.R2, 77)
        any_timing.load(NOP, *divide, HANG)
        cycle = engine.cycle
        assert any_timing.engine.run(cycle + 50) == DIVISION
        assert engine.get(Reg.PC) == at.code + 2
        assert engine.get(Reg.R2) == 77
        assert engine.instructions == 1
        assert engine.cycle == cycle + 1

    def test_by_anything_else_is_none(self, trapping):
        trapping.engine.set(Reg.R0, 3)
        trapping.load(*UDIV, HANG)
        assert trapping.run().kind is StopKind.LIMIT
        assert trapping.engine.get(Reg.R2) == 33

    def test_one_that_its_condition_passes_over_is_none(self, trapping):
        trapping.load(0x2800, 0xBF18, *UDIV, HANG)  # cmp r0, #0; it ne; udivne
        assert trapping.run().kind is StopKind.LIMIT

    @pytest.mark.parametrize(("mask", "place"), [(8, 0), (4, 0), (4, 1), (2, 1), (1, 0), (1, 2), (1, 3)])
    def test_by_zero_in_an_it_block(self, any_timing, at, mask, place):
        """Nothing that comes behind it in the block may happen."""
        engine, length = any_timing.engine, 4 - (mask & -mask).bit_length() + 1
        engine.set(Reg.R2, 77)
        engine.set(Reg.XPSR, 1 << 24 | 1 << 30)
        body = [[0x3301], [0x3301], [0x3301], [0x3301]][:length]  # adds r3, #1
        body[place] = UDIV
        any_timing.load(0xBF00 | mask, *(half for halves in body for half in halves), HANG)
        assert any_timing.engine.run(engine.cycle + 50) == DIVISION
        assert engine.get(Reg.PC) == at.code + 2 + 2 * place
        assert (engine.get(Reg.R2), engine.get(Reg.R3)) == (77, place)
        assert engine.instructions == 1 + place
        engine.set(Reg.R0, 5)
        engine.set(Reg.R1, 100)
        any_timing.run()
        assert (engine.get(Reg.R2), engine.get(Reg.R3)) == (20, length - 1)

    def test_it_can_be_switched_on_and_off_for_code_that_has_run(self, machine, at):
        machine.load(*UDIV, HANG)
        for wanted in (False, True, False, True):
            machine.engine.set_traps(division=wanted, unaligned=False)
            machine.engine.set(Reg.PC, at.code)
            assert (machine.run() == DIVISION) == wanted

    @pytest.mark.parametrize("divide", [SDIV, UDIV], ids=["sdiv", "udiv"])
    def test_by_zero_in_ram(self, any_timing, at, divide):
        engine, ram = any_timing.engine, at.ram + 0x200
        engine.set(Reg.R2, 77)
        any_timing.load(NOP, NOP, *divide, HANG, at=ram)
        assert engine.run(engine.cycle + 50) == DIVISION
        assert (engine.get(Reg.PC), engine.get(Reg.R2)) == (ram + 4, 77)

    def test_by_zero_in_code_that_the_program_has_just_written(self, trapping, at):
        """In place of an addition that has run: strd r4, r5 over two of them, and again."""
        engine, ram = trapping.engine, at.ram + 0x200
        trapping.load(0xF102, 0x0201, 0xF102, 0x0201, 0x4718, at=ram)  # add.w r2, r2, #1, twice; bx r3
        for register, value in ((Reg.R3, at.code | 1), (Reg.R4, UDIV[0] | UDIV[1] << 16), (Reg.R6, ram)):
            engine.set(register, value)
        engine.set(Reg.R5, engine.get(Reg.R4))
        trapping.load(0xE9C6, 0x4500, 0x1C77, 0x4738)  # strd r4, r5, [r6]; adds r7, r6, #1; bx r7
        engine.set(Reg.PC, ram)
        assert trapping.run() == DIVISION
        assert (engine.get(Reg.PC), engine.get(Reg.R2)) == (ram, 2)

    def test_one_that_is_programmed_later_is_found(self, trapping):
        trapping.load(NOP, NOP, HANG)
        trapping.run()
        trapping.load(*UDIV, HANG)
        assert trapping.run() == DIVISION

    def test_asking_for_it_ends_the_slice(self, machine, at):
        machine.on_access = lambda _kind, _offset: machine.engine.set_traps(division=True, unaligned=False)
        machine.engine.set(Reg.R3, at.registers)
        machine.load(0x601B, *UDIV, HANG)  # str r3, [r3]
        assert machine.run().kind is StopKind.LIMIT
        assert machine.engine.get(Reg.PC) == at.code + 2
        assert machine.run() == DIVISION


class TestUnaligned:
    @pytest.mark.parametrize(
        ("halves", "address"),
        [
            ((0x6801,), 1),  # ldr r1, [r0]
            ((0x6801,), 2),
            ((0x8801,), 3),  # ldrh
            ((0x6001,), 2),  # str
            ((0x8001,), 1),  # strh
            ((0xE9D0, 0x2300), 2),  # ldrd r2, r3, [r0]
            ((0xC00C,), 1),  # stmia r0!, {r2, r3}
        ],
    )
    def test_is_a_fault_of_the_instruction(self, any_timing, at, halves, address):
        engine = any_timing.engine
        engine.set(Reg.R0, at.ram + address)
        any_timing.load(NOP, *halves, NOP, HANG)
        cycle = engine.cycle
        assert any_timing.engine.run(cycle + 50) == Stop(
            StopKind.FAULT, fault=FaultKind.UNALIGNED, address=at.ram + address
        )
        assert engine.get(Reg.PC) == at.code + 2
        assert engine.instructions == 1
        assert engine.cycle == cycle + 1

    @pytest.mark.parametrize("load", [0x6801, 0x8801, 0x7801])  # ldr, ldrh, ldrb
    def test_aligned_is_none(self, trapping, at, load):
        trapping.engine.set(Reg.R0, at.ram + {0x6801: 4, 0x8801: 2, 0x7801: 1}[load])
        trapping.load(load, HANG)
        assert trapping.run().kind is StopKind.LIMIT

    def test_where_nothing_is_it_is_still_unaligned(self, trapping):
        trapping.engine.set(Reg.R0, 0x6000_0001)
        trapping.load(NOP, 0x6801, HANG)
        assert trapping.run().fault is FaultKind.UNALIGNED
        assert trapping.engine.instructions == 1

    def test_not_any_more(self, trapping, at):
        trapping.engine.set(Reg.R0, at.ram + 1)
        trapping.load(0x6801, HANG)
        trapping.run()
        trapping.engine.set_traps(division=True, unaligned=False)
        assert trapping.run().kind is StopKind.LIMIT


# From R0, which stands at an odd word of RAM; what is loaded or stored is R2 to R5, S4 to S7 or D2 to D3.
WORDS = {
    "ldm": (0xC83C,),
    "ldm.w": (0xE890, 0x003C),
    "ldm.w-back": (0xE8B0, 0x003C),
    "ldmdb": (0xE930, 0x003C),
    "stm": (0xC03C,),
    "stm.w": (0xE880, 0x003C),
    "stmdb": (0xE920, 0x003C),
    "ldrd": (0xE9D0, 0x2300),
    "ldrd-before": (0xE9F0, 0x2302),
    "ldrd-after": (0xE8F0, 0x2302),
    "strd": (0xE9C0, 0x2300),
    "strd-before": (0xE9E0, 0x2302),
    "strd-after": (0xE8E0, 0x2302),
    "ldrex": (0xE850, 0x2F00),
    "strex": (0xE840, 0x2300),
}
FLOATS = {
    "vldr": (0xED90, 0x2A00),
    "vldr-double": (0xED90, 0x2B00),
    "vstr": (0xED80, 0x2A00),
    "vstr-double": (0xED80, 0x2B00),
    "vldm": (0xEC90, 0x2A04),
    "vldm-back": (0xECB0, 0x2B04),
    "vldmdb": (0xED30, 0x2A04),
    "vstm": (0xEC80, 0x2A04),
    "vstm-back": (0xECA0, 0x2B04),
    "vstmdb": (0xED20, 0x2B04),
}
HALVES = {"ldrexh": (0xE8D0, 0x2F5F), "strexh": (0xE8C0, 0x2F53)}
DOWN = {"ldmdb": 16, "stmdb": 16, "vldmdb": 16, "vstmdb": 16}
BEFORE = {"ldrd-before": 8, "strd-before": 8}


class TestAlwaysUnaligned:
    """Whatever CCR.UNALIGN_TRP says (DDI0403 section A3.2.1); PUSH and POP never are, for SP has no low bits."""

    @pytest.fixture(params=[False, True], ids=["no-trap", "trap"])
    def m7(self, request, make):
        machine = make("flat", kind=CORTEX_M7)
        machine.ram[:] = bytes(n & 0xFF for n in range(len(machine.ram)))
        machine.engine.set_traps(division=False, unaligned=request.param)
        machine.engine.set_floats([n << 24 for n in range(32)] + [0])
        for register in range(1, 6):
            machine.engine.set(Reg(register), 0x1111_1111 * register)
        return machine

    def faults(self, machine, name, halves, base):
        engine, address = machine.engine, base - DOWN.get(name, 0) + BEFORE.get(name, 0)
        engine.set(Reg.R0, base)
        machine.load(*halves, HANG)
        engine.set(Reg.CONTROL, 4)
        before = engine.fingerprint(), bytes(machine.ram), engine.instructions, engine.cycle
        stop = machine.run()
        assert stop == Stop(StopKind.FAULT, fault=FaultKind.UNALIGNED, address=address), (name, hex(base))
        assert (engine.fingerprint(), bytes(machine.ram), engine.instructions, engine.cycle) == before, (
            name,
            hex(base),
        )

    def test_words(self, m7, at):
        for name, halves in (WORDS | FLOATS).items():
            for place in (at.ram + 0x200, at.flash + 0x200, at.registers + 0x40, 0x6000_0000, at.ram + len(m7.ram) - 4):
                for odd in (1, 2, 3):
                    self.faults(m7, name, halves, place + odd)
        assert m7.log == m7.stores == []

    def test_halves(self, m7, at):
        for name, halves in HALVES.items():
            for place in (at.ram + 0x200, at.registers + 0x40, 0x6000_0000):
                for odd in (1, 3):
                    self.faults(m7, name, halves, place + odd)

    def test_aligned_ones_are_done(self, m7, at):
        for name, halves in (WORDS | FLOATS | HALVES).items():
            m7.engine.set(Reg.R0, at.ram + (0x202 if name in HALVES else 0x204))
            m7.load(*halves, HANG)
            assert m7.run(1).kind is StopKind.LIMIT, name
            assert m7.engine.get(Reg.PC) == at.code + 2 * len(halves), name


class TestUnalignedDone:
    """Single accesses without CCR.UNALIGN_TRP (DDI0403 section A3.2.1)."""

    LOADS = ((0x6801, 4, False), (0x8801, 2, False), (0x5E81, 2, True))  # ldr, ldrh, ldrsh r1, [r0], or [r0, r2]
    STORES = ((0x6001, 4), (0x8001, 2))

    def test_in_memory(self, machine, at):
        machine.ram[:] = bytes(0xF0 - n & 0xFF for n in range(len(machine.ram)))
        machine.flash[0x200:0x210] = machine.ram[0x200:0x210]
        for odd in (1, 2, 3):
            for half, size, signed in self.LOADS:
                for base in (at.ram, at.flash):
                    machine.engine.set(Reg.R0, base + 0x200 + odd)
                    machine.load(half, HANG)
                    assert machine.run(1).kind is StopKind.LIMIT
                    word = int.from_bytes(machine.ram[0x200 + odd : 0x200 + odd + size], "little", signed=signed)
                    assert machine.engine.get(Reg.R1) == word & 0xFFFF_FFFF
            for half, size in self.STORES:
                machine.engine.set(Reg.R0, at.ram + 0x300 + odd)
                machine.engine.set(Reg.R1, 0x1234_5678)
                expected = bytearray(machine.ram)
                expected[0x300 + odd : 0x300 + odd + size] = b"\x78\x56\x34\x12"[:size]
                machine.load(half, HANG)
                assert machine.run(1).kind is StopKind.LIMIT
                assert machine.ram == expected

    @pytest.mark.parametrize(("half", "kind"), [(0x6801, FaultKind.READ), (0x6001, FaultKind.WRITE)])
    @pytest.mark.parametrize("behind", [1, 2, 3])
    def test_over_the_end_of_ram(self, machine, at, half, kind, behind):
        end = at.ram + len(machine.ram)
        machine.engine.set(Reg.R0, end - 4 + behind)
        machine.engine.set(Reg.R1, 0x1234_5678)
        machine.load(half, HANG)
        assert machine.run(1) == Stop(StopKind.FAULT, fault=kind, address=end)
        assert machine.engine.get(Reg.R1) == 0x1234_5678
        assert machine.ram == bytes(len(machine.ram))


class TestHalfWay:
    """A store of several words that fails at one of them leaves memory and its base as they were."""

    @pytest.mark.parametrize("words", [1, 2, 3])
    def test_beyond_the_end_of_ram(self, make, at, words):
        for name, halves in (WORDS | FLOATS | {"push": (0xB43C,), "vpush": (0xED2D, 0x2A04)}).items():
            if not name.startswith(("st", "vst", "push", "vpush")) or name in ("strex", "vstr"):
                continue
            double = name.startswith(("strd", "vstr"))
            if double and words > 1:
                continue
            machine = make("flat", kind=CORTEX_M7)
            engine, end = machine.engine, at.ram + len(machine.ram)
            machine.ram[:] = bytes(n & 0xFF for n in range(len(machine.ram)))
            first = end - 4 * words
            down = 16 if "push" in name else DOWN.get(name, 0)
            register = Reg.SP if "push" in name else Reg.R0
            engine.set(register, first + down - BEFORE.get(name, 0))
            machine.load(*halves, HANG)
            engine.set(Reg.CONTROL, 4)
            before = engine.fingerprint(), bytes(machine.ram)
            assert machine.run() == Stop(StopKind.FAULT, fault=FaultKind.WRITE, address=end), name
            assert (engine.fingerprint(), bytes(machine.ram)) == before, name
