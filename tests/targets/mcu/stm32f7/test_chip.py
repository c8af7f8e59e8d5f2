"""How the peripherals of the STM32F767 are connected: memory map, boot addresses, gates, interrupts, absences."""

from __future__ import annotations

import dataclasses
import struct
from functools import partial

import pytest

from targets.boards import Straps, built_in_board
from targets.mcu.engine.api import Reg
from targets.mcu.errors import BusFault
from targets.mcu.fidelity import Fidelity
from targets.mcu.machine import Machine
from targets.mcu.stm32f7.gates import GATES
from targets.mcu.stm32f7.options import FACTORY_OPTCR, Options, encode
from targets.mcu.testing import peek, poke
from tests.targets.mcu.stm32.small_programs import FLASH, HANG, STACK, image, program, start

ITCM_FLASH, OPTIONS = 0x0020_0000, 0x1FFF_0000
BOARD = built_in_board("nucleo-f767zi")


@pytest.fixture
def nucleo():
    return partial(start, BOARD)


# --- memory


def test_ram_is_there(nucleo):
    bus = nucleo().bus
    for address in (0, 0x3FFC, 0x2000_0000, 0x2001_FFFC, 0x2002_0000, 0x2007_BFFC, 0x2007_C000, 0x2007_FFFC):
        bus.write(address, 4, 0x1234_5678)
        bus.write(address + 1, 1, 0xAB)
        assert bus.read(address, 4) == 0x1234_AB78, f"0x{address:08X}"


def test_nothing_is_there(nucleo):
    bus = nucleo().bus
    for address in (0x4000, 0xF_FFFC, 0x11_0000, 0x40_0000, 0x0820_0000, 0x1FF1_0000, 0x2008_0000, 0x5006_0C00):
        with pytest.raises(BusFault):
            pytest.fail(f"0x{address:08X} gives {bus.read(address, 4):#x}")


def test_the_flash_is_seen_at_two_addresses_and_none_of_them_is_0(nucleo):
    machine = nucleo()
    assert machine.bus.read(FLASH, 4) == machine.bus.read(ITCM_FLASH, 4) == STACK
    assert machine.bus.read(0, 4) == 0
    assert machine.chip.in_flash(FLASH + (2 << 20) - 1)
    assert machine.chip.in_flash(ITCM_FLASH)
    assert not machine.chip.in_flash(0)


def test_the_signature(nucleo):
    bus = nucleo().bus
    assert bus.read(0x1FF0_F442, 2) == 2048
    assert bus.read(0x1FF0_F420, 4) != 0xFFFF_FFFF
    assert bus.read(0xE004_2000, 4) == 0x1001_6451
    assert bus.read(OPTIONS, 4) == 0x5500_AAFF


def test_no_word_stands_for_a_bit(nucleo):
    with pytest.raises(BusFault):
        nucleo().bus.read(0x4200_0000, 4)
    with pytest.raises(BusFault):
        nucleo().bus.read(0x2200_0000, 4)


# --- booting


def test_it_starts_by_itcm_from_the_beginning_of_the_flash(nucleo):
    machine = nucleo()
    assert machine.core.scb.read_VTOR() == ITCM_FLASH
    assert machine.engine.get(Reg.PC) == FLASH + 0x40
    assert machine.engine.get(Reg.SP) == STACK
    assert machine.time.hclk_hz == 16_000_000


def optioned(boot_add0, boot_add1=0x0040):
    return OPTIONS, encode(Options(optcr=FACTORY_OPTCR & ~3, optcr1=boot_add1 << 16 | boot_add0))


@pytest.mark.parametrize(
    ("half", "table"),
    [(0x2000, FLASH), (0x2008, FLASH + 0x2_0000), (0x0080, ITCM_FLASH), (0xFFFF, ITCM_FLASH), (0x1000, ITCM_FLASH)],
)
def test_boot_add0_says_where_from(nucleo, half, table):
    machine = nucleo((FLASH, program()), (FLASH + 0x2_0000, program(base=FLASH + 0x2_0000)), optioned(half))
    assert machine.ended is None
    assert machine.core.scb.read_VTOR() == table


