"""Images of a few instructions, made on the spot, and a board that runs one."""

from __future__ import annotations

import struct
from pathlib import Path

from targets.mcu.image import Image, Segment
from targets.mcu.machine import Machine
from targets.mcu.symbols import NO_SYMBOLS

__all__ = ["FLASH", "HANG", "STACK", "image", "program", "start"]

FLASH = 0x0800_0000
STACK = 0x2002_0000
"""The end of a RAM, or within one, on both Nucleo-144."""

HANG = b"\xfe\xe7"


def image(*segments, table=FLASH):
    """Makes an image of segments, address and bytes."""
    parts = [Segment(address, data) for address, data in segments]
    return Image(
        path=Path("image"),
        format="bin",
        digest="",
        segments=tuple(parts),
        table=table,
        stack_pointer=STACK,
        reset_vector=table + 0x41,
        flash_bytes=0,
        ram_bytes=0,
        symbols=NO_SYMBOLS,
        notes=(),
    )


def program(code=HANG, base=FLASH):
    """Makes the bytes of a vector table and code behind it, at `base` + 0x40."""
    return struct.pack("<II", STACK, base + 0x41).ljust(0x40, b"\0") + code


def start(board, *segments, straps=None, table=FLASH, run_ns=10_000):
    """Runs an image on a board for a while; returns its machine. Without segments the program hangs."""
    machine = Machine(board, image(*(segments or ((FLASH, program()),)), table=table), straps=straps)
    machine.run_to(run_ns)
    return machine
