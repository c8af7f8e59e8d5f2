"""Names and source lines for addresses in an image, from its symbol table and its DWARF line tables."""

from __future__ import annotations

import bisect
import functools
import io
import struct
import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any, NamedTuple

__all__ = ["NO_SYMBOLS", "LineRow", "Symbol", "Symbols", "damage"]

_ALLOC = 1 << 1  # SHF_ALLOC: the section is in memory when the program runs

_KEPT_IMAGES = 8
"""Of how many images the line tables are kept (choice): a suite opens the same few for each of its cases."""


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


class LineRow(NamedTuple):
    """What stands in a line table of one piece of code.

    Attributes:
        start: its first address.
        end: the address behind it.
        file: the source, with its folder as the compiler was given it.
        line: counted from 1; 0 for code of no line.
    """

    start: int
    end: int
    file: str
    line: int


class Symbols:
    """Looks up addresses and names. Line tables are read from the ELF file when the first line is asked for.

    Args:
        symbols: the symbol table.
        elf: the whole file, for its line tables; None if there is none.

    Attributes:
        all: the symbol table.
        functions: code in the order of addresses, of several names for one the best.
    """

    def __init__(self, symbols: Iterable[Symbol] = (), elf: bytes | None = None) -> None:
        self.all = tuple(symbols)
        self._by_name = {symbol.name: symbol for symbol in reversed(self.all)}
        best: dict[int, Symbol] = {}
        for symbol in self.all:
            if symbol.is_code and (symbol.address not in best or _rank(symbol) < _rank(best[symbol.address])):
                best[symbol.address] = symbol
        self.functions = sorted(best.values(), key=lambda symbol: symbol.address)
        self._starts = [symbol.address for symbol in self.functions]
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
        symbol = self.functions[index]
        if symbol.size and pc >= symbol.address + symbol.size:
            return None
        return symbol.name

    @property
    def rows(self) -> Sequence[LineRow]:
        """The line tables, in the order of addresses; empty where the image has none."""
        return self._lines.rows

    @property
    def rows_are_whole(self) -> bool:
        """Whether nothing of the line tables is damaged."""
        return bool(self._lines.rows) and not self._lines.damaged

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
        self._rows: Sequence[LineRow] = ()
        self.damaged = False

    @property
    def rows(self) -> Sequence[LineRow]:
        if self._elf is not None:
            self._rows, self.damaged = _read_rows(self._elf)
            self._elf = None
        return self._rows

    def find(self, pc: int) -> str | None:
        index = bisect.bisect_right(self.rows, (pc, 1 << 32)) - 1
        if index >= 0 and self._rows[index].start <= pc < self._rows[index].end:
            row = self._rows[index]
            return f"{PurePosixPath(row.file).name}:{row.line}"
        return None


@functools.lru_cache(maxsize=_KEPT_IMAGES)
def _read_rows(data: bytes) -> tuple[Sequence[LineRow], bool]:
    """Return what can be read, in the order of addresses, and whether something is damaged."""
    from elftools.elf.elffile import ELFFile

    rows: list[LineRow] = []
    damaged = False
    try:
        elf = ELFFile(io.BytesIO(data))
        if elf.has_dwarf_info():
            loaded = _loaded(elf)
            dwarf = elf.get_dwarf_info()
            for unit in dwarf.iter_CUs():
                program = dwarf.line_program_for_CU(unit)
                if program is not None:
                    folder = _text(unit.get_top_DIE().attributes.get("DW_AT_comp_dir"))
                    rows.extend(row for row in _rows_of(program, folder) if any(row.start in one for one in loaded))
    except damage():
        damaged = True  # Debug information is a convenience: what of it is damaged is left out.
    return tuple(sorted(rows)), damaged


def _loaded(elf: Any) -> list[range]:
    """Return where the sections of an image lie.

    The lines of functions that the linker has dropped remain in the tables, at address 0.
    """
    headers = (section.header for section in elf.iter_sections())
    return [range(head["sh_addr"], head["sh_addr"] + head["sh_size"]) for head in headers if head["sh_flags"] & _ALLOC]


def _text(attribute: Any) -> str:
    return "" if attribute is None else str(attribute.value.decode(errors="replace"))


def _files_of(header: Any, folder: str) -> list[str]:
    """Return the sources by their numbers (DWARF 5, section 6.2.4; before that both are counted from 1)."""
    folders = [name.decode(errors="replace") for name in header["include_directory"]]
    files = [(entry.dir_index, entry.name.decode(errors="replace")) for entry in header["file_entry"]]
    if header["version"] < 5:
        folders, files = [folder, *folders], [(0, ""), *files]
    return [str(PurePosixPath(folder, *folders[number : number + 1], name)) for number, name in files]


def _rows_of(program: Any, folder: str) -> Iterable[LineRow]:
    files = _files_of(program.header, folder)
    before = None
    for entry in program.get_entries():
        state = entry.state
        if state is None:
            continue
        if before is not None and before.address < state.address:
            yield LineRow(before.address, state.address, files[before.file], before.line)
        before = None if state.end_sequence else state


NO_SYMBOLS = Symbols()