def test_the_boot_pin_chooses_boot_add1(nucleo):
    machine = nucleo(straps=Straps(boot0=1))
    assert machine.ended is not None
    assert machine.ended.kind == "no-boot"
    assert machine.ended.cause == ("BOOT_ADD1 chooses system memory (0x00100000), whose boot loader is not modelled")
    ram = nucleo((0x2000_0000, program(base=0x2000_0000)), optioned(0x80, 0x8000), straps=Straps(boot0=1))
    assert (ram.ended, ram.engine.get(Reg.PC)) == (None, 0x2000_0040)
    assert peek(ram.chip.peripherals["SYSCFG"], "MEMRMP") & 1


def test_option_bytes_that_are_not_modelled_are_said(nucleo):
    dual = Options(optcr=FACTORY_OPTCR & ~(3 << 28 | 3), optcr1=0x0040_0080)
    machine = nucleo((FLASH, program()), (OPTIONS, encode(dual)))
    assert machine.ended is not None
    assert machine.ended.cause == "nDBOOT has the boot loader choose a bank; it is not modelled"
    window = Options(optcr=FACTORY_OPTCR & ~(1 << 4 | 3), optcr1=0x0040_0080)
    machine = nucleo((FLASH, program()), (OPTIONS, encode(window)))
    assert [note.where for note in machine.notes.all] == ["FLASH_OPTCR.WWDG_SW"]


def test_the_hardware_watchdog_runs_from_the_reset_on(nucleo):
    hardware = Options(optcr=FACTORY_OPTCR & ~(1 << 5 | 3), optcr1=0x0040_0080)
    machine = nucleo((FLASH, program()), (OPTIONS, encode(hardware)))
    assert machine.chip.watchdog_runs()


def test_code_in_the_ram_of_the_core(nucleo):
    # ldr r0, =0x101; bx r0: into ITCM, where an image has put its code
    code = bytes.fromhex("00480047 01010000".replace(" ", ""))
    machine = nucleo((FLASH, program(code)), (0x100, HANG))
    assert machine.engine.get(Reg.PC) == 0x100
    assert machine.waits_in is not None
    machine.reset("POR")
    machine.run_to(20_000)
    assert machine.engine.get(Reg.PC) == 0x100, "what the image puts into RAM is there after power-on, as in a debugger"


def test_a_jump_into_erased_flash_is_said_whatever_the_address(nucleo):
    for target in (FLASH + 0x10_0001, ITCM_FLASH + 0x10_0001):
        code = bytes.fromhex("00480047") + struct.pack("<I", target)
        machine = nucleo((FLASH, program(code)), run_ns=1_000_000)
        assert machine.ended is not None
        assert "the flash is erased there" in machine.ended.cause


def test_an_erased_vector_table(nucleo):
    machine = nucleo((FLASH + 0x4000, b"\x00"), table=FLASH)
    assert machine.ended is not None
    assert machine.ended.kind == "lockup"


# --- how it is connected


def test_every_gate_has_a_peripheral_and_opens_it(nucleo):
    chip = nucleo().chip
    assert set(GATES) <= set(chip.peripherals)
    three_gates = {"ADC"}  # which it looks at itself
    for name, (bus, bit) in GATES.items():
        if name in three_gates:
            continue
        peripheral = chip.peripherals[name]
        register = f"{bus}ENR"
        poke(chip.rcc, register, peek(chip.rcc, register) & ~(1 << bit))
        assert not peripheral.clocked, name
        poke(chip.rcc, register, peek(chip.rcc, register) | 1 << bit)
        assert peripheral.clocked, name


def test_what_is_absent_says_so_at_the_first_touch(nucleo):
    machine = nucleo()
    for name in ("SAI1", "CAN1", "ETH", "USB_OTG_FS", "LTDC", "QUADSPI"):
        peripheral = machine.chip.peripherals[name]
        assert all(register.fidelity is Fidelity.ABSENT for register in peripheral.registers.values()), name
        peripheral.read(min(peripheral.registers))
    touched = {note.where.rpartition("_")[0] for note in machine.notes.all if note.kind == "unmodelled"}
    assert touched == {"SAI1", "CAN1", "ETH", "USB_OTG_FS", "LTDC", "QUADSPI"}


def test_of_a_register_that_an_absent_block_does_not_list_only_that_is_said(nucleo):
    """DIEPCTL1 of USB is there on silicon (RM0410, OTG_DIEPCTLx), one set of registers for each endpoint."""
    machine = nucleo()
    usb = machine.chip.peripherals["USB_OTG_FS"]
    usb.write(0x920, 1)
    assert usb.read(0x920) == 0
    (note,) = machine.notes.all
    assert (note.kind, note.where) == ("unmodelled", "USB_OTG_FS_0x920")
    assert note.text.startswith("USB_OTG_FS is not modelled")


