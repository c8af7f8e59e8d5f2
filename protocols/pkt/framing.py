"""Frames: sync word, length or none, payload, CRC, newline; and the reader that finds them in any stream of bytes.

    LEN     50 4B 54 21  length  payload  CRC high  CRC low  0A
    TERM    50 4B 54 21          payload  CRC high  CRC low  0A

The first is that of all firmware (nhorro/ceai2020 and nhorro/rover-firmware, protocol.cpp), the second that of the
document and the manual. Nothing is escaped: without a length byte, a newline in payload or CRC ends the frame too
early.

What the reader promises:

- every byte received is reported exactly once, in order, in a `Frame` or in a `Dropped`;
- the results depend on the bytes and the times only, never on how the bytes were cut into pieces;
- between calls it keeps at most one unfinished frame or `NOISE_RUN` bytes of noise;
- the work is linear in the bytes received (a byte is looked at again only by the sync words in front of it that a frame
  could still reach from, at most a fourth of the longest frame).

The reader walks the table of `states.py`: byte by byte at the ends of a frame, in one step over its middle, and in one
step over a sound frame that has come as a whole, if the table leads through it.
"""

from __future__ import annotations

import enum
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from protocols.pkt.crc import CRC_BYTES, crc16
from protocols.pkt.errors import LocalProtocolError
from protocols.pkt.options import FrameTimer, Framing, FramingOptions
from protocols.pkt.states import FrameAction, FrameState, FrameTable, FrameTrigger, frame_table

__all__ = [
    "NOISE_RUN",
    "SYNC",
    "TERMINATOR",
    "DropReason",
    "Dropped",
    "Frame",
    "FrameReader",
    "encode_frame",
    "hides_newline",
    "longest_frame",
]

SYNC = b"PKT!"
TERMINATOR = b"\n"
NOISE_RUN = 256
"""Noise is reported in runs of at most this many bytes."""

_P = SYNC[0]
_NEWLINE = TERMINATOR[0]
_LENGTH_BYTES = 1
_NS_PER_S = 1_000_000_000
_DEFAULTS = FramingOptions()


def encode_frame(payload: bytes, options: FramingOptions = _DEFAULTS) -> bytes:
    """The whole frame around a payload.

    Raises:
        LocalProtocolError: the payload is empty, or longer than the options allow.
    """
    if not 1 <= len(payload) <= options.payload_limit:
        raise LocalProtocolError(f"a payload of {len(payload)} bytes is not 1..{options.payload_limit}")
    length = bytes((len(payload),)) if options.framing is Framing.LEN else b""
    return b"".join((SYNC, length, payload, crc16(payload).to_bytes(CRC_BYTES, "big"), TERMINATOR))


def hides_newline(payload: bytes) -> bool:
    """Payload or CRC hold a newline: without a length byte, a strict receiver loses this frame.

    The document has no escape for it. Random payloads of N bytes hold one with a probability of 1 - (255/256)^(N+2).
    """
    return _NEWLINE in payload or _NEWLINE in crc16(payload).to_bytes(CRC_BYTES, "big")


def longest_frame(options: FramingOptions = _DEFAULTS) -> int:
    """The size of the longest frame, in bytes."""
    length = _LENGTH_BYTES if options.framing is Framing.LEN else 0
    return len(SYNC) + length + options.payload_limit + CRC_BYTES + len(TERMINATOR)


class DropReason(enum.Enum):
    """Why bytes did not become a message."""

    NOISE = "no sync word"
    BAD_SYNC = "broken sync word"
    BAD_LENGTH = "length out of range"
    BAD_CRC = "wrong CRC"
    BAD_TERMINATOR = "no newline behind the CRC"
    TIMED_OUT = "unfinished frame abandoned"
    BAD_BODY = "sound frame, senseless payload"
    POLL_OF_ELEVEN = "a look of exactly eleven bytes thrown away"
    OVERRUN = "receive buffer full"


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """A sound frame.

    Attributes:
        raw: as it stood on the wire.
        payload: what it carries.
        behind: what the decoder's buffer holds behind the payload, left there by earlier frames; empty unless the
            reader keeps its buffer.
    """

    raw: bytes
    payload: bytes
    behind: bytes = b""


@dataclass(frozen=True, slots=True, kw_only=True)
class Dropped:
    """Bytes that belong to no sound frame."""

    reason: DropReason
    data: bytes


_REASONS = {
    FrameAction.FAIL_SYNC: DropReason.BAD_SYNC,
    FrameAction.FAIL_LENGTH: DropReason.BAD_LENGTH,
    FrameAction.FAIL_CRC: DropReason.BAD_CRC,
    FrameAction.FAIL_TERMINATOR: DropReason.BAD_TERMINATOR,
    FrameAction.ABANDON: DropReason.TIMED_OUT,
}
_SYNC_BYTES = {FrameState.SYNC1: SYNC[1], FrameState.SYNC2: SYNC[2], FrameState.SYNC3: SYNC[3]}
_WAITED_FOR = {**_SYNC_BYTES, FrameState.TERMINATOR: _NEWLINE}


