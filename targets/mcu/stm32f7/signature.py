"""System memory of the STM32F76x: a boot loader that is not there, OTP, the electronic signature (RM0410)."""

from __future__ import annotations

import struct

from targets.mcu.stm32.adc import Internal
from targets.mcu.stm32.adc_format import code

__all__ = ["SYSTEM_MEMORY_BASE", "SYSTEM_MEMORY_ITCM", "diagnose", "system_memory"]

SYSTEM_MEMORY_BASE, SYSTEM_MEMORY_ITCM = 0x1FF0_0000, 0x0010_0000
SIZE = 0x1_0000
OTP_AT, UNIQUE_ID_AT, FLASH_SIZE_AT, CALIBRATION_AT, PACKAGE_AT = 0xF000, 0xF420, 0xF442, 0xF44A, 0xF7E0
LQFP144 = 0b110  # PKG, bits 10 to 8, assumed

# What a program finds that starts the boot loader as its vectors say: permanently undefined instructions (choice).
ENTRY = SYSTEM_MEMORY_BASE + 0x21
STACK = 0x2000_0800
UNDEFINED = b"\x00\xde"


def system_memory(flash_kb: int, identity: bytes) -> bytearray:
    """Return the 64 KB of system memory of a chip.

    Args:
        flash_kb: kilobytes of flash, at 0x1FF0F442.
        identity: twelve bytes, at 0x1FF0F420.
    """
    memory = bytearray(UNDEFINED * (OTP_AT // 2)) + bytearray(b"\xff" * (SIZE - OTP_AT))
    memory[:8] = struct.pack("<II", STACK, ENTRY)
    memory[UNIQUE_ID_AT : UNIQUE_ID_AT + 12] = identity
    memory[FLASH_SIZE_AT : FLASH_SIZE_AT + 2] = flash_kb.to_bytes(2, "little")
    memory[CALIBRATION_AT : CALIBRATION_AT + 6] = _calibration()
    memory[PACKAGE_AT : PACKAGE_AT + 2] = (LQFP144 << 8).to_bytes(2, "little")
    return memory


def _calibration() -> bytes:
    """Return VREFINT_CAL, TS_CAL1 and TS_CAL2: 12-bit codes at 3.3 V, at 30 and at 110 degrees (DS11532).

    Choice: as they are where the typical figures of the data sheet are exact.
    """
    inside = Internal()
    volts = (inside.vrefint_volts, inside.sensor_volts(30.0), inside.sensor_volts(110.0))
    return struct.pack("<HHH", *(code(one, 3.3, 12) for one in volts))


def diagnose(pc: int) -> str | None:
    """Return what is to be said when the program executes at `pc`, or None if that is not in system memory."""
    if any(base <= pc < base + OTP_AT for base in (SYSTEM_MEMORY_BASE, SYSTEM_MEMORY_ITCM)):
        return "the program jumped to the boot loader in system memory, which is not modelled"
    return None
