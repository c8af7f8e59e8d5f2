"""Loops that wait for a counter: they do the same, to the cycle, whether they are passed over or executed."""

from __future__ import annotations

import struct
from itertools import pairwise

import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

from targets.boards import built_in_board
from targets.firmware import image_path
from targets.mcu.engine.api import Reg
from targets.mcu.engine.counted import CountedLoops
from targets.mcu.image import Image, Segment
from targets.mcu.machine import Machine
from targets.mcu.symbols import NO_SYMBOLS
from tests.each import each
from tests.share import examples, matrix
from tests.targets.mcu.engine.thumb_code import BASE, BASE_REGISTER, OTHER_REGISTER, stretches

FLASH, CODE = 0x0800_0000, 0x0800_0100
BOARD = built_in_board("bluepill")
DEMCR, DWT_CTRL, CYCCNT = 0xE000_EDFC, 0xE000_1000, 0xE000_1004
SYST_CSR, SYST_RVR, SYST_CVR = 0xE000_E010, 0xE000_E014, 0xE000_E018
APB1ENR, APB2ENR, FLASH_ACR = 0x4002_101C, 0x4002_1018, 0x4002_2000
TIM2, GPIOA = 0x4000_0000, 0x4001_0800
CR1, EGR, CCMR1, CCER, CNT, PSC, ARR, CCR1 = 0x00, 0x14, 0x18, 0x20, 0x24, 0x28, 0x2C, 0x34
HANG = 0xE7FE


def image(code):
    words = [0x2000_1000, CODE | 1, *[CODE | 1] * 13, 0x0800_00F1, *[CODE | 1] * 40]
    count_ticks = (0xF8D6, 0x00C8, 0x3001, 0xF8C6, 0x00C8, 0x4770)  # ldr.w r0, [r6, #200]; adds; str.w; bx lr
    segments = (
        Segment(FLASH, struct.pack(f"<{len(words)}I", *words)),
        Segment(0x0800_00F0, struct.pack("<6H", *count_ticks)),
        Segment(CODE, struct.pack(f"<{len(code)}H", *code)),
    )
    return Image(
        path=image_path("selftest-crc"),
        format="bin",
        digest="0" * 64,
        segments=segments,
        table=FLASH,
        stack_pointer=words[0],
        reset_vector=words[1],
        flash_bytes=0x200,
        ram_bytes=0,
        symbols=NO_SYMBOLS,
        notes=(),
    )


class Rig:
    """A machine at the head of a loop, with its counters set up."""

    def __init__(self, code, *, timing="flat", skip=True, registers=(), setup=()):
        self.machine = machine = Machine(BOARD, image(code), timing=timing, skip_idle=skip)
        machine.run_to(1)
        for address, value in ((APB1ENR, 1), (DEMCR, 1 << 24), (DWT_CTRL, 1), *setup):
            machine.bus.write(address, 4, value)
        machine.engine.set(Reg(BASE_REGISTER), BASE)
        for number, value in registers:
            machine.engine.set(Reg(number), value)
        machine.engine.set(Reg.PC, CODE)

    def state(self):
        engine = self.machine.engine
        return engine.fingerprint(), engine.cycle, engine.instructions, bytes(self.machine.ram), self.machine.now_ns


def compare(code, ends_ns, prepare=lambda _machine: None, **options):
    """Run with and without passing over; return how many turns were passed over."""
    executed, skipped = Rig(code, skip=False, **options), Rig(code, skip=True, **options)
    prepare(executed.machine)
    prepare(skipped.machine)
    passed = 0
    for name in ("pass_known", "pass_new"):
        method = getattr(CountedLoops, name)

        def counted(target, method=method, loops=skipped.machine._idle._counted, **options):
            nonlocal passed
            known = method(loops, target, **options)
            passed += 0 if known is None else known[1]
            return known

        setattr(skipped.machine._idle._counted, name, counted)
    for end_ns in ends_ns:
        executed.machine.run_to(end_ns)
        skipped.machine.run_to(end_ns)
        assert skipped.state() == executed.state()
    return passed


US, MS = 1000, 1_000_000
# nobody watches the PWM at PA0, so IDR must be asked for; PA3 is another input of the port
PWM = (
    *((APB2ENR, 4), (GPIOA, 0x4444_444B), (TIM2 + ARR, 359), (TIM2 + CCR1, 100), (TIM2 + CCMR1, 0x68)),
    *((TIM2 + CCER, 1), (TIM2 + EGR, 1), (TIM2 + CR1, 1)),
)
counters = {
    "cyccnt": (CYCCNT, ()),
    "tim2": (TIM2 + CNT, ((TIM2 + PSC, 7), (TIM2 + EGR, 1), (TIM2 + CR1, 1))),
    "tim2-down": (TIM2 + CNT, ((TIM2 + PSC, 2), (TIM2 + ARR, 9999), (TIM2 + EGR, 1), (TIM2 + CR1, 0x11))),
    "tim2-centre": (TIM2 + CNT, ((TIM2 + ARR, 1500), (TIM2 + EGR, 1), (TIM2 + CR1, 0x21))),
    "systick": (SYST_CVR, ((SYST_RVR, 0xFF_FFFF), (SYST_CVR, 0), (SYST_CSR, 5))),
    "systick-8": (SYST_CVR, ((SYST_RVR, 1999), (SYST_CVR, 0), (SYST_CSR, 1))),
    "pins-with-pwm": (GPIOA + 8, PWM),
    "systick-irq": (SYST_CVR, ((SYST_RVR, 7999), (SYST_CVR, 0), (SYST_CSR, 7))),
}