class _Edge:
    """An edge of the table, ready to be taken."""

    __slots__ = ("acts", "begins", "count", "place")

    def __init__(self, place: _Place, acts: tuple[Callable[[], None], ...], begins: bool) -> None:
        self.place = place
        self.acts = acts
        self.begins = begins
        self.count = 0


class _Place:
    """A state of the table with what is done there."""

    __slots__ = ("edges", "state", "step", "waited_for")

    def __init__(self, state: FrameState, step: Callable[[bytes, int], int]) -> None:
        self.state = state
        self.step = step
        self.waited_for = _WAITED_FOR.get(state)
        self.edges: dict[FrameTrigger, _Edge] = {}


class FrameReader:
    """Finds the frames in a stream of bytes.

    Args:
        options: see `FramingOptions`.
        table: another machine than that of the options, for tests that must be able to fail.
        keep_buffer: keep what earlier frames left in the decoder's buffer, as the firmware's C array does, and hand it
            out behind each payload. It begins as zeros (on the chip: whatever stood on the stack).
        epoch_ns: when the decoder was first reset, in ns of bench time.
    """

    def __init__(
        self,
        options: FramingOptions = _DEFAULTS,
        *,
        table: FrameTable | None = None,
        keep_buffer: bool = False,
        epoch_ns: int = 0,
    ) -> None:
        self._whole_frames = 0
        table = frame_table(options) if table is None else table
        self._options = options
        self._body_limit = options.payload_limit + (0 if options.strict_diagram else CRC_BYTES)
        self._body_at = len(SYNC) + (_LENGTH_BYTES if options.framing is Framing.LEN else 0)
        self._way = _way_of_a_frame(table, options.framing)
        self._raw = bytearray()  # the frame so far, sync word and all
        self._noise = bytearray()
        self._length = 0
        self._newline_seen = False
        self._found: list[Frame | Dropped] = []
        self._dropped = Dropped(reason=DropReason.NOISE, data=b"")  # the last frame that failed
        self._buffer = bytearray(options.payload_limit + 1) if keep_buffer else None
        self._timeout_ns = round(options.timeout_s * _NS_PER_S)
        self._reset_ns = epoch_ns
        self._now_ns = self._held_since_ns = 0
        self._deadline_ns: int | None = None
        places = self._compile(table)
        self._places = tuple(places.values())
        self._place = places[FrameState.IDLE]

    def _compile(self, table: FrameTable) -> dict[FrameState, _Place]:
        """The table as places that know their edges: looking up pairs of enumerations takes most of a step."""
        steps: dict[FrameState, Callable[[bytes, int], int]] = {
            FrameState.IDLE: self._step_idle,
            **dict.fromkeys(_WAITED_FOR, self._step_waiting),
            FrameState.LENGTH: self._step_length,
            FrameState.PAYLOAD: self._step_payload,
            FrameState.CRC1: self._step_crc_high,
            FrameState.CRC2: self._step_crc_low,
            FrameState.BODY: self._step_body,
        }
        acts: dict[FrameAction, Callable[[], None]] = {
            FrameAction.BEGIN: self._begin,
            FrameAction.DISPATCH: self._dispatch,
            FrameAction.RESCAN: self._rescan,
            **{action: partial(self._drop, reason) for action, reason in _REASONS.items()},
        }
        places = {state: _Place(state, steps[state]) for state in FrameState}
        for (state, trigger), edge in table.items():
            place, begins = places[edge.next_state], FrameAction.BEGIN in edge.actions
            places[state].edges[trigger] = _Edge(place, tuple(acts[action] for action in edge.actions), begins)
        return places

    @property
    def state(self) -> FrameState:
        """Where the decoder is."""
        return self._place.state

    @property
    def visits(self) -> Counter[tuple[FrameState, FrameTrigger]]:
        """How often each edge of the table was taken."""
        stepped = {
            (place.state, trigger): edge.count for place in self._places for trigger, edge in place.edges.items()
        }
        return Counter(dict.fromkeys(self._way, self._whole_frames)) + Counter(stepped)

    @property
    def held(self) -> int:
        """How many bytes wait for more; never more than the longest frame or `NOISE_RUN`."""
        return len(self._raw) + len(self._noise)

    def next_deadline_ns(self) -> int | None:
        """When the bytes held are given up, in ns of bench time; None when none are held or no timer runs."""
        return self._deadline_ns

    def receive(self, data: bytes, now_ns: int) -> list[Frame | Dropped]:
        """Takes the bytes that came at `now_ns`, in ns of bench time, and returns what they complete."""
        found = self.expire(now_ns)
        if data:
            self._now_ns = max(now_ns, self._now_ns)
            self._feed(data)
            found += self._take_found()
            self._set_deadline()
        return found

    def expire(self, now_ns: int) -> list[Frame | Dropped]:
        """Gives up the bytes held if their time is over; frames that are searched again are still found."""
        if self._deadline_ns is not None and now_ns >= self._deadline_ns:
            self._now_ns = self._deadline_ns
            self._give_up()
        return self._take_found()

    def reset(self) -> list[Frame | Dropped]:
        """Gives up the bytes held at once: the line went down."""
        self._give_up()
        return self._take_found()

    def _give_up(self) -> None:
        """Ends every unfinished frame, one after the other where they are searched again, until nothing is held."""
        while self._raw and self._fire(FrameTrigger.TIME_UP):
            pass
        self._end_noise()
        self._reset_ns = self._now_ns
        self._deadline_ns = None

    def _take_found(self) -> list[Frame | Dropped]:
        found, self._found = self._found, []
        return found

    def _set_deadline(self) -> None:
        if not self.held or self._options.timer is FrameTimer.OFF:
            self._deadline_ns = None
            return
        since_ns = self._now_ns
        if self._options.timer is FrameTimer.SINCE_FIRST_BYTE:
            since_ns = self._held_since_ns
        elif self._options.timer is FrameTimer.SINCE_RESET:
            # With nothing in flight the decoder has reset itself once in each such time since.
            since_ns = self._reset_ns + (self._now_ns - self._reset_ns) // self._timeout_ns * self._timeout_ns
        self._deadline_ns = since_ns + self._timeout_ns

    def _feed(self, data: bytes) -> None:
        """Takes bytes, in as few steps as the table allows."""
        at, size = 0, len(data)
        while at < size:
            at = self._place.step(data, at)

    def _fire(self, trigger: FrameTrigger) -> bool:
        """Takes the edge for this trigger; says whether there is one."""
        edge = self._place.edges.get(trigger)
        if edge is None:
            return False
        edge.count += 1
        self._place = edge.place
        for act in edge.acts:
            act()
        return True

    def _drop(self, reason: DropReason) -> None:
        self._dropped = Dropped(reason=reason, data=bytes(self._raw))
        self._found.append(self._dropped)
        self._clear()

    def _begin(self) -> None:
        """A frame begins with the P just seen."""
        self._end_noise()
        self._raw[:] = SYNC[:1]
        self._held_since_ns = self._now_ns

    def _dispatch(self) -> None:
        self._deliver(bytes(self._raw))
        self._clear()

    def _deliver(self, raw: bytes) -> None:
        payload = raw[self._body_at : -CRC_BYTES - 1]
        behind = b""
        if self._buffer is not None:
            self._buffer[: len(payload) + 1] = payload + b"\0"
            behind = bytes(self._buffer[len(payload) :])
        self._found.append(Frame(raw=raw, payload=payload, behind=behind))
        self._reset_ns = self._now_ns

    def _clear(self) -> None:
        self._raw.clear()
        self._newline_seen = False
        self._reset_ns = self._now_ns

    def _rescan(self) -> None:
        """Reads on from the next sync word, or the beginning of one at the very end, in what was just dropped."""
        last = self._dropped
        at = _sync_start(last.data, 1)
        if at < len(last.data):
            self._found[-1] = Dropped(reason=last.reason, data=last.data[:at])
            self._feed(last.data[at:])

    def _end_noise(self) -> None:
        if self._noise:
            self._found.append(Dropped(reason=DropReason.NOISE, data=bytes(self._noise)))
            self._noise.clear()

    def _step_idle(self, data: bytes, at: int) -> int:
        start = data.find(_P, at)
        if start == at:
            end = self._end_of_sound_frame(data, at) if self._way else 0
            if end:
                self._take_whole(data[at:end])
                return end
            self._fire(FrameTrigger.EXPECTED)
            return at + 1
        end = min(len(data) if start < 0 else start, at + NOISE_RUN - len(self._noise))
        if not self._noise:
            self._held_since_ns = self._now_ns
        self._noise += data[at:end]
        if len(self._noise) == NOISE_RUN:
            self._end_noise()
        return end

    def _end_of_sound_frame(self, data: bytes, at: int) -> int:
        """Where the sound frame that begins at `at` ends; 0 if there is none, or not yet."""
        body_at = at + self._body_at
        if not data.startswith(SYNC, at) or body_at >= len(data):
            return 0
        if self._options.framing is Framing.LEN:
            length = data[body_at - 1]
            last = body_at + length + CRC_BYTES
            if not 1 <= length <= self._options.payload_limit or data[last : last + 1] != TERMINATOR:
                return 0
        else:
            last = data.find(_NEWLINE, body_at, body_at + self._body_limit + 1)
            if last - body_at <= CRC_BYTES:
                return 0
        return last + 1 if crc16(data[body_at:last]) == 0 else 0

    def _take_whole(self, raw: bytes) -> None:
        """What the steps from state to state would come to."""
        self._end_noise()
        self._whole_frames += 1
        self._deliver(raw)

    def _step_waiting(self, data: bytes, at: int) -> int:
        """Takes the one byte that stands at each of these places."""
        byte, place = data[at], self._place
        if byte == place.waited_for:
            self._raw.append(byte)
            self._fire(FrameTrigger.EXPECTED)
            return at + 1
        trigger = FrameTrigger.WRONG_P if byte == _P else FrameTrigger.WRONG
        edge = place.edges.get(trigger)
        if edge is None or not edge.begins:
            self._raw.append(byte)
        self._fire(trigger)
        return at + 1

    def _step_length(self, data: bytes, at: int) -> int:
        self._length = data[at]
        self._raw.append(self._length)
        good = 1 <= self._length <= self._options.payload_limit
        self._fire(FrameTrigger.GOOD_LENGTH if good else FrameTrigger.BAD_LENGTH)
        return at + 1

    def _step_payload(self, data: bytes, at: int) -> int:
        had = len(self._raw) - self._body_at
        taken = data[at : at + max(1, self._length - had)]
        self._raw += taken
        has = had + len(taken)
        if self._buffer is not None:
            self._buffer[had:has] = taken
        if has >= self._length:
            if self._buffer is not None:
                self._buffer[has] = 0  # protocol.cpp, `handle_pkt_state_expecting_payload`
            self._fire(FrameTrigger.COMPLETE)
        return at + len(taken)

    def _step_crc_high(self, data: bytes, at: int) -> int:
        self._raw.append(data[at])
        self._fire(FrameTrigger.CRC_HIGH)
        return at + 1

    def _step_crc_low(self, data: bytes, at: int) -> int:
        self._raw.append(data[at])
        # A CRC run over its own two bytes as well comes out as nothing.
        right = crc16(bytes(self._raw[self._body_at :])) == 0
        self._fire(FrameTrigger.GOOD_CRC if right else FrameTrigger.BAD_CRC)
        return at + 1

    def _step_body(self, data: bytes, at: int) -> int:
        """Takes bytes up to a newline, or to the first byte beyond the limit."""
        room = self._body_limit + self._body_at - len(self._raw)
        end = data.find(_NEWLINE, at, at + room + 1)
        taken = data[at : end + 1 if end >= 0 else at + room + 1]
        self._raw += taken
        if end >= 0:
            self._end_body()
        if len(taken) > room and self._place.state is FrameState.BODY:
            self._fire(FrameTrigger.TOO_LONG_AFTER_END if self._newline_seen else FrameTrigger.TOO_LONG)
        return at + len(taken)

    def _end_body(self) -> None:
        """A newline: the CRC says whether it is the end."""
        body = bytes(self._raw[self._body_at : -1])
        self._newline_seen = True
        right = len(body) > CRC_BYTES and crc16(body) == 0
        self._fire(FrameTrigger.GOOD_END if right else FrameTrigger.BAD_END)


