"""Every register after reset, and which of its bits keep a one and a zero, against the second opinion."""

from __future__ import annotations

import pytest

from targets.mcu.fidelity import Fidelity
from tests.share import few

CLOCKS = [
    ("write4", "RCC_AHBENR", 0x55),
    ("write4", "RCC_APB2ENR", 0x5E7D),
    ("write4", "RCC_APB1ENR", 0x1AE6_4807),
    ("write4", "PWR_CR", 0x100),
]
PARTS = [
    "ADC1", "ADC2", "AFIO", "BKP", "CRC", "DBGMCU", "DMA1", "EXTI", "FLASH", "GPIOA", "GPIOB", "GPIOC", "GPIOD",
    "GPIOE",
    "I2C1", "I2C2", "IWDG", "NVIC", "PWR", "RCC", "RTC", "SCB", "SPI1", "SPI2", "STK", "TIM1", "TIM2", "TIM3", "TIM4",
    "USART1", "USART2", "USART3",
    "WWDG",
]  # fmt: skip
THEY_HAVE_NOT = ["DWT", "FPB", "ITM", "ROM", "TPIU"]
ABSENT = ["CAN", "USB", "USB_SRAM"]

HELD = [
    "RCC_CR", "RCC_CFGR", "RCC_BDCR", "RCC_CSR", "RCC_AHBENR", "RCC_APB2ENR", "RCC_APB1ENR", "PWR_CR",
    "WWDG_CR", "FLASH_KEYR", "FLASH_OPTKEYR", "FLASH_ACR", "SCB_AIRCR", "SCB_ICSR", "SCB_SHCSR", "SCB_DEMCR",
    "NVIC_STIR",
]  # fmt: skip
"""Not overwritten here: ones would take away the clocks, reset the chip or raise exceptions. See sequences.txt."""
HELD_KINDS = ("NVIC_IS", "NVIC_IC")


def registers_of(bench, part):
    return [f"{part}_{register.name}" for register in bench.parts[part].registers.values()]


def overwritten(bench, part):
    """Return the registers whose bits are tried."""
    names = [name for name in registers_of(bench, part) if name not in HELD and not name.startswith(HELD_KINDS)]
    return [name for name in names if bench.registers[name][1].fidelity is not Fidelity.ABSENT]


def test_every_part_is_compared(bench):
    assert sorted([*PARTS, *THEY_HAVE_NOT, *ABSENT]) == sorted(bench.parts)


def test_reset_values(bench, compare, make_program):
    for parts, clocks in ((["PWR"], CLOCKS[:3]), ([part for part in (*PARTS, *ABSENT) if part != "PWR"], CLOCKS)):
        names = [name for part in parts for name in registers_of(bench, part)]
        steps = [("read4", name, 0, (name, "reset")) for name in names]
        complaints, _ = compare(make_program(bench, [*clocks, *steps]))
        assert not complaints, "\n".join(["", *complaints])


@pytest.mark.parametrize("part", few([*PARTS], 9, "the gate has nine of the parts"))
def test_bits_that_can_be_written(bench, compare, make_program, part):
    steps = list(CLOCKS)
    for name in overwritten(bench, part):
        steps += [("write4", name, 0xFFFF_FFFF), ("read4", name, 0, (name, "ones"))]
        steps += [
            ("write4", name, 0),
            ("read4", name, 0, (name, "zeros")),
            ("write4", name, bench.registers[name][1].reset),
        ]
    complaints, _ = compare(make_program(bench, steps))
    assert not complaints, "\n".join(["", *complaints])


def test_every_line_of_the_table_is_about_something(bench, table):
    labels = {(name, "reset") for part in (*PARTS, *ABSENT) for name in registers_of(bench, part)}
    labels |= {(name, what) for part in PARTS for name in overwritten(bench, part) for what in ("ones", "zeros")}
    of_registers = [row for row in table.rows if ":" not in row.where and "_" in row.where]
    assert not [row for row in of_registers if not any(row.covers(*label) for label in labels)]
