"""How frames are found: as the originals do it, and so that a damaged byte costs what it hit and no more.

The original's parser is the same on both sides, but for the letters; `PARSER_TABLE` is its machine. Its fields are
live: they are written as they come, and a frame that dies half-way leaves old and new side by side.
Sources: microAutoware taksControl.c `HAL_UART_RxCpltCallback`; carla_serial_bridge_node.cpp `timer_callback`.
"""

from __future__ import annotations

import enum
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from protocols.carla.frames import (
    END,
    START,
    STATUS_BYTES,
    STATUS_LAYOUT,
    CommandFrame,
    Layout,
    StatusFrame,
    decode_command,
    decode_status,
)

__all__ = [
    "NOISE_RUN",
    "PARSER_TABLE",
    "BlockReader",
    "DropReason",
    "Dropped",
    "Found",
    "LiveParser",
    "ParserState",
    "ParserTrigger",
    "StreamReader",
    "message_of",
]

NOISE_RUN = 256
"""Bytes of noise after which it is reported, though it goes on (choice)."""


class DropReason(enum.Enum):
    """Why bytes did not become a message."""

    NOISE = "no frame begins here"
    BAD_LETTER = "another byte where a letter should stand"
    MISSING_FIELD = "the letter of a later field, or the end, too early"
    DUPLICATE_FIELD = "the letter of an earlier field again"
    TIMED_OUT = "unfinished for too long"
    NOT_FINITE = "a NaN or an infinity"
    IMPLAUSIBLE = "a value beyond what can be true"
    UNKNOWN_MODE = "a mode that nobody knows"
    EMPTY_BLOCK = "a block of 22 bytes in which no frame ends"
    OVERRUN = "the receive buffer was full"

    def __str__(self) -> str:
        return self.value


@dataclass(frozen=True, slots=True, kw_only=True)
class Dropped:
    """Bytes that did not become a message; `data` is what stood on the line."""

    reason: DropReason
    data: bytes


Found = StatusFrame | CommandFrame | Dropped


class ParserState(enum.Enum):
    """Where the original's parser is."""

    START = "waits for #"
    FIELDS = "waits for a letter or $ (IDLE)"
    DATA = "reads the bytes of a field, whatever they are"


class ParserTrigger(enum.Enum):
    """What the original's parser sees."""

    HASH = "#"
    LETTER = "the letter of a field"
    END = "$"
    OTHER = "another byte"
    MORE = "a byte of the field, not its last"
    LAST = "the last byte of the field"


_P, _T = ParserState, ParserTrigger

PARSER_TABLE: Mapping[tuple[ParserState, ParserTrigger], ParserState] = MappingProxyType(
    {
        (_P.START, _T.HASH): _P.FIELDS,
        **{(_P.START, trigger): _P.START for trigger in (_T.LETTER, _T.END, _T.OTHER)},
        (_P.FIELDS, _T.LETTER): _P.DATA,
        (_P.FIELDS, _T.END): _P.START,
        (_P.FIELDS, _T.HASH): _P.START,
        (_P.FIELDS, _T.OTHER): _P.START,
        (_P.DATA, _T.MORE): _P.DATA,
        (_P.DATA, _T.LAST): _P.FIELDS,
    }
)
"""The original's parser. At (FIELDS, END) a frame is complete, whatever fields it had; nothing is ever reported."""


def message_of(layout: Layout, raw: bytes) -> StatusFrame | CommandFrame:
    """The message in one whole frame."""
    return decode_status(raw) if layout is STATUS_LAYOUT else decode_command(raw)


class LiveParser:
    """The original's parser over a block of bytes, always from its start, with fields that outlive the block.

    Args:
        layout: the letters; the order of the fields does not matter to it.

    Attributes:
        live: the bytes of each field by its letter, zeros at first.
        visits: how often each edge of `PARSER_TABLE` was taken.
    """

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self.live = {field.tag: bytearray(field.size) for field in layout.fields}
        self.visits: Counter[tuple[ParserState, ParserTrigger]] = Counter()

    def parse(self, block: bytes) -> Iterator[StatusFrame | CommandFrame]:
        """Yields what the fields are at each end of a frame."""
        state, tag, at = _P.START, 0, 0
        for byte in block:
            if state is _P.DATA:
                self.live[tag][at] = byte
                at += 1
                trigger = _T.LAST if at == len(self.live[tag]) else _T.MORE
            else:
                trigger = self._trigger(byte)
            following = PARSER_TABLE[state, trigger]
            self.visits[state, trigger] += 1
            if trigger is _T.LETTER and following is _P.DATA:
                tag, at = byte, 0
            elif state is _P.FIELDS and trigger is _T.END:
                yield self.snapshot()
            state = following

    def snapshot(self) -> StatusFrame | CommandFrame:
        """What the fields are now."""
        body = bytes((START,)) + b"".join(bytes((tag,)) + data for tag, data in self.live.items()) + bytes((END,))
        return message_of(self.layout, body)

    def _trigger(self, byte: int) -> ParserTrigger:
        if byte == START:
            return _T.HASH
        if byte == END:
            return _T.END
        return _T.LETTER if byte in self.live else _T.OTHER