_Cells = tuple[tuple[FrameState, FrameTrigger], ...]
_BEGINNING = (FrameTrigger.EXPECTED,) * len(SYNC)
_ENDINGS = {
    Framing.LEN: (
        *(FrameTrigger.GOOD_LENGTH, FrameTrigger.COMPLETE, FrameTrigger.CRC_HIGH, FrameTrigger.GOOD_CRC),
        FrameTrigger.EXPECTED,
    ),
    Framing.TERM: (FrameTrigger.GOOD_END,),
}


def _way_of_a_frame(table: FrameTable, framing: Framing) -> _Cells:
    """The edges that a sound frame takes; none if this table does not simply begin it, deliver it and end in IDLE."""
    cells: list[tuple[FrameState, FrameTrigger]] = []
    actions: list[FrameAction] = []
    state = FrameState.IDLE
    for trigger in (*_BEGINNING, *_ENDINGS[framing]):
        edge = table.get((state, trigger))
        if edge is None:
            return ()
        cells.append((state, trigger))
        actions += edge.actions
        state = edge.next_state
    simple = state is FrameState.IDLE and actions == [FrameAction.BEGIN, FrameAction.DISPATCH]
    return tuple(cells) if simple else ()


def _sync_start(data: bytes, at: int) -> int:
    """Where the next sync word, or the beginning of one at the very end, stands behind `at`; the end if nowhere."""
    start = data.find(SYNC, at)
    if start >= 0:
        return start
    for size in range(len(SYNC) - 1, 0, -1):
        if len(data) - size >= at and data.endswith(SYNC[:size]):
            return len(data) - size
    return len(data)
