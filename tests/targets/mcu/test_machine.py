"""The machine: how a run begins and ends, what stops it, and that it does not matter how it is cut."""

from __future__ import annotations

import dataclasses
import itertools
import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from targets.boards import Straps, built_in_board
from targets.firmware import image_path
from targets.mcu.cortexm.exceptions import Number
from targets.mcu.engine.api import Reg
from targets.mcu.image import Image, Segment, limits_for, load_image
from targets.mcu.machine import Machine
from targets.mcu.symbols import NO_SYMBOLS
from tests.each import each
from tests.share import examples, matrix

FLASH, RAM, STACK = 0x0800_0000, 0x2000_0000, 0x2000_5000
CODE = FLASH + 0x100
MS = 1_000_000
NOP, HANG, WFI, WFE, SEV = 0xBF00, 0xE7FE, 0xBF30, 0xBF20, 0xBF40

# PC13 as an output, then toggled for ever: written in C, compiled with -Os for ARMv7-M
# RCC->APB2ENR = 1 << 4; GPIOC->CRH = 0x44344444; for (;;) GPIOC->ODR ^= 1 << 13;
TOGGLE = (
    *(0x4B07, 0x2210, 0x619A),  # ldr r3, [pc, #28]; movs r2, #16; str r2, [r3, #24]
    *(0x4B07, 0x4A07, 0x605A),  # ldr r3, [pc, #28]; ldr r2, [pc, #28]; str r2, [r3, #4]
    *(0x68DA, 0xF482, 0x5200),  # ldr r2, [r3, #12]; eor r2, r2, #8192
    *(0x60DA, 0xE7FA, NOP),  # str r2, [r3, #12]; b to the load
    *(NOP, NOP, NOP, NOP),
    *(0x1000, 0x4002, 0x1000, 0x4001, 0x4444, 0x4434),
)


# SysTick every 100 cycles, priority 0x80; for ever: CPSID i, a loop, CPSIE i, BASEPRI = 0x40, a loop, BASEPRI = 0.
MASKING = (
    *(0x4C0B, 0x2063, 0x6060, 0x2007, 0x6020),  # ldr r4, =SYST_CSR; movs r0, #99; str r0, [r4, #4]; movs r0, #7; str
    *(0x4D0A, 0xF04F, 0x4000, 0x6028),  # ldr r5, =SHPR3; mov.w r0, #0x80000000; str r0, [r5]
    *(0xB672, 0x204D, 0x3801, 0xD1FD, 0xB662),  # cpsid i; movs r0, #77; subs r0, #1; bne; cpsie i
    *(0x2040, 0xF380, 0x8811, 0x2021, 0x3801, 0xD1FD),  # movs r0, #0x40; msr basepri, r0; movs r0, #33; subs; bne
    *(0xF380, 0x8811, 0xE7F1, NOP),  # msr basepri, r0; b to the cpsid
    *(0xE010, 0xE000, 0xED20, 0xE000),
)
# Its handler notes where it came in: the low byte of the return address, r0 and SYST_CVR mixed, from RAM + 4 on.
NOTE_ENTRY = (
    *(0xF04F, 0x5100, 0x680A, 0x3204, 0x600A),  # mov.w r1, #RAM; ldr r2, [r1]; adds r2, #4; str r2, [r1]
    *(0x68A3, 0x021B, 0x181B),  # ldr r3, [r4, #8]; lsls r3, r3, #8; adds r3, r3, r0
    *(0x9D06, 0x062D, 0x406B),  # ldr r5, [sp, #24]; lsls r5, r5, #24; eors r3, r5
    *(0xF5B2, 0x6F80, 0xD200, 0x508B, 0x4770),  # cmp.w r2, #1024; bcs to the end; str r3, [r1, r2]; bx lr
)


def program(*halves, vectors=(), table=FLASH, stack=STACK, reset=None, more=()):
    """Return an image of a vector table and code at `CODE`; `vectors` are (number, address)."""
    words = [stack, (CODE if reset is None else reset) | 1, *[CODE + 0x80 | 1] * 57]
    for number, address in vectors:
        words[number] = address
    code = struct.pack(f"<{len(halves)}H", *halves)
    hang = struct.pack("<H", HANG)
    segments = (
        Segment(table, struct.pack(f"<{len(words)}I", *words)),
        Segment(CODE, code),
        Segment(CODE + 0x80, hang),
        *more,
    )
    return Image(
        path=image_path("selftest-crc"),
        format="bin",
        digest="0" * 64,
        segments=segments,
        table=table,
        stack_pointer=stack,
        reset_vector=words[1],
        flash_bytes=0x200,
        ram_bytes=0,
        symbols=NO_SYMBOLS,
        notes=(),
    )


@pytest.fixture(scope="module")
def board():
    return built_in_board("bluepill")


