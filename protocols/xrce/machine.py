"""Both ends of a session around the common state machine: messages, streams, timers, what the actions do."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass, replace

from protocols.common.flagged_connection import FlaggedMachine
from protocols.xrce.codes import NO_SESSION, NO_SESSION_WITH_KEY, NO_STREAM, has_client_key, is_reliable
from protocols.xrce.errors import LocalProtocolError, RemoteProtocolError
from protocols.xrce.events import Event, MessagesLost, Received, Senseless, StreamsReset
from protocols.xrce.framing import Dropped, DropReason, Frame, encode_frame
from protocols.xrce.message import Header, decode_header, encode_message, pack_submessages
from protocols.xrce.options import AgentOptions, ClientOptions, Framing
from protocols.xrce.states import TIMER_STATES, Action, State, Table, Timer, Trigger
from protocols.xrce.streams import ReliableInput, Streams
from protocols.xrce.submessages import (
    AckNack,
    Fragment,
    Heartbeat,
    Reset,
    Submessage,
    decode_submessage,
    encode_submessage,
    split_submessages,
)

__all__ = ["Counters", "Machine"]

_SUBHEADER_BYTES = _ALIGNMENT = 4


@dataclass(slots=True, kw_only=True)
class Counters:
    """What a session has seen, since it was made.

    Attributes:
        bytes_in: bytes received.
        bytes_out: bytes sent or handed out to be sent.
        frames_in: sound frames received, readable or not.
        frames_out: frames sent.
        noise: runs of bytes without a flag.
        cut_short: frames with a flag inside.
        not_for_us: frames for another address.
        bad_lengths: frames longer than the limit.
        bad_crcs: frames whose CRC is wrong.
        bad_bodies: messages without a whole header, and submessages that make no sense.
        foreign: messages that belong to no session, or another one.
        stale: messages of a stream that came before, or are older than one that did.
        repeated: messages of reliable streams that were sent again.
        lost: messages of reliable streams that the other end does not have any more.
        refused: messages of streams that are too many.
        misplaced: submessages that the other end has no business to send, or not now.
        ignored: triggers that the state has no edge for.
    """

    bytes_in: int = 0
    bytes_out: int = 0
    frames_in: int = 0
    frames_out: int = 0
    noise: int = 0
    cut_short: int = 0
    not_for_us: int = 0
    bad_lengths: int = 0
    bad_crcs: int = 0
    bad_bodies: int = 0
    foreign: int = 0
    stale: int = 0
    repeated: int = 0
    lost: int = 0
    refused: int = 0
    misplaced: int = 0
    ignored: int = 0


class Machine(FlaggedMachine[State, Trigger, Action, Timer, Event, Counters]):
    """One end of a session.

    Args:
        table: the edges.
        state: where it begins.
        options: those of its role.

    Attributes:
        streams: of the session; new ones with each session.
        session_id: of the session.
        client_key: of the session's client, or the one that it is to have.
        mtu: the longest message that may be sent, in bytes.
    """

    OPEN: State

    def __init__(self, table: Table, state: State, options: ClientOptions | AgentOptions) -> None:
        super().__init__(table, state, Counters(), timer_states=TIMER_STATES, step_timers=(Timer.RETRY,))
        self._stream_options = options.streams
        self._frames = options.frames
        self._epoch_ns = options.epoch_ns
        self.streams = Streams(options.streams)
        self.session_id = NO_SESSION
        self.client_key = b""
        self._of_session = False
        self._ready: dict[int, ReliableInput] = {}  # by stream: what is handed on behind the message that is handled
        self.mtu = min(options.mtu, options.frames.max_payload)

    @property
    def framing(self) -> Framing:
        """How messages stand on the line."""
        return self._frames.framing

    @framing.setter
    def framing(self, framing: Framing) -> None:
        if framing is not self._frames.framing:
            self._frames = replace(self._frames, framing=framing)

    # --- what comes

    def take_frame(self, frame: Frame) -> None:
        """Handles a sound frame."""
        try:
            header, body = decode_header(frame.payload)
        except RemoteProtocolError:
            self.drop(Dropped(reason=DropReason.BAD_BODY, data=frame.raw))
            return
        self.take_message(header, body)

    def take_message(self, header: Header, body: bytes) -> None:
        """Handles a message: one of the session, or one that needs none."""
        self._of_session = self.belongs(header)
        if self._of_session:
            self.take_streamed(header, body)
        elif self.heeds(header):
            self.take_body(body, header.stream_id)
        else:
            self.counters.foreign += 1
        self._hand_on()

    @abstractmethod
    def heeds(self, header: Header) -> bool:
        """A message that is not of the session can mean something."""

    @abstractmethod
    def take_said(self, said: Submessage, stream_id: int) -> None:
        """Handles a submessage that is peculiar to the role."""

    @property
    def inside(self) -> bool:
        """What is handled now came in the session that there is."""
        return self._of_session and self.state is self.OPEN

    def belongs(self, header: Header) -> bool:
        """The message is one of the session that there is."""
        key = self.client_key if has_client_key(self.session_id) else None
        return self.state is self.OPEN and (header.session_id, header.client_key) == (self.session_id, key)

    def take_streamed(self, header: Header, body: bytes) -> None:
        """Handles a message of the session by the rules of its stream."""
        stream_id = header.stream_id
        if stream_id == NO_STREAM:
            self.take_body(body, stream_id)
        elif is_reliable(stream_id):
            self._take_reliable(header, body)
        elif (one := self.streams.best_effort_input(stream_id)) is None:
            self.counters.refused += 1
        elif one.accepts(header.sequence):
            self.take_body(body, stream_id)
        else:
            self.counters.stale += 1

    def take_body(self, body: bytes, stream_id: int, *, whole: bool = False) -> None:
        """Handles the submessages of a message, or of fragments that are a whole."""
        raws = split_submessages(body)
        while True:
            try:
                raw = next(raws, None)
                if raw is None:
                    return
                said = decode_submessage(raw)
                if isinstance(said, Fragment):
                    self._take_fragment(said, stream_id, whole=whole)
                    continue
            except RemoteProtocolError as error:
                self.counters.bad_bodies += 1
                self.events.append(Senseless(stream_id=stream_id, why=str(error)))
                continue
            self._take_submessage(said, stream_id)

    def _take_submessage(self, said: Submessage, stream_id: int) -> None:
        match said:
            case AckNack() | Heartbeat() if not self.inside:
                self.counters.misplaced += 1
            case AckNack():
                self._take_acknack(said)
            case Heartbeat():
                self._take_heartbeat(said)
            case _:
                self.take_said(said, stream_id)

    def _take_fragment(self, said: Fragment, stream_id: int, *, whole: bool) -> None:
        one = None if whole or not self.inside else self.streams.reliable_input(stream_id)
        if one is None:
            raise RemoteProtocolError("a fragment where none can be")
        body = one.fragments.add(said.data, last=said.last)
        if body is not None:
            self.take_body(body, stream_id, whole=True)

    def _take_reliable(self, header: Header, body: bytes) -> None:
        one = self.streams.reliable_input(header.stream_id)
        if one is None:
            self.counters.refused += 1
            return
        self.counters.stale += not one.take(header.sequence, body)
        self._ready[header.stream_id] = one

    def _hand_on(self) -> None:
        """Handles what is complete, until that ends the session, and says what was received.

        What that makes ready waits for its turn: a message is handled to its end before the next one.
        """
        while self._ready:
            stream_id, one = next(iter(self._ready.items()))
            while self.streams.reliable_input(stream_id) is one and (body := one.next()) is not None:
                self.take_body(body, stream_id)
            del self._ready[stream_id]
            if self.inside and self.streams.reliable_input(stream_id) is one:
                self.reply(one.acknack())

    def _take_acknack(self, said: AckNack) -> None:
        output = self.streams.reliable_outputs.get(said.stream_id)
        if output is None:
            self.counters.misplaced += 1
            return
        for number, body in output.acknowledge(said, self.now_ns):
            self.counters.repeated += 1
            self.transmit(self._frame(said.stream_id, number, body))
        for number, body in output.sendable(self.now_ns):
            self.transmit(self._frame(said.stream_id, number, body))
        self.wait_for_acknacks()

    def _take_heartbeat(self, said: Heartbeat) -> None:
        one = self.streams.reliable_input(said.stream_id)
        if one is None:
            self.counters.misplaced += 1
            return
        lost = one.announced(said)
        if lost:
            self.counters.lost += lost
            self.events.append(MessagesLost(stream_id=said.stream_id, count=lost))
        self._ready[said.stream_id] = one

    def hand_over(self, said: Submessage, stream_id: int, kinds: tuple[type, ...]) -> None:
        """Reports a submessage of one of these kinds to the program."""
        if self.inside and isinstance(said, kinds):
            self.events.append(Received(stream_id=stream_id, submessage=said))
        else:
            self.counters.misplaced += 1

    # --- what goes

    def outgoing(self, submessages: Iterable[Submessage], stream_id: int) -> list[bytes]:
        """The frames in which submessages go on a stream now; on a reliable one they may have to wait.

        Raises:
            LocalProtocolError: they do not fit.
            StreamFullError: they would have to wait, and too much waits already.
        """
        body = pack_submessages(map(encode_submessage, submessages))
        room = self.mtu - self.header(stream_id).size
        if is_reliable(stream_id):
            output = self.streams.reliable_output(stream_id)
            output.push([body] if len(body) <= room else list(_fragments(body, room - _SUBHEADER_BYTES)))
            frames = [self._frame(stream_id, *numbered) for numbered in output.sendable(self.now_ns)]
            self.wait_for_acknacks()
            return frames
        if len(body) > room:
            raise LocalProtocolError(f"{len(body)} bytes where one message has {room}; a reliable stream has several")
        number = 0 if stream_id == NO_STREAM else self.streams.best_effort_output(stream_id).number()
        return [self._frame(stream_id, number, body)]

    def reply(self, said: Submessage, header: Header | None = None) -> None:
        """Sends a submessage outside of any stream, by default in the session that there is."""
        self.transmit(self.unnumbered(said, header))

    def unnumbered(self, said: Submessage, header: Header | None = None) -> bytes:
        """The frame of a submessage outside of any stream, by default in the session or, without one, in none."""
        if header is None:
            header = self.header() if self.state is self.OPEN else self.outer_header()
        return self._framed(encode_message(header, encode_submessage(said)))

    def header(self, stream_id: int = NO_STREAM, sequence: int = 0) -> Header:
        """The header of a message of the session."""
        key = self.client_key if has_client_key(self.session_id) else None
        return Header(session_id=self.session_id, stream_id=stream_id, sequence=sequence, client_key=key)

    def outer_header(self) -> Header:
        """The header of a message of the session's client that belongs to no session."""
        if has_client_key(self.session_id):
            return Header(session_id=NO_SESSION_WITH_KEY, client_key=self.client_key)
        return Header(session_id=NO_SESSION)

    def _frame(self, stream_id: int, number: int, body: bytes) -> bytes:
        return self._framed(encode_message(self.header(stream_id, number), body))

    def _framed(self, message: bytes) -> bytes:
        return encode_frame(message, self._frames)

    # --- what both roles do

    @property
    def clock_ns(self) -> int:
        """What this side's clock says, in ns."""
        return self._epoch_ns + self.now_ns

    def wait_for_acknacks(self) -> None:
        """Waits until the next HEARTBEAT is due."""
        due_ns = self.streams.due_ns
        if due_ns is None or self.state is not self.OPEN:
            self._timers.pop(Timer.HEARTBEAT, None)
        else:
            self._timers[Timer.HEARTBEAT] = due_ns

    def act(self, action: Action, trigger: Trigger) -> None:
        """Carries out one action of an edge; those of the roles are theirs."""
        match action:
            case Action.RESET_STREAMS:
                self.streams = Streams(self._stream_options)
                self.wait_for_acknacks()
            case Action.SEND_HEARTBEATS:
                due = [output.heartbeat(self.now_ns) for output in self.streams.reliable_outputs.values()]
                for said in filter(None, due):
                    self.reply(said)
                self.wait_for_acknacks()
            case Action.SEND_RESET:
                self.reply(Reset())
            case Action.REPORT_RESET:
                self.events.append(StreamsReset())
            case _:
                self.act_in_role(action, trigger)

    @abstractmethod
    def act_in_role(self, action: Action, trigger: Trigger) -> None:
        """Carries out one action of the role."""


def _fragments(body: bytes, size: int) -> Iterable[bytes]:
    """Submessages in pieces of at most so many bytes, each of them a submessage itself.

    All but the last are multiples of 4, so that nothing aligned is cut, whoever puts them together.
    """
    size -= size % _ALIGNMENT
    for at in range(0, len(body), size):
        yield encode_submessage(Fragment(data=body[at : at + size], last=at + size >= len(body)))
