"""Which lines of the sources a run has executed, in the format of lcov: genhtml and editors show it.

The image is the unmodified one: the emulated CPU says which instructions it has executed, line tables say of which
lines they are. A line counts as executed if any of its instructions was. What the compiler has removed has no line.
"""

from __future__ import annotations

import bisect
from collections.abc import Iterator, Mapping
from pathlib import Path

from hilbench.errors import UsageError
from hilbench.files import write_atomically
from hilbench.mcu.emulated import EmulatedBench
from targets.mcu.symbols import Symbols

__all__ = ["Coverage"]

_Lines = dict[str, dict[int, bool]]
"""By source and line: whether it was executed."""


class Coverage:
    """Follows what all boards of a bench execute, from now on.

    Args:
        emulated: the bench, before it runs.

    Raises:
        UsageError: an image has no line tables, or damaged ones.
    """

    def __init__(self, emulated: EmulatedBench) -> None:
        for name, image in emulated.images.items():
            if not image.symbols.rows:
                hint = "give the ELF file, compiled and linked with -g"
                raise UsageError(f"{image.path}: has no line tables", where=f"--coverage: {name}", hint=hint)
            if not image.symbols.rows_are_whole:
                message = f"{image.path}: its line tables are damaged, so lines would be missing"
                raise UsageError(message, where=f"--coverage: {name}", hint="link it again")
        for machine in emulated.machines.values():
            machine.cover()
        self._emulated = emulated

    def counted(self) -> tuple[int, int]:
        """Return how many lines of all boards were executed until now, and how many there are."""
        lines = [hit for board in self._boards().values() for file in board.values() for hit in file.values()]
        return sum(lines), len(lines)

    def write(self, path: Path) -> None:
        """Write it (geninfo(1), "TRACEFILE FORMAT"); an older file is overwritten.

        Raises:
            UnavailableError: it cannot be written.
        """
        records = [line for name, files in self._boards().items() for line in self._records(name, files)]
        write_atomically(path, "".join(f"{line}\n" for line in records))

    def _records(self, name: str, files: _Lines) -> Iterator[str]:
        functions = self._functions(name)
        for file, lines in sorted(files.items()):
            yield f"TN:{name.replace('-', '_')}"
            yield f"SF:{file}"
            there = functions.get(file, [])
            yield from (f"FN:{line},{function}" for line, function, _ in there)
            yield from (f"FNDA:{int(hit)},{function}" for _, function, hit in there)
            yield from (f"FNF:{len(there)}", f"FNH:{sum(hit for _, _, hit in there)}")
            yield from (f"DA:{line},{int(hit)}" for line, hit in sorted(lines.items()))
            yield from (f"LF:{len(lines)}", f"LH:{sum(lines.values())}", "end_of_record")

    def _boards(self) -> Mapping[str, _Lines]:
        return {name: self._lines(image.symbols, self._executed(name)) for name, image in self._emulated.images.items()}

    def _executed(self, name: str) -> list[int]:
        return sorted(self._emulated.machines[name].executed())

    def _lines(self, symbols: Symbols, executed: list[int]) -> _Lines:
        files: _Lines = {}
        for row in symbols.rows:
            if row.line:
                first = bisect.bisect_left(executed, row.start)
                hit = first < len(executed) and executed[first] < row.end
                lines = files.setdefault(row.file, {})
                lines[row.line] = lines.get(row.line, False) or hit
        return files

    def _functions(self, name: str) -> dict[str, list[tuple[int, str, bool]]]:
        """Return line, name and whether it was begun of the functions of a board, by source."""
        symbols, executed = self._emulated.images[name].symbols, {*self._executed(name)}
        begins = {row.start: row for row in reversed(symbols.rows)}
        found: dict[str, list[tuple[int, str, bool]]] = {}
        for symbol in symbols.functions:
            if symbol.size and (row := begins.get(symbol.address)):
                found.setdefault(row.file, []).append((row.line, symbol.name, symbol.address in executed))
        return {file: sorted(functions) for file, functions in found.items()}
