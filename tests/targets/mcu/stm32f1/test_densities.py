"""What a device of low, medium and high density has, and what the others have that it lacks.

RM0008 sections 2.2 and 7.3, tables 3 and 63; DS6087, DS5319, DS5792; PM0075.
"""

from __future__ import annotations

import pytest

from targets.boards import Board
from targets.firmware import image_path
from targets.mcu.errors import BusFault
from targets.mcu.fidelity import Fidelity
from targets.mcu.image import limits_for, load_image
from targets.mcu.machine import Machine
from targets.mcu.registers import Peripheral
from targets.mcu.stm32f1.signature import SYSTEM_MEMORY_BASE
from targets.mcu.testing import peek, poke
from tests.each import each

OF_ALL = {f"GPIO{port}" for port in "ABCD"} | {"TIM1", "TIM2", "TIM3", "USART1", "USART2", "SPI1", "I2C1", "USB", "CAN"}
OF_ALL |= {"ADC1", "ADC2", "DMA1", "RTC", "BKP", "PWR", "WWDG", "IWDG", "EXTI", "AFIO", "CRC", "RCC", "FLASH", "DBGMCU"}
FROM_MEDIUM = {"GPIOE", "TIM4", "USART3", "SPI2", "I2C2"}
# By where they are.
MODELLED_OF_HIGH = {
    "TIM5": 0x4000_0C00,
    "TIM6": 0x4000_1000,
    "TIM7": 0x4000_1400,
    "UART4": 0x4000_4C00,
    "UART5": 0x4000_5000,
    "DAC": 0x4000_7400,
    "TIM8": 0x4001_3400,
    "DMA2": 0x4002_0400,
}
ABSENT_OF_HIGH = {
    "FSMC": 0xA000_0000,
}
FROM_HIGH = {"GPIOF", "GPIOG", "SDIO", *MODELLED_OF_HIGH, *ABSENT_OF_HIGH}

IMAGE = load_image(image_path("selftest-crc"), limits_for("STM32F103C8"))


def machine_with(chip: str) -> Machine:
    return Machine(Board.from_mapping({"name": chip, "chip": chip}), IMAGE)


@pytest.fixture(scope="module")
def high() -> Machine:
    return machine_with("STM32F103ZE")


@each(
    ("chip", "has", "lacks", "gates", "idcode", "flash_kb"),
    [
        ("STM32F103C4", OF_ALL, FROM_MEDIUM | FROM_HIGH, (0x55, 0x1AA2_0803, 0x5E3D), 0x412, 16),
        ("STM32F103CB", OF_ALL | FROM_MEDIUM, FROM_HIGH, (0x55, 0x1AE6_4807, 0x5E7D), 0x410, 128),
        ("STM32F103RC", OF_ALL | FROM_MEDIUM | FROM_HIGH, set(), (0x557, 0x3AFE_C83F, 0xFFFD), 0x414, 256),
    ],
)
def test_a_density_has_its_peripherals_and_their_gates(chip, has, lacks, gates, idcode, flash_kb):
    made = machine_with(chip).chip
    assert has <= set(made.peripherals)
    assert not lacks & set(made.peripherals)
    for register, bits in zip(("AHBENR", "APB1ENR", "APB2ENR"), gates, strict=True):
        poke(made.rcc, register, 0xFFFF_FFFF)
        assert peek(made.rcc, register) == bits, register
    assert peek(made.dbgmcu, "IDCODE") & 0xFFF == idcode
    offset = 0x1FFF_F7E0 - SYSTEM_MEMORY_BASE
    assert int.from_bytes(made.system_memory[offset : offset + 2], "little") == flash_kb


def test_what_is_missing_of_high_density_stands_in_the_ledger_and_is_said(high):
    chip = high.chip
    poke(chip.rcc, "AHBENR", 0x557)
    poke(chip.rcc, "APB1ENR", 0x3AFE_C83F)
    poke(chip.rcc, "APB2ENR", 0xFFFD)
    for name, base in ABSENT_OF_HIGH.items():
        part: Peripheral = chip.peripherals[name]
        assert part.base == base
        assert all(register.fidelity is Fidelity.ABSENT and register.note for register in part.registers.values())
        high.bus.read(base, 4)
    said = {note.where.partition("_")[0] for note in high.notes.all if note.kind == "unmodelled"}
    assert said == set(ABSENT_OF_HIGH)


def test_what_is_modelled_of_high_density_is_where_it_should_be(high):
    for name, base in MODELLED_OF_HIGH.items():
        part: Peripheral = high.chip.peripherals[name]
        assert part.base == base
        assert all(register.fidelity is not Fidelity.ABSENT for register in part.registers.values())


def test_reset_values_of_what_only_high_density_has(high):
    """RM0008, the register maps at the end of the sections."""
    nonzero = {
        (name, register.name): register.reset
        for name in (*ABSENT_OF_HIGH, *MODELLED_OF_HIGH)
        for register in high.chip.peripherals[name].registers.values()
        if register.reset and name != "FSMC"
    }
    assert nonzero == {
        **{(f"TIM{number}", "ARR"): 0xFFFF for number in (5, 6, 7, 8)},
        ("UART4", "SR"): 0xC0,
        ("UART5", "SR"): 0xC0,
    }
    fsmc = high.chip.peripherals["FSMC"]
    assert [peek(fsmc, name) for name in ("BCR1", "BCR4", "BTR2", "PCR3", "SR2", "PATT4")] == [
        *(0x30DB, 0x30D2, 0x0FFF_FFFF, 0x18, 0x40, 0xFCFC_FCFC),
    ]
    assert fsmc.registers[0x11C].name == "BWTR4"
    assert high.chip.peripherals["DMA2"].registers[0x64].name == "CMAR5"


