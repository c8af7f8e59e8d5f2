"""What can be wrong with an image or a board, and what ends a run of an emulated microcontroller."""

from __future__ import annotations

__all__ = ["BoardError", "BusFault", "EngineError", "ImageError", "McuError"]


class McuError(Exception):
    """Base of what this package raises.

    Attributes:
        where: file, line, address or key; empty if the text says it.
        hint: what to do next; empty if there is nothing to say.
    """

    def __init__(self, text: str, *, where: str = "", hint: str = "") -> None:
        super().__init__(text)
        self.where = where
        self.hint = hint


class ImageError(McuError):
    """The image cannot run on this chip: truncated, erased, for another chip, not for ARM."""


class BoardError(McuError):
    """The description of a board is wrong."""


class EngineError(McuError):
    """The CPU engine is missing or is not the one this was written for."""


class BusFault(McuError):  # noqa: N818 - the name the field uses
    """Nothing answers at an address, or what is there answers with an error.

    Attributes:
        address: where.
        refusal: who refused the access and why; empty where nothing is.
    """

    def __init__(self, address: int, refusal: str = "") -> None:
        super().__init__(f"{refusal or 'nothing answers'} at 0x{address:08X}")
        self.address = address
        self.refusal = refusal
