"""A door for programs that want a serial port: a pseudo-terminal under a stable name.

The bench holds the master side, and one descriptor of the slave side for the whole run: without it the master would
report an error whenever no client is there, and the settings would be lost (pty(7)). Clients are noticed by inotify on
the slave. Settings are made with the termios2 ioctls of Linux, which know every baud rate (ioctl_tty(2)).
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import select
import struct
import termios
from pathlib import Path

from hilbench.clock import Scheduler
from hilbench.errors import UnavailableError, UsageError
from hilbench.links.door import READ_BYTES, Door, Input
from hilbench.links.inotify import OpenCloseWatch
from hilbench.links.port import Line
from hilbench.links.uart import Timeline

_TERMIOS2 = struct.Struct("=IIIIB19sII")  # iflag, oflag, cflag, lflag, line, cc, ispeed, ospeed
_TCGETS2 = 0x802C542A
_TCSETS2 = 0x402C542B
_TIOCGEXCL = 0x80045440
_INT = struct.Struct("i")
_BAUD_BITS = 0o010017  # CBAUD
_BAUD_IN_SPEED_FIELDS = 0o010000  # BOTHER
_UNPACED_BAUD = 115_200  # what the slave says on a line without pace; some rate it must have
# While a process is within open(2) or close(2). Choices: many times what it takes on a busy machine, and a delay of the
# bench that is only met when notices were merged, by several clients at one port.
_CHANGE_TAKES_AT_MOST_MS = 20
_NOTICES_OF_ONE_CHANGE = 4
_PTS = re.compile(r"/dev/pts/\d+")


class PtyDoor(Door):
    """A pseudo-terminal with a symbolic link to it.

    The line is up while a client has the slave open. What is written while none has, or while one does not read, is
    lost and counted, as on a UART. On a real line both ends must have the same rate: unless `any_baud`, a client that
    has set another one receives and sends what that makes of the bytes.

    Args:
        scheduler: Owner of bench time, locked to the host's clock before it runs.
        path: Where the symbolic link is put; None for none. What is there already is left alone, except a link to a
            pseudo-terminal that no longer exists.
        line: Baud rate of the line, and of the slave before a client sets it; 0 for no pace.
        any_baud: Understand a client whatever rate it has set.
        name: For the journal and for messages.
        chip_time: Time of the chip whose USART the door leads to; None if it leads to anything else.

    Raises:
        UsageError: something else is at `path`, or its folder does not exist.
        UnavailableError: another bench serves `path`, or no pseudo-terminal is to be had.

    Attributes:
        slave_name: The slave's own name, /dev/pts/N.
    """

    def __init__(
        self,
        scheduler: Scheduler,
        path: Path | str | None,
        line: Line | None = None,
        *,
        any_baud: bool = False,
        name: str = "pty",
        chip_time: Timeline | None = None,
    ) -> None:
        super().__init__(scheduler, name, line or Line(), chip_time, any_baud=any_baud)
        self.path = None if path is None else Path(path)
        self._clients = 0
        self._coming = False  # a client is there, and what is older than its opening has not all left the wire
        try:
            self._master, self._slave = os.openpty()
        except OSError as error:
            raise UnavailableError(f"no pseudo-terminal: {error.strerror}", where=name) from error
        os.set_blocking(self._master, False)
        self.slave_name = os.ttyname(self._slave)
        self._reset_slave()
        with contextlib.ExitStack() as undo:
            undo.callback(os.close, self._master)
            undo.callback(os.close, self._slave)
            self._watch = OpenCloseWatch(self.slave_name)
            undo.callback(self._watch.close)
            self._put_link()
            undo.pop_all()
        self._input = Input(descriptor=self._master, read=self._look)
        self._comings = Input(descriptor=self._watch.fileno(), read=self._look)
        scheduler.add_source(self._comings)
        scheduler.add_source(self._input)

    @property
    def client_baud(self) -> int:
        """The rate the slave is set to, bit/s: the client's, or ours before a client sets it."""
        return int(_TERMIOS2.unpack(fcntl.ioctl(self._slave, _TCGETS2, bytes(_TERMIOS2.size)))[7])

    def follow(self, was_baud: int, *, unasked: bool) -> None:
        """See `Door.follow`."""
        if not self._clients or (unasked and self.client_baud == was_baud):
            self._set_slave_baud(self.baud)

    # --- bytes

    def _look(self, at_ns: int) -> None:
        """Take what clients did and wrote.

        The notices do not say when the bytes came in between. Bytes belong to the client that opened last: a client
        that comes on the heels of another must not lose its first words.
        """
        happened = self._watch.read()
        leaving = _trailing_closings(happened)
        for opened in happened[: len(happened) - leaving]:
            self._count(self._clients + (1 if opened else -1), at_ns)
        if all(happened):
            if not self._held:
                self._read(at_ns, everything=False)
            return
        # Notices may have been merged: the count is only a guess, but whether anybody is there can be found out.
        somebody, heir = self._who_is_there(nobody_counted=self._clients <= leaving)
        read = not self._held or leaving > 0
        chunks = self._chunks(everything=leaving > 0 or not somebody) if read else []
        if chunks and not somebody:
            # They may come from a client whose opening was taken for our own: then it is still there.
            somebody = heir = self._who_is_there(nobody_counted=False)[0]
        if heir:
            self._count(self._clients - leaving, at_ns)
            self._count(self._clients + 1, at_ns)
            leaving = 0
        self._bring(chunks, at_ns)
        self._count(max(1, self._clients - leaving) if somebody else 0, at_ns)
        if not somebody:
            self._reset_slave()

    def _count(self, clients: int, at_ns: int) -> None:
        before, self._clients = self._clients, max(0, clients)
        if self._clients and not before:
            self._garbled = False
            self._coming = True
            self._drop_unread()  # at once: what this client has been given must not be taken from it
            self._in_order(at_ns, self._client_came)
        elif before and not self._clients:
            self._in_order(at_ns, self._client_left)

    def _client_came(self) -> None:
        self._coming = False
        super()._client_came()

    def _read(self, at_ns: int, *, everything: bool) -> None:
        self._bring(self._chunks(everything=everything), at_ns)

    def _chunks(self, *, everything: bool) -> list[bytes]:
        """Return what clients have written: all of it, or one piece."""
        chunks: list[bytes] = []
        while everything or not chunks:
            try:
                chunks.append(os.read(self._master, READ_BYTES))
            except OSError:
                break  # nothing there
        return chunks

    def _bring(self, chunks: list[bytes], at_ns: int) -> None:
        for data in chunks:
            if not self._clients:
                self._count(1, at_ns)  # who writes has opened; the notice of it was merged with our own
            self._hear(self._input, data, at_ns)

    def _put(self, data: bytes, _at_ns: int) -> None:
        if not self._clients or self._coming:
            self.counters.lost += len(data)
            return
        heard = self._across(data, self.baud, self.client_baud)
        try:
            self.counters.lost += len(heard) - os.write(self._master, heard)
        except BlockingIOError:
            self.counters.lost += len(heard)

    # --- clients

    def _who_is_there(self, *, nobody_counted: bool) -> tuple[bool, bool]:
        """Let go of our own slave descriptor for a moment: the master hangs up only if no other is left.

        The kernel tells of a closing before it is done, and of an opening after it is. Where that may be why somebody
        seems to be there though the notices know of nobody, the one who is at it is given the time to get through.

        Returns:
            Whether a client is there, and whether one has come since the notices were last read: a client that opens
            right behind the closing of another is no proof that the other is still there.
        """
        poll = select.poll()
        poll.register(self._master, 0)
        happened = self._watch.read()
        alone = self._let_others_open()
        os.close(self._slave)
        hung_up = bool(poll.poll(0))
        happened += self._watch.read()  # with our own closing, and before our own opening can be merged with another
        if nobody_counted:
            poll.register(self._watch.fileno(), select.POLLIN)
            for _ in range(_NOTICES_OF_ONE_CHANGE):
                if hung_up or True in happened:
                    break
                stirred = poll.poll(_CHANGE_TAKES_AT_MOST_MS)
                if not stirred:
                    break  # nobody is at it
                hung_up = any(descriptor == self._master for descriptor, _ in stirred)
                happened += self._watch.read()
        self._slave = self._open_slave()
        self._watch.read()  # our own opening
        if alone and not hung_up:
            fcntl.ioctl(self._slave, termios.TIOCEXCL)  # for the client that is there
        return not hung_up, True in happened

    def _let_others_open(self) -> bool:
        """Lift a client's claim to have the port alone, which keeps us out and outlives him; return whether it was."""
        (alone,) = _INT.unpack(fcntl.ioctl(self._slave, _TIOCGEXCL, bytes(_INT.size)))
        fcntl.ioctl(self._slave, termios.TIOCNXCL)
        return bool(alone)

    def _open_slave(self) -> int:
        try:
            return os.open(self.slave_name, os.O_RDWR | os.O_NOCTTY)
        except OSError as error:
            self._slave = -1
            message = f"a client took it for itself alone (TIOCEXCL) as another left: {error.strerror}"
            raise UnavailableError(message, where=self.name, hint="start again") from error

    def _reset_slave(self) -> None:
        """Make the slave raw, at the line's rate, with nothing unread in it."""
        baud = self.baud or _UNPACED_BAUD
        attributes = termios.tcgetattr(self._slave)
        attributes[0] = attributes[1] = attributes[3] = 0
        attributes[2] = termios.CS8 | termios.CREAD | termios.CLOCAL
        attributes[6][termios.VMIN], attributes[6][termios.VTIME] = 1, 0
        termios.tcsetattr(self._slave, termios.TCSANOW, attributes)
        self._set_slave_baud(baud)
        self._drop_unread()

    def _drop_unread(self) -> None:
        """Throw away what a former client left unread.

        Only if there is something: a client that polls within a flush, be it of nothing, may be told that there is
        something to read (n_tty moves the tail of its buffer before the head), and pyserial takes that for an unplugged
        port.
        """
        poll = select.poll()
        poll.register(self._slave, select.POLLIN)
        poll.poll(0)  # has the kernel hand on what it still carries, which it does not count
        (unread_bytes,) = _INT.unpack(fcntl.ioctl(self._slave, termios.FIONREAD, bytes(_INT.size)))
        if unread_bytes:
            termios.tcflush(self._slave, termios.TCIFLUSH)

    def _set_slave_baud(self, baud: int) -> None:
        iflag, oflag, cflag, lflag, discipline, characters, _, _ = _TERMIOS2.unpack(
            fcntl.ioctl(self._slave, _TCGETS2, bytes(_TERMIOS2.size))
        )
        cflag = cflag & ~_BAUD_BITS | _BAUD_IN_SPEED_FIELDS
        packed = _TERMIOS2.pack(iflag, oflag, cflag, lflag, discipline, characters, baud, baud)
        fcntl.ioctl(self._slave, _TCSETS2, packed)

    # --- the name

    def _put_link(self) -> None:
        if self.path is None:
            return
        if self.path.is_symlink():
            self._drop_stale_link(self.path)
        try:
            self.path.symlink_to(self.slave_name)
        except FileExistsError as error:
            raise UsageError(
                "something is there already", where=str(self.path), hint="remove it or choose another path"
            ) from error
        except OSError as error:
            reason = error.strerror or str(error)
            raise UsageError(
                f"no link can be made: {reason}", where=str(self.path), hint="choose another path"
            ) from error

    def _drop_stale_link(self, path: Path) -> None:
        target = str(path.readlink())
        if not _PTS.fullmatch(target):
            raise UsageError(f"is a link to {target}", where=str(path), hint="remove it or choose another path")
        # The number of a pseudo-terminal that died is given out again, perhaps to the one just made.
        if target != self.slave_name and Path(target).exists():
            raise UnavailableError(
                f"leads to {target}, which is in use",
                where=str(path),
                hint="stop the other bench or choose another path",
            )
        path.unlink()

    def _release(self) -> None:
        for source in (self._input, self._comings):
            self._scheduler.remove_source(source)
        if self.path is not None and self.path.is_symlink() and str(self.path.readlink()) == self.slave_name:
            self.path.unlink()
        self._watch.close()
        os.close(self._master)
        if self._slave >= 0:
            os.close(self._slave)


def _trailing_closings(happened: list[bool]) -> int:
    """Return how many closings follow the last opening."""
    return happened[::-1].index(True) if True in happened else len(happened)
