"""A UART's two halves: the transmitter that lets bytes out at the baud rate, and what a receiver makes of them."""

from __future__ import annotations

import functools
import itertools
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from hilbench.clock import NS_PER_S, ClockDomain, EventClass
from hilbench.links.port import Line

_BYTES = tuple(bytes((value,)) for value in range(256))


@dataclass(frozen=True, slots=True, kw_only=True)
class Fate:
    """What becomes of one byte on a faulty line.

    Attributes:
        values: The bytes that go out in its stead; none for a byte that is lost (its time passes all the same).
        pause_ns: How long the line idles before them.
        cut: Whether what waits behind it is lost.
    """

    values: tuple[int, ...]
    pause_ns: int = 0
    cut: bool = False


class Injector(Protocol):
    """Decides what becomes of bytes."""

    def fate(self, value: int, at_ns: int) -> Fate | None:
        """Return what becomes of the byte that starts to shift out at `at_ns`; None if nothing happens to it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Gap:
    """A time without bytes on the line: silence, or a break."""

    duration_ns: int
    is_break: bool


class Timeline(Protocol):
    """Where a transmitter's time comes from: the scheduler, or a chip that runs ahead of it."""

    @property
    def now_ns(self) -> int:
        """The present, in ns of bench time."""

    def at(self, when_ns: int, action: Callable[[], None], *, order: EventClass, source: str) -> object:
        """Have `action` happen at `when_ns`."""


