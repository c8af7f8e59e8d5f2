"""How the peripherals of the STM32H753 are connected: memory map, boot addresses, gates, interrupts, absences."""

from __future__ import annotations

import dataclasses
import struct
from functools import partial

import pytest

from targets.boards import Straps, built_in_board
from targets.mcu.engine.api import Reg
from targets.mcu.errors import BusFault
from targets.mcu.fidelity import Fidelity
from targets.mcu.stm32h7.gates import GATES
from targets.mcu.testing import peek, poke
from tests.targets.mcu.stm32.small_programs import FLASH, HANG, STACK, program, start

BANK_2 = 0x0810_0000
BOARD = built_in_board("nucleo-h753zi")


@pytest.fixture
def nucleo():
    return partial(start, BOARD)


# --- memory

RAM = [
    *(0, 0xFFFC, 0x2000_0000, 0x2001_FFFC, 0x2400_0000, 0x2407_FFFC),
    *(0x3000_0000, 0x3001_FFFC, 0x3002_0000, 0x3004_0000, 0x3004_7FFC, 0x3800_0000, 0x3800_FFFC),
]


def test_ram_is_there_and_each_word_is_its_own(nucleo):
    bus = nucleo().bus
    for number, address in enumerate(RAM):
        bus.write(address, 4, 0x1234_5600 + number)
        bus.write(address + 1, 1, 0xAB)
    assert [bus.read(address, 4) for address in RAM] == [0x1234_AB00 + number for number in range(len(RAM))]
    assert bus.read(0x1000_0000, 4) == bus.read(0x3000_0000, 4)
    assert bus.read(0x1004_7FFC, 4) == bus.read(0x3004_7FFC, 4)


def test_nothing_is_there(nucleo):
    bus = nucleo().bus
    for address in (
        *(0x1_0000, 0x0080_0000, 0x0820_0000, 0x1004_8000, 0x1FF2_0000, 0x2002_0000, 0x2408_0000, 0x3004_8000),
        *(0x3801_0000, 0x3880_1000, 0x4002_0C00, 0x4200_0000, 0x5802_1C00 + 0x1_0000, 0x5C00_1400),
    ):
        with pytest.raises(BusFault):
            pytest.fail(f"0x{address:08X} gives {bus.read(address, 4):#x}")


def test_the_flash_has_one_place(nucleo):
    machine = nucleo((FLASH, program()), (BANK_2, b"\x12\x34\x56\x78"))
    assert machine.bus.read(FLASH, 4) == STACK
    assert machine.bus.read(BANK_2, 4) == 0x7856_3412
    assert machine.chip.in_flash(FLASH + (2 << 20) - 1)
    assert not machine.chip.in_flash(0)


def test_the_signature(nucleo):
    bus = nucleo().bus
    assert bus.read(0x1FF1_E880, 2) == 2048
    assert bus.read(0x1FF1_E800, 4) != 0xFFFF_FFFF
    assert bus.read(0x5C00_1000, 4) == 0x2003_6450
    reference, cold, hot = (bus.read(0x1FF1_E800 + offset, 2) for offset in (0x60, 0x20, 0x40))
    assert reference == round(1.216 / 3.3 * 65_536)
    assert (hot - cold) * 3.3 / 65_536 / 80 == pytest.approx(0.002, rel=1e-3)


def test_the_core(nucleo):
    bus = nucleo().bus
    assert bus.read(0xE000_ED00, 4) == 0x411F_C271
    assert bus.read(0xE000_ED90, 4) >> 8 & 0xFF == 16, "regions of the MPU"
    assert bus.read(0xE000_E004, 4) == 4, "ICTR: 129 to 160 interrupts"
    bus.write(0xE000_E110, 4, 1 << 21)
    assert bus.read(0xE000_E110, 4) == 1 << 21, "interrupt 149"
    bus.write(0xE000_E110, 4, 1 << 22)
    assert bus.read(0xE000_E110, 4) == 1 << 21, "there is no interrupt 150"


# --- booting


