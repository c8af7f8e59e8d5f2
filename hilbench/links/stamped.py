"""Bytes of a port with the moments between which they came; a process of its own takes them down.

See `hilbench.clock.stamping`.
"""

from __future__ import annotations

import contextlib
import socket
import subprocess
import sys
from dataclasses import dataclass
from typing import Protocol

from hilbench.clock.stamping import CHUNK_BYTES, HEAD, RUNS_FIRST
from hilbench.errors import UnavailableError

__all__ = ["Stamped", "Stamper", "StampingProcess", "Stamps"]


@dataclass(frozen=True, slots=True)
class Stamped:
    """Bytes that came together; both moments are the host's monotonic time, in ns.

    Attributes:
        data: the bytes.
        after_ns: at that moment none of them was there.
        by_ns: at that moment all of them were there.
    """

    data: bytes
    after_ns: int
    by_ns: int


class Stamper(Protocol):
    """What reads a port, and knows when its bytes came."""

    def fileno(self) -> int:
        """Return the descriptor that is readable when `take` has something."""

    @property
    def runs_first(self) -> bool:
        """Whether the system runs it before others."""

    def take(self) -> Stamped | None:
        """Return the next bytes, None if there are none; raises OSError when the port has hung up."""

    def close(self) -> None:
        """Read no more."""


class Stamps(Protocol):
    """Whoever wants to know when bytes came and left; `hilbench.bench.stamps.PortStamps` is one."""

    def open(self, descriptor: int) -> Stamper:
        """Return what is to read a port; raises OSError where nothing can be made that does."""

    def came(self, at_ns: int, read: Stamped) -> None:
        """Learn that bytes came at a bench time, in ns."""

    def left(self, asked_ns: int, late_ns: int) -> None:
        """Learn that bytes that were to leave at a bench time, in ns, were out so much later at the most."""


class StampingProcess:
    """A process that reads a port; it has begun to when this is made: an answer must not wait for its start.

    Args:
        descriptor: of the port, which does not block.

    Raises:
        OSError: it cannot be started.
        UnavailableError: it has ended before it began to read.
    """

    def __init__(self, descriptor: int) -> None:
        self._ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        words = [sys.executable, "-P", "-m", "hilbench.clock.stamping", str(descriptor), str(theirs.fileno())]
        with theirs:
            self._process = subprocess.Popen(  # in a group of its own: Ctrl-C is not for it
                words,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                pass_fds=[descriptor, theirs.fileno()],
                process_group=0,
            )
        with contextlib.ExitStack() as undo:
            undo.callback(self.close)
            said = self._ours.recv(1)
            if not said:
                raise UnavailableError("the process that is to read the port has not begun", hint="see its error above")
            undo.pop_all()
        self._runs_first = said == RUNS_FIRST
        self._ours.setblocking(False)

    @property
    def runs_first(self) -> bool:
        """Whether the system runs it before others."""
        return self._runs_first

    def fileno(self) -> int:
        """Return the descriptor that is readable when `take` has something."""
        return self._ours.fileno()

    def take(self) -> Stamped | None:
        """Return the next bytes, None if there are none.

        Raises:
            OSError: the port has hung up.
        """
        try:
            record = self._ours.recv(HEAD.size + CHUNK_BYTES)
        except BlockingIOError:
            return None
        if len(record) <= HEAD.size:
            raise OSError("readable without a byte: the other end is gone")
        return Stamped(record[HEAD.size :], *HEAD.unpack_from(record))

    def close(self) -> None:
        """End the process."""
        self._ours.close()
        self._process.wait()
