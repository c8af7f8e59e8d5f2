"""The file of a journal: for one program at a time, over nothing but an older journal, begun anew where it is limited.

A file that is full becomes FILE.1. That moves names about, so it is done to files alone, under the names they have:
never to a device, a pipe, or what a link of the system leads to (``/dev/stdout``), where somebody else's file may be.
"""

from __future__ import annotations

import fcntl
import os
import stat
import weakref
from pathlib import Path

from hilbench.errors import HilbenchError, UnavailableError, UsageError
from hilbench.files.paths import absolute_path, real_path

__all__ = ["JournalFile", "limited_name"]

_MARK, _MARK_WITHIN = b'"kind":"journal"', 32
_OF_THE_SYSTEM = ("/dev", "/proc")
_NO_JOURNAL = "is not a journal and will not be overwritten"
_OTHER = "choose another file"
_MOST_LINKS = 40
"""How many links the system follows (path_resolution(7))."""


class JournalFile:
    """A file that is appended to.

    Args:
        path: its name. An older journal there is overwritten, any other file is refused.
        max_bytes: what it and the part before it, FILE.1, may take together; None for no limit. What has no name that
            could be changed has no limit.

    Raises:
        UsageError: the path, or that of the part before, holds something else.
        UnavailableError: it cannot be written, or another program writes it.
    """

    def __init__(self, path: Path, max_bytes: int | None = None) -> None:
        self._path = path
        self._max_bytes = max_bytes
        self._name = None if max_bytes is None else limited_name(path)
        if self._name is not None:
            _check_part(_part_before(self._name))
        self._hold(_open(path))

    @property
    def full(self) -> bool:
        """Whether it is time to begin anew; never once somebody has moved it away or removed it."""
        limit = self._max_bytes
        return limit is not None and self._written_bytes >= limit // 2 and self._has_its_name()

    @property
    def room_bytes(self) -> int:
        """How much a part takes before it is full; only of a file that has a limit."""
        assert self._max_bytes is not None
        return self._max_bytes // 2

    def write(self, data: bytes) -> None:
        """Append; UnavailableError if that cannot be done."""
        view = memoryview(data)
        try:
            while view:
                view = view[os.write(self._descriptor, view) :]
        except OSError as error:
            raise _cannot_write(self._path, error) from error
        self._written_bytes += len(data)

    def begin_anew(self) -> None:
        """Make it the part before, and go on in an empty file; if that cannot be done, the old one is still open.

        Raises:
            UsageError, UnavailableError: as when it was opened.
        """
        assert self._name is not None
        before = _part_before(self._name)
        _check_part(before)
        try:
            self._name.replace(before)
        except OSError as error:
            raise _cannot_write(before, error) from error
        new = _open(self._name)
        self.close()
        self._hold(new)

    def close(self) -> None:
        """Let go of it."""
        self._let_go()

    def _hold(self, descriptor: int) -> None:
        """Have it open until it is closed, or forgotten: an error must not keep it locked."""
        self._descriptor, self._written_bytes = descriptor, 0
        self._let_go = weakref.finalize(self, os.close, descriptor)

    def _has_its_name(self) -> bool:
        try:
            return self._name is not None and os.path.samestat(self._name.lstat(), os.fstat(self._descriptor))
        except OSError:
            return False


def limited_name(path: Path) -> Path | None:
    """Return under which name a file is renamed when it is full, links of the user's followed; None if it must not be.

    A file that is not there yet is one that may be. What is wrong with a name is for the one to say who opens it.
    """
    name = _in_real_folder(path)
    try:
        for _ in range(_MOST_LINKS):
            mode = name.lstat().st_mode
            if not stat.S_ISLNK(mode):
                return name if stat.S_ISREG(mode) else None
            if any(name.is_relative_to(folder) for folder in _OF_THE_SYSTEM):
                return None
            name = _in_real_folder(name.parent / name.readlink())
    except OSError:
        pass
    return name


def _in_real_folder(path: Path) -> Path:
    return Path(real_path(absolute_path(path).parent)) / path.name


def _part_before(name: Path) -> Path:
    return name.with_name(name.name + ".1")


def _open(path: Path) -> int:
    """Open a file to append to, and empty it."""
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o644)
    except OSError as error:
        raise _cannot_write(path, error) from error
    try:
        if stat.S_ISREG(os.fstat(descriptor).st_mode):
            _claim(descriptor, path)
            os.ftruncate(descriptor, 0)
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor


def _check_part(path: Path) -> None:
    """Make sure that what will be replaced by the part before is an older one, or is not there."""
    try:
        if not stat.S_ISREG(path.lstat().st_mode):
            raise UsageError(_NO_JOURNAL, where=str(path), hint=_OTHER)
        descriptor = os.open(path, os.O_RDONLY)
    except FileNotFoundError:
        return
    except OSError as error:
        raise _cannot_write(path, error) from error
    try:
        _claim(descriptor, path)
    finally:
        os.close(descriptor)


def _claim(descriptor: int, path: Path) -> None:
    """Make sure that a file is a journal, or empty, and that nobody else writes it while it is open (flock(2))."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        raise UnavailableError("is being written by another program", where=str(path), hint=_OTHER) from error
    except OSError:
        pass  # a file system without locks
    if os.fstat(descriptor).st_size and _MARK not in os.pread(descriptor, _MARK_WITHIN, 0):
        raise UsageError(_NO_JOURNAL, where=str(path), hint=_OTHER)


def _cannot_write(path: Path, error: OSError) -> HilbenchError:
    reason = error.strerror or str(error)
    return UnavailableError(f"the journal cannot be written: {reason}", where=str(path), hint=_OTHER)
