"""The register accesses of ST's start-up code and HAL for this chip end where they should, and are no misuse.

Sequences as in system_stm32h7xx.c and the drivers PWR, RCC, FLASH, RTC and HSEM of STM32CubeH7; each wait has the limit
that the driver gives it, or less.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pytest

from targets.boards import built_in_board
from targets.mcu.image import Image, Segment
from targets.mcu.machine import Machine
from targets.mcu.symbols import NO_SYMBOLS

RCC, PWR, FLASH, SYSCFG, EXTI, HSEM = 0x5802_4400, 0x5802_4800, 0x5200_2000, 0x5800_0400, 0x5800_0000, 0x5802_6400
CR, CFGR, D1CFGR, D2CFGR, D3CFGR, PLLCKSELR, PLLCFGR, PLL1DIVR, PLL1FRACR = (
    RCC + offset for offset in (0x00, 0x10, 0x18, 0x1C, 0x20, 0x28, 0x2C, 0x30, 0x34)
)
CIER, BDCR, CSR, AHB3ENR, AHB4ENR, APB4ENR = (RCC + offset for offset in (0x60, 0x70, 0x74, 0xD4, 0xE0, 0xF4))
ACTVOSRDY = VOSRDY = 1 << 13
MS = 1_000_000


class Program:
    """A machine whose CPU turns in a circle, while a test plays the program over the bus."""

    def __init__(self):
        table = (0x2002_0000).to_bytes(4, "little") + (0x0800_0009).to_bytes(4, "little") + b"\xfe\xe7" * 4
        image = Image(
            path=Path("image"),
            format="bin",
            digest="",
            segments=(Segment(0x0800_0000, table),),
            table=0x0800_0000,
            stack_pointer=0x2002_0000,
            reset_vector=0x0800_0009,
            flash_bytes=0,
            ram_bytes=0,
            symbols=NO_SYMBOLS,
            notes=(),
        )
        self.machine = Machine(built_in_board("nucleo-h753zi"), image)
        self.machine.run_to(1000)

    def get(self, address):
        return self.machine.bus.read(address, 4)

    def put(self, address, value):
        self.machine.bus.write(address, 4, value)

    def change(self, address, mask, value):
        self.put(address, self.get(address) & ~mask | value)

    def wait(self, address, mask, value, limit_ms=2):
        end_ns = self.machine.now_ns + limit_ms * MS
        while self.get(address) & mask != value:
            assert self.machine.now_ns < end_ns, f"0x{address:08X} never has 0x{value:X} in 0x{mask:X}"
            self.machine.run_to(self.machine.now_ns + limit_ms * MS // 1000)

    def notes(self, *kinds):
        return [note.where for note in self.machine.notes.all if note.kind in kinds]


@pytest.fixture
def program():
    return Program()


def system_init(program):
    program.change(CR, 0, 1)
    program.put(CFGR, 0)
    program.change(CR, 0xFFFF_FFFF & ~0xEAF6_ED7F, 0)
    for register in (D1CFGR, D2CFGR, D3CFGR):
        program.put(register, 0)
    program.put(PLLCKSELR, 0x0202_0200)
    program.put(PLLCFGR, 0x01FF_0000)
    for index in range(3):
        program.put(PLL1DIVR + 8 * index, 0x0101_0280)
        program.put(PLL1FRACR + 8 * index, 0)
    program.change(CR, 1 << 18, 0)
    program.put(CIER, 0)
    if program.get(0x5C00_1000) >> 16 < 0x2000:
        program.put(0x5100_8108, 1)
    program.change(AHB3ENR, 0, 1 << 12)
    program.put(0x5200_4000, 0x30D2)  # FMC_BCR1
    program.change(AHB3ENR, 1 << 12, 0)


def choose_supply(program):
    assert program.get(PWR + 0x0C) & 7 == 6, "HAL_PWREx_ConfigSupply takes it for configured already otherwise"
    program.change(PWR + 0x0C, 7, 2)
    program.wait(PWR + 0x04, ACTVOSRDY, ACTVOSRDY)


def choose_scale_0(program):
    program.change(APB4ENR, 0, 2)
    program.change(PWR + 0x18, 3 << 14, 3 << 14)
    program.change(SYSCFG + 0x2C, 0, 1)
    program.wait(PWR + 0x18, VOSRDY, VOSRDY)


def start_hse_and_pll1(program):
    program.change(CR, 0, 1 << 18)
    program.change(CR, 0, 1 << 16)
    program.wait(CR, 1 << 17, 1 << 17, limit_ms=100)
    program.change(CR, 1 << 24, 0)
    program.wait(CR, 1 << 25, 0)
    program.change(PLLCKSELR, 0x3F3, 2 | 1 << 4)
    program.put(PLL1DIVR, 119 | 1 << 9 | 1 << 16 | 1 << 24)
    program.change(PLLCFGR, 1, 0)
    program.change(PLL1FRACR, 0x1FFF << 3, 0)
    program.change(PLLCFGR, 3 << 2, 3 << 2)
    program.change(PLLCFGR, 2, 0)
    for output in (16, 17, 18, 0):
        program.change(PLLCFGR, 0, 1 << output)
    program.change(CR, 0, 1 << 24)
    program.wait(CR, 1 << 25, 1 << 25)


def switch_to_pll1(program):
    program.change(FLASH, 0xF, 4)
    assert program.get(FLASH) & 0xF == 4
    for register, shift in ((D1CFGR, 4), (D2CFGR, 4), (D2CFGR, 8), (D3CFGR, 4)):
        program.change(register, 7 << shift, 4 << shift)
    program.change(D1CFGR, 0xF, 8)
    program.change(D1CFGR, 0xF00, 0)
    program.change(CFGR, 7, 3)
    program.wait(CFGR, 7 << 3, 3 << 3)


def start(program):
    for step in (system_init, choose_supply, choose_scale_0, start_hse_and_pll1, switch_to_pll1):
        step(program)


def test_the_usual_start_reaches_480_mhz_without_a_misuse(program):
    start(program)
    assert program.machine.time.hclk_hz == 480_000_000
    assert program.notes("misuse", "reserved", "clock-off", "assumed") == []
    assert program.notes("unmodelled") == ["FMC_BCR1"]


def test_the_rtc_starts_on_the_lse(program):
    start(program)
    program.change(PWR, 0, 1 << 8)
    program.wait(PWR, 1 << 8, 1 << 8)
    program.change(BDCR, 0, 1)
    program.wait(BDCR, 2, 2, limit_ms=5000)
    program.change(BDCR, 0x300, 0x100)
    program.change(BDCR, 0, 1 << 15)
    rtc = 0x5800_4000
    for key in (0xCA, 0x53):
        program.put(rtc + 0x24, key)
    program.change(rtc + 0x0C, 0, 1 << 7)
    program.wait(rtc + 0x0C, 1 << 6, 1 << 6, limit_ms=1000)
    assert program.notes("misuse", "reserved", "clock-off") == []


def unlock_bank_2(program):
    for key in (0x4567_0123, 0xCDEF_89AB):
        program.put(FLASH + 0x104, key)
    assert not program.get(FLASH + 0x10C) & 1


def finish(program, limit_ms):
    program.wait(FLASH + 0x110, 4, 0, limit_ms=limit_ms)
    assert program.get(FLASH + 0x110) & 0x0FEE_0000 == 0
    program.put(FLASH + 0x114, 1 << 16)


def test_a_sector_is_erased_and_a_flash_word_programmed(program):
    start(program)
    program.machine.chip.flash.memory[0x12_0000:0x12_0020] = bytes(32)
    unlock_bank_2(program)
    program.change(FLASH + 0x10C, 0x730, 0)
    program.change(FLASH + 0x10C, 0, 1 << 2 | 3 << 4 | 1 << 8 | 1 << 7)
    finish(program, 4000)
    program.change(FLASH + 0x10C, 0x704, 0)
    assert program.get(0x0812_0000) == 0xFFFF_FFFF
    program.change(FLASH + 0x10C, 0, 1 << 1)
    for index in range(8):
        program.machine.chip.flash.program(0x0812_0000 + 4 * index, 4, 0x1111_1111 * index)
    finish(program, 1)
    program.change(FLASH + 0x10C, 2, 1)
    assert [program.get(0x0812_0000 + 4 * index) for index in range(8)] == [0x1111_1111 * index for index in range(8)]
    assert program.notes("misuse", "reserved") == []


def test_an_interrupt_of_a_pin(program):
    start(program)
    program.change(AHB4ENR, 0, 1 << 2)
    program.change(0x5802_0800, 3 << 26, 0)  # GPIOC_MODER: PC13
    program.change(SYSCFG + 0x14, 0xF0, 0x20)
    program.change(EXTI + 0x00, 0, 1 << 13)
    program.change(EXTI + 0x80, 0, 1 << 13)
    program.machine.chip.pins["PC13"].drive(True)
    assert program.get(EXTI + 0x88) == 1 << 13
    assert program.machine.core.exceptions.lines[40].level


def test_a_semaphore_is_taken_by_the_identifier_of_the_header(program):
    program.change(AHB4ENR, 0, 1 << 25)
    assert program.get(HSEM + 0x80 + 4 * 2) == 1 << 31 | 3 << 8
    program.put(HSEM + 4 * 2, 3 << 8)
    program.put(HSEM + 4 * 2, 1 << 31 | 3 << 8 | 5)
    assert program.get(HSEM + 4 * 2) == 1 << 31 | 3 << 8 | 5


def test_the_lsi_at_a_pin_is_told_edge_by_edge(program):
    """HAL_RCC_MCOConfig(RCC_MCO2, RCC_MCO2SOURCE_LSICLK, RCC_MCODIV_4), on PC9: 8 kHz, which the host can follow."""
    edges = []
    program.machine.chip.pins["PC9"].on_edge(lambda _cycle, ns, level: edges.append((ns, level)))
    program.change(CSR, 0, 1)
    program.wait(CSR, 2, 2)
    program.change(AHB4ENR, 0, 1 << 2)
    program.change(0x5802_0800, 3 << 18, 2 << 18)  # GPIOC_MODER
    program.change(CFGR, 0x7F << 25, 5 << 29 | 4 << 25)
    began_ns = program.machine.now_ns
    program.machine.run_to(began_ns + MS)
    since = [(ns, level) for ns, level in edges if ns > began_ns]
    assert [level for _, level in since] == [True, False] * 8
    assert {round((later - ns) / 100) for (ns, _), (later, _) in pairwise(since)} == {625}