# What compilers make of `while (counter - start < limit)` and the like; r7 points to the counter, r5 is the limit.
LOOPS = {
    "O2": (0x683C, 0x683B, 0x1B1B, 0x42AB, 0xD3FB, HANG),  # ldr r4, [r7]; ldr r3, [r7]; subs r3, r3, r4; cmp; bcc
    "halfword": (0x883C, 0x883B, 0x1B1B, 0xB29B, 0x42AB, 0xD3FA, HANG),  # ldrh, with uxth r3, r3
    "down": (0x683C, 0x683B, 0x1AE3, 0x42AB, 0xD3FB, HANG),  # start - counter
    "signed": (0x683C, 0x683B, 0x1B1B, 0x42AB, 0xDBFB, HANG),  # blt
    "equal": (0x683B, 0x2B64, 0xD1FC, HANG),  # until the counter is 100
    # start and limit on the stack, as with -O0
    "O0": (0x683C, 0x9401, 0x9502, 0x683A, 0x9B01, 0x1AD2, 0x9B02, 0x429A, 0xD3F9, HANG),
    # elapsed += now - old; old = now, in volatile variables
    "adding": (
        *(0x683C, 0x9401, 0x2100, 0x9102),  # ldr r4, [r7]; str r4, [sp, #4]; movs r1, #0; str r1, [sp, #8]
        *(0x683A, 0x9B01, 0x1AD0, 0x9A01, 0x683A, 0x9201),  # now, old, difference; now; old = now
        *(0x9902, 0x1809, 0x9102, 0x42A9, 0xD3F4, HANG),  # elapsed += difference; cmp elapsed, limit; bcc
    ),
    # a function that reads the counter: bl; subs r0, r0, r4; cmp r0, r5; bcc; hang / push {r3, lr}; ldr r0, [r7]; pop
    "call": (0x683C, 0xF000, 0xF804, 0x1B00, 0x42A8, 0xD3FA, HANG, 0xB508, 0x6838, 0xBD08),
    # the same with a frame pointer, as with -O0: bl; mov r1, r0; bl; subs r0, r0, r1; cmp r0, r5; bcc; hang /
    # push {r7}; add r7, sp, #0; ldr r0, [r4]; mov sp, r7; pop {r7}; bx lr
    "frame": (
        *(0xF000, 0xF807, 0x4601, 0xF000, 0xF804, 0x1A40, 0x42A8, 0xD3FA, HANG),
        *(0xB480, 0xAF00, 0x6820, 0x46BD, 0xBC80, 0x4770),
    ),
    # a count of tries, too: subs r1, #1; beq out; ldr r3, [r7]; subs r3, r3, r4; cmp r3, r5; bcc
    "tries": (0x683C, 0xF240, 0x71D0, 0x3901, 0xD003, 0x683B, 0x1B1B, 0x42AB, 0xD3F9, HANG),
    # milliseconds from memory with a handler that counts, read again until they are the same: as micros() is
    "micros": (0x683C, 0xF8D6, 0x20C8, 0x683B, 0xF8D6, 0x10C8, 0x428A, 0xD1F8, 0x1B1B, 0x42AB, 0xD3F5, HANG),
    # an IT block: the larger of two differences
    "it": (0x683C, 0x683B, 0x1B1B, 0x2B08, 0xBF38, 0x2308, 0x42AB, 0xD3F8, HANG),
}


@pytest.mark.parametrize(("loop", "counter"), matrix(list(LOOPS), list(counters)))
@pytest.mark.parametrize("timing", ["flat", "table"])
def test_a_waiting_loop_is_the_same_passed_over_as_executed(loop, counter, timing):
    address, setup = counters[counter]
    span_ns = MS if timing == "flat" else MS // 8
    ends_ns = [US, 7 * US, 90 * US, span_ns]
    compare(
        LOOPS[loop], ends_ns, timing=timing, registers=((OTHER_REGISTER, address), (4, address), (5, 3000)), setup=setup
    )


@pytest.mark.parametrize(
    ("loop", "timing"),
    matrix(["O2", "halfword", "O0", "adding", "call", "frame", "tries", "micros", "it"], ["flat", "table"]),
)
def test_most_of_a_wait_is_passed_over(loop, timing):
    address, setup = counters["tim2"]
    rig = (OTHER_REGISTER, address), (4, address), (5, 600)
    assert compare(LOOPS[loop], [MS], timing=timing, registers=rig, setup=setup) > 200


