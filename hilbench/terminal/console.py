"""The process's own standard streams: data on one, narration on the other.

A reader that goes away (``hilbench check | head``) is nobody's error: what is left is dropped. Data that is lost in any
other way, such as on a full disk, was not delivered, and says so. Narration never stands in anybody's way.
"""

from __future__ import annotations

import contextlib
import errno
import os
import select
import sys
from collections.abc import Callable, Iterator
from typing import ClassVar, TextIO

from hilbench.errors import UnavailableError

_DEFAULT_WIDTH = 100
_LOOK_S = 0.05
"""How long room for more is waited for at a time (choice)."""
_PIECE = select.PIPE_BUF // 4
"""Characters, of four bytes at most, that a pipe takes at once where it says that it has room."""


class Console:
    """Where to print. The streams are those of the moment it is made; a capture begun later does not get its lines.

    Args:
        out: for data; the standard output by default.
        err: for narration; the standard error by default.

    Attributes:
        plain: print to a terminal as into a file. It holds for each console of this process.
        reader_gone: nobody reads the data any more; what is still printed is dropped.
    """

    plain: ClassVar[bool] = False

    def __init__(self, out: TextIO | None = None, err: TextIO | None = None) -> None:
        self._out = out or sys.stdout or _nowhere()
        self._err = err or sys.stderr or _nowhere()
        self.reader_gone = False

    def data(self, text: str) -> None:
        """Print lines of data.

        Raises:
            UnavailableError: they cannot be written. What follows is dropped.
        """
        self._put_data(f"{text}\n")

    def data_as_read(self, text: str, give_up: Callable[[float], bool]) -> bool:
        """Print lines of data as fast as their reader takes them.

        Args:
            text: the lines.
            give_up: asked with the seconds that the reader has taken nothing whether to print no more.

        Returns:
            Whether they were printed, as `data` prints them; otherwise the reader may have a part of them.

        Raises:
            UnavailableError: they cannot be written. What follows is dropped.
        """
        rest = f"{text}\n"
        while rest and not self.reader_gone:
            waited_s = 0.0
            while not _has_room(self._out):
                waited_s += _LOOK_S
                if give_up(waited_s):
                    return False
            self._put_data(rest[:_PIECE])
            rest = rest[_PIECE:]
        return True

    def _put_data(self, text: str) -> None:
        try:
            self.reader_gone = not _put(self._out, text) or self.reader_gone
        except (OSError, ValueError) as error:
            raise _lost(error) from error

    def narrate(self, text: str) -> None:
        """Print lines for a person."""
        _write(self._err, f"{text}\n")

    def mention(self, text: str) -> None:
        """Print lines for a person who may not be reading: what finds no room is dropped rather than waited for."""
        with contextlib.suppress(OSError, ValueError):
            poll = select.poll()
            poll.register(self._err.fileno(), select.POLLOUT)
            if not poll.poll(0):
                return
        _write(self._err, f"{text}\n")

    @property
    def colours(self) -> bool:
        """Whether data may be coloured: on a terminal only, and not if ``NO_COLOR`` is set."""
        return self.terminal and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"

    @property
    def terminal(self) -> bool:
        """Whether data goes to a terminal that may be told so."""
        return self._out.isatty() and not self.plain

    @property
    def watched(self) -> bool:
        """Whether narration goes to a terminal that may be told so."""
        return self._err.isatty() and not self.plain

    @property
    def width(self) -> int:
        """Columns of the terminal; 100 where it is not known."""
        try:
            return os.get_terminal_size(self._out.fileno()).columns or _DEFAULT_WIDTH
        except (OSError, ValueError):
            return _DEFAULT_WIDTH

    @contextlib.contextmanager
    def progress(self) -> Iterator[Callable[[str], None]]:
        """Give a function that shows one line of progress; it shows nothing where nobody watches."""
        if not self.watched:
            yield lambda _: None
            return
        columns = self.width - 1
        try:
            yield lambda text: _write(self._err, f"\r\x1b[K{text[:columns]}")
        finally:
            _write(self._err, "\r\x1b[K")


def flush_data() -> None:
    """Print what is buffered of the standard output.

    Raises:
        UnavailableError: it cannot be written.
    """
    try:
        _put(sys.stdout, "")
    except (OSError, ValueError) as error:
        raise _lost(error) from error


def flush_narration() -> None:
    """Print what is buffered of the standard error, if that is possible."""
    _write(sys.stderr, "")


def _lost(error: OSError | ValueError) -> UnavailableError:
    reason = str(error)
    if isinstance(error, OSError):
        reason = "it is closed" if error.errno == errno.EBADF else error.strerror or reason
    return UnavailableError(f"cannot be written: {reason}", where="the standard output")


def _write(stream: TextIO, text: str) -> None:
    with contextlib.suppress(OSError, ValueError):
        _put(stream, text)


def _put(stream: TextIO | None, text: str) -> bool:
    """Write; whatever goes wrong goes wrong once, and a reader that has gone is no error. Say whether there is one."""
    if stream is None:
        return True
    try:
        if text:
            stream.write(text)
        stream.flush()
    except BrokenPipeError:
        _point_nowhere(stream)
        return False
    except (OSError, ValueError):
        _point_nowhere(stream)
        raise
    return True


def _has_room(stream: TextIO) -> bool:
    """Say whether a stream takes something now, or soon; one without a descriptor always does."""
    poll = select.poll()
    try:
        poll.register(stream.fileno(), select.POLLOUT)
    except (OSError, ValueError):
        return True
    return bool(poll.poll(_LOOK_S * 1000))


def _nowhere() -> TextIO:
    return open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123 - stays open as long as the process


def _point_nowhere(stream: TextIO) -> None:
    """Have the rest of what is buffered go nowhere, so that closing the stream does not raise again."""
    with contextlib.suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
