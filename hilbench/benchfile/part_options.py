"""The option ``--part``: parts at a board that was named with its image, without a bench file."""

from __future__ import annotations

import argparse
import dataclasses
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hilbench.benchfile.bench_file import BenchFile
    from hilbench.benchfile.bench_model import PartEntry
    from hilbench.terminal.parser import Parser

__all__ = ["add_parts", "with_parts"]


def add_parts(parser: Parser) -> None:
    """Add ``--part``."""
    parser.add_argument(
        "--part",
        metavar="NAME=KIND[@BUS]",
        action="append",
        default=[],
        help="solder a part to the board: display=ssd1306@I2C1, flash=w25q@SPI1,cs=PA4 (docs/parts.md)",
    )


def with_parts(parsed: argparse.Namespace, bench_file: BenchFile) -> BenchFile:
    """Return a bench with the parts of a command line.

    Raises:
        UsageError: one of them is none, or the bench is no board with an image.
    """
    if not parsed.part:
        return bench_file

    from hilbench.benchfile.bench_model import BenchModel, TargetEntry
    from hilbench.benchfile.part_grammar import parse_part
    from hilbench.benchfile.wiring_reader import WiringReader
    from hilbench.errors import UsageError
    from hilbench.strict import Strict

    if bench_file.path is not None or len(bench_file.boards) != 1:
        raise UsageError("is for one board with an image", where="--part", hint="in a bench file: [parts.NAME]")
    ((board, emulated),) = bench_file.boards.items()
    entries: dict[str, PartEntry] = {}
    for name, entry in (parse_part(text, board, emulated.board) for text in parsed.part):
        if name in entries:
            raise UsageError(f"there are two parts called {name}", where="--part", hint="give each a name of its own")
        entries[name] = entry
    model = BenchModel(version=1, targets={board: TargetEntry(board=board)}, parts=entries)
    strict = Strict(lambda _path: "--part")
    wiring = WiringReader(model, bench_file.boards, None, strict, add_pin="add ,{}=PIN to it".format)
    return dataclasses.replace(bench_file, parts=wiring.parts(), nets=wiring.nets())