class Transmitter:
    """Lets bytes out one behind the other, each at the instant its last stop bit ends.

    Byte k of a busy period ends at floor((k + 1) * bits / baud) after the period's start: the rounding does not add
    up. Without pace (baud 0) everything waiting goes out in the next entry.

    Args:
        timeline: Whose time it keeps; usually the scheduler.
        source: Name for the scheduler's order.
        line: Baud rate and bits per byte.
        emit: Called with bytes that are out, and the bench time in ns.
        on_break: Called when a break ends.
        on_idle: Called when the last byte is out.
        depth: Bytes the queue holds, including the one that shifts out; None for no limit.
        group_ns: Bytes that end within this span are let out together, when the last of them is out. For ports where
            every write costs a system call; 0 lets out every byte by itself.
        injector: Decides what becomes of each byte.
        at_start: Let each byte out, and tell of each break, when it begins: for a receiver that does the rest of the
            waiting. Those of a group come with the first of them, each to begin when the one before it ends.

    Attributes:
        bits_per_byte: Bit times from the start bit to the end of the last stop bit.
        break_ns: How long the break is that `on_break` was called for last, in ns.
        recall: Takes back what of a group has not begun, given its size, and returns how many bytes that is; never all.
    """

    def __init__(
        self,
        timeline: Timeline,
        source: str,
        line: Line,
        emit: Callable[[bytes, int], None],
        *,
        on_break: Callable[[int], None] | None = None,
        on_idle: Callable[[int], None] | None = None,
        depth: int | None = None,
        group_ns: int = 0,
        injector: Injector | None = None,
        at_start: bool = False,
    ) -> None:
        self._timeline = timeline
        self._source = source
        self.bits_per_byte = line.bits_per_byte
        self.break_ns = 0
        self._emit = emit
        self._on_break = on_break
        self._on_idle = on_idle
        self._depth = depth
        self._group_ns = group_ns
        self._injector = injector
        self._at_start = at_start
        self.recall: Callable[[int], int] = lambda _count: 0
        self._queue: deque[int | _Gap] = deque()
        self._bulk = bytearray()  # instead of the queue, where bytes need not be looked at one by one
        self._shifting = 0  # items at the head of either that are on the line
        self._judged = 0  # items at the head of the queue whose fate is settled
        self._epoch_ns = 0
        self._bytes_since_epoch = 0
        self._generation = 0
        self.baud = line.baud

    @property
    def baud(self) -> int:
        """Bits per second, 0 for no pace; a change holds from the next byte on."""
        return self._baud

    @baud.setter
    def baud(self, baud: int) -> None:
        self._take_back()
        self._single_out()
        self._baud = baud
        self._domain = ClockDomain(baud) if baud else None
        self._new_epoch = True
        self.group_ns = self._group_ns

    @property
    def group_ns(self) -> int:
        """See the class; a change holds from the next byte on."""
        return self._group_ns

    @group_ns.setter
    def group_ns(self, group_ns: int) -> None:
        self._group_ns = group_ns
        self._group = max(1, group_ns // max(1, self.byte_ns)) if self._domain and self._injector is None else 1

    @property
    def byte_ns(self) -> int:
        """Duration of one byte in ns, rounded down; 0 without pace."""
        return self._domain.ns(self.bits_per_byte) if self._domain else 0

    @property
    def pending(self) -> int:
        """Bytes and gaps that are not out yet."""
        return len(self._queue) + len(self._bulk)

    @property
    def idle(self) -> bool:
        """True if nothing is on the line or waits for it."""
        return not (self._queue or self._bulk)

    def write(self, data: bytes) -> int:
        """Queue bytes; return how many found room."""
        if self._depth is not None:
            data = data[: max(0, self._depth - self.pending)]
        if self._bulk:
            self._bulk += data
        elif data and self._domain is None and self._injector is None and not (self._at_start or self._queue):
            self._bulk += data
            self._start_bulk()
        elif data:
            self._append(data)
        return len(data)

    def send_break(self, duration_ns: int) -> None:
        """Queue a break of `duration_ns`."""
        self._append((_Gap(duration_ns=duration_ns, is_break=True),))

    def strike_with(self, injector: Injector | None) -> None:
        """Have another injector decide what becomes of each byte, from those on that are written now."""
        self._injector = injector
        self.group_ns = self._group_ns

    def clear(self) -> int:
        """Forget everything that is not out yet; return how many bytes that were."""
        self._take_back()
        lost = sum(1 for item in self._queue if isinstance(item, int)) + len(self._bulk)
        self._queue.clear()
        self._bulk.clear()
        self._shifting = self._judged = 0
        self._generation += 1
        return lost

    def withdraw(self, keep: int, *, judged: bool = False) -> int:
        """Forget what waits but for the next `keep` bytes and those on the line; return how many bytes that were.

        What the injector has made of a byte stays whole once some of it is on the line, unless `judged` is set. Of
        bytes that are let out together, only the first counts as being on the line; or those that have begun.
        """
        self._take_back()
        keep = max(keep, 0 if judged else self._judged, self._shifting if self._at_start else min(self._shifting, 1))
        withdrawn = len(self._bulk[keep:])
        del self._bulk[keep:]
        while len(self._queue) > keep:
            withdrawn += isinstance(self._queue.pop(), int)
        self._shifting = min(self._shifting, keep)
        self._judged = min(self._judged, keep)
        return withdrawn

    def set_frame(self, baud: int, bits_per_byte: int) -> None:
        """Let bytes take so many bits each at a rate in bit/s, from the next on."""
        self._take_back()
        self.bits_per_byte = bits_per_byte
        self.baud = baud

    def _take_back(self) -> None:
        """Forget what is out of a group that was let out with its first byte, and have wait what has not begun."""
        if not self._at_start or self._shifting < 2:
            return
        waiting = self.recall(self._shifting)
        for _ in range(self._shifting - waiting - 1):
            self._queue.popleft()
        self._shifting = 1
        if waiting:
            assert self._domain is not None
            self._bytes_since_epoch -= waiting
            self._generation += 1
            self._book_end(self._epoch_ns + self._domain.ns(self._bytes_since_epoch * self.bits_per_byte))

    def _start_bulk(self) -> None:
        """Let all that waits be out in the next entry."""
        self._shifting = len(self._bulk)
        self._book_end(self._timeline.now_ns)

    def _end_bulk(self) -> None:
        out = bytes(self._bulk[: self._shifting])
        del self._bulk[: self._shifting]
        self._shifting = 0
        now_ns = self._timeline.now_ns
        if self._bulk:
            self._start_bulk()
        self._emit(out, now_ns)
        if self._on_idle is not None and self.idle:
            self._on_idle(now_ns)

    def _single_out(self) -> None:
        """From now on look at the bytes that wait one by one; what is on the line ends as it would have."""
        self._queue.extend(self._bulk)
        self._bulk.clear()

    def _append(self, items: bytes | tuple[_Gap]) -> None:
        self._single_out()
        was_idle = not self._queue
        self._queue.extend(items)
        if was_idle:
            self._new_epoch = True
            self._start_next()

    def _start_next(self) -> None:
        now_ns = self._timeline.now_ns
        if self._new_epoch:
            self._epoch_ns = now_ns
            self._bytes_since_epoch = 0
            self._new_epoch = False
        if self._injector is not None and not self._judged:
            self._judge(self._injector, now_ns)
        head = self._queue[0]
        if isinstance(head, _Gap):
            self._shifting = 1
            self._new_epoch = True
            end_ns = now_ns + head.duration_ns
        else:
            self._shifting = self._bytes_to_shift()
            self._bytes_since_epoch += self._shifting
            end_ns = now_ns
            if self._domain is not None:
                end_ns = self._epoch_ns + self._domain.ns(self._bytes_since_epoch * self.bits_per_byte)
        self._book_end(end_ns)
        if self._at_start:
            self._let_out(list(itertools.islice(self._queue, self._shifting)), now_ns)

    def _book_end(self, end_ns: int) -> None:
        action = functools.partial(self._end, self._generation)
        self._timeline.at(end_ns, action, order=EventClass.BYTE, source=self._source)

    def _bytes_to_shift(self) -> int:
        if self._injector is not None or (self._domain is not None and self._group == 1):
            return 1
        limit = len(self._queue) if self._domain is None else self._group
        count = 0
        for item in self._queue:
            if count == limit or isinstance(item, _Gap):
                break
            count += 1
        return count

    def _judge(self, injector: Injector, now_ns: int) -> None:
        head = self._queue[0]
        fate = injector.fate(head, now_ns) if isinstance(head, int) else None
        if fate is None:
            self._judged = 1
            return
        self._queue.popleft()
        if fate.cut:
            self._queue.clear()
        items: list[int | _Gap] = list(fate.values) or [_Gap(duration_ns=self.byte_ns, is_break=False)]
        if fate.pause_ns:
            items.insert(0, _Gap(duration_ns=fate.pause_ns, is_break=False))
        self._queue.extendleft(reversed(items))
        self._judged = len(items)

    def _end(self, generation: int) -> None:
        if generation != self._generation:
            return  # cleared since
        if self._bulk:
            self._end_bulk()
            return
        queue, count = self._queue, self._shifting
        out = [queue.popleft()] if count == 1 else [queue.popleft() for _ in range(count)]
        if self._judged:
            self._judged = max(0, self._judged - count)
        self._shifting = 0
        now_ns = self._timeline.now_ns
        if queue:
            self._start_next()
        if not self._at_start:
            self._let_out(out, now_ns)
        if self._on_idle is not None and self.idle:
            self._on_idle(now_ns)

    def _let_out(self, out: list[int | _Gap], now_ns: int) -> None:
        head = out[0]
        if not isinstance(head, _Gap):
            self._emit(_BYTES[head] if len(out) == 1 else bytes(item for item in out if isinstance(item, int)), now_ns)
        elif head.is_break and self._on_break is not None:
            self.break_ns = head.duration_ns
            self._on_break(now_ns)


@dataclass(frozen=True, slots=True, kw_only=True)
class Sampled:
    """A byte as a receiver sampled it; `framing_error` if the line was low where the stop bit was due."""

    value: int
    framing_error: bool


class Sampler:
    """A receiver listening at one rate to a line sent at another (8N1).

    It does what a UART does: it takes a falling edge for a start bit, samples the middle of each of the following
    bits at its own rate, and looks for the next falling edge once it has sampled the stop bit. Within some 5 % of the
    right rate that gives the bytes that were sent; beyond, the garbage a real line gives.

    Args:
        sent_baud: Rate of the transmitter, bit/s.
        own_baud: Rate of the receiver, bit/s.
    """

    def __init__(self, sent_baud: int, own_baud: int) -> None:
        self.sent_baud = sent_baud
        self.own_baud = own_baud
        self.wake_ns: int | None = None
        """When the byte that is being received will be complete; None between bytes."""
        self._bytes: deque[tuple[int, int]] = deque()  # start in ns, frame of ten bits, first bit lowest
        self._free_ns = 0

    def feed(self, start_ns: int, value: int) -> None:
        """Take note of a byte whose start bit began at `start_ns`; bytes must come in order."""
        self._bytes.append((start_ns, 0x200 | value << 1))

    def take(self, known_ns: int) -> list[Sampled]:
        """Return the bytes sampled by `known_ns`, the time up to which all that is on the line was fed."""
        out: list[Sampled] = []
        self.wake_ns = None
        while (edge_ns := self._next_edge_ns()) is not None:
            stop_ns = self._sample_ns(edge_ns, 9)
            if stop_ns >= known_ns:
                self.wake_ns = stop_ns + 1
                break
            value = sum(self._level(self._sample_ns(edge_ns, bit + 1)) << bit for bit in range(8))
            out.append(Sampled(value=value, framing_error=not self._level(stop_ns)))
            self._free_ns = stop_ns
        while self._bytes and self._bytes[0][0] + self._bit_start_ns(10) <= min(self._free_ns, known_ns):
            self._bytes.popleft()
        return out

    def _sample_ns(self, edge_ns: int, bit: int) -> int:
        return edge_ns + (2 * bit + 1) * NS_PER_S // (2 * self.own_baud)

    def _bit_start_ns(self, bit: int) -> int:
        return bit * NS_PER_S // self.sent_baud

    def _level(self, at_ns: int) -> int:
        for start_ns, frame in reversed(self._bytes):
            if start_ns <= at_ns:
                bit = ((at_ns - start_ns + 1) * self.sent_baud - 1) // NS_PER_S
                return frame >> bit & 1 if bit < 10 else 1
        return 1

    def _next_edge_ns(self) -> int | None:
        for start_ns, frame in self._bytes:
            falls = ~frame & (frame << 1 | 1)
            for bit in range(9):
                if falls >> bit & 1 and start_ns + self._bit_start_ns(bit) >= self._free_ns:
                    return start_ns + self._bit_start_ns(bit)
        return None


def resample(data: bytes, sent_baud: int, own_baud: int) -> list[Sampled]:
    """Return what a receiver at `own_baud` gets of `data` sent without gaps at `sent_baud`."""
    if sent_baud == own_baud or not sent_baud or not own_baud:
        return [Sampled(value=value, framing_error=False) for value in data]
    sampler = Sampler(sent_baud, own_baud)
    for index, value in enumerate(data):
        sampler.feed(index * 10 * NS_PER_S // sent_baud, value)
    return sampler.take((len(data) + 1) * 10 * NS_PER_S // sent_baud + 11 * NS_PER_S // own_baud)
