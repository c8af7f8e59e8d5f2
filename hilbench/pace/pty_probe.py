"""How late this host's kernel hands on what is written into a pseudo-terminal.

It does so in a worker of its own (Linux, drivers/tty/tty_buffer.c: `flush_to_ldisc`, on a queue of work), which waits
for a processor like everyone else: on a busy host tens of milliseconds, while the programs at both ends are in time and
notice nothing. So a byte is sent through a pair of our own, again and again: its work stands in the same queue. A
worker that has something to do every few milliseconds is also late less often.
"""

from __future__ import annotations

import fcntl
import os
import struct
import termios
import tty

from hilbench.clock import NS_PER_MS, Entry, EventClass, HostClock, LatenessMeter, Scheduler
from hilbench.errors import UnavailableError
from hilbench.pace.lateness import IN_TIME, Lateness

__all__ = ["PtyProbe"]

_EVERY_NS = 5 * NS_PER_MS
"""How often a byte is sent, and looked for (choice: as often as a bench measures how late it is itself)."""
_WAYS = 2
"""A question is handed on, and its answer."""
_INT = struct.Struct("i")


class PtyProbe:
    """See the module. While it takes less than `_EVERY_NS`, nothing is counted: `LOCAL_PORT_S` has what is usual.

    Args:
        scheduler: which runs in real time.
        host: the clock it follows.

    Raises:
        UnavailableError: the host has no pseudo-terminal left.
    """

    def __init__(self, scheduler: Scheduler, host: HostClock) -> None:
        self._scheduler = scheduler
        self._host = host
        self._late = LatenessMeter()
        try:
            self._reads, self._writes = os.openpty()
        except OSError as error:
            message = f"no pseudo-terminal: {error.strerror}"
            raise UnavailableError(message, hint="one is needed to measure how late the host hands on bytes") from error
        tty.setraw(self._writes)
        os.set_blocking(self._reads, False)
        self._sent_ns: int | None = None
        self._missed_ns = 0
        scheduler.add_source(self)
        self._next = self._beat_later()

    def fileno(self) -> int:
        """Return the descriptor that the byte comes out of."""
        return self._reads

    def on_readable(self, at_ns: int) -> None:
        """Take the byte. What counts is when it was not there yet: how late this bench reads is counted elsewhere.

        It counts for spans that begin a little later, too: their first byte may have been kept beside this one.
        """
        del at_ns
        os.read(self._reads, 1)
        if late_ns := self._late_ns():
            self._late.record(late_ns, self._host.monotonic_ns() + _EVERY_NS)
        self._sent_ns = None

    def lateness(self, since_ns: int) -> Lateness:
        """Return how late a question and its answer may have been handed on since a moment of the host, in ns."""
        late_ns = max(self._late.max_since_ns(since_ns), self._late_ns())
        return Lateness(late_ns=_WAYS * late_ns) if late_ns else IN_TIME

    def close(self) -> None:
        """Give the pair back."""
        self._scheduler.cancel(self._next)
        self._scheduler.remove_source(self)
        os.close(self._writes)
        os.close(self._reads)

    def _late_ns(self) -> int:
        """Return how late the byte is that is on its way, or has just come; 0 while that is less than `_EVERY_NS`.

        A bench that was late itself may look for it right after it was sent: then it is not late for that.
        """
        if self._sent_ns is None or not self._missed_ns:
            return 0
        late_ns = min(self._missed_ns + _EVERY_NS, self._host.monotonic_ns() - self._sent_ns)
        return late_ns if late_ns >= _EVERY_NS else 0

    def _beat(self) -> None:
        now_ns = self._host.monotonic_ns()
        if self._sent_ns is None:
            self._sent_ns, self._missed_ns = now_ns, 0
            os.write(self._writes, b"\0")
        elif not self._is_there():
            self._missed_ns = now_ns - self._sent_ns
        self._next = self._beat_later()

    def _beat_later(self) -> Entry:
        return self._scheduler.after(_EVERY_NS, self._beat, order=EventClass.CHECK, source="~pty-probe")

    def _is_there(self) -> bool:
        """Say whether the byte can be read.

        The kernel is asked what it counts. A poll, where there is nothing yet, waits until the worker has done its work
        (drivers/tty/n_tty.c: `n_tty_poll`): it would always find the byte, and this bench would be late instead.
        """
        return bool(_INT.unpack(fcntl.ioctl(self._reads, termios.FIONREAD, bytes(_INT.size)))[0])
