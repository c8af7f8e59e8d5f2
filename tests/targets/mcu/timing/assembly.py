"""Just enough of an assembler to write the programs of these tests (encodings: DDI0403 section A7.7)."""

from __future__ import annotations

import struct

from targets.firmware import image_path
from targets.mcu.image import Image, Segment
from targets.mcu.symbols import NO_SYMBOLS

NOP, HANG, BX_LR, WFI, WFE, CPSID = 0xBF00, 0xE7FE, 0x4770, 0xBF30, 0xBF20, 0xB672
STR_R3_R2 = 0x6013  # str r3, [r2]
LDR = 0x6820  # ldr r0, [r4]
DIV = (0xFBB5, 0xF0F6)  # udiv r0, r5, r6
PUSH_POP = (0xB4F0, 0xBCF0)  # push {r4-r7}; pop {r4-r7}

TIM2, TIM3 = 0x4000_0000, 0x4000_0400
USART1, USART2 = 0x4001_3800, 0x4000_4400
AFIO, EXTI, GPIOA = 0x4001_0000, 0x4001_0400, 0x4001_0800
RCC, FLASH = 0x4002_1000, 0x4002_2000
SCS, SYSTICK, CYCCNT = 0xE000_E000, 0xE000_E010, 0xE000_1004

_FLASH_MEMORY, _STACK = 0x0800_0000, 0x2000_5000
_CODE, _ROOM = _FLASH_MEMORY + 0x400, 0x1000


class Code:
    """Half-words of a program, one instruction after the other; every method returns the same object."""

    def __init__(self, *halves: int) -> None:
        self.halves = list(halves)

    def add(self, *halves: int) -> Code:
        self.halves += halves
        return self

    def load(self, register: int, value: int) -> Code:
        """movw and movt."""
        for opcode, half in ((0xF240, value & 0xFFFF), (0xF2C0, value >> 16)):
            self.add(opcode | (half >> 11 & 1) << 10 | half >> 12, (half >> 8 & 7) << 12 | register << 8 | half & 0xFF)
        return self

    def poke(self, *writes: tuple[int, int]) -> Code:
        """Store words at addresses; uses r0 and r1."""
        for address, value in writes:
            self.load(0, value).load(1, address).add(0x6008)  # str r0, [r1]
        return self

    def wait(self, address: int, mask: int) -> Code:
        """Poll until a bit of a word is set; uses r0, r1 and r2."""
        return self.load(1, address).load(2, mask).add(0x6808, 0x4210, 0xD0FC)  # ldr r0, [r1]; tst r0, r2; beq

    def hang(self) -> Code:
        return self.add(HANG)

    @property
    def bytes(self) -> bytes:
        return struct.pack(f"<{len(self.halves)}H", *self.halves)


def program(main: Code, handlers: dict[int, Code]) -> Image:
    """Return an image; `handlers` by exception number, all others hang."""
    words = [_STACK, _CODE | 1, *[_CODE - 0x10 | 1] * 74]
    segments = [Segment(_CODE - 0x10, Code(HANG).bytes), Segment(_CODE, main.bytes)]
    for place, (number, handler) in enumerate(handlers.items(), 1):
        address = _CODE + place * _ROOM
        words[number] = address | 1
        segments.append(Segment(address, handler.bytes))
    return Image(
        path=image_path("selftest-crc"),
        format="bin",
        digest="0" * 64,
        segments=(Segment(_FLASH_MEMORY, struct.pack(f"<{len(words)}I", *words)), *segments),
        table=_FLASH_MEMORY,
        stack_pointer=_STACK,
        reset_vector=words[1],
        flash_bytes=0x8000,
        ram_bytes=0,
        symbols=NO_SYMBOLS,
        notes=(),
    )


CLOCK_72_MHZ = (
    Code()
    .poke((FLASH, 0x12), (RCC, 1 << 16 | 1))  # two wait states; HSEON
    .wait(RCC, 1 << 17)
    .poke((RCC + 4, 1 << 16 | 7 << 18 | 4 << 8), (RCC, 1 << 24 | 1 << 16 | 1))  # HSE times 9, APB1 half; PLLON
    .wait(RCC, 1 << 25)
    .poke((RCC + 4, 1 << 16 | 7 << 18 | 4 << 8 | 2))
)
"""HSE of 8 MHz and PLL: HCLK and APB2 at 72 MHz, APB1 at 36 MHz."""