@settings(max_examples=examples(60))
@given(
    body=stretches(0, 4),
    condition=st.integers(0, 13),
    compared=st.integers(0, 63),
    registers=st.lists(st.integers(0, 20_000) | st.integers(0, (1 << 32) - 1), min_size=6, max_size=6),
    counter=st.sampled_from(sorted(counters)),
    wait_states=st.integers(0, 2),
    timing=st.sampled_from(["flat", "flat", "table"]),
    cuts=st.lists(st.integers(1, 600 * US), max_size=4),
)
def test_random_loops(body, condition, compared, registers, counter, wait_states, timing, cuts):
    address, setup = counters[counter]
    code = [0x6838, *(half for item in body for halves in item for half in halves), 0x4280 | compared]
    code += [0xD000 | condition << 8 | -(len(code) + 2) & 0xFF, HANG]
    passed = compare(
        code,
        sorted({*cuts, 600 * US}),
        timing=timing,
        registers=((OTHER_REGISTER, address), *enumerate(registers)),
        setup=(*setup, (FLASH_ACR, 0x30 | wait_states)),
    )
    event("passed over" if passed else "executed")


WAITS_FOR_PA3 = {
    "shifted": (0x683B, 0x071B, 0xD5FC, HANG),  # ldr r3, [r7]; lsls r3, r3, #28; bpl
    "masked": (0x683B, 0x422B, 0xD0FC, HANG),  # ldr r3, [r7]; tst r3, r5; beq
    "masked-in-a-copy": (0x683B, 0xEA05, 0x0203, 0x2A00, 0xD0FA, HANG),  # ldr; and.w r2, r5, r3; cmp r2, #0; beq
    "field": (0x8838, 0xF3C0, 0x00C0, 0x2800, 0xD0FA, HANG),  # ldrh r0, [r7]; ubfx r0, r0, #3, #1; cmp r0, #0; beq
    # the port is kept, on the stack and in r4: ldr r3, [r7]; str r3, [sp, #4]; mov r4, r3; ldr r3, [sp, #4]; tst; beq
    "kept": (0x683B, 0x9301, 0x461C, 0x9B01, 0x422B, 0xD0F9, HANG),
}


@each("timing", ["flat", "table"])
@each("loop", WAITS_FOR_PA3)
def test_a_pin_is_waited_for_beside_pwm_that_nobody_watches(loop, timing):
    registers = (OTHER_REGISTER, GPIOA + 8), (5, 8)
    options = {"timing": timing, "registers": registers, "setup": PWM}

    def press(machine):
        machine.at_ns(MS // 2, lambda: machine.chip.pins["PA3"].drive(True))

    assert compare(WAITS_FOR_PA3[loop], [MS // 10, MS // 3, MS], prepare=press, **options) > 200


def test_a_wait_for_a_pin_with_pwm_itself_is_executed():
    # ldr r3, [r7]; lsls r3, r3, #31; bpl
    registers = ((OTHER_REGISTER, GPIOA + 8),)
    assert not compare((0x683B, 0x07DB, 0xD5FC, HANG), [MS // 10], registers=registers, setup=PWM)


def test_what_is_read_once_differently_is_not_passed_over():
    """COUNTFLAG is cleared by its read: the turns after the first read something else."""
    # ldr r0, [r7]; ldr r1, [r4]; lsrs r1, r1, #16; adds r2, r2, r1; cmp r0, r5; bcc
    code = (0x6838, 0x6821, 0x0C09, 0x1852, 0x42A8, 0xD3F9, HANG)
    setup = ((SYST_RVR, 999), (SYST_CVR, 0), (SYST_CSR, 5))
    registers = ((OTHER_REGISTER, CYCCNT), (4, SYST_CSR), (5, 100_000), (2, 0))
    ends = [US * step for step in range(50, 2000, 130)]
    assert compare(code, ends, registers=registers, setup=setup) > 100


def test_code_that_was_programmed_anew_is_not_taken_for_what_it_was():
    address, setup = counters["cyccnt"]
    rig = Rig(LOOPS["O2"], registers=((OTHER_REGISTER, address), (5, 0x7FFF_FFFF)), setup=setup)
    rig.machine.run_to(MS)
    at = CODE - FLASH + 6
    rig.machine.chip.flash.memory[at : at + 2] = struct.pack("<H", 0x2B00)  # cmp r3, #0, and so it ends
    rig.machine.engine.forget(CODE, 16)
    rig.machine.run_to(2 * MS)
    assert rig.machine.engine.get(Reg.PC) == CODE + 10


def test_how_counters_go_on_is_what_they_read():
    for address, setup in counters.values():
        rig = Rig((HANG,), setup=setup)
        for before, after in pairwise(range(10, 700, 53)):
            rig.machine.run_to(before * US)
            count = rig.machine.bus.count(address)
            rig.machine.run_to(after * US)
            if count is not None and rig.machine.cycle < count.until:
                assert count.at(rig.machine.cycle) == rig.machine.bus.read(address, 4)
