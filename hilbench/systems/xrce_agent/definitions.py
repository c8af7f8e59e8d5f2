"""Definitions of ROS 2 in folders."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hilbench.errors import UsageError
from protocols.xrce import LocalProtocolError
from protocols.xrce.cdr import Library, parse_action, parse_message, parse_service

__all__ = ["library_of"]

_PARSERS = {".msg": parse_message, ".srv": parse_service, ".action": parse_action}


def library_of(folders: Sequence[Path]) -> Library:
    """Return the definitions that stand in folders, and those that are known without.

    Reading one that is there and is no text, or makes no sense, raises `UsageError`.

    Args:
        folders: as ``share`` of an installed ROS 2: ``PACKAGE/msg/NAME.msg`` in it, and so with ``srv`` and ``action``.
    """

    def read(name: str) -> str | None:
        for folder in folders:
            path = folder / name
            try:
                text = path.read_text(encoding="utf-8-sig")
                _PARSERS[path.suffix](str(Path(name).with_suffix("")), text)
            except FileNotFoundError:
                continue
            except (OSError, UnicodeDecodeError, LocalProtocolError) as error:
                raise UsageError(f"cannot be read: {error}", where=str(path)) from None
            return text
        return None

    return Library(read)
