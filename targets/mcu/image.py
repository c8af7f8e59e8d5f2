"""Firmware as it would be flashed: ELF, Intel HEX or raw BIN, read, placed and checked before anything runs.

An image that does not begin at the first address of flash is taken to stand behind a boot loader which is not part of
it; the chip then starts from the image's own vector table, as it would after the boot loader has jumped to it.
"""

from __future__ import annotations

import hashlib
import io
import re
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from targets.mcu.chip_limits import FLASH_BASE, RAM_BASE, ChipLimits, fitting, limits_for, limits_of
from targets.mcu.elf import read_elf
from targets.mcu.errors import ImageError
from targets.mcu.symbols import NO_SYMBOLS, Symbols

__all__ = ["ChipLimits", "Image", "Segment", "limits_for", "limits_of", "load_image"]

# Symbols at the vector table, in the start-up files of ST, libopencm3, CMSIS, Arduino, ChibiOS, NuttX, Zephyr, IAR.
TABLE_NAMES = (
    "g_pfnVectors",
    "vector_table",
    "__isr_vector",
    "__Vectors",
    "__vector_table",
    "_vector_table",
    "__stm32_vector_table",
    "_vectors",
    "__vectors",
    "vectors",
)
LOOP_FOREVER = b"\xfe\xe7"  # b .
_KEPT = 8
"""Images that are not taken apart again while the file is the same; every case of a check opens its own (choice)."""


@dataclass(frozen=True, slots=True)
class Segment:
    """Bytes at an address."""

    address: int
    data: bytes

    @property
    def end(self) -> int:
        """First address behind it."""
        return self.address + len(self.data)


@dataclass(frozen=True, slots=True, kw_only=True)
class Image:
    """Firmware that can run on the chip it was loaded for.

    Attributes:
        path: the file.
        format: ``elf``, ``hex`` or ``bin``.
        digest: SHA-256 of the file, in hexadecimal.
        segments: what goes where, by address: flash, option bytes, RAM.
        table: address of the vector table.
        stack_pointer: its first word.
        reset_vector: its second word, with the Thumb bit.
        flash_bytes: bytes of flash that the image fills.
        ram_bytes: bytes of RAM that the program takes for itself, as far as the file says; 0 for HEX and BIN.
        symbols: names and source lines; none for HEX and BIN.
        notes: what a user should know, in sentences.
    """

    path: Path
    format: str
    digest: str
    segments: tuple[Segment, ...]
    table: int
    stack_pointer: int
    reset_vector: int
    flash_bytes: int
    ram_bytes: int
    symbols: Symbols
    notes: tuple[str, ...]

    def function_at(self, pc: int) -> str | None:
        """Return the name of the function that holds `pc`, or None."""
        if not any(segment.address <= pc < segment.end for segment in self.segments):
            return None
        return self.symbols.function_at(pc)

    def line_at(self, pc: int) -> str | None:
        """Return ``file.c:42`` for `pc`, or None."""
        return self.symbols.line_at(pc)


@dataclass(slots=True)
class _Contents:
    """What a file holds, before it was checked."""

    format: str
    segments: list[Segment]
    occupied: Sequence[tuple[int, int]] = ()
    symbols: Symbols = NO_SYMBOLS
    notes: list[str] | None = None


def load_image(path: str | Path, chip: ChipLimits, *, base: int | None = None) -> Image:
    """Read firmware and check that `chip` can run it.

    Args:
        path: an ELF file, an Intel HEX file, or the raw bytes of flash.
        chip: what it is to run on.
        base: where raw bytes belong, if not at the beginning of flash or where they seem to have been linked for.

    Raises:
        ImageError: it cannot be read, is damaged, or cannot run on this chip.
    """
    path = Path(path)
    return _image(path, _read(path), chip, base)