def test_it_starts_from_the_beginning_of_the_flash_at_64_mhz(nucleo):
    machine = nucleo()
    assert machine.core.scb.read_VTOR() == FLASH
    assert machine.engine.get(Reg.PC) == FLASH + 0x40
    assert machine.engine.get(Reg.SP) == STACK
    assert machine.time.hclk_hz == 64_000_000
    assert not machine.notes.all


def test_the_boot_pin_chooses_the_boot_loader_which_is_not_there(nucleo):
    machine = nucleo(straps=Straps(boot0=1))
    assert machine.ended is not None
    assert machine.ended.kind == "no-boot"
    assert machine.ended.cause == "BOOT_ADD1 chooses system memory (0x1FF00000), whose boot loader is not modelled"


def option_keys(flash):
    poke(flash, "OPTKEYR", 0x0819_2A3B)
    poke(flash, "OPTKEYR", 0x4C5D_6E7F)


def test_boot_add0_says_where_from_after_the_next_reset(nucleo):
    machine = nucleo((FLASH, program()), (BANK_2, program(base=BANK_2)))
    flash = machine.chip.flash
    option_keys(flash)
    poke(flash, "BOOT_PRGR", 0x1FF0_0810)
    poke(flash, "OPTCR", 2)
    machine.run_to(100_000_000)
    assert peek(flash, "BOOT_CURR") == 0x1FF0_0810
    machine.reset("PIN")
    machine.run_to(101_000_000)
    assert machine.core.scb.read_VTOR() == BANK_2
    assert machine.engine.get(Reg.PC) == BANK_2 + 0x40


def test_the_hardware_watchdog_runs_from_the_reset_on(nucleo):
    machine = nucleo()
    flash = machine.chip.flash
    option_keys(flash)
    poke(flash, "OPTSR_PRG", peek(flash, "OPTSR_PRG") & ~(1 << 4))
    poke(flash, "OPTCR", 2)
    machine.run_to(100_000_000)
    machine.reset("PIN")
    machine.run_to(100_100_000)
    assert machine.chip.watchdog_runs()


@pytest.mark.parametrize("place", [0x100, 0x2000_0100, 0x2400_0100, 0x3800_0100])
def test_code_in_any_ram(nucleo, place):
    code = bytes.fromhex("00480047") + struct.pack("<I", place | 1)  # ldr r0, =place; bx r0
    machine = nucleo((FLASH, program(code)), (place, HANG))
    assert machine.engine.get(Reg.PC) == place
    assert machine.waits_in is not None


# --- how it is connected


def test_every_gate_has_a_peripheral_and_opens_it(nucleo):
    chip = nucleo().chip
    assert set(GATES) <= set(chip.peripherals)
    for name, (bus, bit) in GATES.items():
        peripheral, register = chip.peripherals[name], f"{bus}ENR"
        poke(chip.rcc, register, peek(chip.rcc, register) & ~(1 << bit))
        assert not peripheral.clocked, name
        poke(chip.rcc, f"C1_{register}", peek(chip.rcc, register) | 1 << bit)
        assert peripheral.clocked, name
        assert peek(chip.rcc, register) >> bit & 1


ABSENT = ("SAI1", "FDCAN1", "ETH", "USB1_OTG_HS", "LTDC", "QUADSPI", "MDMA", "BDMA", "HRTIM", "SAI4", "CRYP")


def test_what_is_absent_says_so_at_the_first_touch(nucleo):
    machine = nucleo()
    for name in ABSENT:
        peripheral = machine.chip.peripherals[name]
        assert all(register.fidelity is Fidelity.ABSENT for register in peripheral.registers.values()), name
        peripheral.read(min(peripheral.registers))
    noted = {note.where for note in machine.notes.all if note.kind == "unmodelled"}
    assert {where.removesuffix(f"_{where.split('_')[-1]}") for where in noted} == set(ABSENT)


def test_only_the_h753_has_the_cryptographic_processor(nucleo):
    board = dataclasses.replace(BOARD, chip="STM32H743ZI")
    assert not {"CRYP", "HASH"} & set(start(board).chip.peripherals)


