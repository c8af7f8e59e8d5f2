"""The streams of a session: what is sent again, what is waited for, what is kept; all of it bounded.

A reliable stream numbers its messages. The sender keeps what is not acknowledged, at most a window of it, says in
HEARTBEAT from where to where that is, and sends again what an ACKNACK names as missing, but none twice within
`repeat_s`: one lost message is named in the answer to each that follows it. The receiver hands on message
after message without a gap; what comes too early it keeps, what comes again it drops. It answers each message and each
HEARTBEAT with an ACKNACK, as eProsima's client and agent do (session.c, Processor.cpp); in the specification (OMG
DDS-XRCE 1.0, 8.4.14) only a HEARTBEAT is answered.

Bodies are what stands behind the header of a message. None of this knows bytes on a line or what submessages mean, but
for FRAGMENT.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

from protocols.xrce.codes import BUILTIN_RELIABLE, is_reliable
from protocols.xrce.errors import LocalProtocolError, RemoteProtocolError, StreamFullError
from protocols.xrce.options import StreamOptions
from protocols.xrce.sequence import BEFORE_FIRST, after, ahead, is_newer
from protocols.xrce.submessages import AckNack, Heartbeat

__all__ = ["BestEffortInput", "BestEffortOutput", "Fragments", "Numbered", "ReliableInput", "ReliableOutput", "Streams"]

_NS_PER_S = 1_000_000_000
_BITMAP_BITS = 16

Numbered = tuple[int, bytes]
"""A sequence number and a body."""


class BestEffortOutput:
    """Numbers messages."""

    def __init__(self) -> None:
        self._next = 0

    def number(self) -> int:
        """The number of one more message."""
        number, self._next = self._next, after(self._next)
        return number


class BestEffortInput:
    """Takes what is newer than all before it."""

    def __init__(self) -> None:
        self._latest = BEFORE_FIRST

    def accepts(self, number: int) -> bool:
        """The message is to be handed on."""
        newer = is_newer(number, self._latest)
        if newer:
            self._latest = number
        return newer


@dataclass(slots=True)
class _Sent:
    """A message that is not acknowledged; when it may be sent again, in ns."""

    body: bytes
    again_ns: int


class ReliableOutput:
    """Keeps messages until they are acknowledged.

    Args:
        stream_id: of the stream.
        options: window, times and limits.
    """

    def __init__(self, stream_id: int, options: StreamOptions) -> None:
        self._stream_id = stream_id
        self._options = options
        self._first = 0
        self._sent: deque[_Sent] = deque()
        self._waiting: deque[bytes] = deque()
        self._waiting_bytes = 0
        self._pause_ns = self._shortest_ns = round(options.heartbeat_s * _NS_PER_S)
        self._repeat_ns = round(options.repeat_s * _NS_PER_S)
        self._longest_ns = round(options.heartbeat_max_s * _NS_PER_S)
        self.due_ns: int | None = None

    @property
    def unacknowledged(self) -> int:
        """Messages that were sent or wait, and are not acknowledged."""
        return len(self._sent) + len(self._waiting)

    @property
    def held(self) -> int:
        """Bytes of these."""
        return sum(len(one.body) for one in self._sent) + self._waiting_bytes

    def push(self, bodies: list[bytes]) -> None:
        """Takes messages, to be sent by `sendable`.

        Raises:
            LocalProtocolError: even an empty stream could not take them; none is taken then.
            StreamFullError: those that would have to wait are too many bytes; none is taken then.
        """
        most, at_least = self._options.max_queued, sum(map(len, bodies[self._options.window :]))
        if at_least > most:
            raise LocalProtocolError(f"{at_least} bytes would wait where {most} may, however empty the stream is")
        free = self._options.window - len(self._sent)
        waiting = self._waiting_bytes + sum(map(len, bodies[free:]))
        if waiting > most:
            raise StreamFullError(
                f"stream {self._stream_id:#04x} has {self.unacknowledged} messages unacknowledged; {waiting} bytes "
                f"would wait where {most} may"
            )
        self._waiting.extend(bodies)
        self._waiting_bytes += sum(map(len, bodies))

    def sendable(self, now_ns: int) -> Iterator[Numbered]:
        """Messages that the window has room for now."""
        while self._waiting and len(self._sent) < self._options.window:
            body = self._waiting.popleft()
            self._waiting_bytes -= len(body)
            number = after(self._first, len(self._sent))
            self._sent.append(_Sent(body, now_ns))
            if self.due_ns is None:
                self._restart(now_ns)
            yield number, body

    def acknowledge(self, said: AckNack, now_ns: int) -> list[Numbered]:
        """Drops what was received; returns what is missing, to be sent again, less what was sent again just now.

        An ACKNACK about other messages than those sent means nothing.
        """
        received = ahead(said.first_unacked, self._first)
        if received > len(self._sent):
            return []
        for _ in range(received):
            self._sent.popleft()
        self._first = said.first_unacked
        self._restart(now_ns)
        missing = [
            (after(self._first, bit), one)
            for bit, one in enumerate(self._sent)
            if said.nack_bitmap >> bit & 1 and one.again_ns <= now_ns
        ]
        for _, one in missing:
            one.again_ns = now_ns + self._repeat_ns
        return [(number, one.body) for number, one in missing]

    def heartbeat(self, now_ns: int) -> Heartbeat | None:
        """What is unacknowledged, if it is time to say so."""
        if self.due_ns is None or now_ns < self.due_ns:
            return None
        self._pause_ns = min(2 * self._pause_ns, self._longest_ns)
        self.due_ns = now_ns + self._pause_ns
        last = after(self._first, len(self._sent) - 1)
        return Heartbeat(first_unacked=self._first, last_unacked=last, stream_id=self._stream_id)

    def _restart(self, now_ns: int) -> None:
        self._pause_ns = self._shortest_ns
        self.due_ns = now_ns + self._pause_ns if self._sent else None


class ReliableInput:
    """Hands messages on in order.

    Args:
        stream_id: of the stream.
        options: window and limits.
    """

    def __init__(self, stream_id: int, options: StreamOptions) -> None:
        self._stream_id = stream_id
        self._window = options.window
        self._expected = 0
        self._latest = BEFORE_FIRST
        self._early: dict[int, bytes] = {}
        self.fragments = Fragments(options.max_message)

    @property
    def held(self) -> int:
        """Bytes that are kept: messages that came too early, and fragments."""
        return sum(map(len, self._early.values())) + self.fragments.held

    def take(self, number: int, body: bytes) -> bool:
        """Takes a message, to be handed on by `next`; whether it is one more."""
        if ahead(number, self._expected) >= self._window or number in self._early:
            return False
        self._early[number] = body
        self._announce(number)
        return True

    def next(self) -> bytes | None:
        """The next message in order, if it has come."""
        body = self._early.pop(self._expected, None)
        if body is not None:
            self._expected = after(self._expected)
        return body

    def announced(self, said: Heartbeat) -> int:
        """Takes a HEARTBEAT; returns how many messages the sender does not have any more.

        That is never so with a sender that keeps to the protocol; if it is, the stream goes on behind them.
        """
        self._announce(said.last_unacked)
        if not is_newer(said.first_unacked, self._expected):
            return 0
        lost = ahead(said.first_unacked, self._expected)
        self._expected = said.first_unacked
        self._early = {number: body for number, body in self._early.items() if not is_newer(self._expected, number)}
        self._announce(after(self._expected, -1))
        self.fragments.drop()
        return lost

    def acknack(self) -> AckNack:
        """What was received, and what is missing of what is known to have been sent."""
        sent = ahead(after(self._latest), self._expected)
        missing = [bit for bit in range(min(sent, _BITMAP_BITS)) if after(self._expected, bit) not in self._early]
        return AckNack(
            first_unacked=self._expected, nack_bitmap=sum(1 << bit for bit in missing), stream_id=self._stream_id
        )

    def _announce(self, number: int) -> None:
        if is_newer(number, self._latest):
            self._latest = number


class Fragments:
    """Puts submessages together that came in pieces.

    Args:
        most: bytes that are kept; a longer one is passed over up to its last piece.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._pieces = bytearray()
        self._too_long = False

    @property
    def held(self) -> int:
        """Bytes that are kept."""
        return len(self._pieces)

    def add(self, data: bytes, *, last: bool) -> bytes | None:
        """Takes a piece; returns the whole with the last one.

        Raises:
            RemoteProtocolError: this was the last piece of one that is too long.
        """
        self._too_long |= len(self._pieces) + len(data) > self._most
        if not self._too_long:
            self._pieces += data
        if not last:
            return None
        whole, too_long = bytes(self._pieces), self._too_long
        self.drop()
        if too_long:
            raise RemoteProtocolError(f"fragments of more than {self._most} bytes")
        return whole

    def drop(self) -> None:
        """Forgets the pieces."""
        self._pieces.clear()
        self._too_long = False