@lru_cache(maxsize=_KEPT)
def _image(path: Path, data: bytes, chip: ChipLimits, base: int | None) -> Image:
    where = str(path)
    contents = _take_apart(data, where, chip, base)
    notes = list(contents.notes or ())
    _check_places(contents, where, chip, notes)
    table = _find_table(contents, where, chip, notes)
    stack_pointer, reset_vector = _check_table(contents.segments, table, where, chip)
    return Image(
        path=path,
        format=contents.format,
        digest=hashlib.sha256(data).hexdigest(),
        segments=tuple(sorted(contents.segments, key=lambda segment: segment.address)),
        table=table,
        stack_pointer=stack_pointer,
        reset_vector=reset_vector,
        flash_bytes=sum(len(one.data) for one in contents.segments if chip.in_flash(one.address)),
        ram_bytes=sum(size for address, size in contents.occupied if chip.in_ram(address)),
        symbols=contents.symbols,
        notes=tuple(notes),
    )


# --- reading


def _read(path: Path) -> bytes:
    where = str(path)
    if path.is_dir():
        raise ImageError("a directory, not an image", where=where, hint="name the ELF, HEX or BIN file in it")
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise ImageError("no such file", where=where, hint="build the firmware first, or check the path") from None
    except OSError as error:
        raise ImageError(f"cannot be read: {error.strerror}", where=where, hint="check its permissions") from error
    if not data:
        raise ImageError("the file is empty", where=where, hint="build or copy it again")
    return data


def _take_apart(data: bytes, where: str, chip: ChipLimits, base: int | None) -> _Contents:
    if data.startswith(b"\x7fELF"):
        elf = read_elf(data, where, chip.cpu)
        segments = [Segment(address, piece) for address, piece in elf.segments]
        return _Contents("elf", segments, elf.occupied, elf.symbols, list(elf.notes))
    if data.lstrip().startswith(b":"):
        return _Contents("hex", _read_hex(data, where))
    for magic, name in ((b"UF2\n", "UF2"), (b"S0", "Motorola S-record"), (b"DfuSe", "DfuSe"), (b"PK\x03\x04", "ZIP")):
        if data.startswith(magic):
            raise ImageError(f"a {name} file", where=where, hint="ELF, Intel HEX and raw BIN can be loaded")
    if len(data) < 8:
        raise ImageError(f"truncated: {len(data)} bytes hold no vector table", where=where, hint="build it again")
    return _read_bin(data, chip, base)


_HEX_END = re.compile(r"^:00[0-9A-Fa-f]{4}01[0-9A-Fa-f]{2}\s*$", re.MULTILINE)
_HEX_START = re.compile(r"^:04[0-9A-Fa-f]{4}0[35][0-9A-Fa-f]{10}", re.MULTILINE)


def _read_hex(data: bytes, where: str) -> list[Segment]:
    from intelhex import IntelHex, IntelHexError

    hint = "the file is truncated or damaged: build or copy it again"
    try:
        text = data.decode("ascii")
        # Two files that were joined have two start addresses, which nobody asks for: the vectors say where to start.
        parsed = IntelHex(io.StringIO(_HEX_START.sub("", text)))
    except UnicodeDecodeError:
        raise ImageError("an Intel HEX file with bytes that are not text", where=where, hint=hint) from None
    except (IntelHexError, ValueError) as error:
        raise ImageError(f"a bad Intel HEX file: {error}", where=where, hint=hint) from error
    end = _HEX_END.search(text)
    if not end:
        raise ImageError("an Intel HEX file without its end record", where=where, hint=hint)
    if ":" in text[end.end() :]:
        hint = "if two files were joined, leave out the end record of the first, or join them with srec_cat"
        raise ImageError("an Intel HEX file that goes on after its end record", where=where, hint=hint)
    segments = [Segment(start, parsed.tobinstr(start, end - 1)) for start, end in parsed.segments()]
    if not segments:
        raise ImageError("an Intel HEX file without data", where=where, hint=hint)
    return segments


