"""An ELF file for a Cortex-M, taken apart: what goes where, the symbols, and whether it is one at all."""

from __future__ import annotations

import io
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from targets.mcu.armv7e_m import first_beyond_armv7_m
from targets.mcu.errors import ImageError
from targets.mcu.symbols import Symbol, Symbols, damage

if TYPE_CHECKING:
    from elftools.elf.elffile import ELFFile

__all__ = ["ElfContents", "read_elf"]

MACHINES = {
    3: "x86",
    8: "MIPS",
    62: "x86-64",
    83: "AVR",
    94: "Xtensa",
    183: "64-bit ARM",
    243: "RISC-V",
}
EM_ARM = 40
ET_REL, ET_EXEC, ET_DYN, ET_CORE = 1, 2, 3, 4
TYPES = {ET_REL: "an object file that is not linked", ET_DYN: "a shared library", ET_CORE: "a core dump"}
PT_LOAD = 1
SHT_NOBITS, SHF_ALLOC = 8, 2

# Build attributes of the ARM ABI (ARM IHI0045, sections 2.3.5 and 2.4): values of Tag_CPU_arch beyond ARMv7-M.
MICROCONTROLLER = 0x4D
PROFILES = {0x41: "A (application)", 0x52: "R (real-time)"}
ARCHITECTURES = {"cortex-m3": 10, "cortex-m7": 13}
NEWER_ARCHITECTURES = {13: "ARMv7E-M (Cortex-M4, M7)", 16: "ARMv8-M baseline", 17: "ARMv8-M mainline"}


@dataclass(frozen=True, slots=True, kw_only=True)
class ElfContents:
    """What an ELF file says.

    Attributes:
        segments: (address where a programmer puts it, bytes).
        occupied: (first address, bytes) of memory that the program takes at run time.
        symbols: names and lines.
        notes: what is odd about it.
    """

    segments: tuple[tuple[int, bytes], ...]
    occupied: tuple[tuple[int, int], ...]
    symbols: Symbols
    notes: tuple[str, ...]


def read_elf(data: bytes, where: str, cpu: str = "cortex-m3") -> ElfContents:
    """Take an ELF file apart.

    Args:
        data: the whole file.
        where: its name, for errors.
        cpu: the core it is to run on, as a compiler calls it.

    Raises:
        ImageError: it is damaged, or not a linked program for a Cortex-M.
    """
    from elftools.elf.elffile import ELFFile

    _check_header(data, where, cpu)
    try:
        elf = ELFFile(io.BytesIO(data))
        notes = tuple(_check_attributes(elf, where, cpu))
        pieces = tuple(_pieces(elf))
        occupied = tuple(
            (segment["p_vaddr"], segment["p_memsz"])
            for segment in elf.iter_segments()
            if segment["p_type"] == "PT_LOAD" and segment["p_memsz"]
        )
        symbols = Symbols(_symbols(elf), data)
    except damage() as error:
        raise ImageError(
            f"the ELF file is damaged: {str(error) or type(error).__name__}", where=where, hint="build it again"
        ) from error
    if not pieces:
        raise ImageError("the ELF file has nothing to load", where=where, hint="was it linked, and not stripped bare?")
    return ElfContents(segments=pieces, occupied=occupied, symbols=symbols, notes=notes)


def _check_header(data: bytes, where: str, cpu: str) -> None:
    if len(data) < 16:
        raise _truncated(where, len(data), 52)
    if data[4] != 1:
        raise ImageError("a 64-bit ELF file; this chip is a 32-bit ARM", where=where, hint="use the firmware's ELF")
    if data[5] != 1:
        raise ImageError(
            "a big-endian ELF file; this chip is little-endian", where=where, hint="build with -mlittle-endian"
        )
    if len(data) < 52:
        raise _truncated(where, len(data), 52)
    header = struct.unpack_from("<HHIIIIIHHHHHH", data, 16)
    kind, machine = header[0], header[1]
    if machine != EM_ARM:
        name = MACHINES.get(machine, f"machine {machine}")
        raise ImageError(
            f"built for {name}, not for ARM", where=where, hint=f"build it for {_called(cpu)} (-mcpu={cpu})"
        )
    if kind != ET_EXEC:
        raise ImageError(
            f"{TYPES.get(kind, f'an ELF file of type {kind}')}, not a program", where=where, hint="link it"
        )
    end = max(_ends(data, header), default=0)
    if end > len(data):
        raise _truncated(where, len(data), end)


def _ends(data: bytes, header: tuple[int, ...]) -> Iterator[int]:
    """Yield where each header, segment and section ends in the file, as far as the headers themselves are there."""
    _, _, _, _, phoff, shoff, _, _, phentsize, phnum, shentsize, shnum, _ = header
    tables = ((phoff, phentsize, phnum, "<IIIIIIII"), (shoff, shentsize, shnum, "<IIIIIIIIII"))
    for table, (offset, entry_size, count, layout) in enumerate(tables):
        yield offset + entry_size * count
        for index in range(count):
            at = offset + entry_size * index
            if at + struct.calcsize(layout) > len(data):
                return
            fields = struct.unpack_from(layout, data, at)
            if table == 0 and fields[0] == PT_LOAD:
                yield fields[1] + fields[4]
            if table == 1 and fields[1] not in (0, SHT_NOBITS):
                yield fields[4] + fields[5]


