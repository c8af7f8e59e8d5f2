"""Images that run random sequences one after the other and leave what became of each in RAM.

A case is a call of `begin`, a record, a body and an end. `begin` fills the block with random words, resets what is
outside of registers, loads all registers and the flags from the record and goes to the body. The end stores all
registers, with the one that the body never writes as its pointer; `finish` puts a checksum of the block behind them.
After the last case the results, and the block as it then is, are written to the console by semihosting. Any exception
ends the image with its return address as the first word of the results.
"""

from __future__ import annotations

import random
import struct
from collections import Counter
from dataclasses import dataclass
from typing import NamedTuple

from tests.targets.mcu.differential.branches import branch_link, branch_wide
from tests.targets.mcu.differential.groups import body
from tests.targets.mcu.differential.sequence import BLOCK_SIZE, LR, SP, interesting

FLASH, RAM = 0x0000_0000, 0x2000_0000
BLOCK, PARAMETERS, RESULTS = RAM + 0x400, RAM + 0x800, RAM + 0x1000
STACK_TOP = RAM + 0x400

_BEGIN, _FINISH, _END, _FAULT, _POOL, _CASES = 0x100, 0x180, 0x2C0, 0x380, 0x400, 0x2000
_POOL_SIZE = 0x1000
_LITERALS_REACH = 0x1100  # what PC-relative loads can reach behind the last case
_FRAME_WORDS, _RECORD_WORDS = 16, 18
_HEADER_SIZE = 16
_REGISTERS = 15  # that a result holds: R0-R12 but one, LR, flags, SP
RESULT_SIZE = 4 * (_REGISTERS + 1)
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

    def result(self, output: bytes, place: int) -> tuple[int, ...]:
        """Return the words of the result of the case at that place among `cases`."""
        return struct.unpack_from(f"<{_REGISTERS + 1}I", output, _HEADER_SIZE + place * RESULT_SIZE)

    def exception(self, output: bytes) -> int:
        """Return the address of the instruction that ended the image by an exception, or 0."""
        return int.from_bytes(output[:4], "little")

    def block(self, output: bytes) -> bytes:
        """Return the block as the last case left it."""
        return output[-BLOCK_SIZE:]


def image_of(seed: int, number: int) -> Image:
    """Return the image that has this sequence of the series, but executes it alone; addresses are the same."""
    first = number // CASES * CASES
    whole = make_image(seed, range(first, first + CASES))
    place = number - first
    flash, case = bytearray(whole.data), whole.cases[place]
    _put(flash, 4, (case.start | 1).to_bytes(4, "little"))
    if place + 1 < CASES:
        following = whole.cases[place + 1].start
        _put(flash, following, _code(*branch_wide(_END - following)))
    return whole._replace(data=bytes(flash))


def make_image(seed: int, numbers: range) -> Image:
    """Return the image with these cases of the series, at most `CASES`."""
    assert len(numbers) <= CASES
    rng = random.Random(f"{seed}: image from {numbers.start}")
    flash = bytearray(rng.randbytes(_CASES))
    cases = []
    for place, number in enumerate(numbers):
        case, code = _case(seed, number, len(flash), RESULTS + _HEADER_SIZE + place * RESULT_SIZE)
        flash += code
        cases.append(case)
    end = len(flash)
    flash += _code(*branch_wide(_END - end)) + rng.randbytes(_LITERALS_REACH)
    assert len(flash) <= _FLASH_SIZE
    size = _HEADER_SIZE + len(cases) * RESULT_SIZE
    _put(flash, 0, struct.pack("<16I", STACK_TOP, _CASES | 1, *[_FAULT | 1] * 14))
    _put(flash, _BEGIN, _code(*_begin()))
    _put(flash, _FINISH, _code(*_finish()))
    _put(flash, _END, _end(size))
    _put(flash, _FAULT, _code(*_fault()))
    return Image(bytes(flash), cases, size + BLOCK_SIZE)


def _case(seed: int, number: int, start: int, result: int) -> tuple[Case, bytes]:
    rng = random.Random(f"{seed}: {number}")
    sequence, pointers, untouched = body(rng)
    values = [interesting(rng) for _ in range(15)]
    for register, span in pointers.items():
        values[register] = BLOCK + span.low
    values[untouched] = result
    flags = rng.getrandbits(4) << 28 | (rng.random() < 0.2) << 27
    at_body = start + 4 + 4 * _RECORD_WORDS
    pool = _POOL + 4 * rng.randrange((_POOL_SIZE - BLOCK_SIZE) // 4)
    stack = values[SP] - 4 * _FRAME_WORDS
    record = (flags, *values[:SP], values[LR], at_body | 1, pool, stack)
    code = _code(*branch_link(_BEGIN - start)) + struct.pack(f"<{_RECORD_WORDS}I", *record)
    code += _code(*sequence.halves)
    end = start + len(code)
    tail, names = _case_end(untouched, end)
    code += _code(*tail)
    halves = tuple(sequence.halves)
    begins = {"apsr": flags, **{f"r{register}": values[register] for register in range(SP)}, "lr": values[LR]}
    return Case(number, start, at_body, end, names, halves, begins, sequence.made), code


def _case_end(pointer: int, at: int) -> tuple[list[int], tuple[str, ...]]:
    """Return the code that stores the registers at `pointer` and calls `finish`, and the names of what it stores."""
    stored = [register for register in (*range(13), LR) if register != pointer]
    flags, stack = stored[0], stored[1]
    halves = [
        *(0xE8A0 | pointer, sum(1 << register for register in stored)),  # stmia.w pointer!, {stored}
        *(0xF3EF, 0x8000 | flags << 8),  # mrs flags, apsr
        0x4668 | (stack >> 3) << 7 | stack & 7,  # mov stack, sp
        *(0xE8A0 | pointer, 1 << flags | 1 << stack),
        0x4600 | pointer << 3,  # mov r0, pointer
    ]
    # The next case begins on a word, so the call must end on one; a NOP of either size sees to it.
    halves += [0xBF00] if (at + 2 * len(halves)) % 4 else [0xF3AF, 0x8000]
    halves += branch_link(_FINISH - at - 2 * len(halves))
    names = [f"r{register}" if register != LR else "lr" for register in stored]
    return halves, (*names, "apsr", "sp", "memory")


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
