"""Images that run random sequences one after the other and leave what became of each in RAM.

A case is a call of `begin`, a record, a body and an end. `begin` fills the block with random words, resets what is
outside of registers, loads all registers and the flags from the record and goes to the body. The end stores all
registers, with the one that the body never writes as its pointer; `finish` puts a checksum of the block behind them.
After the last case the results, and the block as it then is, are written to the console by semihosting. Any exception
ends the image with its return address as the first word of the results.

For a core with floating point an image begins by allowing it; `begin` then loads FPSCR and all floating-point registers
too, and the end of a case stores them.
"""

from __future__ import annotations

import random
import struct
from collections import Counter
from dataclasses import dataclass
from typing import NamedTuple

from tests.targets.mcu.differential.branches import branch_link, branch_wide
from tests.targets.mcu.differential.floats import interesting_float, interesting_status
from tests.targets.mcu.differential.groups import M3, Core, body
from tests.targets.mcu.differential.sequence import BLOCK_SIZE, LR, SP, interesting

FLASH, RAM = 0x0000_0000, 0x2000_0000
BLOCK, PARAMETERS, RESULTS = RAM + 0x400, RAM + 0x800, RAM + 0x1000
STACK_TOP = RAM + 0x400

_BEGIN, _FINISH, _END, _FAULT, _POOL, _CASES = 0x100, 0x180, 0x2C0, 0x380, 0x400, 0x2000
_POOL_SIZE = 0x1000
_FLOATS, _FLOATS_SIZE, _ALLOW, _BEGIN_WITH_FLOATS = 0x1400, 0x800, 0x1C00, 0x1D00
_FLOAT_REGISTERS = 32
_CPACR = 0xE000_ED88
_LITERALS_REACH = 0x1100  # what PC-relative loads can reach behind the last case
_FRAME_WORDS, _RECORD_WORDS = 16, 18
_HEADER_SIZE = 16
_REGISTERS = 15  # that a result holds: R0-R12 but one, LR, flags, SP
RESULT_SIZE = 4 * (_REGISTERS + 1)
_RESULT_SIZE_WITH_FLOATS = RESULT_SIZE + 4 * (_FLOAT_REGISTERS + 1)
BETWEEN_INSTRUCTIONS = 115  # and a few more, from the end of a case to the body of the next
CASES = 200  # in an image; the smallest chip has room for them
_FLASH_SIZE = 0x1_0000
_SYS_OPEN, _SYS_WRITE, _SYS_EXIT = 0x01, 0x05, 0x18
_APPLICATION_EXIT = 0x20026


@dataclass(frozen=True, slots=True)
class Case:
    """One sequence in an image.

    Attributes:
        number: in the series that the seed makes.
        start: address of the call that begins it.
        body: address of the first instruction of the sequence.
        end: address after its last instruction.
        names: of the words of the result.
        halves: the sequence.
        record: flags and registers that it begins with, by name.
        made: how often each atom was used in it.
    """

    number: int
    start: int
    body: int
    end: int
    names: tuple[str, ...]
    halves: tuple[int, ...]
    record: dict[str, int]
    made: Counter[str]


class Image(NamedTuple):
    """What goes into flash at `FLASH`, its cases, and how many bytes it writes: `header`, results, block."""

    data: bytes
    cases: list[Case]
    output_size: int
    result_size: int = RESULT_SIZE

    def result(self, output: bytes, place: int) -> tuple[int, ...]:
        """Return the words of the result of the case at that place among `cases`."""
        return struct.unpack_from(f"<{self.result_size // 4}I", output, _HEADER_SIZE + place * self.result_size)

    def exception(self, output: bytes) -> int:
        """Return the address of the instruction that ended the image by an exception, or 0."""
        return int.from_bytes(output[:4], "little")

    def block(self, output: bytes) -> bytes:
        """Return the block as the last case left it."""
        return output[-BLOCK_SIZE:]


def image_of(seed: int, number: int, core: Core = M3) -> Image:
    """Return the image that has this sequence of the series, but executes it alone; addresses are the same."""
    first = number // CASES * CASES
    whole = make_image(seed, range(first, first + CASES), core)
    place = number - first
    flash, case = bytearray(whole.data), whole.cases[place]
    _put_start(flash, case.start, core)
    if place + 1 < CASES:
        following = whole.cases[place + 1].start
        _put(flash, following, _code(*branch_wide(_END - following)))
    return whole._replace(data=bytes(flash))