def test_resets_that_drivers_wait_for_end_at_once(nucleo):
    chip = nucleo().chip
    poke(chip.peripherals["ETH"], "DMABMR", 0x2_0101)
    assert not peek(chip.peripherals["ETH"], "DMABMR") & 1
    poke(chip.peripherals["ETH"], "MACMIIAR", 2 << 6 | 4 << 2 | 1)  # a PHY's register 2
    assert not peek(chip.peripherals["ETH"], "MACMIIAR") & 1
    assert peek(chip.peripherals["ETH"], "MACMIIDR") == 0xFFFF  # nobody pulls MDIO down
    poke(chip.peripherals["USB_OTG_FS"], "GRSTCTL", 1)
    assert peek(chip.peripherals["USB_OTG_FS"], "GRSTCTL") == 0x8000_0000


def test_exti_lines_have_the_ports_that_syscfg_chooses(nucleo):
    machine = nucleo()
    chip = machine.chip
    poke(chip.rcc, "APB2ENR", 1 << 14)
    for port in "ABCDEFG":
        poke(chip.peripherals["SYSCFG"], "EXTICR4", ("ABCDEFGHIJK".index(port)) << 8)
        assert chip.signals.route_of("EXTI14") == f"P{port}14"
    poke(chip.peripherals["SYSCFG"], "EXTICR4", 0xF << 8)
    assert chip.signals.route_of("EXTI14") is None
    poke(chip.peripherals["SYSCFG"], "EXTICR3", 10)
    assert chip.signals.route_of("EXTI8") is None, "port K has 8 pins"


def test_the_wake_up_pins_of_the_package(nucleo):
    signals = nucleo().chip.signals
    assert [signals.route_of(f"WKUP{number}") for number in range(1, 5)] == ["PA0", "PA2", "PC1", "PC13"]


def test_a_reset_leaves_the_backup_domain_and_the_causes(nucleo):
    machine = nucleo()
    chip = machine.chip
    poke(chip.rcc, "APB1ENR", 1 << 28)
    poke(chip.pwr, "CR1", 0xC100)
    poke(chip.rcc, "BDCR", 0x8100)
    machine.reset("PIN")
    machine.run_to(20_000)
    assert peek(chip.rcc, "BDCR") & 0x8100 == 0x8100
    assert peek(chip.rcc, "CSR") >> 24 == 0x0E
    machine.reset("POR")
    machine.run_to(30_000)
    assert peek(chip.rcc, "BDCR") == 0


def test_a_smaller_flash():
    board = dataclasses.replace(BOARD, chip="STM32F767ZG")
    machine = Machine(board, image((FLASH, program())))
    assert len(machine.chip.flash.memory) == 1 << 20
    assert machine.bus.read(0x1FF0_F442, 2) == 1024
    with pytest.raises(BusFault):
        machine.bus.read(FLASH + (1 << 20), 4)


def test_the_crc_unit_takes_bytes_as_bytes(nucleo):
    machine = nucleo()
    poke(machine.chip.rcc, "AHB1ENR", 1 << 12)
    for byte in b"123456789":
        machine.bus.write(0x4002_3000, 1, byte)
    assert machine.bus.read(0x4002_3000, 4) == 0x0376_E6E7, "CRC-32/MPEG-2"


def test_random_numbers_take_the_48_mhz_clock(nucleo):
    machine = nucleo()
    rcc, rng = machine.chip.rcc, machine.chip.peripherals["RNG"]
    poke(rcc, "AHB2ENR", 1 << 6)
    poke(rng, "CR", 1 << 2)
    machine.run_to(2_000_000)
    assert not peek(rng, "SR") & 1, "the PLL is off"
    poke(rcc, "PLLCFGR", 16 | 192 << 6 | 4 << 24)
    poke(rcc, "CR", peek(rcc, "CR") | 1 << 24)
    machine.run_to(4_000_000)
    assert machine.chip.services.clocks.kernel("RNG") != 0
    assert peek(rng, "SR") & 1
    assert peek(rng, "DR") != 0