def test_every_interrupt_has_its_number_once_or_is_shared_by_design(nucleo):
    """RM0433 section 19.1.2: what this model drives."""
    chip = nucleo().chip
    poke(chip.rcc, "AHB4ENR", 1 << 25)
    poke(chip.peripherals["HSEM"], "C1IER", 1)
    chip.peripherals["HSEM"].read(0x80)
    poke(chip.peripherals["HSEM"], "R0", 3 << 8)
    assert chip.core.exceptions.lines[125].level


def test_resets_that_drivers_wait_for_end_at_once(nucleo):
    chip = nucleo().chip
    eth = chip.peripherals["ETH"]
    poke(eth, "DMAMR", 1)
    assert not peek(eth, "DMAMR") & 1
    poke(eth, "MACMDIOAR", 2 << 16 | 3 << 2 | 1)  # a PHY's register 2
    assert not peek(eth, "MACMDIOAR") & 1
    assert peek(eth, "MACMDIODR") == 0xFFFF  # nobody pulls MDIO down
    poke(chip.peripherals["USB1_OTG_HS"], "GRSTCTL", 1)
    assert peek(chip.peripherals["USB1_OTG_HS"], "GRSTCTL") == 0x8000_0000
    poke(chip.peripherals["VREFBUF"], "CSR", 1)
    assert peek(chip.peripherals["VREFBUF"], "CSR") & 8


def test_exti_lines_have_the_ports_that_syscfg_chooses(nucleo):
    chip = nucleo().chip
    poke(chip.rcc, "APB4ENR", 1 << 1)
    for port in "ABCDEFG":
        poke(chip.peripherals["SYSCFG"], "EXTICR4", ("ABCDEFGHIJK".index(port)) << 8)
        assert chip.signals.route_of("EXTI14") == f"P{port}14"
    poke(chip.peripherals["SYSCFG"], "EXTICR4", 0xF << 8)
    assert chip.signals.route_of("EXTI14") is None


def test_pins_are_analog_after_a_reset_but_for_those_of_the_debugger(nucleo):
    chip = nucleo().chip
    poke(chip.rcc, "AHB4ENR", 0x7FF)
    modes = {letter: peek(chip.peripherals[f"GPIO{letter}"], "MODER") for letter in "ABCK"}
    assert modes == {"A": 0xABFF_FFFF, "B": 0xFFFF_FEBF, "C": 0xFFFF_FFFF, "K": 0xFFFF_FFFF}


def test_a_reset_leaves_the_backup_domain_and_tells_its_cause(nucleo):
    machine = nucleo()
    chip = machine.chip
    assert peek(chip.rcc, "RSR") == 0x00FA_0000, "power-on"
    poke(chip.rcc, "RSR", 1 << 16)
    assert peek(chip.rcc, "C1_RSR") == 0
    poke(chip.pwr, "CR1", 1 << 8)
    poke(chip.rcc, "BDCR", 0x8100)
    machine.reset("PIN")
    machine.run_to(20_000)
    assert peek(chip.rcc, "BDCR") & 0x8100 == 0x8100
    assert peek(chip.rcc, "RSR") == 1 << 22 | 1 << 17
    machine.reset("SFT")
    machine.run_to(30_000)
    assert peek(chip.rcc, "RSR") == 1 << 24 | 1 << 22 | 1 << 17, "flags stay until RMVF"
    machine.reset("POR")
    machine.run_to(40_000)
    assert peek(chip.rcc, "BDCR") == 0


def test_the_rtc_reaches_exti_by_the_lines_of_this_family(nucleo):
    chip = nucleo().chip
    poke(chip.peripherals["EXTI"], "RTSR1", 7 << 17)
    poke(chip.peripherals["EXTI"], "CPUIMR1", 0xFFC0_0000 | 7 << 17)
    for line in (17, 18, 19):
        chip.signals.output(f"EXTI{line}").set(True)
    assert peek(chip.peripherals["EXTI"], "CPUPR1") == 7 << 17
    assert [number for number in (2, 3, 41) if chip.core.exceptions.lines[number].level] == [2, 3, 41]


