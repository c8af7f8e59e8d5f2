"""System memory: the electronic signature, and a boot loader that is not there (RM0008 sections 3.4 and 30)."""

from __future__ import annotations

import struct

__all__ = ["SYSTEM_MEMORY_BASE", "SYSTEM_MEMORY_SIZE", "diagnose", "system_memory"]

SYSTEM_MEMORY_BASE = 0x1FFF_F000
SYSTEM_MEMORY_SIZE = 0x800
FLASH_SIZE_AT, UNIQUE_ID_AT = 0x7E0, 0x7E8

# What a program finds that starts the boot loader as its vectors say: permanently undefined instructions (choice).
ENTRY = SYSTEM_MEMORY_BASE + 0x21
STACK = 0x2000_0200
UNDEFINED = b"\x00\xde"


def system_memory(flash_kb: int, identity: bytes) -> bytearray:
    """Return the 2 KB of system memory of a chip.

    Args:
        flash_kb: kilobytes of flash, at 0x1FFFF7E0.
        identity: twelve bytes, at 0x1FFFF7E8.
    """
    memory = bytearray(UNDEFINED * (SYSTEM_MEMORY_SIZE // 2))
    memory[:8] = struct.pack("<II", STACK, ENTRY)
    memory[FLASH_SIZE_AT:] = b"\xff" * (SYSTEM_MEMORY_SIZE - FLASH_SIZE_AT)
    memory[FLASH_SIZE_AT : FLASH_SIZE_AT + 2] = flash_kb.to_bytes(2, "little")
    memory[UNIQUE_ID_AT : UNIQUE_ID_AT + 12] = identity
    return memory


def diagnose(pc: int) -> str | None:
    """Return what is to be said when the program executes at `pc`, or None if that is not in system memory."""
    if SYSTEM_MEMORY_BASE <= pc < SYSTEM_MEMORY_BASE + SYSTEM_MEMORY_SIZE:
        return "the program jumped to the boot loader in system memory, which is not modelled"
    return None
