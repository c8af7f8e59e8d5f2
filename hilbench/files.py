"""Writes a file whole or not at all."""

from __future__ import annotations

import contextlib
import os
import tempfile
from pathlib import Path

from hilbench.errors import UnavailableError, UsageError

_DEFAULT_MODE = 0o666


def write_atomically(path: Path, text: str) -> None:
    """Write a text file so that a reader sees the old one or the new one, and a crash leaves no half.

    A path that is not a regular file, such as ``/dev/stdout`` or a fifo, is written to as it stands.

    Raises:
        UnavailableError: the file cannot be written, by now; `check_writable` says so beforehand.
    """
    try:
        if path.exists() and not path.is_file():
            path.write_text(text, encoding="utf-8")
        else:
            _replace(path.resolve(), text)
    except OSError as error:
        raise UnavailableError(f"cannot be written: {error.strerror or error}", where=str(path)) from error


def check_writable(path: Path, option: str) -> None:
    """Make sure, before a run and not after it, that a file can be written.

    Args:
        path: the file that will be written.
        option: the option that named it.

    Raises:
        UsageError: it cannot.
    """
    folder = path.resolve().parent
    where = f"{option} {path}"
    if path.is_dir():
        raise UsageError("is a folder", where=where)
    if not folder.is_dir():
        raise UsageError(f"there is no folder {folder}", where=where)
    if not os.access(path if path.exists() else folder, os.W_OK):
        raise UsageError("cannot be written: permission denied", where=where)


def _replace(path: Path, text: str) -> None:
    descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(descriptor, "w", encoding="utf-8") as file:
            file.write(text)
            os.fchmod(file.fileno(), _DEFAULT_MODE & ~_umask())
        Path(name).replace(path)
    except BaseException:
        with contextlib.suppress(OSError):
            Path(name).unlink()
        raise


def _umask() -> int:
    current = os.umask(0)
    os.umask(current)
    return current
