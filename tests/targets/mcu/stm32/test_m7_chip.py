"""What the chips of both Nucleo-144 have in common: buses, the way behind a boot loader, loops in any RAM."""

from __future__ import annotations

import itertools
import struct

import pytest

from targets.boards import built_in_board
from targets.mcu.engine.api import Reg
from targets.mcu.machine import Machine
from targets.mcu.testing import poke
from tests.each import each
from tests.targets.mcu.stm32.small_programs import FLASH, image, program, start

BOARDS = [built_in_board(name) for name in ("nucleo-f767zi", "nucleo-h753zi")]
SYSTEM = 0x1FF0_0000

LOOP_CYCLES = 640_000
"""So long the program that counts to 50000 takes at the most."""

on_both = pytest.mark.parametrize("board", BOARDS, ids=lambda board: board.chip)


@each(
    ("board", "ahb", "apb", "port"),
    [(BOARDS[0], "AHB1ENR", "APB1ENR", 0x4002_0014), (BOARDS[1], "AHB4ENR", "APB1LENR", 0x5802_0014)],
)
def test_a_byte_to_ahb_leaves_the_other_lanes_alone_and_one_to_apb_does_not(board, ahb, apb, port):
    machine = start(board)
    poke(machine.chip.rcc, ahb, 1)
    poke(machine.chip.rcc, apb, 1)
    machine.bus.write(port, 4, 0xFFFF)  # GPIOA_ODR
    machine.bus.write(port, 1, 0)
    assert machine.bus.read(port, 4) == 0xFF00
    machine.bus.write(0x4000_0028, 1, 0x12)  # TIM2_PSC
    assert machine.bus.read(0x4000_0028, 4) == 0x1212


@on_both
def test_behind_a_boot_loader_it_starts_where_the_image_begins(board):
    base = FLASH + 0x2_0000
    machine = start(board, (base, program(base=base)), table=base)
    assert machine.core.scb.read_VTOR() == base
    assert machine.engine.get(Reg.PC) == base + 0x40


@on_both
def test_a_jump_into_the_boot_loader_is_said(board):
    code = bytes.fromhex("00480047") + struct.pack("<I", SYSTEM + 0x21)
    machine = start(board, (FLASH, program(code)), run_ns=1_000_000)
    assert machine.ended is not None
    assert "boot loader in system memory, which is not modelled" in machine.ended.cause


ANY_MEMORY = pytest.mark.exhaustive("the same in each memory; the gate has one of each chip")


@pytest.mark.parametrize(
    ("board", "variable"),
    [
        (BOARDS[0], 0x2007_F000),
        (BOARDS[1], 0x2400_0100),
        *(pytest.param(BOARDS[0], variable, marks=ANY_MEMORY) for variable in (0x100, 0x2000_0100)),
        *(
            pytest.param(BOARDS[1], variable, marks=ANY_MEMORY)
            for variable in (0x100, 0x2000_0100, 0x3000_0100, 0x1000_0100)
        ),
    ],
    ids=lambda value: f"{value:#x}" if isinstance(value, int) else value.chip,
)
def test_loops_that_count_in_memory_are_passed_over_rightly(board, variable):
    # ldr r1, =variable; ldr r3, =50000; movs r0, #0; str r0, [r1]; ldr r2, [r1]; adds r0, #1; cmp r2, r3; bne; b .
    code = bytes.fromhex("0449 054b 0020 0860 0a68 0130 9a42 fad1 fee7 00bf")
    code += struct.pack("<II", variable, 50_000)
    found = []
    for skip in (True, False):
        machine = Machine(board, image((FLASH, program(code))), skip_idle=skip)
        machine.run_to(LOOP_CYCLES * 1_000_000_000 // machine.time.hclk_hz)
        found.append((machine.engine.fingerprint(), machine.engine.instructions, bytes(machine.ram)))
        assert machine.bus.read(variable, 4) == 50_000
    assert found[0] == found[1]


@on_both
def test_peripherals_do_not_overlap_and_lie_in_windows(board):
    chip = start(board).chip
    places = sorted((one.base, one.base + one.size, one.name) for one in chip.peripherals.values())
    for (_, end, name), (begin, _, other) in itertools.pairwise(places):
        assert end <= begin, f"{name} and {other}"
    for begin, end, name in places:
        assert any(base <= begin and end <= base + size for base, size in chip.REGISTER_WINDOWS), name
    for one in chip.peripherals.values():
        assert [offset for offset in one.registers if offset % 4] == [], one.name