def test_the_rtc_runs_on_the_crystal_and_wakes_by_its_line(nucleo):
    machine = nucleo()
    chip = machine.chip
    rcc, pwr, rtc = chip.rcc, chip.pwr, chip.peripherals["RTC"]
    poke(rcc, "APB1ENR", 1 << 28 | 1 << 10)
    poke(pwr, "CR1", 0xC100)
    poke(rcc, "BDCR", 1)
    machine.run_to(2_100_000_000)
    poke(rcc, "BDCR", 1 | 0x100 | 1 << 15)
    poke(chip.exti, "IMR", 1 << 22)
    poke(chip.exti, "RTSR", 1 << 22)
    for key in (0xCA, 0x53):
        poke(rtc, "WPR", key)
    poke(rtc, "WUTR", 0)
    poke(rtc, "CR", 1 << 14 | 1 << 10 | 0b100)
    machine.run_to(2_900_000_000)
    assert not peek(chip.exti, "PR")
    machine.run_to(3_200_000_000)
    assert peek(chip.exti, "PR") == 1 << 22, "a second of the crystal later"
    assert peek(rtc, "TR") & 0xF in (1, 2)
    assert not chip.standby_may_end()
    poke(pwr, "CSR1", 1 << 8)
    assert chip.standby_may_end()


def test_the_rtc_stands_still_without_its_crystal():
    machine = Machine(dataclasses.replace(BOARD, lse_hz=None), image((FLASH, program())))
    machine.run_to(10_000)
    chip = machine.chip
    poke(chip.rcc, "APB1ENR", 1 << 28 | 1 << 10)
    poke(chip.pwr, "CR1", 0xC100)
    poke(chip.rcc, "BDCR", 1 | 0x100 | 1 << 15)
    machine.run_to(5_000_000_000)
    assert (peek(chip.peripherals["RTC"], "TR"), peek(chip.peripherals["RTC"], "DR")) == (0, 0x2101)
    poke(chip.rcc, "BDCR", 1 << 16)
    poke(chip.rcc, "BDCR", 0x200 | 1 << 15)
    poke(chip.rcc, "CSR", 1)
    machine.run_to(12_000_000_000)
    assert peek(chip.peripherals["RTC"], "TR") & 0xF == 6, "LSI, 32 kHz behind the prescalers for 32.768"


# ldr r0, =0x100; ldr r1, FIRST; ldr r2, =0x47704770; str r1, [r0]; str r2, [r0, #4]; dsb; isb; adds r3, r0, #1;
# movs r4, #1; blx r3; ldr r1, SECOND; str r1, [r0]; dsb; isb; blx r3; movs r0, #0x18; ldr r1, =0x20026; bkpt 0xab
CODE_THAT_CHANGES = """
4ff480700c490a4a01604260bff34f8fbff36f8f431c0124984708490160bff3
4f8fbff36f8f984718200249abbe00bf7047704726000200
"""


def test_code_that_changes_in_the_ram_of_the_core_takes_what_it_takes():
    """It stores an instruction and a return at 0x100, calls it, stores another one there, calls that, and ends."""
    code = bytes.fromhex(CODE_THAT_CHANGES)
    division, nothing = 0xF4F4_FBB4, 0x8000_F3AF

    def cycles(first, second):
        words = struct.pack("<II", first, second)
        machine = Machine(BOARD, image((FLASH, program(code + words))), timing="table")
        machine.run_to(1_000_000)
        return machine.ended.cycle

    assert (
        cycles(division, division) > cycles(nothing, division) == cycles(division, nothing) > cycles(nothing, nothing)
    )


def test_both_clock_outputs_at_their_pins(nucleo):
    """From the reset on HSI and SYSCLK, without a prescaler."""
    machine = nucleo()
    bus, pins = machine.bus, machine.chip.pins
    bus.write(0x4002_3830, 4, 0b101)  # RCC_AHB1ENR
    bus.write(0x4002_0000, 4, 0xA802_0000)  # GPIOA_MODER: PA8 and the debug pins
    bus.write(0x4002_0800, 4, 2 << 18)  # GPIOC_MODER: PC9
    assert {name: pins[name].wave.hz for name in ("PA8", "PC9")} == {"PA8": 16_000_000, "PC9": 16_000_000}
    bus.write(0x4002_3808, 4, 7 << 24 | 4 << 27)
    assert [pins[name].wave.hz for name in ("PA8", "PC9")] == [3_200_000, 8_000_000]