@pytest.fixture
def start(board):
    def starter(*halves, machine=None, **options):
        return Machine(board, program(*halves, **options), **(machine or {}))

    return starter


@pytest.fixture
def run_image(board):
    def runner(name, until_ms, **options):
        machine = Machine(board, load_image(image_path(name), limits_for(board.chip)), **options)
        machine.run_to(until_ms * MS)
        return machine

    return runner


class TestTime:
    def test_a_run_ends_at_its_limit(self, start):
        machine = start(HANG)
        for limit_ns in (1, 999_999, 1_000_000, 123_456_789):
            machine.run_to(limit_ns)
            assert limit_ns <= machine.now_ns < limit_ns + 125

    def test_a_run_that_is_over_already_does_nothing(self, start):
        machine = start(HANG)
        machine.run_to(MS)
        cycle = machine.cycle
        machine.run_to(MS // 2)
        assert machine.cycle == cycle

    def test_an_outside_event_happens_at_the_first_cycle_not_before_it(self, start):
        machine = start(*TOGGLE)
        seen = []
        machine.at_ns(1_000_001, lambda: seen.append(machine.cycle))
        machine.run_to(2 * MS)
        assert seen == [8001]

    def test_an_outside_event_in_the_past_happens_now(self, start):
        machine = start(HANG)
        machine.run_to(MS)
        seen = []
        machine.at_ns(10, lambda: seen.append(machine.now_ns))
        machine.run_to(2 * MS)
        assert seen == [MS]

    def test_an_output_can_end_the_run(self, start):
        machine = start(*TOGGLE)
        machine.chip.pins["PC13"].on_edge(lambda _cycle, ns, _level: machine.horizon(ns))
        machine.run_to(MS)
        first_ns = machine.now_ns
        assert first_ns < 10_000
        machine.run_to(MS)
        assert first_ns < machine.now_ns < 20_000

    @each("halves", [(HANG,), TOGGLE, (WFI, HANG)])
    def test_an_event_can_end_the_run(self, start, halves):
        """The rest of its instant still happens, and nothing of later."""
        machine, happened = start(*halves), []

        def end():
            happened.append("end")
            machine.horizon(machine.now_ns)

        machine.at_ns(500_000, end)
        machine.at_ns(500_000, lambda: happened.append("same instant"))
        machine.at_ns(501_000, lambda: happened.append("later"))
        machine.run_to(MS)
        assert happened == ["end", "same instant"]
        assert 500_000 <= machine.now_ns < 501_000
        machine.run_to(MS)
        assert happened == ["end", "same instant", "later"]

    @each("halves", [(HANG,), (WFI, HANG)])
    def test_what_an_event_raises_comes_out_of_the_run(self, start, halves):
        machine, happened = start(*halves), []

        def fail():
            raise LookupError

        machine.at_ns(500_000, fail)
        machine.at_ns(500_000, lambda: happened.append(machine.now_ns))
        with pytest.raises(LookupError):
            machine.run_to(MS)
        assert happened == []
        machine.run_to(MS)
        assert happened == [500_000]

    @settings(max_examples=examples(20))
    @given(
        cuts=st.lists(st.integers(1, 400_000), max_size=12),
        inputs=st.lists(st.integers(0, 400_000), max_size=4),
        skip=st.booleans(),
        timing=st.sampled_from(["flat", "table"]),
    )
    def test_it_does_not_matter_how_a_run_is_cut(self, board, cuts, inputs, skip, timing):
        def edges(cuts, skip):
            machine = Machine(board, program(*TOGGLE), timing=timing, skip_idle=skip)
            machine.chip.pins["PC13"].record()
            for at_ns in inputs:
                machine.at_ns(at_ns, lambda: machine.chip.pins["PA0"].drive(True))
            for cut_ns in sorted(cuts):
                machine.run_to(cut_ns)
            machine.run_to(400_000)
            return machine.chip.pins["PC13"].edges, machine.engine.instructions, machine.engine.cycle

        assert edges(cuts, skip) == edges([], True)


class TestBoot:
    def test_power_on(self, start):
        causes = []
        machine = start(HANG)
        machine.on_reset = causes.append
        machine.run_to(1000)
        assert causes == ["POR"]

    def test_button(self, start):
        machine = start(HANG)
        machine.run_to(MS)
        causes = []
        machine.on_reset = causes.append
        machine.reset()
        machine.run_to(2 * MS)
        assert causes == ["PIN"]
        assert machine.bus.read(0x4002_1024, 4) >> 24 == 0x0C  # PORRSTF of power-on is kept, PINRSTF

    def test_an_image_behind_a_boot_loader_starts_at_its_own_table(self, run_image):
        machine = run_image("boot-application", 100)
        assert machine.ended is None
        assert machine.chip.pins["PC13"].level is not None

    def test_system_memory_has_no_boot_loader(self, board):
        machine = Machine(board, program(HANG), straps=Straps(boot0=1, boot1=0))
        machine.run_to(MS)
        assert machine.ended.kind == "no-boot"
        assert "system memory" in machine.ended.cause


@each("timing", ["flat", "table"])
def test_an_image_of_the_vendors_library_gets_its_crystal_however_well_it_was_compiled(board, timing):
    """SystemInit waits for HSERDY by 0x500 polls; no compiler makes the loop shorter than this."""
    wait = (
        *(0x4C05, 0xF44F, 0x3080, 0x6020),  # ldr r4, =RCC; mov.w r0, #HSEON; str r0, [r4]
        *(0xF44F, 0x61A0),  # mov.w r1, #0x500
        *(0x6820, 0x0382, 0xD401, 0x3901, 0xD1FA),  # 1: ldr r0, [r4]; lsls r2, r0, #14; bmi 2f; subs r1, #1; bne 1b
        *(HANG, 0x1000, 0x4002),  # 2: b .
    )
    machine = Machine(board, program(*wait), timing=timing)
    machine.run_to(3 * MS)
    assert machine.engine.get(Reg.R1) > 0
    assert machine.bus.read(0x4002_1000, 4) & 1 << 17


@each("startup_us", [40, 3000])
def test_the_crystal_takes_as_long_as_the_board_says(board, startup_us):
    code = (0x4C05, 0xF44F, 0x3080, 0x6020, HANG, *[NOP] * 7, 0x1000, 0x4002)
    machine = Machine(dataclasses.replace(board, hse_startup_us=startup_us), program(*code))
    machine.run_to(startup_us * 1000)
    assert not machine.bus.read(0x4002_1000, 4) & 1 << 17
    machine.run_to(startup_us * 1000 + 10_000)
    assert machine.bus.read(0x4002_1000, 4) & 1 << 17


class TestCore:
    def test_sev_lets_the_next_wfe_through(self, start):
        machine = start(SEV, WFE, 0x2001, WFE, 0x2002, HANG)  # movs r0, #1 and #2
        machine.run_to(MS)
        assert machine.core.sleeping
        assert machine.engine.get(Reg.R0) == 1

    def test_an_exception_forgets_what_ldrex_marked(self, start):
        machine = start(
            *(0x4669, 0x3980),  # mov r1, sp; subs r1, #128
            *(0xE851, 0x0F00),  # ldrex r0, [r1]
            0xDF00,  # svc 0
            *(0xE841, 0x2300),  # strex r3, r2, [r1]
            HANG,
            vectors=[(11, CODE + 0x60 | 1)],
            more=(Segment(CODE + 0x60, b"\x70\x47"),),  # bx lr
        )
        machine.run_to(MS)
        assert machine.engine.get(Reg.R3) == 1

    @each("control", [1, 3])
    def test_unprivileged_code_is_interrupted_and_gone_back_to(self, start, control):
        machine = start(
            *(0x4668, 0x3880),  # mov r0, sp; subs r0, #128
            *(0xF380, 0x8809),  # msr psp, r0
            0x2000 | control,  # movs r0, #control
            *(0xF380, 0x8814),  # msr control, r0
            *(0xF3BF, 0x8F6F),  # isb
            0xDF00,  # svc 0
            *(0x2507, 0x466F, HANG),  # movs r5, #7; mov r7, sp
            vectors=[(11, CODE + 0x60 | 1)],
            more=(
                Segment(CODE + 0x60, struct.pack("<4H", 0x2409, 0x466E, 0x4770, 0)),
            ),  # movs r4, #9; mov r6, sp; bx lr
        )
        machine.run_to(MS)
        engine = machine.engine
        assert (engine.get(Reg.R4), engine.get(Reg.R5)) == (9, 7)
        assert engine.get(Reg.R6) == (STACK if control == 3 else STACK - 32)
        assert engine.get(Reg.R7) == (STACK - 128 if control == 3 else STACK)
        assert engine.get(Reg.CONTROL) == control
        assert not machine.notes.all


class TestEnds:
    @pytest.mark.parametrize(
        "options",
        [
            pytest.param({}, id="skipping"),
            pytest.param(
                {"skip_idle": False}, id="stepping", marks=pytest.mark.exhaustive("stepping ends alike, below")
            ),
        ],
    )
    @pytest.mark.parametrize(
        ("name", "kind", "words"),
        [
            ("bad-hardfault-loop", "fault-loop", ("over and over", "0x60000000", "PRECISERR")),
            ("bad-jump-erased", "fault-loop", ("erased", "0x0800F000", "call_application")),
            ("bad-runaway-nowhere", "fault-loop", ("fetch", "0x30000000")),
            ("bad-runaway-ram", "fault-loop", ("undefined instruction", "call_junk")),
            ("bad-stack-overflow", "fault-loop", ("STKERR",)),
            ("bad-lockup", "lockup", ("lockup", "0x60000004")),
        ],
    )
    def test_a_firmware_that_cannot_go_on(self, run_image, name, kind, words, options):
        machine = run_image(name, 20, **options)
        assert machine.ended.kind == kind
        assert machine.ended.status == 1
        assert machine.ended.ns < 10 * MS
        assert all(word in machine.ended.cause for word in words), machine.ended.cause

    @pytest.mark.parametrize(
        "name",
        [
            "bad-jump-erased",
            "bad-lockup",
            *(
                pytest.param(name, marks=pytest.mark.exhaustive("other ends in four ways; the gate has two"))
                for name in ("bad-hardfault-loop", "bad-stack-overflow")
            ),
        ],
    )
    def test_the_end_is_the_same_however_it_is_run(self, board, name):
        def end(step_ns, skip):
            machine = Machine(board, load_image(image_path(name), limits_for(board.chip)), skip_idle=skip)
            limit_ns = 0
            while machine.ended is None and limit_ns < 20 * MS:
                limit_ns += step_ns
                machine.run_to(limit_ns)
            return machine.ended

        assert end(20 * MS, True) == end(20 * MS, False) == end(77_777, True) == end(1_000_000, False)

    def test_watchdog_over_and_over(self, run_image):
        machine = run_image("bad-iwdg-loop", 20_000)
        assert machine.ended.kind == "reset-loop"
        assert "watchdog" in machine.ended.cause
        assert "forget_to_feed" in machine.ended.place

    def test_a_wait_for_what_never_comes_is_told_but_no_end(self, run_image):
        machine = run_image("bad-stuck", 1000)
        assert machine.ended is None
        assert machine.waits_in.polled

    def test_semihosting_ends_with_a_status(self, run_image):
        machine = run_image("selftest-crc", 1000)
        assert (machine.ended.kind, machine.ended.status) == ("exit", 0)


class TestMasks:
    """An exception is taken at the first instruction boundary where no mask holds it back, however one gets there."""

    HANDLER = FLASH + 0x200
    STEPS_NS = (125, 1000, 375, 2125, 250)
    # cpsid i; ldr r1, =RAM + 0x800 | 1; blx r1; b to the cpsid. There: cpsie i, with a nop on either side, and back.
    UNMASKED_IN_RAM = (*MASKING[:9], 0xB672, 0x4908, 0x4788, 0xE7FB, *[NOP] * 11, *MASKING[-4:], 0x0801, 0x2000)
    IN_RAM = Segment(RAM + 0x800, struct.pack("<4H", NOP, 0xB662, NOP, 0x4770))

    @pytest.fixture
    def noted(self, board):
        """What the handler notes within 2 ms, the cycle, and how many instructions; executed whole, or in steps."""
        handler = Segment(self.HANDLER, struct.pack(f"<{len(NOTE_ENTRY)}H", *NOTE_ENTRY))

        def note(code, *more, cut=False, **options):
            image = program(*code, vectors=[(15, self.HANDLER | 1)], more=(handler, *more))
            machine = Machine(board, image, **options)
            ends = itertools.accumulate(itertools.cycle(self.STEPS_NS))
            for end_ns in itertools.takewhile(lambda end_ns: cut and end_ns < 2 * MS, ends):
                machine.run_to(end_ns)
            machine.run_to(2 * MS)
            return bytes(machine.ram[:1024]), machine.cycle, machine.engine.instructions

        return note

    @pytest.mark.parametrize(("timing", "skip"), matrix(["flat", "table"], [True, False]))
    def test_it_is_the_same_boundary_whole_or_in_steps(self, noted, timing, skip):
        expected = noted(MASKING, timing=timing, skip_idle=False)
        assert len(set(struct.unpack("<255I", expected[0][4:]))) > 2
        assert noted(MASKING, timing=timing, skip_idle=skip) == expected
        assert noted(MASKING, timing=timing, skip_idle=skip, cut=True) == expected

    def test_a_loop_under_a_mask_that_changes_nothing_is_passed_over(self, start):
        # as above with SysTick every 28672 cycles (lsls r0, r0, #12 after movs r0, #7); then cpsid i and b .
        code = (0x4C0B, 0x2007, 0x0300, *MASKING[2:5], 0x4D09, *MASKING[6:9], 0xB672, HANG)
        machine = start(*code, *[NOP] * 12, *MASKING[-4:])
        machine.run_to(20 * MS)
        assert machine.core.exceptions.is_pending(Number.SYSTICK)
        assert machine.waits_in is not None

    def test_code_in_ram_ends_masks_too(self, noted):
        expected = noted(self.UNMASKED_IN_RAM, self.IN_RAM)
        assert any(expected[0][4:])
        assert noted(self.UNMASKED_IN_RAM, self.IN_RAM, skip_idle=False) == expected
        assert noted(self.UNMASKED_IN_RAM, self.IN_RAM, cut=True) == expected


def test_a_jump_to_the_boot_loader_of_the_vendor_is_called_that(start):
    machine = start(0x4800, 0x4700, 0xF021, 0x1FFF)  # ldr r0, =0x1FFFF021; bx r0
    machine.run_to(10 * MS)
    assert machine.ended.kind == "fault-loop"
    assert "boot loader in system memory, which is not modelled" in machine.ended.cause
    assert [note.where for note in machine.notes.all] == ["system memory"]


def test_where_a_program_is_that_is_about_to_return_from_an_exception(start):
    """A task that yields for ever: PC is an EXC_RETURN value at many a look."""
    machine = start(0xDF00, 0xE7FD, 0x4770, vectors=[(11, CODE + 4 | 1)])  # svc 0; b to it; bx lr
    seen, returning = set(), 0
    for step in range(1, 60):
        machine.run_to(step * 1000)
        seen.add(machine.pc)
        returning += machine.engine.get(Reg.PC) >= 0xFFFF_FFE0
    assert returning > 10
    assert seen <= {CODE, CODE + 2, CODE + 4}


@each("stack", [0x1000_0000, 0x4001_3800])  # nothing; USART1
def test_a_return_from_an_exception_with_a_stack_that_is_none_changes_nothing(start, stack):
    machine = start(HANG)
    machine.engine.set(Reg.MSP, stack)
    machine.engine.set(Reg.PC, 0xFFFF_FFF9)
    assert machine.pc >= 0xFFFF_FFE0
    assert machine.notes.all == []


@each(
    ("set_up", "mode"),
    [
        ((), "Sleep"),
        # the clock of PWR; PDDS or not; SLEEPDEEP
        ((0x4A05, 0x4906, 0x61D1, 0x4A06, 0x2100, 0x6011, 0x4A05, 0x2104, 0x6111), "Stop"),
        ((0x4A05, 0x4906, 0x61D1, 0x4A06, 0x2102, 0x6011, 0x4A05, 0x2104, 0x6111), "Standby"),
    ],
)
def test_where_the_cpu_sleeps(start, set_up, mode):
    """Loads of 0x40021000, 1 << 28, 0x40007000 and 0xE000ED00, which stand 24 bytes after the start."""
    code = (*set_up, WFI, HANG, *[NOP] * (10 - len(set_up)))
    machine = start(*code, 0x1000, 0x4002, 0x0000, 0x1000, 0x7000, 0x4000, 0xED00, 0xE000)
    machine.run_to(MS)
    assert machine.asleep == (mode, CODE + 2 * len(set_up))


class TestFaultHandlers:
    """A fault handler that waits for something is not one that waits for ever."""

    HANDLER = FLASH + 0x200
    # USART1 on, at 9600 baud from 8 MHz; then a load from 0x30000000
    CRASH = (
        *(0x4806, 0xF244, 0x0104, 0x6181),  # ldr r0, =RCC; movw r1, #0x4004; str r1, [r0, #0x18]
        *(0x4C05, 0xF240, 0x3141, 0x60A1, 0xF242, 0x010C, 0x60E1),  # ldr r4, =USART1; BRR = 833; CR1 = 0x200C
        *(0xF04F, 0x5040, 0x6800),  # mov.w r0, #0x30000000; ldr r0, [r0]
        *(0x1000, 0x4002, 0x3800, 0x4001),
    )
    # Five words, each when TXE is there: movs r5, #5; 1: ldr r0, [r4]; lsls r0, #24; bpl 1b; str r5, [r4, #4]; ...
    PRINT = (0x2505, 0x6820, 0x0600, 0xD5FC, 0x6065, 0x3D01, 0xD1F9)
    POLL_FOR_EVER = (0x6820, 0x07C0, 0xD5FC)  # 2: ldr r0, [r4]; lsls r0, r0, #31; bpl 2b

    @pytest.fixture
    def crash(self, board):
        def crashed(*handler):
            more = (Segment(self.HANDLER, struct.pack(f"<{len(handler)}H", *handler)),)
            return Machine(board, program(*self.CRASH, vectors=[(3, self.HANDLER | 1)], more=more))

        return crashed

    def test_a_kernel_that_is_entered_by_an_escalated_call_is_no_fault_over_and_over(self, start):
        code = (0xB672, 0x2000, 0xDF00, 0x3001, 0xE7FC)  # cpsid i; movs r0, #0; svc #0; adds r0, #1; b to the svc
        handler = Segment(self.HANDLER, struct.pack("<H", 0x4770))
        machine = start(*code, vectors=[(3, self.HANDLER | 1)], more=(handler,))
        machine.run_to(8 * MS)
        assert machine.ended is None
        assert machine.engine.get(Reg.R0) > 2000

    def test_it_may_print_before_it_hangs(self, crash):
        machine = crash(*self.PRINT, HANG)
        machine.run_to(MS * 3 // 2)
        assert machine.ended is None
        told = {note.where: note.text for note in machine.notes.all}
        assert told[machine.place(CODE + 26)].endswith("; the handler has not returned")
        machine.run_to(100 * MS)
        assert machine.engine.get(Reg.R5) == 0
        assert machine.ended.kind == "fault-loop"
        assert 3 * MS < machine.ended.ns < 10 * MS

    def test_it_waits_for_ever_when_nothing_was_written_for_a_second(self, crash):
        machine = crash(*self.PRINT, *self.POLL_FOR_EVER)
        machine.run_to(1000 * MS)
        assert machine.ended is None
        machine.run_to(5000 * MS)
        assert machine.engine.get(Reg.R5) == 0
        assert machine.ended.kind == "fault-loop"


class TestSleepInFaultHandlers:
    """A fault handler that sleeps is lost, unless something may still come that interrupts or resets it."""

    HANDLER = FLASH + 0x200
    CRASH = (HANG, 0xF04F, 0x5040, 0x6800)  # b . until the test has set things up; ldr r0, [#0x30000000]
    SHCSR, SHPR1, SHPR3, SCR, ISER = 0xE000_ED24, 0xE000_ED18, 0xE000_ED20, 0xE000_ED10, 0xE000_E100
    SYST_CSR, SYST_RVR = 0xE000_E010, 0xE000_E014
    BUS_FAULT_AT_0X80 = ((SHCSR, 1 << 17), (SHPR1, 0x80 << 8))
    TICKING = ((SYST_RVR, 7999), (SYST_CSR, 7))
    APB2ENR, EXTI_EMR, EXTI_RTSR = 0x4002_1018, 0x4001_0404, 0x4001_0408
    PWR_CLOCK, STANDBY, WAKE_UP_PIN = ((0x4002_101C, 1 << 28),), ((0x4000_7000, 2), (SCR, 4)), ((0x4000_7004, 1 << 8),)

    @pytest.fixture
    def crash(self, board):
        def crashed(*set_up, sleep=WFI, number=3, steps_ns=20 * MS, masks=(), **options):
            more = (
                Segment(self.HANDLER, struct.pack("<3H", sleep, 0xE7FD, 0x4770)),  # sleep; b back; SysTick: bx lr
            )
            vectors = [(number, self.HANDLER | 1), (15, self.HANDLER + 4 | 1)]
            machine = Machine(board, program(*self.CRASH, vectors=vectors, more=more), **options)
            machine.run_to(10_000)
            for address, value in set_up:
                machine.bus.write(address, 4, value)
            machine.engine.set(Reg.PC, CODE + 2)
            machine.run_to(50_000)
            for register, value in masks:  # with them set before, a BusFault would have become a HardFault
                machine.engine.set(register, value)
            while machine.ended is None and machine.now_ns < 20 * MS:
                machine.run_to(machine.now_ns + steps_ns)
            return machine

        return crashed

    @each("sleep", [WFI, WFE])
    @each("set_up", [(), TICKING, ((SCR, 4),), (*PWR_CLOCK, *STANDBY)])
    def test_nothing_wakes_a_hard_fault(self, crash, sleep, set_up):
        machine = crash(*set_up, sleep=sleep)
        assert machine.ended.kind == "fault-loop"
        assert machine.ended.status == 1
        assert "a fault handler sleeps for ever: BusFault, escalated to HardFault" in machine.ended.cause
        assert machine.ended.ns < 2 * MS
        assert machine.ended.pc == CODE + 6

    @each("options", [{"skip_idle": False}, {"steps_ns": 77_777}, {"steps_ns": 1_000}])
    def test_the_end_is_the_same_however_it_is_run(self, crash, options):
        assert crash(*self.TICKING, **options).ended == crash(*self.TICKING).ended

    @each(
        ("set_up", "masks", "ends"),
        [
            (TICKING, (), False),
            (((SYST_RVR, 7999), (SYST_CSR, 5)), (), True),  # no TICKINT
            ((*TICKING, (SHPR3, 0x80 << 24)), (), True),  # no more urgent than the handler
            (TICKING, ((Reg.PRIMASK, 1),), False),  # which WFI passes by
            (TICKING, ((Reg.BASEPRI, 0x40),), False),
            ((*TICKING, (SHPR3, 0x40 << 24)), ((Reg.BASEPRI, 0x40),), True),
            ((), (), True),
            (((ISER, 1 << 6),), (), False),  # an interrupt of a pin may come
            (((ISER, 1 << 6), (0xE000_E404, 0x80 << 16)), (), True),
        ],
    )
    def test_a_bus_fault_is_woken_by_what_is_more_urgent(self, crash, set_up, masks, ends):
        machine = crash(*self.BUS_FAULT_AT_0X80, *set_up, masks=masks, number=5)
        assert (machine.ended is not None) is ends

    def test_that_it_has_not_returned_is_noted(self, crash):
        machine = crash(*self.BUS_FAULT_AT_0X80, *self.TICKING, number=5)
        (note,) = (note for note in machine.notes.all if note.kind == "misuse")
        assert note.text.endswith("; the handler has not returned")

    @each(
        ("set_up", "ends"),
        [
            (((SCR, 1 << 4),), False),  # SEVONPEND
            (((APB2ENR, 1), (EXTI_EMR, 1), (EXTI_RTSR, 1)), False),
            (((APB2ENR, 1), (EXTI_EMR, 1)), True),  # no edge is chosen
        ],
    )
    def test_an_event_ends_wfe(self, crash, set_up, ends):
        assert (crash(*set_up, sleep=WFE).ended is not None) is ends
        assert crash(*set_up, sleep=WFI).ended is not None

    def test_the_wake_up_pin_ends_standby(self, crash):
        assert crash(*self.PWR_CLOCK, *self.STANDBY, *self.WAKE_UP_PIN).ended is None

    def test_a_watchdog_resets_it(self, crash):
        machine = crash((0x4000_3000, 0x5555), (0x4000_3008, 1), (0x4000_3000, 0xAAAA), (0x4000_3000, 0xCCCC))
        assert machine.ended is None
        assert machine.bus.read(0x4002_1024, 4) & 1 << 29  # IWDGRSTF

    @each("watchdog", [True, False])
    def test_a_program_that_hangs_is_set_going_by_a_reset_alone(self, board, watchdog):
        """It counts in r2; the watchdog, fed never, would reset it after some 0.5 s."""
        machine = Machine(board, program(0x3201, 0xE7FD))  # adds r2, #1; b .-2
        machine.run_to(1 * MS)
        if watchdog:
            for address, value in ((0x4000_3000, 0x5555), (0x4000_3000, 0xCCCC)):
                machine.bus.write(address, 4, value)
        before = machine.engine.get(Reg.R2)
        causes = []
        machine.on_reset = causes.append
        machine.hang()
        machine.run_to(300 * MS)
        assert (machine.now_ns, machine.engine.get(Reg.R2), causes) == (300 * MS, before, [])
        machine.run_to(700 * MS)
        assert causes == (["IWDG"] if watchdog else [])
        machine.reset()
        machine.run_to(710 * MS)
        assert causes[-1] == "PIN"
        assert machine.engine.get(Reg.R2) != before
        assert machine.ended is None

    def test_sleep_after_a_fault_is_no_end(self, board):
        handler = (0x9806, 0x3002, 0x9006, 0x4770)  # ldr r0, [sp, #24]; adds r0, #2; str r0, [sp, #24]; bx lr
        more = (Segment(self.HANDLER, struct.pack("<4H", *handler)),)
        machine = Machine(board, program(*self.CRASH[1:], WFI, HANG, vectors=[(3, self.HANDLER | 1)], more=more))
        machine.run_to(20 * MS)
        assert machine.ended is None
        assert machine.asleep is not None


class TestConditions:
    """What is gone over in the middle of an IT block leaves the conditions of the rest as they are."""

    # itet eq with what is in its middle; adds r2, #1; adds r3, #1; b .  r2 is for NE
    REST = (0x3201, 0x3301, HANG)

    @each(("compare", "sums"), [(0x4280, (0, 1)), (0x2800, (1, 0))])  # cmp r0, r0; cmp r0, #0
    def test_semihosting(self, start, compare, sums):
        machine = start(0x2013, compare, 0xBF0A, 0xBEAB, *self.REST)  # BKPT, whatever the condition: SYS_ERRNO
        machine.run_to(MS)
        assert (machine.engine.get(Reg.R2), machine.engine.get(Reg.R3)) == sums
        assert machine.engine.get(Reg.R0) == 0

    @each("fault", [(0x6801,), (0x6001,), (0xF8D0, 0x1000), (0xF8C0, 0x1000)])
    def test_a_bus_error_that_is_ignored(self, start, fault):
        set_up = (
            *(0xF04F, 0x20E0, 0xF44F, 0x7180, 0xF8C0, 0x1D14),  # mov.w r0, #SCS; mov.w r1, #BFHFNMIGN; str CCR
            *(0xB671, 0xF04F, 0x5040),  # cpsid f; mov.w r0, #0x30000000
            *(0x4280, 0xBF0A),  # cmp r0, r0; itet eq
        )
        machine = start(*set_up, *fault, *self.REST)
        machine.run_to(MS)
        assert machine.ended is None
        assert (machine.engine.get(Reg.R2), machine.engine.get(Reg.R3)) == (0, 1)
        assert machine.engine.get(Reg.R1) == 0x100  # a load that fails leaves its register

    def test_a_fault_may_be_returned_to(self, start):
        """The handler makes the address good, and the block goes on with the load."""
        handler = FLASH + 0x200
        more = (Segment(handler, struct.pack("<4H", 0xA800, 0xF8CD, 0xD000, 0x4770)),)  # str.w sp, [sp]: r0 = sp
        code = (0xF04F, 0x5040, 0x4280, 0xBF0A, 0x6801, *self.REST)  # mov.w r0, #0x30000000; cmp r0, r0; itet; ldr
        machine = start(*code, vectors=[(3, handler | 1)], more=more)
        machine.run_to(MS)
        assert machine.ended is None
        assert machine.engine.get(Reg.R1) == STACK - 32
        assert (machine.engine.get(Reg.R2), machine.engine.get(Reg.R3)) == (0, 1)


class TestRefusals:
    """A bus error of a peripheral that is there is not told as an address where nothing is."""

    # ldr r0, =address; ldr r1, =value; the store
    @each(
        ("address", "value", "store", "said"),
        [
            (0x4002_2004, 0xBAD, 0x6001, "FLASH_KEYR got a wrong key, and takes none until the next reset"),
            (0x0800_0400, 1, 0x8001, "the flash takes stores only with PG of FLASH_CR set (0x08000400)"),
            (0x1FFF_F800, 1, 0x8001, "option bytes take stores only with OPTPG and OPTWRE of FLASH_CR set"),
            (0x3000_0000, 1, 0x6001, "an access to an address where nothing answers (0x30000000)"),
        ],
    )
    def test_a_store(self, start, address, value, store, said):
        literals = (address & 0xFFFF, address >> 16, value, 0)
        machine = start(0x4801, 0x4902, store, HANG, *literals)
        machine.run_to(10 * MS)
        assert machine.ended.kind == "fault-loop"
        assert said in machine.ended.cause
        assert ("refused" in machine.ended.cause) is ("nothing" not in said)

    def test_a_word_into_flash(self, start):
        machine = start(HANG, 0x4801, 0x4902, 0x6001, 0x0400, 0x0800)  # ldr r0, =0x08000400; str r1, [r0]
        machine.run_to(10_000)
        for key in (0x4567_0123, 0xCDEF_89AB):
            machine.bus.write(0x4002_2004, 4, key)
        machine.bus.write(0x4002_2010, 4, 1)
        machine.engine.set(Reg.PC, CODE + 2)
        machine.run_to(10 * MS)
        assert "refused: the flash takes half-words only (0x08000400)" in machine.ended.cause

    def test_unprivileged_software(self, start):
        # movs r0, #1; msr control, r0; isb; ldr r0, =SHCSR; ldr r1, [r0]
        machine = start(0x2001, 0xF380, 0x8814, 0xF3BF, 0x8F6F, 0x4801, 0x6801, HANG, 0xED24, 0xE000)
        machine.run_to(10 * MS)
        assert "refused: SCS is for privileged software only (0xE000ED24)" in machine.ended.cause


@each(
    ("address", "instruction", "said"),
    [
        (0x2000_5000, 0x6801, "RAM of the STM32F103C8, 20 KB from 0x20000000 on; the STM32F103RC has 48 KB"),
        (0x2000_5000, 0x6001, "RAM of the STM32F103C8, 20 KB from 0x20000000 on; the STM32F103RC has 48 KB"),
        (0x0801_0000, 0x6801, "flash of the STM32F103C8, 64 KB from 0x08000000 on; the STM32F103CB has 128 KB"),
        (0x0801_0001, 0x4700, "flash of the STM32F103C8, 64 KB from 0x08000000 on; the STM32F103CB has 128 KB"),
    ],
)
def test_a_fault_just_past_the_end_of_a_memory_says_which_chip_has_more(start, address, instruction, said):
    """Read by ldr r1, [r0]; written by str r1, [r0]; jumped to by bx r0."""
    machine = start(0x4800, instruction, address & 0xFFFF, address >> 16)
    machine.run_to(10 * MS)
    assert f"; past the end of the {said}" in machine.ended.cause


def test_a_lockup_tells_each_fault_once(start):
    machine = start(0xB671, 0xDF00)  # cpsid f; svc 0
    machine.run_to(MS)
    assert machine.ended.kind == "lockup"
    assert machine.ended.cause.count("SVCall") == 1
