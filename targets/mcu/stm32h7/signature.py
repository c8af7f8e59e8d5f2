"""System memory of the STM32H743 and H753: a boot loader that is not there, the electronic signature (RM0433)."""

from __future__ import annotations

import struct

__all__ = ["SYSTEM_MEMORY_BASE", "diagnose", "system_memory"]

SYSTEM_MEMORY_BASE = 0x1FF0_0000
SIZE = 0x2_0000
SIGNATURE_AT, UNIQUE_ID_AT, CALIBRATION_AT, FLASH_SIZE_AT = 0x1_E000, 0x1_E800, 0x1_E820, 0x1_E880

# What a program finds that starts the boot loader as its vectors say: permanently undefined instructions (choice).
ENTRY = SYSTEM_MEMORY_BASE + 0x2A1
STACK = 0x2400_2000
UNDEFINED = b"\x00\xde"


def system_memory(flash_kb: int, identity: bytes, calibration: dict[int, int]) -> bytearray:
    """Return the 128 KB of system memory of a chip.

    Args:
        flash_kb: kilobytes of flash, at 0x1FF1E880.
        identity: twelve bytes, at 0x1FF1E800.
        calibration: half-words by address, such as TS_CAL1.
    """
    memory = bytearray(UNDEFINED * (SIGNATURE_AT // 2)) + bytearray(b"\xff" * (SIZE - SIGNATURE_AT))
    memory[:8] = struct.pack("<II", STACK, ENTRY)
    memory[UNIQUE_ID_AT : UNIQUE_ID_AT + 12] = identity
    memory[FLASH_SIZE_AT : FLASH_SIZE_AT + 2] = flash_kb.to_bytes(2, "little")
    for address, value in calibration.items():
        offset = address - SYSTEM_MEMORY_BASE
        memory[offset : offset + 2] = value.to_bytes(2, "little")
    return memory


def diagnose(pc: int) -> str | None:
    """Return what is to be said when the program executes at `pc`, or None if that is not in system memory."""
    if SYSTEM_MEMORY_BASE <= pc < SYSTEM_MEMORY_BASE + SIGNATURE_AT:
        return "the program jumped to the boot loader in system memory, which is not modelled"
    return None