def test_a_program_reaches_them_all_as_registers(high):
    """SDIO and FSMC lie outside of the windows that other densities have."""
    windows = high.chip.REGISTER_WINDOWS
    for part in high.chip.peripherals.values():
        assert any(base <= part.base and part.base + part.size <= base + size for base, size in windows), part.name


@each(
    ("register", "value", "address", "answers"),
    [
        ("BCR1", 0x30DB, 0x6000_0000, True),  # after a reset it is on
        ("BCR2", 0x30D2, 0x6400_0000, False),
        ("BCR4", 0x1011, 0x6C00_0800, True),  # SRAM, as displays are connected
        ("BCR4", 0x1010, 0x6C00_0800, False),
        ("BCR3", 0x1019, 0x6800_0000, False),  # NOR flash without FACCEN
        ("BCR3", 0x1059, 0x6BFF_FFFE, True),
        ("PCR2", 0x000C, 0x7000_0000, True),
        ("PCR3", 0x0008, 0x8801_0000, False),
        ("PCR4", 0x0004, 0x9C00_0000, True),
    ],
)
def test_memory_outside_answers_where_its_bank_is_on(register, value, address, answers):
    """RM0008 section 21.3: an access to a bank that is off is an AHB error. Nothing is attached."""
    machine = machine_with("STM32F103ZE")
    poke(machine.chip.rcc, "AHBENR", 0x114)
    poke(machine.chip.peripherals["FSMC"], register, value)
    if not answers:
        with pytest.raises(BusFault):
            machine.bus.write(address, 2, 0x1234)
        return
    machine.bus.write(address, 2, 0x1234)
    assert machine.bus.read(address, 2) == 0
    assert [note.text for note in machine.notes.all][-1].startswith("no external memory is there")
    poke(machine.chip.rcc, "AHBENR", 0x14)
    with pytest.raises(BusFault):
        machine.bus.read(address, 2)


def test_interrupts_go_up_to_59_with_high_density(high):
    iser1 = 0xE000_E104
    for machine, lines in ((high, 60), (machine_with("STM32F103C8"), 43)):
        machine.bus.write(iser1, 4, 0xFFFF_FFFF)
        assert machine.bus.read(iser1, 4) == (1 << lines - 32) - 1


@each(("chip", "page"), [("STM32F103R6", 0x400), ("STM32F103RB", 0x400), ("STM32F103RC", 0x800)])
def test_a_page_of_the_flash(chip, page):
    """PM0075 section 1.2; each bit of WRPR is for 4 KB."""
    machine = machine_with(chip)
    flash = machine.chip.flash
    flash.memory[:] = bytes(len(flash.memory))
    for key in (0x4567_0123, 0xCDEF_89AB):
        poke(flash, "KEYR", key)
    poke(flash, "CR", 0x02)
    poke(flash, "AR", 0x0800_1FFF)
    poke(flash, "CR", 0x42)
    machine.time.run_due(1_000_000)
    begin = 0x2000 - page
    assert flash.memory[begin : begin + page] == b"\xff" * page
    assert flash.memory.count(b"\xff") == page


def test_backup_registers(high):
    """RM0008 section 6.4: ten, and 42 with high density, the others behind CSR."""
    for machine, last, offset in ((high, 42, 0xBC), (machine_with("STM32F103C8"), 10, 0x28)):
        bkp = machine.chip.bkp
        data = {register.name: register.offset for register in bkp.registers.values() if register.name[:2] == "DR"}
        assert (len(data), data[f"DR{last}"]) == (last, offset)


@each(
    ("chip", "shared"), [("STM32F103C8", True), ("STM32F103RE", True), ("STM32F103VB", False), ("STM32F103ZC", False)]
)
def test_oscillator_pins_are_shared_on_packages_of_up_to_64_pins(chip, shared):
    """RM0008 section 9.3.3."""
    assert (machine_with(chip).chip.pins["PD0"].claimed_by is not None) is shared


def test_exti_lines_have_ports_f_and_g_where_there_are_some(high):
    for machine, pin in ((high, "PG3"), (machine_with("STM32F103C8"), None)):
        poke(machine.chip.rcc, "APB2ENR", 1)
        poke(machine.chip.afio, "EXTICR1", 6 << 12)
        assert machine.chip.signals.route_of("EXTI3") == pin


def test_memory_ends_where_it_does():
    for chip, flash, ram in (("STM32F103C4", 16, 6), ("STM32F103C6", 32, 10), ("STM32F103VD", 384, 64)):
        bus = machine_with(chip).bus
        for last in (0x0800_0000 + (flash << 10) - 4, 0x2000_0000 + (ram << 10) - 4):
            bus.read(last, 4)
            with pytest.raises(BusFault):
                bus.read(last + 4, 4)
