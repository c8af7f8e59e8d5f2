"""Definitions of ROS 2 in folders."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hilbench.errors import UsageError
from protocols.xrce.cdr import Library

__all__ = ["library_of"]


def library_of(folders: Sequence[Path]) -> Library:
    """Return the definitions that stand in folders, and those that are known without.

    Reading one that is there and no text raises `UsageError`.

    Args:
        folders: as ``share`` of an installed ROS 2: ``PACKAGE/msg/NAME.msg`` in it, likewise ``srv`` and ``action``.
    """

    def read(name: str) -> str | None:
        for folder in folders:
            path = folder / name
            try:
                return path.read_text(encoding="utf-8")
            except FileNotFoundError:
                continue
            except (OSError, UnicodeDecodeError) as error:
                raise UsageError(f"cannot be read: {error}", where=str(path)) from None
        return None

    return Library(read)
