"""Writes a file whole or not at all, and none that is read."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterable
from pathlib import Path

from hilbench.errors import UnavailableError, UsageError
from hilbench.files.paths import real_path

_DEFAULT_MODE = 0o666

Named = tuple[str, Path | None]
"""A file, after what it is to the reader of a message; None for one that is not asked for."""


def write_atomically(path: Path, content: str | bytes) -> None:
    """Write a file, text as UTF-8, so that a reader sees the old one or the new one, and a crash leaves no half.

    A path that is not a regular file, such as ``/dev/stdout`` or a fifo, is written to as it stands.

    Raises:
        UnavailableError: the file cannot be written, by now; `check_writable` says so beforehand.
    """
    data = content.encode() if isinstance(content, str) else content
    try:
        if path.exists() and not path.is_file():
            path.write_bytes(data)
        else:
            _replace(Path(real_path(path)), data)
    except OSError as error:
        raise UnavailableError(f"cannot be written: {error.strerror or error}", where=str(path)) from error


def check_writable(path: Path, option: str) -> None:
    """Make sure, before a run and not after it, that a file can be written.

    Args:
        path: the file that will be written.
        option: the option that named it.

    Raises:
        UsageError: it cannot.
        UnavailableError: it would be below the working folder, and that has been removed.
    """
    real = Path(real_path(path))
    folder, where = real.parent, f"{option} {path}"
    if real.is_symlink():
        raise UsageError("is a link that leads to itself", where=where)
    if path.is_dir():
        raise UsageError("is a folder", where=where)
    if not folder.is_dir():
        raise UsageError(f"there is no folder {folder}", where=where, hint="make it first")
    if not os.access(path if path.exists() else folder, os.W_OK):
        raise UsageError("cannot be written: permission denied", where=where)


def check_ordinary(path: Path, option: str, what: str) -> None:
    """Make sure that what is written in place, back and forth, goes to a file on a disk, and to one of its own.

    Args:
        path: the file that will be written.
        option: the option that named it.
        what: what will be written, for people; more than one.

    Raises:
        UsageError: it cannot be written, is no ordinary file, or is where our data goes.
        UnavailableError: see `check_writable`.
    """
    check_writable(path, option)
    where = f"{option} {path}"
    if path.exists() and not path.is_file():
        raise UsageError(f"is not a regular file, and {what} are written in place", where=where, hint="name a file")
    if is_standard_output(path):
        raise UsageError(f"is the standard output, and {what} need a file of their own", where=where, hint="name one")


def is_standard_output(path: Path) -> bool:
    """Say whether a path leads to where our data goes: ``/dev/stdout``, or the file it was redirected to."""
    try:
        return os.path.samestat(path.stat(), os.fstat(1))
    except OSError:
        return False


def refuse_overwriting(outputs: Iterable[Named], inputs: Iterable[Named] = ()) -> None:
    """Make sure that no output is an input or another output, whatever links lead there.

    A terminal or ``/dev/null`` may take several. A folder among the inputs stands for the Python files in it.

    Args:
        outputs: what will be written, after the option that named it.
        inputs: what is read.

    Raises:
        UsageError: one file is meant twice.
        UnavailableError: one is below the working folder, and that has been removed.
    """
    asked = [(option, path) for option, path in outputs if path is not None and not path.is_char_device()]
    if not asked:
        return
    read = [(what, path) for what, path in inputs if path is not None]
    taken = {identity: what for what, path in read for identity in _identities(path)}
    folders = [(what, real_path(path)) for what, path in read if path.is_dir()]
    for option, path in asked:
        what = next((taken[one] for one in _identities(path) if one in taken), None) or _holder(path, folders)
        if what is not None:
            raise UsageError(f"would overwrite {what}", where=f"{option} {path}", hint="choose another file")
        taken |= dict.fromkeys(_identities(path), f"what {option} writes")


def refuse_writing_into(outputs: Iterable[Named], lines: Iterable[Named]) -> None:
    """Make sure that no output is a line to somebody, who would get it: a port or a pseudo-terminal, there yet or not.

    Args:
        outputs: what will be written, after the option that named it.
        lines: the ports, and the links that lead to pseudo-terminals.

    Raises:
        UsageError: one is.
    """
    taken = {identity: what for what, path in lines if path is not None for identity in _identities(path)}
    for option, path in outputs:
        what = None if path is None else next((taken[one] for one in _identities(path) if one in taken), None)
        if what is not None:
            raise UsageError(f"would be written into {what}", where=f"{option} {path}", hint="choose another file")


def _replace(path: Path, data: bytes) -> None:
    descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(data)
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


def _identities(path: Path) -> tuple[object, ...]:
    """Return what a file is known by: its place in the file system, and the name under which it was asked for."""
    name = os.path.join(real_path(path.parent), path.name)  # noqa: PTH118 - the name itself is not resolved
    try:
        status = path.stat()
    except OSError:
        return (real_path(path), name)
    return ((status.st_dev, status.st_ino), name)


def _holder(path: Path, folders: Iterable[tuple[str, str]]) -> str | None:
    """Return the folder of suites in which a path is a suite."""
    real = Path(real_path(path))
    return next((what for what, folder in folders if real.suffix == ".py" and real.is_relative_to(folder)), None)