def _truncated(where: str, size: int, needed: int) -> ImageError:
    text = f"truncated: the file has {size} bytes, its headers speak of {needed}"
    return ImageError(text, where=where, hint="copy or build it again")


def _check_attributes(elf: ELFFile, where: str, cpu: str) -> Iterator[str]:
    attributes = _attributes(elf)
    profile = attributes.get("TAG_CPU_ARCH_PROFILE", 0)
    if profile in PROFILES:
        text = f"built for an ARM of profile {PROFILES[profile]}, not for a Cortex-M"
        raise ImageError(text, where=where, hint=f"build it for {_called(cpu)} (-mcpu={cpu} -mthumb)")
    entry = elf.header["e_entry"]
    # Without attributes the vectors decide: a chip does not know an entry point, and linker scripts forget ENTRY().
    if attributes and profile != MICROCONTROLLER and entry and not entry & 1:
        text = f"the entry point 0x{entry:08X} is ARM code; a Cortex-M executes Thumb only"
        raise ImageError(text, where=where, hint=f"build it for {_called(cpu)} (-mcpu={cpu} -mthumb)")
    architecture = attributes.get("TAG_CPU_ARCH", 0)
    if architecture in NEWER_ARCHITECTURES and architecture > ARCHITECTURES[cpu]:
        yield from _beyond(elf, NEWER_ARCHITECTURES[architecture], cpu)


def _beyond(elf: ELFFile, built_for: str, cpu: str) -> Iterator[str]:
    """Tell of an image that calls itself newer than its core; not if its code has nothing that the core lacks."""
    pieces = list(_thumb(elf)) if cpu == "cortex-m3" else []
    if not pieces:
        yield f"built for {built_for}: instructions that a {_called(cpu)} lacks will fault"
    for address, code in pieces:
        if (at := first_beyond_armv7_m(code)) is not None:
            yield f"built for {built_for}: a {_called(cpu)} lacks the instruction at 0x{address + at:08X}: it faults"
            return


def _thumb(elf: ELFFile) -> Iterator[tuple[int, bytes]]:
    """Yield (address, code) of each stretch between mapping symbols (ARM IHI0044, section 5.5.5: $t, $d)."""
    from elftools.elf.sections import SymbolTableSection

    table = elf.get_section_by_name(".symtab")
    marks: dict[int, list[tuple[int, bool]]] = {}
    for symbol in table.iter_symbols() if isinstance(table, SymbolTableSection) else ():
        if symbol.name[:2] in ("$t", "$d", "$a") and isinstance(symbol["st_shndx"], int):
            marks.setdefault(symbol["st_shndx"], []).append((symbol["st_value"], symbol.name[:2] == "$t"))
    for index, found in sorted(marks.items()):
        section = elf.get_section(index)
        base, data = section["sh_addr"], section.data()
        found.sort()
        for (begin, is_code), (end, _) in zip(found, [*found[1:], (base + len(data), False)], strict=True):
            if is_code:
                yield begin, data[begin - base : end - base]


def _called(cpu: str) -> str:
    return cpu.replace("cortex-m", "Cortex-M")


def _attributes(elf: ELFFile) -> dict[str, int]:
    section = elf.get_section_by_name(".ARM.attributes")
    found: dict[str, int] = {}
    if section is None or not hasattr(section, "iter_subsections"):
        return found
    for subsection in section.iter_subsections():
        for part in subsection.iter_subsubsections():
            for attribute in part.iter_attributes():
                if isinstance(attribute.value, int):
                    found[attribute.tag] = attribute.value
    return found


def _pieces(elf: ELFFile) -> Iterator[tuple[int, bytes]]:
    """Yield what is loaded, section by section as objcopy does: a segment may begin with headers of the file itself."""
    sections = [
        section
        for section in elf.iter_sections()
        if section["sh_flags"] & SHF_ALLOC
        and section["sh_type"] not in ("SHT_NOBITS", "SHT_NULL")
        and section["sh_size"]
    ]
    for segment in elf.iter_segments():
        if segment["p_type"] != "PT_LOAD" or not segment["p_filesz"]:
            continue
        start, end = segment["p_offset"], segment["p_offset"] + segment["p_filesz"]
        inside = [one for one in sections if start <= one["sh_offset"] and one["sh_offset"] + one["sh_size"] <= end]
        for section in inside:
            yield segment["p_paddr"] + section["sh_offset"] - start, section.data()
        if not inside:
            yield segment["p_paddr"], segment.data()


def _symbols(elf: ELFFile) -> Iterator[Symbol]:
    table = elf.get_section_by_name(".symtab")
    if table is None or not hasattr(table, "iter_symbols"):
        return
    code = {index for index, section in enumerate(elf.iter_sections()) if section["sh_flags"] & 4}
    for symbol in table.iter_symbols():
        kind, name = symbol["st_info"]["type"], symbol.name
        if not name or name.startswith("$") or kind in ("STT_FILE", "STT_SECTION") or symbol["st_shndx"] == "SHN_UNDEF":
            continue
        is_code = kind == "STT_FUNC" or (kind == "STT_NOTYPE" and symbol["st_shndx"] in code)
        yield Symbol(
            name=name,
            address=symbol["st_value"] & ~1 if kind == "STT_FUNC" else symbol["st_value"],
            size=symbol["st_size"],
            is_code=is_code,
            is_weak=symbol["st_info"]["bind"] == "STB_WEAK",
        )
