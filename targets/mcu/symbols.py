"""Names and source lines for addresses in an image, from its symbol table and its DWARF line tables."""

from __future__ import annotations

import bisect
import io
import struct
import zlib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

__all__ = ["NO_SYMBOLS", "Symbol", "Symbols", "damage"]

_ALLOC = 1 << 1  # SHF_ALLOC: the section is in memory when the program runs


@dataclass(frozen=True, slots=True, kw_only=True)
class Symbol:
    """A name of the symbol table.

    Attributes:
        name: as in the symbol table; C++ names are mangled.
        address: first byte; the Thumb bit of a function is taken off.
        size: bytes; 0 if the symbol table does not say.
        is_code: a function or a label in code.
        is_weak: it may stand for something else, as the many names of a default handler do.
    """

    name: str
    address: int
    size: int
    is_code: bool
    is_weak: bool


class Symbols:
    """Looks up addresses and names. Line tables are read from the ELF file when the first line is asked for.

    Args:
        symbols: the symbol table.
        elf: the whole file, for its line tables; None if there is none.
    """

    def __init__(self, symbols: Iterable[Symbol] = (), elf: bytes | None = None) -> None:
        self.all = tuple(symbols)
        self._by_name = {symbol.name: symbol for symbol in reversed(self.all)}
        best: dict[int, Symbol] = {}
        for symbol in self.all:
            if symbol.is_code and (symbol.address not in best or _rank(symbol) < _rank(best[symbol.address])):
                best[symbol.address] = symbol
        self._functions = sorted(best.values(), key=lambda symbol: symbol.address)
        self._starts = [symbol.address for symbol in self._functions]
        self._lines = _LineTables(elf)

    def find(self, name: str) -> Symbol | None:
        """Return the symbol of that name, or None."""
        return self._by_name.get(name)

    def function_at(self, pc: int) -> str | None:
        """Return the name of the function that holds the address `pc`, or None.

        A label without a size reaches to the next one.
        """
        index = bisect.bisect_right(self._starts, pc) - 1
        if index < 0:
            return None
        symbol = self._functions[index]
        if symbol.size and pc >= symbol.address + symbol.size:
            return None
        return symbol.name

    def line_at(self, pc: int) -> str | None:
        """Return ``file.c:42`` for the address `pc`, or None where the image does not say."""
        return self._lines.find(pc)


def damage() -> tuple[type[Exception], ...]:
    """Return what pyelftools raises over a damaged file: its own errors, and what its parsers stumble over."""
    from elftools.common.exceptions import DWARFError, ELFError
    from elftools.construct import ConstructError

    stumbles = (ArithmeticError, AssertionError, AttributeError, LookupError, RuntimeError, TypeError, ValueError)
    return (ELFError, DWARFError, ConstructError, zlib.error, struct.error, EOFError, MemoryError, *stumbles)


def _rank(symbol: Symbol) -> tuple[bool, bool, str]:
    return symbol.is_weak, not symbol.size, symbol.name


class _LineTables:
    """The line tables of an ELF file, read when the first line is asked for."""

    def __init__(self, elf: bytes | None) -> None:
        self._elf = elf
        self._rows: list[tuple[int, int, str]] = []  # (first address, address behind, file:line)

    def find(self, pc: int) -> str | None:
        if self._elf is not None:
            self._rows = sorted(_read_rows(self._elf))
            self._elf = None
        index = bisect.bisect_right(self._rows, (pc, 1 << 32, "")) - 1
        if index >= 0 and self._rows[index][0] <= pc < self._rows[index][1]:
            return self._rows[index][2]
        return None


def _read_rows(data: bytes) -> list[tuple[int, int, str]]:
    from elftools.elf.elffile import ELFFile

    rows: list[tuple[int, int, str]] = []
    try:
        elf = ELFFile(io.BytesIO(data))
        if elf.has_dwarf_info():
            loaded = _loaded(elf)
            dwarf = elf.get_dwarf_info()
            for unit in dwarf.iter_CUs():
                program = dwarf.line_program_for_CU(unit)
                if program is not None:
                    rows.extend(row for row in _rows_of(program) if any(row[0] in section for section in loaded))
    except damage():
        # Debug information is a convenience: what of it is damaged is left out.
        return rows
    return rows


def _loaded(elf: Any) -> list[range]:
    """Return where the sections of an image lie.

    The lines of functions that the linker has dropped remain in the tables, at address 0.
    """
    headers = (section.header for section in elf.iter_sections())
    return [range(head["sh_addr"], head["sh_addr"] + head["sh_size"]) for head in headers if head["sh_flags"] & _ALLOC]


def _rows_of(program: Any) -> Iterable[tuple[int, int, str]]:
    header = program.header
    files = header["file_entry"]
    first = 0 if header["version"] >= 5 else 1  # files are counted from 0 since DWARF 5, section 6.2.4
    before = None
    for entry in program.get_entries():
        state = entry.state
        if state is None:
            continue
        if before is not None and before.address < state.address:
            name = files[before.file - first].name.decode(errors="replace")
            yield before.address, state.address, f"{PurePosixPath(name).name}:{before.line}"
        before = None if state.end_sequence else state


NO_SYMBOLS = Symbols()