def test_random_numbers_take_the_48_mhz_oscillator_or_no_heed_of_a_slow_clock(nucleo):
    machine = nucleo()
    rcc, rng = machine.chip.rcc, machine.chip.peripherals["RNG"]
    poke(rcc, "AHB2ENR", 1 << 6)
    poke(rng, "CR", 1 << 2)
    machine.run_to(1_000_000)
    assert peek(rng, "SR") == 0x22, "HSI48 is off"
    poke(rcc, "CR", peek(rcc, "CR") | 1 << 12)
    machine.run_to(2_000_000)
    assert peek(rng, "SR") & 3 == 1
    assert peek(rng, "DR") != 0
    poke(rng, "CR", 0)
    poke(rcc, "CSR", 1)
    poke(rcc, "D2CCIP2R", 3 << 8)  # LSI
    poke(rng, "CR", 1 << 2 | 1 << 5)
    machine.run_to(10_000_000)
    assert peek(rng, "SR") & 3 == 1, "CED"


def test_the_crc_unit_has_32_bits_to_spare_and_takes_bytes_as_bytes(nucleo):
    machine = nucleo()
    poke(machine.chip.rcc, "AHB4ENR", 1 << 19)
    for byte in b"123456789":
        machine.bus.write(0x5802_4C00, 1, byte)
    assert machine.bus.read(0x5802_4C00, 4) == 0x0376_E6E7, "CRC-32/MPEG-2"
    machine.bus.write(0x5802_4C04, 4, 0x1234_5678)
    assert machine.bus.read(0x5802_4C04, 4) == 0x1234_5678


def test_the_window_watchdog_runs_on_apb3(nucleo):
    machine = nucleo()
    resets = []
    machine.on_reset = resets.append
    poke(machine.chip.rcc, "D1CFGR", 4 << 4)  # PCLK3 is half of HCLK
    poke(machine.chip.rcc, "APB3ENR", 1 << 6)
    began_ns = machine.now_ns
    poke(machine.chip.wwdg, "CR", 0xC3)
    poke(machine.chip.wwdg, "CFR", 0x7F)
    poke(machine.chip.wwdg, "CR", 0xC3)
    machine.run_to(began_ns + 510_000)
    assert not resets
    machine.run_to(began_ns + 513_000)
    assert resets == ["WWDG"], "4 x 4096 cycles of 32 MHz are 512 us"
    assert peek(machine.chip.rcc, "RSR") >> 28 & 1


def test_the_independent_watchdog_runs_on_the_lsi(nucleo):
    machine = nucleo()
    resets = []
    machine.on_reset = resets.append
    for key in (0xCCCC, 0x5555):
        machine.bus.write(0x5800_4800, 4, key)
    machine.bus.write(0x5800_4808, 4, 9)
    machine.run_to(5_000_000)
    machine.bus.write(0x5800_4800, 4, 0xAAAA)
    machine.run_to(6_000_000)
    assert not resets
    machine.run_to(7_000_000)
    assert resets == ["IWDG"], "10 x 4 periods of 32 kHz are 1.25 ms"


def test_both_clock_outputs_at_their_pins(nucleo):
    """From the reset on they are off."""
    machine = nucleo()
    bus, pins = machine.bus, machine.chip.pins
    bus.write(0x5802_44E0, 4, 0b101)  # RCC_AHB4ENR
    bus.write(0x5802_0000, 4, 0xABFE_FFFF)  # GPIOA_MODER: PA8
    bus.write(0x5802_0800, 4, 0xFFFB_FFFF)  # GPIOC_MODER: PC9
    assert [(pins[name].level, pins[name].wave) for name in ("PA8", "PC9")] == [(False, None)] * 2
    bus.write(0x5802_4410, 4, 4 << 18 | 10 << 25)
    assert [pins[name].wave.hz for name in ("PA8", "PC9")] == [16_000_000, 6_400_000]
