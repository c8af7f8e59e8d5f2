"""Keep the C library's chatter away from our output, and read it for warnings.

PyBullet writes its build time to descriptor 2 when it is imported and ``b3Warning`` lines to descriptor 1 while it
loads, from C, where replacing ``sys.stdout`` does not reach. Its warnings matter (a bad inertia is silently replaced
by zero), so both descriptors point at an unlinked file while something loads, and the file is read afterwards.

Stepping, casting rays and reading state print nothing, so only loading pays (some tens of microseconds).

The descriptors belong to the process: what another thread writes to 1 or 2 while something loads lands in the file.
The bench is one thread; a program with more should open its worlds before it starts them.
"""

from __future__ import annotations

import ctypes
import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager

from worlds.errors import PhysicsOutputError

_LOWEST_SPARE_DESCRIPTOR = 3
_WARNING_MARKS = ("b3Warning", "b3Error")


@contextmanager
def captured_output() -> Iterator[None]:
    """Point descriptors 1 and 2 at a file for the duration, then put them back exactly as they were.

    Works whatever the two are: a terminal, a pipe, pytest's capture, or closed.

    Raises:
        PhysicsOutputError: the library warned. Not raised when the body itself raises.
    """
    _flush_c_streams()  # text other C code has buffered belongs where the descriptors point now
    kept = {descriptor: _duplicate(descriptor) for descriptor in (1, 2)}
    log = _open_log()
    try:
        for descriptor in kept:
            os.dup2(log, descriptor)
        try:
            yield
        finally:
            _flush_c_streams()  # on a pipe the library's lines are still in its buffer
            for descriptor, copy in kept.items():
                _restore(descriptor, copy)
        _raise_for_warnings(_text(log))
    finally:
        os.close(log)


def _flush_c_streams() -> None:
    ctypes.CDLL(None).fflush(None)


def _duplicate(descriptor: int) -> int | None:
    try:
        return fcntl.fcntl(descriptor, fcntl.F_DUPFD_CLOEXEC, _LOWEST_SPARE_DESCRIPTOR)
    except OSError:  # closed, and closed it must be again
        return None


def _open_log() -> int:
    # Where 1 or 2 is closed the new file would take that very number, hence the duplicate further up.
    with tempfile.TemporaryFile() as file:
        return fcntl.fcntl(file.fileno(), fcntl.F_DUPFD_CLOEXEC, _LOWEST_SPARE_DESCRIPTOR)


def _restore(descriptor: int, copy: int | None) -> None:
    if copy is None:
        os.close(descriptor)
    else:
        os.dup2(copy, descriptor)
        os.close(copy)


def _text(log: int) -> str:
    return os.pread(log, os.fstat(log).st_size, 0).decode(errors="replace")


def _raise_for_warnings(text: str) -> None:
    warnings = [line.strip() for line in text.splitlines() if any(mark in line for mark in _WARNING_MARKS)]
    if warnings:
        raise PhysicsOutputError(f"the physics library warned while loading: {'; '.join(warnings)}")
