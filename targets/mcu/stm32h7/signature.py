"""System memory of the STM32H743 and H753: a boot loader that is not there, the electronic signature (RM0433)."""

from __future__ import annotations

import struct

from targets.mcu.stm32.adc16 import Inside
from targets.mcu.stm32.adc_format import code

__all__ = ["SYSTEM_MEMORY_BASE", "diagnose", "system_memory"]

SYSTEM_MEMORY_BASE = 0x1FF0_0000
SIZE = 0x2_0000
SIGNATURE_AT, UNIQUE_ID_AT, FLASH_SIZE_AT = 0x1_E000, 0x1_E800, 0x1_E880
CALIBRATION_AT = (0x1_E820, 0x1_E840, 0x1_E860)

# What a program finds that starts the boot loader as its vectors say: permanently undefined instructions (choice).
ENTRY = SYSTEM_MEMORY_BASE + 0x2A1
STACK = 0x2400_2000
UNDEFINED = b"\x00\xde"


def system_memory(flash_kb: int, identity: bytes) -> bytearray:
    """Return the 128 KB of system memory of a chip.

    Args:
        flash_kb: kilobytes of flash, at 0x1FF1E880.
        identity: twelve bytes, at 0x1FF1E800.
    """
    memory = bytearray(UNDEFINED * (SIGNATURE_AT // 2)) + bytearray(b"\xff" * (SIZE - SIGNATURE_AT))
    memory[:8] = struct.pack("<II", STACK, ENTRY)
    memory[UNIQUE_ID_AT : UNIQUE_ID_AT + 12] = identity
    memory[FLASH_SIZE_AT : FLASH_SIZE_AT + 2] = flash_kb.to_bytes(2, "little")
    for offset, value in _calibration().items():
        memory[offset : offset + 2] = value.to_bytes(2, "little")
    return memory


def _calibration() -> dict[int, int]:
    """Return TS_CAL1, TS_CAL2 and VREFINT_CAL: 16-bit codes at 3.3 V, at 30 and at 110 degrees (DS12117).

    Choice: as they are where the typical figures of the data sheet are exact.
    """
    inside = Inside()
    volts = (inside.sensor_volts(30.0), inside.sensor_volts(110.0), inside.vrefint_volts)
    return {offset: code(one, 3.3, 16) for offset, one in zip(CALIBRATION_AT, volts, strict=True)}


def diagnose(pc: int) -> str | None:
    """Return what is to be said when the program executes at `pc`, or None if that is not in system memory."""
    if SYSTEM_MEMORY_BASE <= pc < SYSTEM_MEMORY_BASE + SIGNATURE_AT:
        return "the program jumped to the boot loader in system memory, which is not modelled"
    return None
