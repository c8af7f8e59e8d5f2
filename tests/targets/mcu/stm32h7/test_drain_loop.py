"""A loop that reads a FIFO empty changes something with each read, however equal the words in it are."""

from __future__ import annotations

import struct

from targets.boards import built_in_board
from targets.mcu.machine import Machine
from targets.mcu.testing import poke
from tests.share import ALL
from tests.targets.mcu.stm32.small_programs import FLASH, image, program

USART3, RAM = 0x4000_4800, 0x2400_0000
FIFOEN, RE, UE = 1 << 29, 1 << 2, 1 << 0
WORDS = 17


def drained(delay, *, skip):
    """Return how many words are left, and whether the program is through its loop, 200 us after it began."""
    # ldr r4, =USART3; ldr r5, =RAM; movs r6, #1; movs r7, #delay; subs r7, #1; bne to it;
    # ldr r1, [r4, #ISR]; lsls r1, r1, #26; bpl out; ldr r2, [r4, #RDR]; b to the first; out: str r6, [r5]; b to itself
    code = (0x4C06, 0x4D07, 0x2601, 0x2700 | delay, 0x3F01, 0xD1FD)
    code += (0x69E1, 0x0689, 0xD501, 0x6A62, 0xE7FA, 0x602E, 0xE7FE, 0xBF00)
    data = struct.pack(f"<{len(code)}H2I", *code, USART3, RAM)
    machine = Machine(built_in_board("nucleo-h753zi"), image((FLASH, program(data))), skip_idle=skip)
    machine.run_to(1)  # the reset
    usart = machine.chip.usarts["USART3"]
    usart.clocked = True
    poke(usart, "CR1", FIFOEN)
    poke(usart, "CR1", FIFOEN | RE | UE)
    for _ in range(WORDS):
        usart._line.take_word(0x55, False, False)
    usart._update()
    machine.run_to(200_000)
    return usart._kept.unread, machine.bus.read(RAM, 4)


def test_it_is_executed():
    for delay in range(1, 255, 6 if ALL else 24):
        assert drained(delay, skip=True) == drained(delay, skip=False) == (0, 1), delay