class BlockReader:
    """The board's receiver as it was shipped: blocks of 22 bytes, each parsed from its start.

    Promises: never raises, `held` below 22, the same finds however the bytes are cut.
    """

    def __init__(self) -> None:
        self.parser = LiveParser(STATUS_LAYOUT)
        self._block = bytearray()

    @property
    def held(self) -> int:
        """Bytes of the block that is not full yet."""
        return len(self._block)

    def receive(self, data: bytes, now_ns: int) -> list[Found]:
        """Takes bytes; returns what the blocks hold that they fill. A block may hold several ends of frames."""
        del now_ns
        self._block += data
        found: list[Found] = []
        while len(self._block) >= STATUS_BYTES:
            block = bytes(self._block[:STATUS_BYTES])
            del self._block[:STATUS_BYTES]
            statuses = list(self.parser.parse(block))
            found += statuses or [Dropped(reason=DropReason.EMPTY_BLOCK, data=block)]
        return found

    def next_deadline_ns(self) -> int | None:
        """It waits for ever."""
        return None

    def expire(self, now_ns: int) -> list[Found]:
        """Nothing is ever due."""
        del now_ns
        return []


class StreamReader:
    """Finds frames wherever they begin: every letter must stand in its place, what fails is searched again for ``#``.

    Promises: never raises, `held` below the length of a frame plus a run of noise, the same finds however the bytes are
    cut.

    Args:
        layouts: of the frames; where there are several, the first letter says which it is.
        check: why a frame whose letters are right is dropped all the same; None where it is not.
        timeout_ns: how long after its first byte an unfinished frame is given up, in ns; None for never.
    """

    def __init__(
        self,
        layouts: Layout | tuple[Layout, ...],
        check: Callable[[StatusFrame | CommandFrame], DropReason | None],
        *,
        timeout_ns: int | None = None,
    ) -> None:
        self._layouts = layouts if isinstance(layouts, tuple) else (layouts,)
        self._layout = self._layouts[0]
        self._check = check
        self._timeout_ns = timeout_ns
        self._held = bytearray()
        self._times: list[int] = []
        self._noise = bytearray()
        self._padding_may_come = False
        self._found: list[Found] = []

    @property
    def held(self) -> int:
        """Bytes of an unfinished frame, or of noise that was not reported yet."""
        return len(self._held) + len(self._noise)

    def next_deadline_ns(self) -> int | None:
        """When an unfinished frame is given up, in ns of bench time; None when there is none."""
        return self._times[0] + self._timeout_ns if self._times and self._timeout_ns is not None else None

    def receive(self, data: bytes, now_ns: int) -> list[Found]:
        """Takes the bytes that came at `now_ns`, in ns of bench time, and returns what they complete."""
        self._found = self.expire(now_ns)
        for byte in data:
            self._take(byte, now_ns)
        found, self._found = self._found, []
        return found

    def expire(self, now_ns: int) -> list[Found]:
        """Gives up what has been unfinished for too long."""
        found: list[Found] = []
        while (deadline_ns := self.next_deadline_ns()) is not None and deadline_ns <= now_ns:
            self._found = found
            self._give_up(DropReason.TIMED_OUT)
        return found

    def reset(self) -> list[Found]:
        """Gives up what is held; returns it."""
        self._found = []
        while self._held:
            self._give_up(DropReason.TIMED_OUT)
        self._end_noise()
        found, self._found = self._found, []
        return found

    def _take(self, byte: int, now_ns: int) -> None:
        padding, self._padding_may_come = self._padding_may_come, False
        if not self._held:
            if padding and byte in self._layout.padding:
                return
            if byte != START:
                self._noise.append(byte)
                if len(self._noise) == NOISE_RUN:
                    self._end_noise()
                return
            self._end_noise()
        elif len(self._held) == 1:
            self._choose(byte)
        letter = self._layout.letters.get(len(self._held))
        self._held.append(byte)
        self._times.append(now_ns)
        if letter is not None and byte != letter:
            self._give_up(self._reason(byte))
        elif len(self._held) == self._layout.length:
            self._complete()

    def _choose(self, letter: int) -> None:
        """Which kind of frame it is, by its first letter."""
        for layout in self._layouts:
            if layout.fields[0].tag == letter:
                self._layout = layout

    def _reason(self, byte: int) -> DropReason:
        """Why a byte is wrong where the letter of a field, or the end, should stand."""
        order = [field.tag for field in self._layout.fields]
        due = sum(1 for at in self._layout.letters if 0 < at < len(self._held) - 1)
        if byte == END or byte in order[due + 1 :]:
            return DropReason.MISSING_FIELD
        return DropReason.DUPLICATE_FIELD if byte in order else DropReason.BAD_LETTER

    def _give_up(self, reason: DropReason) -> None:
        """Drops the bytes up to the next # among them, and reads on from there."""
        at = self._held.find(START, 1)
        at = at if at > 0 else len(self._held)
        self._found.append(Dropped(reason=reason, data=bytes(self._held[:at])))
        rest, times = bytes(self._held[at:]), self._times[at:]
        self._held.clear()
        self._times = []
        for byte, time_ns in zip(rest, times, strict=True):
            self._take(byte, time_ns)

    def _complete(self) -> None:
        raw = bytes(self._held)
        self._held.clear()
        self._times = []
        self._padding_may_come = True
        frame = message_of(self._layout, raw)
        reason = self._check(frame)
        self._found.append(frame if reason is None else Dropped(reason=reason, data=raw))

    def _end_noise(self) -> None:
        if self._noise:
            self._found.append(Dropped(reason=DropReason.NOISE, data=bytes(self._noise)))
            self._noise.clear()
