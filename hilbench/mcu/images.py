"""Firmware images: loaded for a board, with every mistake in one line and the right exit code."""

from __future__ import annotations

import stat
from pathlib import Path

from hilbench.benchfile.bench_file import EmulatedBoard
from hilbench.errors import HilbenchError, UnavailableError, UsageError
from targets.mcu.errors import BoardError, EngineError, ImageError, McuError
from targets.mcu.image import Image, limits_of, load_image

__all__ = ["load", "translated"]

_LARGEST_BYTES = 64 << 20
"""An ELF file with all its debug information stays far below that (choice)."""


def load(emulated: EmulatedBoard) -> Image:
    """Return the image of a board.

    Raises:
        UnavailableError: there is no such file, or it cannot be read.
        UsageError: it cannot run on the board's chip, or is no file.
    """
    _check_file(emulated.firmware)
    try:
        return load_image(emulated.firmware, limits_of(emulated.board.variant), base=emulated.base)
    except ImageError as error:
        raise translated(error) from error


def _check_file(path: Path) -> None:
    """Make sure that there is a file to read, and that reading it comes to an end."""
    try:
        status = path.stat()
        if stat.S_ISREG(status.st_mode):
            with path.open("rb"):
                pass
    except OSError as error:
        missing = isinstance(error, FileNotFoundError)
        reason = "no such firmware file" if missing else f"cannot be read: {error.strerror}"
        raise UnavailableError(reason, where=str(path), hint="build it, or check the path") from None
    if stat.S_ISDIR(status.st_mode):
        return  # the loader has words for it
    if not stat.S_ISREG(status.st_mode):
        raise UsageError("a device or a pipe, not a file", where=str(path), hint="name the ELF, HEX or BIN file")
    if status.st_size > _LARGEST_BYTES:
        text = f"too large for firmware: {status.st_size} bytes"
        raise UsageError(text, where=str(path), hint="name the ELF, HEX or BIN file")


def translated(error: McuError) -> HilbenchError:
    """Return what a person is told of an error of the emulated chip: wrong image or board 2, missing engine 3."""
    kind = UsageError if isinstance(error, ImageError | BoardError) else UnavailableError
    if not isinstance(error, ImageError | BoardError | EngineError):
        raise error
    return kind(str(error), where=error.where or None, hint=error.hint or None)
