"""What is not modelled: every register with its reset value (RM0008), and a note for whoever touches it."""

from __future__ import annotations

import pytest

from targets.mcu.fidelity import Fidelity
from targets.mcu.stm32.unique_id import unique_id
from targets.mcu.stm32f1.absent import absent_peripherals
from targets.mcu.stm32f1.dbgmcu import Dbgmcu
from targets.mcu.stm32f1.signature import diagnose, system_memory
from targets.mcu.testing import FakeChip, peek, poke

# Registers whose reset value is not 0, by the kind of peripheral; RM0008.
RESET_VALUES = {
    "CAN": {"MCR": 0x0001_0002, "MSR": 0xC02, "TSR": 0x1C00_0000, "BTR": 0x0123_0000, "FMR": 0x2A1C_0E01},
    "USB": {"CNTR": 3},
}
COUNTS = {"CAN": 8 + 12 + 8 + 5 + 28, "USB": 13}


@pytest.fixture
def chip():
    return FakeChip()


@pytest.fixture
def parts(chip):
    return {part.name: part for part in absent_peripherals(chip.services)}


def test_everything_is_there(parts):
    assert {name: part.base for name, part in parts.items()} == {
        "USB": 0x4000_5C00,
        "USB_SRAM": 0x4000_6000,
        "CAN": 0x4000_6400,
    }


def test_reset_values_and_fidelity_of_every_register(parts):
    for name, part in parts.items():
        if name == "USB_SRAM":
            continue
        registers = part.registers.values()
        assert len(part.registers) == COUNTS[name], name
        assert all(register.fidelity is Fidelity.ABSENT and register.note for register in registers)
        values = {register.name: peek(part, register.name) for register in registers}
        expected = dict.fromkeys(values, 0) | RESET_VALUES[name]
        assert values == expected, name


def test_the_first_touch_of_a_register_is_noted(chip, parts):
    peek(parts["CAN"], "MSR")
    peek(parts["CAN"], "MSR")
    poke(parts["CAN"], "BTR", 1)
    poke(parts["USB"], "EP0R", 0)
    assert chip.noted("unmodelled") == ["CAN_MSR", "CAN_BTR", "USB_EP0R"]


def test_can_enters_and_leaves_its_modes_at_once(parts):
    can = parts["CAN"]
    poke(can, "MCR", 0x0001_0001)
    assert peek(can, "MSR") & 3 == 1
    poke(can, "MCR", 0x0001_0000)
    assert peek(can, "MSR") & 3 == 0
    poke(can, "MCR", 0x0001_0002)
    assert peek(can, "MSR") & 3 == 2
    poke(can, "MCR", 0x0001_8000)
    assert peek(can, "MCR") == 0x0001_0002


def test_can_messages_wait_until_they_are_aborted(parts):
    can = parts["CAN"]
    poke(can, "TI1R", 0x1234_0001)
    assert peek(can, "TSR") == 0x1400_0000
    assert peek(can, "TI1R") == 0x1234_0001
    poke(can, "TSR", 0x8000)
    assert peek(can, "TSR") == 0x1C00_0100
    assert peek(can, "TI1R") == 0x1234_0000
    poke(can, "TSR", 0x0100)
    assert peek(can, "TSR") == 0x1C00_0000


def test_usb_endpoint_bits_toggle(parts):
    usb = parts["USB"]
    poke(usb, "EP1R", 0x3221)
    assert peek(usb, "EP1R") == 0x3221
    poke(usb, "EP1R", 0x1011)
    assert peek(usb, "EP1R") == 0x2031
    poke(usb, "EP1R", 0x8080)
    assert peek(usb, "EP1R") == 0x2030


def test_usb_memory_has_half_words_at_every_fourth_address(parts):
    memory = parts["USB_SRAM"]
    memory.write(0x3FC, 0xABCD_1234)
    assert memory.read(0x3FC) == 0x1234
    assert memory.read(0x3F8) == 0


# --- DBGMCU, system memory


def test_dbgmcu(chip):
    dbgmcu = Dbgmcu(0xE004_2000, chip.services)
    assert peek(dbgmcu, "IDCODE") == 0x2003_6410
    poke(dbgmcu, "IDCODE", 0)
    poke(dbgmcu, "CR", 0x300)
    dbgmcu.reset()
    assert peek(dbgmcu, "CR") == 0x300
    dbgmcu.power_on()
    assert peek(dbgmcu, "CR") == 0
    assert chip.noted() == ["DBGMCU_IDCODE"]


def test_system_memory():
    identity = unique_id("left")
    memory = system_memory(64, identity)
    assert len(memory) == 0x800
    assert memory[0x7E0:0x7E2] == b"\x40\0"
    assert memory[0x7E8:0x7F4] == identity
    assert unique_id("right") != identity == unique_id("left")
    assert diagnose(int.from_bytes(memory[4:8], "little"))
    assert diagnose(0x0800_0100) is None
