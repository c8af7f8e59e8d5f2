"""Who opens and closes a file: the two events of Linux's inotify that the pty door needs (inotify(7))."""

from __future__ import annotations

import ctypes
import os
import struct

from hilbench.errors import UnavailableError

_IN_CLOSE_WRITE = 0x08
_IN_CLOSE_NOWRITE = 0x10
_IN_OPEN = 0x20
_IN_CLOSE = _IN_CLOSE_WRITE | _IN_CLOSE_NOWRITE
_HEAD = struct.Struct("iIII")  # watch, mask, cookie, length of the name


class OpenCloseWatch:
    """Tells that a file was opened and closed.

    The kernel merges an event with the one before it if both are the same and the first was not read yet: two openings
    in a row may be reported as one.

    Args:
        path: The file; it must exist.

    Raises:
        UnavailableError: this system has no inotify, or no watch is left.
    """

    def __init__(self, path: str) -> None:
        self._libc = ctypes.CDLL(None, use_errno=True)
        if not hasattr(self._libc, "inotify_init1"):
            raise UnavailableError("this system has no inotify", where=path, hint="use a TCP port instead of a pty")
        self._descriptor = self._libc.inotify_init1(os.O_NONBLOCK | os.O_CLOEXEC)
        if self._descriptor < 0:
            raise _cannot_watch(path)
        if self._libc.inotify_add_watch(self._descriptor, os.fsencode(path), _IN_OPEN | _IN_CLOSE) < 0:
            error = _cannot_watch(path)
            self.close()
            raise error

    def fileno(self) -> int:
        """Return the descriptor, readable when there is something to tell."""
        return int(self._descriptor)

    def read(self) -> list[bool]:
        """Return what happened since the last call: True for opened, False for closed."""
        try:
            data = os.read(self._descriptor, 4096)
        except BlockingIOError:
            return []
        happened = []
        while data:
            _, mask, _, name_bytes = _HEAD.unpack_from(data)
            if mask & (_IN_OPEN | _IN_CLOSE):
                happened.append(bool(mask & _IN_OPEN))
            data = data[_HEAD.size + name_bytes :]
        return happened

    def close(self) -> None:
        """Stop watching."""
        os.close(self._descriptor)


def _cannot_watch(path: str) -> UnavailableError:
    reason = os.strerror(ctypes.get_errno())
    return UnavailableError(f"cannot watch for clients: {reason}", where=path, hint="see fs.inotify in sysctl")