def _read_bin(data: bytes, chip: ChipLimits, base: int | None) -> _Contents:
    notes = []
    if base is None:
        base = _guess_base(data, chip)
        if base != FLASH_BASE:
            notes.append(f"the raw bytes were linked for 0x{base:08X}, judging by their vectors, and are put there")
    return _Contents("bin", [Segment(base, data)], notes=notes)


def _guess_base(data: bytes, chip: ChipLimits) -> int:
    """Return where raw bytes were linked for, judging by their vectors; where they tell nothing, the base of flash.

    All handlers must lie inside the bytes. If that leaves several places, one of the handlers must be `b .`, as default
    handlers mostly are.
    """
    vectors = struct.unpack_from(f"<{min(len(data) // 4, chip.table_words)}I", data)[1:]
    for start in chip.flash_bases:
        handlers = {vector - 1 for vector in vectors if vector & 1 and start < vector < start + chip.flash_size}
        candidates = (start, *(start + size for size in chip.boot_loader_sizes))
        possible = [one for one in candidates if handlers and one < min(handlers) and max(handlers) < one + len(data)]
        if len(possible) == 1:
            return possible[0]
        for base in possible:
            if any(data.startswith(LOOP_FOREVER, handler - base) for handler in handlers):
                return base
    return FLASH_BASE


# --- checking


def _fitting(chip: ChipLimits, flash: int, ram: int) -> str:
    found = fitting(chip, flash, ram)
    if found is None:
        return f"no {chip.series} is that large"
    flash_kb, ram_kb = found.flash_bytes // 1024, found.ram_bytes // 1024
    text = f"it would fit an {found.name} ({flash_kb} KB of flash, {ram_kb} KB of RAM)"
    return text if found.name.startswith(chip.series) else f"no {chip.series} is that large; {text}"


def _check_places(contents: _Contents, where: str, chip: ChipLimits, notes: list[str]) -> None:
    for segment in contents.segments:
        if chip.in_flash(segment.address):
            needed = chip.home(segment.address) + len(segment.data) - FLASH_BASE
            if needed > chip.flash_size:
                text = f"too large: reaches {needed} bytes into flash, {chip.name} has {chip.flash_size}"
                raise ImageError(text, where=where, hint=_fitting(chip, needed, 0))
        elif chip.in_ram(segment.address):
            _check_ram(segment.address, len(segment.data), where, chip)
            notes.append(f"{len(segment.data)} bytes are put into RAM at 0x{segment.address:08X}; power-off loses them")
        elif not chip.in_options(segment.address, segment.end):
            text = f"has data at 0x{segment.address:08X}, where {chip.name} has no memory to program"
            raise ImageError(text, where=where, hint="flash is at 0x08000000: check the linker script")
    for address, size in contents.occupied:
        if chip.in_ram(address):
            _check_ram(address, size, where, chip)


def _check_ram(address: int, size: int, where: str, chip: ChipLimits) -> None:
    if address < RAM_BASE:
        if address + size > chip.itcm_size:
            text = f"needs {address + size} bytes of RAM from 0 on, {chip.name} has {chip.itcm_size}"
            raise ImageError(text, where=where, hint="flash is at 0x08000000: check the linker script")
        return
    part = chip.ram_at(address)
    if part is not None:
        needed = address + size - part[0]
        if needed > part[1]:
            text = f"needs {needed} bytes of RAM from 0x{part[0]:08X} on, {chip.name} has {part[1]}"
            raise ImageError(text, where=where, hint="put some of its data elsewhere in the linker script")
        return
    needed = address + size - RAM_BASE
    if needed > chip.ram_size:
        text = f"needs {needed} bytes of RAM, {chip.name} has {chip.ram_size}"
        fits = fitting(chip, 0, needed)
        hint = _fitting(chip, 0, needed) if fits else f"no RAM is at 0x{address:08X}: check the linker script"
        raise ImageError(text, where=where, hint=hint)


