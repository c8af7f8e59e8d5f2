"""Firmware images: loaded for a board, with every mistake in one line and the right exit code."""

from __future__ import annotations

from hilbench.bench_file import EmulatedBoard
from hilbench.errors import HilbenchError, UnavailableError, UsageError
from targets.mcu.errors import BoardError, EngineError, ImageError, McuError
from targets.mcu.image import ChipLimits, Image, load_image

__all__ = ["load", "translated"]


def load(emulated: EmulatedBoard) -> Image:
    """Return the image of a board.

    Raises:
        UnavailableError: there is no such file, or it cannot be read.
        UsageError: it cannot run on the board's chip.
    """
    variant = emulated.board.variant
    limits = ChipLimits(name=variant.name, flash_size=variant.flash_bytes, ram_size=variant.ram_bytes)
    try:
        with emulated.firmware.open("rb"):
            pass
    except IsADirectoryError:
        pass  # the loader has words for it
    except OSError as error:
        reason = (
            "no such firmware file" if isinstance(error, FileNotFoundError) else f"cannot be read: {error.strerror}"
        )
        raise UnavailableError(reason, where=str(emulated.firmware), hint="build it, or check the path") from None
    try:
        return load_image(emulated.firmware, limits, base=emulated.base)
    except ImageError as error:
        raise translated(error) from error


def translated(error: McuError) -> HilbenchError:
    """Return what a person is told of an error of the emulated chip: wrong image or board 2, missing engine 3."""
    kind = UsageError if isinstance(error, ImageError | BoardError) else UnavailableError
    if not isinstance(error, ImageError | BoardError | EngineError):
        raise error
    return kind(str(error), where=error.where or None, hint=error.hint or None)
