"""Files that `hilbench init` writes: all of them or none, and over nothing that is there."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from hilbench.errors import UsageError
from hilbench.files import check_writable, write_atomically

__all__ = ["Written", "quoted", "write_new"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Written:
    """What was written.

    Attributes:
        files: the files.
        notes: what there is to know of them and what else there is to do, for the user.
    """

    files: tuple[Path, ...]
    notes: tuple[str, ...]


def write_new(texts: Mapping[Path, str]) -> tuple[Path, ...]:
    """Write files; return them.

    Raises:
        UsageError: one is there already, or cannot be written; nothing is written then.
    """
    for file in texts:
        if file.exists() or file.is_symlink():
            raise UsageError("is there already", where=str(file), hint="remove it, or choose another folder with --dir")
        check_writable(file, "--dir")
    for file, text in texts.items():
        write_atomically(file, text)
    return tuple(texts)


def quoted(text: str) -> str:
    """Return a TOML string; the escapes of JSON are those of TOML."""
    return json.dumps(text, ensure_ascii=False)