def _find_table(contents: _Contents, where: str, chip: ChipLimits, notes: list[str]) -> int:
    in_flash = [segment.address for segment in contents.segments if chip.in_flash(segment.address)]
    if not in_flash:
        raise ImageError(
            "linked to run from RAM: nothing of it is in flash", where=where, hint="link it for 0x08000000"
        )
    lowest = min(in_flash, key=chip.home)
    if chip.home(lowest) == FLASH_BASE:
        return FLASH_BASE  # this is where the chip looks, whatever else the image has
    named = (contents.symbols.find(name) for name in TABLE_NAMES)
    table = next((symbol.address for symbol in named if symbol is not None and chip.in_flash(symbol.address)), lowest)
    notes.append(
        f"the image stands behind a boot loader that is not part of it: the chip starts from the vector table at "
        f"0x{table:08X}"
    )
    return table


def _bytes_at(segments: list[Segment], address: int, size: int, chip: ChipLimits) -> bytes | None:
    for segment in segments:
        offset = chip.home(address) - chip.home(segment.address)
        if offset >= 0 and offset + size <= len(segment.data):
            return segment.data[offset : offset + size]
    return None


def _check_table(segments: list[Segment], table: int, where: str, chip: ChipLimits) -> tuple[int, int]:
    words = _bytes_at(segments, table, 8, chip)
    if words is None:
        raise ImageError(f"has no vector table at 0x{table:08X}", where=where, hint="check the linker script")
    stack_pointer, reset_vector = struct.unpack("<II", words)
    if 0xFFFF_FFFF in (stack_pointer, reset_vector):
        text = f"the vector table at 0x{table:08X} is erased (0xFFFFFFFF)"
        raise ImageError(text, where=where, hint="was the start-up file linked, and its section kept?")
    _check_stack_pointer(stack_pointer, where, chip)
    _check_reset_vector(segments, reset_vector, where, chip)
    return stack_pointer, reset_vector


def _check_stack_pointer(stack_pointer: int, where: str, chip: ChipLimits) -> None:
    text = f"the initial stack pointer 0x{stack_pointer:08X} "
    if stack_pointer & 3:
        raise ImageError(text + "is not a multiple of 4", where=where, hint="is this an image for a Cortex-M?")
    elsewhere = chip.ram_at(stack_pointer - 4) is not None
    if not (elsewhere or RAM_BASE < stack_pointer <= chip.ram_end or 0 < stack_pointer <= chip.itcm_size):
        needed = stack_pointer - RAM_BASE
        near = needed > 0 and fitting(chip, 0, needed)
        hint = _fitting(chip, 0, needed) if near else "is this an image for a Cortex-M, and from its first byte on?"
        raise ImageError(
            text + f"is outside the RAM of {chip.name} (0x{RAM_BASE:08X} to 0x{chip.ram_end:08X})",
            where=where,
            hint=hint,
        )


def _check_reset_vector(segments: list[Segment], reset_vector: int, where: str, chip: ChipLimits) -> None:
    text = f"the reset vector 0x{reset_vector:08X} "
    if not FLASH_BASE <= chip.home(reset_vector) < chip.flash_end:
        ours = f"is this an image for an {chip.series[:7]}?"
        hint = "link it for flash at 0x08000000" if reset_vector >= RAM_BASE else ours
        raise ImageError(text + f"is not in the flash of {chip.name}", where=where, hint=hint)
    if not reset_vector & 1:
        raise ImageError(text + "has no Thumb bit", where=where, hint="declare the handler as a function (.thumb_func)")
    code = _bytes_at(segments, reset_vector - 1, 2, chip)
    if code is None or code == b"\xff\xff":
        hint = "is the file truncated? raw bytes that were linked for another address need that as base"
        raise ImageError(text + "points to erased flash", where=where, hint=hint)
