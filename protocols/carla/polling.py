"""The simulator's receiver as it was shipped: one read in each 20 ms, into a buffer that keeps what it held.

Sources: LMA-FEM-UNICAMP/carla_serial_bridge, carla_serial_bridge_node.cpp `timer_callback` and serial_com.cpp. A read
of k bytes overwrites the first k of 30; then all 30 are parsed from START. A read that fails parses them once more. A
read that finds nothing waits for half a second, with the node's only thread, and blanks the first byte.

`PollStreamReader` reads and waits at the same times and is sound otherwise, so that the waiting can be had by itself.
"""

from __future__ import annotations

from protocols.carla.frames import COMMAND_LAYOUT
from protocols.carla.options import PollOptions
from protocols.carla.reading import Dropped, DropReason, Found, LiveParser, StreamReader

__all__ = ["TTY_BYTES", "PollReader", "PollStreamReader"]

TTY_BYTES = 4096
"""What Linux's line discipline keeps for a reader (N_TTY_BUF_SIZE); more is lost."""

_NS_PER_S = 1_000_000_000
_MODE_TAG = ord("M")
_CR_TO_LF = bytes.maketrans(b"\r", b"\n")


class PollReader:
    """Reads as the bridge does.

    Args:
        options: its figures.
        idle_block_s: how long a read that finds nothing waits, in seconds; None: not at all.
        icrnl: a carriage return is read as a newline.
        epoch_ns: the time of the first read, in ns of bench time.

    Attributes:
        parser: the original's parser, with its live fields.
        polls: reads that yielded bytes.
        blocks: reads that found nothing and waited.
        errors: reads that failed.
    """

    def __init__(self, options: PollOptions, *, idle_block_s: float | None, icrnl: bool, epoch_ns: int) -> None:
        self.parser = LiveParser(COMMAND_LAYOUT)
        self._failing = False
        self.polls = self.blocks = self.errors = 0
        self._options = options
        self._block_ns = None if idle_block_s is None else round(idle_block_s * _NS_PER_S)
        self._icrnl = icrnl
        self._period_ns = round(options.period_s * _NS_PER_S)
        self._gather_ns = round(options.gather_s * _NS_PER_S)
        self._buffer = bytearray(options.bytes_each)
        self._gathered = bytearray()
        self._gathered_at_ns: int | None = None
        self._tty = bytearray()
        self._tick_ns = epoch_ns
        self._blocked_until_ns: int | None = None

    @property
    def held(self) -> int:
        """Bytes that were not read yet."""
        return len(self._gathered) + len(self._tty)

    @property
    def blocked(self) -> bool:
        """A read waits for a byte, and so does all else."""
        return self._blocked_until_ns is not None

    def receive(self, data: bytes, now_ns: int) -> list[Found]:
        """Takes bytes that came at `now_ns`; they can be read when the adapter hands them on."""
        if data:
            self._gathered += data.translate(_CR_TO_LF) if self._icrnl else data
            if self._gathered_at_ns is None:
                self._gathered_at_ns = now_ns + self._gather_ns
        return []

    def next_deadline_ns(self) -> int | None:
        """When it does something next, in ns of bench time."""
        pending = self._tick_ns if self._blocked_until_ns is None else self._blocked_until_ns
        return pending if self._gathered_at_ns is None else min(pending, self._gathered_at_ns)

    def expire(self, now_ns: int) -> list[Found]:
        """Does what is due, one thing of it: bytes that are handed on first."""
        if self._gathered_at_ns is not None and self._gathered_at_ns <= now_ns:
            return self._hand_on(now_ns)
        if self._blocked_until_ns is not None and self._blocked_until_ns <= now_ns:
            self._blocked_until_ns = None
            self._buffer[0] = 0
            return []
        if self._blocked_until_ns is None and self._tick_ns <= now_ns:
            self._tick_ns += self._period_ns * (1 + (now_ns - self._tick_ns) // self._period_ns)
            return self._tick(now_ns)
        return []

    def fail(self, failing: bool) -> list[Found]:
        """Reads fail from now on, one that waits at once, or work again."""
        self._failing = failing
        if not failing or not self.blocked:
            return []
        self._blocked_until_ns = None
        return self._fail()

    def forget_mode(self) -> None:
        """Sets the mode variable to 0, as sending a status does."""
        self.parser.live[_MODE_TAG][0] = 0

    def _hand_on(self, now_ns: int) -> list[Found]:
        room = TTY_BYTES - len(self._tty)
        lost = bytes(self._gathered[room:])
        self._tty += self._gathered[:room]
        self._gathered.clear()
        self._gathered_at_ns = None
        found: list[Found] = [Dropped(reason=DropReason.OVERRUN, data=lost)] if lost else []
        if self.blocked:
            self._blocked_until_ns = None
            found += self._read(now_ns)
        return found

    def _tick(self, now_ns: int) -> list[Found]:
        if self._failing:
            return self._fail()
        if self._tty:
            return self._read(now_ns)
        if self._block_ns is None:
            self._buffer[0] = 0
        else:
            self.blocks += 1
            self._blocked_until_ns = now_ns + self._block_ns
        return []

    def _fail(self) -> list[Found]:
        self.errors += 1
        return [*self.parser.parse(bytes(self._buffer))]

    def _read(self, now_ns: int) -> list[Found]:
        del now_ns
        self.polls += 1
        taken = self._tty[: self._options.bytes_each]
        del self._tty[: len(taken)]
        self._buffer[: len(taken)] = taken
        return [*self.parser.parse(bytes(self._buffer))]


class PollStreamReader(PollReader):
    """Reads when the bridge does, and waits as it does; what it reads goes on where the read before ended.

    Args:
        options: its figures; it reads all that is there.
        idle_block_s: see `PollReader`.
        icrnl: as above.
        epoch_ns: as above.
        timeout_ns: how long after its first byte an unfinished frame is given up, in ns; None for never.
    """

    def __init__(
        self, options: PollOptions, *, idle_block_s: float | None, icrnl: bool, epoch_ns: int, timeout_ns: int | None
    ) -> None:
        super().__init__(options, idle_block_s=idle_block_s, icrnl=icrnl, epoch_ns=epoch_ns)
        self._frames = StreamReader(COMMAND_LAYOUT, lambda _frame: None, timeout_ns=timeout_ns)

    @property
    def held(self) -> int:
        """Bytes that were not read yet, and those of an unfinished frame."""
        return super().held + self._frames.held

    def next_deadline_ns(self) -> int | None:
        """When it does something next, in ns of bench time."""
        due = (super().next_deadline_ns(), self._frames.next_deadline_ns())
        return min((ns for ns in due if ns is not None), default=None)

    def expire(self, now_ns: int) -> list[Found]:
        """Does what is due, one thing of it, and gives up what has been unfinished for too long."""
        return [*self._frames.expire(now_ns), *super().expire(now_ns)]

    def _fail(self) -> list[Found]:
        self.errors += 1
        return []

    def _read(self, now_ns: int) -> list[Found]:
        self.polls += 1
        taken = bytes(self._tty)
        self._tty.clear()
        return self._frames.receive(taken, now_ns)
