"""Emulated boards on the command line: ``BOARD:IMAGE``, ``./my-board.toml:IMAGE``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from hilbench.benchfile.bench_file import BenchFile, EmulatedBoard
from hilbench.benchfile.board_files import is_board_file, open_board, with_chip
from hilbench.benchfile.reader import open_bench
from hilbench.benchfile.target_grammar import parse_target
from hilbench.errors import UsageError
from hilbench.files.built_in import built_in_benches
from hilbench.nearest import did_you_mean
from hilbench.strict.changes import Change
from targets.boards import board_names
from targets.mcu.variants import VARIANTS

__all__ = ["open_target"]

_IMAGE_SUFFIXES = frozenset({".elf", ".axf", ".out", ".hex", ".ihex", ".bin"})


def open_target(
    what: str | None,
    chip: str | None = None,
    *,
    timing: Literal["flat", "table"] | None = None,
    changes: Sequence[Change] = (),
) -> BenchFile:
    """Return the bench that a command line means: one board with an image, a built-in bench, or a bench file.

    Args:
        what: the words; None for the bench file of the working folder.
        chip: part number of the chip that the one board has instead of its own; None for its own.
        timing: how many cycles its instructions take; None for the usual.
        changes: what is different from the bench file; one board with an image has none.

    Raises:
        UsageError: there is no such board, chip or bench, or its file is wrong or firmware.
        UnavailableError: an image that a bench file names is not there.
    """
    spec, colon, image = (what or "").partition(":")
    if what is not None:
        _refuse_image(what)
    is_bench = what in built_in_benches() or not (colon or spec in board_names())
    if what is None or is_bench or Path(what).is_file():
        for option, value in (("chip", chip), ("timing", timing)):
            if value is not None:
                hint = f'in a bench file: {option} = "..."'
                raise UsageError("is for one board with an image", where=f"--{option}", hint=hint)
        return open_bench(what, changes=changes)
    if not (spec in board_names() or is_board_file(spec)):
        if spec in built_in_benches():
            hint = _of_bench(spec, image)
            raise UsageError(f"'{spec}' is a bench, with nothing behind a colon", where=what, hint=hint)
        if spec in {"serial", "listen", "exec", "capture"} or "://" in what:
            raise UsageError("cannot be run here", where=what, hint="name a bench, or a board with an image")
        if spec.upper() in VARIANTS:
            hint = f"a chip goes onto a board: {board_names()[0]}:{image} --chip {spec.upper()}"
            raise UsageError(f"'{spec}' is a chip", where=what, hint=hint)
        raise UsageError(f"no board '{spec}'", where=what, hint=did_you_mean(spec, board_names(), "built-in boards"))
    target = parse_target(what, what)
    board = open_board(target.name, Path())
    if chip is not None:
        board = with_chip(board, chip, "--chip")
    name, firmware = Path(target.name).stem, Path(target.rest)
    emulated = EmulatedBoard(
        board=board,
        board_name=spec,
        firmware=firmware,
        timing=timing or "flat",
        straps=board.straps,
        where=what,
    )
    return BenchFile(name=name, path=None, digest="", boards={name: emulated})


def _of_bench(name: str, words: str) -> str:
    """Return what to write instead of ``BENCH:WORDS``."""
    models = [model for model, target in open_bench(name).targets.items() if hasattr(target.settings, "profile")]
    if not models:
        return f"write {name}"
    return f'for a profile of it write a bench file with [targets.{models[0]}.settings] profile = "{words}"'


def _refuse_image(what: str) -> None:
    """Tell somebody who names firmware alone what is missing before it."""
    path = Path(what)
    if ":" in what and not path.is_file():
        return
    if path.suffix.lower() in _IMAGE_SUFFIXES or _is_elf(path):
        raise UsageError("is firmware, and no bench", where=what, hint=f"write {board_names()[0]}:{what}")


def _is_elf(path: Path) -> bool:
    if not path.is_file():
        return False
    try:
        with path.open("rb") as file:
            return file.read(4) == b"\x7fELF"
    except OSError:
        return False