class Streams:
    """All streams of a session, each made when it is first used.

    Args:
        options: windows, times and limits.
    """

    def __init__(self, options: StreamOptions) -> None:
        self._options = options
        self.reliable_outputs: dict[int, ReliableOutput] = {}
        self._best_effort_outputs: dict[int, BestEffortOutput] = {}
        self._reliable_inputs: dict[int, ReliableInput] = {}
        self._best_effort_inputs: dict[int, BestEffortInput] = {}

    @property
    def unacknowledged(self) -> int:
        """Messages on all reliable streams that are not acknowledged."""
        return sum(output.unacknowledged for output in self.reliable_outputs.values())

    @property
    def held(self) -> int:
        """Bytes that all streams keep."""
        sent = sum(output.held for output in self.reliable_outputs.values())
        return sent + sum(one.held for one in self._reliable_inputs.values())

    @property
    def due_ns(self) -> int | None:
        """When the next HEARTBEAT is due, in ns."""
        return min((one.due_ns for one in self.reliable_outputs.values() if one.due_ns is not None), default=None)

    def reliable_output(self, stream_id: int) -> ReliableOutput:
        """The one of this id.

        Raises:
            LocalProtocolError: it is one too many.
        """
        outputs, most = self.reliable_outputs, self._options.max_streams
        if stream_id not in outputs:
            if stream_id != BUILTIN_RELIABLE and len(outputs.keys() - {BUILTIN_RELIABLE}) >= most:
                raise LocalProtocolError(f"stream {stream_id:#04x} is one too many: {most} streams are sent on")
            outputs[stream_id] = ReliableOutput(stream_id, self._options)
        return outputs[stream_id]

    def best_effort_output(self, stream_id: int) -> BestEffortOutput:
        """The one of this id."""
        return self._best_effort_outputs.setdefault(stream_id, BestEffortOutput())

    def reliable_input(self, stream_id: int) -> ReliableInput | None:
        """The one of this id; None if it is no reliable one, or one too many."""
        inputs = self._reliable_inputs
        if stream_id not in inputs and is_reliable(stream_id) and len(inputs) < self._options.max_streams:
            inputs[stream_id] = ReliableInput(stream_id, self._options)
        return inputs.get(stream_id)

    def best_effort_input(self, stream_id: int) -> BestEffortInput | None:
        """The one of this id; None if it is one too many."""
        inputs = self._best_effort_inputs
        if stream_id not in inputs and len(inputs) < self._options.max_streams:
            inputs[stream_id] = BestEffortInput()
        return inputs.get(stream_id)