def make_image(seed: int, numbers: range, core: Core = M3) -> Image:
    """Return the image with these cases of the series, at most `CASES`."""
    assert len(numbers) <= CASES
    rng = random.Random(f"{seed}: image from {numbers.start}")
    flash = bytearray(rng.randbytes(_CASES))
    cases = []
    result_size = _RESULT_SIZE_WITH_FLOATS if core.floats else RESULT_SIZE
    for place, number in enumerate(numbers):
        case, code = _case(seed, number, len(flash), RESULTS + _HEADER_SIZE + place * result_size, core)
        flash += code
        cases.append(case)
    end = len(flash)
    flash += _code(*branch_wide(_END - end)) + rng.randbytes(_LITERALS_REACH)
    assert len(flash) <= _FLASH_SIZE
    size = _HEADER_SIZE + len(cases) * result_size
    _put(flash, 0, struct.pack("<16I", STACK_TOP, _CASES | 1, *[_FAULT | 1] * 14))
    _put(flash, _BEGIN, _code(*_begin()))
    if core.floats:
        _put(flash, _FLOATS, struct.pack("<512I", *(interesting_float(rng) for _ in range(_FLOATS_SIZE // 4))))
        _put(flash, _BEGIN_WITH_FLOATS, _code(*_begin_with_floats()))
        _put_start(flash, _CASES, core)
    _put(flash, _FINISH, _code(*_finish()))
    _put(flash, _END, _end(size))
    _put(flash, _FAULT, _code(*_fault()))
    return Image(bytes(flash), cases, size + BLOCK_SIZE, result_size)


def _put_start(flash: bytearray, start: int, core: Core) -> None:
    """Let the image begin with the case that starts there."""
    if core.floats:
        code = _code(*_constant(0, 0xF << 20), *_constant(1, _CPACR), 0x6008, 0xF3BF, 0x8F4F, 0xF3BF, 0x8F6F)
        end = _ALLOW + len(code)
        _put(flash, _ALLOW, code + _code(*branch_wide(start - end)))
        start = _ALLOW
    _put(flash, 4, (start | 1).to_bytes(4, "little"))


def _case(seed: int, number: int, start: int, result: int, core: Core) -> tuple[Case, bytes]:
    rng = random.Random(f"{seed}: {number}")
    sequence, pointers, untouched = body(rng, core)
    values = [interesting(rng) for _ in range(15)]
    for register, span in pointers.items():
        values[register] = BLOCK + span.low
    values[untouched] = result
    flags = rng.getrandbits(4) << 28 | (rng.random() < 0.2) << 27
    begin, words = (_BEGIN_WITH_FLOATS, _RECORD_WORDS + 2) if core.floats else (_BEGIN, _RECORD_WORDS)
    at_body = start + 4 + 4 * words
    pool = _POOL + 4 * rng.randrange((_POOL_SIZE - BLOCK_SIZE) // 4)
    stack = values[SP] - 4 * _FRAME_WORDS
    status = []
    if core.floats:
        flags |= rng.getrandbits(4) << 16
        floats = _FLOATS + 4 * rng.randrange(_FLOATS_SIZE // 4 - _FLOAT_REGISTERS)
        status = [floats, interesting_status(rng)]
    record = (flags, *values[:SP], values[LR], at_body | 1, pool, stack, *status)
    code = _code(*branch_link(begin - start)) + struct.pack(f"<{words}I", *record)
    code += _code(*sequence.halves)
    end = start + len(code)
    tail, names = _case_end(untouched, end, floats=core.floats)
    code += _code(*tail)
    halves = tuple(sequence.halves)
    begins = {"apsr": flags, **{f"r{register}": values[register] for register in range(SP)}, "lr": values[LR]}
    begins |= dict(zip(("floats at", "fpscr"), status, strict=False))
    return Case(number, start, at_body, end, names, halves, begins, sequence.made), code


def _case_end(pointer: int, at: int, *, floats: bool) -> tuple[list[int], tuple[str, ...]]:
    """Return the code that stores the registers at `pointer` and calls `finish`, and the names of what it stores."""
    stored = [register for register in (*range(13), LR) if register != pointer]
    flags, stack = stored[0], stored[1]
    halves = [
        *(0xE8A0 | pointer, sum(1 << register for register in stored)),  # stmia.w pointer!, {stored}
        *(0xF3EF, 0x8000 | flags << 8),  # mrs flags, apsr
        0x4668 | (stack >> 3) << 7 | stack & 7,  # mov stack, sp
        *(0xE8A0 | pointer, 1 << flags | 1 << stack),
    ]
    if floats:
        halves += [
            *(0xEEF1, 0x0A10 | flags << 12),  # vmrs flags, fpscr
            *(0xECA0 | pointer, 0x0A00 | _FLOAT_REGISTERS),  # vstmia pointer!, {s0-s31}
            *(0xF840 | pointer, flags << 12 | 0xB04),  # str flags, [pointer], #4
        ]
    halves += [0x4600 | pointer << 3]  # mov r0, pointer
    # The next case begins on a word, so the call must end on one; a NOP of either size sees to it.
    halves += [0xBF00] if (at + 2 * len(halves)) % 4 else [0xF3AF, 0x8000]
    halves += branch_link(_FINISH - at - 2 * len(halves))
    names = [f"r{register}" if register != LR else "lr" for register in stored]
    more = (*(f"s{register}" for register in range(_FLOAT_REGISTERS)), "fpscr") if floats else ()
    return halves, (*names, "apsr", "sp", *more, "memory")


def _begin() -> list[int]:
    """LR: the record, plus 1. The flags and registers go through a frame below the new SP."""
    return [
        *(0xF1AE, 0x0001),  # sub.w r0, lr, #1
        0x6C01,  # ldr r1, [r0, #64]: words for the block
        0x6C42,  # ldr r2, [r0, #68]: the frame
        0x4695,  # mov sp, r2
        *_constant(3, BLOCK),
        *([0xE8B1, 0x0FF0, 0xE8A3, 0x0FF0] * (BLOCK_SIZE // 32)),  # ldmia r1!, {r4-r11}; stmia r3!, {r4-r11}
        *([0xE8B0, 0x0FF0, 0xE8A2, 0x0FF0] * (_FRAME_WORDS // 8)),  # the same from r0 to r2
        0xB663,  # cpsie if
        0x2300,  # movs r3, #0
        *(0xF383, 0x8811),  # msr basepri, r3
        *(0xF383, 0x8809),  # msr psp, r3
        *(0xF3BF, 0x8F2F),  # clrex
        0xBC01,  # pop {r0}
        *(0xF380, 0x8800),  # msr apsr_nzcvq, r0
        *(0xE8BD, 0x5FFF),  # pop.w {r0-r12, lr}
        0xBD00,  # pop {pc}
    ]


def _begin_with_floats() -> list[int]:
    """The same with floating-point registers and all flags; FPSCR last but for the core's own."""
    halves = _begin()
    halves[halves.index(0xF380) + 1] = 0x8C00  # msr apsr_nzcvqg, r0
    return [
        *(0xF1AE, 0x0001),  # sub.w r0, lr, #1
        0x6C83,  # ldr r3, [r0, #72]: where the floating-point registers are
        *(0xEC93, 0x0A00 | _FLOAT_REGISTERS),  # vldmia r3, {s0-s31}
        0x6CC3,  # ldr r3, [r0, #76]: FPSCR
        *(0xEEE1, 0x3A10),  # vmsr fpscr, r3
        *halves,
    ]


def _finish() -> list[int]:
    """R0: where the checksum goes: of every word in turn, plus what there was before, rotated by 27 bits."""
    halves = [*_constant(1, BLOCK), 0x2200]  # movs r2, #0
    for _ in range(BLOCK_SIZE // 32):
        halves += [0xE8B1, 0x0FF0]  # ldmia r1!, {r4-r11}
        for register in range(4, 12):
            halves += [0xEB00 | register, 0x62F2]  # add r2, register, r2, ror #27
    return [*halves, 0x6002, 0x4770]  # str r2, [r0]; bx lr


def _end(size: int) -> bytes:
    """Open the console, write the results and the block, exit; the constants stand behind the code."""
    name = _END + 128
    parameters = name + 4
    code = _code(
        *_constant(0, STACK_TOP),
        0x4685,  # mov sp, r0
        *_constant(1, parameters),
        *(0x2000 | _SYS_OPEN, 0xBEAB),
        *_constant(1, PARAMETERS),
        0x6008,  # str r0, [r1]: the handle
        *_write(RESULTS, size),
        *_write(BLOCK, BLOCK_SIZE),
        *_constant(1, _APPLICATION_EXIT),
        *(0x2000 | _SYS_EXIT, 0xBEAB),
        0xE7FE,
    )
    assert len(code) <= 128
    return code.ljust(128, b"\0") + b":tt\0" + struct.pack("<3I", name, 4, 3)  # mode 4: write


def _write(start: int, size: int) -> list[int]:
    """R1: the parameters, with the handle."""
    return [
        *_constant(2, start),
        0x604A,  # str r2, [r1, #4]
        *_constant(2, size),
        0x608A,  # str r2, [r1, #8]
        *(0x2000 | _SYS_WRITE, 0xBEAB),
    ]


def _fault() -> list[int]:
    return [
        0x9806,  # ldr r0, [sp, #24]: the return address
        *_constant(1, RESULTS),
        0x6008,  # str r0, [r1]
        *branch_wide(_END - (_FAULT + 12)),
    ]


def _constant(register: int, value: int) -> list[int]:
    """MOVW, MOVT."""
    low, high = _split(value & 0xFFFF), _split(value >> 16)
    return [0xF240 | low[0], low[1] | register << 8, 0xF2C0 | high[0], high[1] | register << 8]


def _split(half: int) -> tuple[int, int]:
    return (half >> 11 & 1) << 10 | half >> 12, (half >> 8 & 7) << 12 | half & 0xFF


def _code(*halves: int) -> bytes:
    return struct.pack(f"<{len(halves)}H", *halves)


def _put(flash: bytearray, at: int, data: bytes) -> None:
    flash[at : at + len(data)] = data
