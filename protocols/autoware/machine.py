"""Both ends of the stand-in link around the common state machine: counters, timers, what the actions do."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

from protocols.autoware.errors import RemoteProtocolError
from protocols.autoware.events import (
    AgentAbsent,
    AgentFound,
    BoardFound,
    BoardLost,
    Event,
    LossReason,
    MessageReceived,
)
from protocols.autoware.messages import AgentOnline, AgentPing, Message
from protocols.autoware.options import AgentOptions, BoardOptions, FramingOptions
from protocols.autoware.payload import UnknownMessage, decode_message, encode_message
from protocols.autoware.stand_in import Dropped, DropReason, Frame, encode_frame
from protocols.autoware.states import (
    AGENT_TABLE,
    BOARD_TABLE,
    TIMER_STATES,
    Action,
    AgentState,
    AgentTrigger,
    BoardState,
    BoardTrigger,
    State,
    Table,
    Timer,
    Trigger,
)
from protocols.common.flagged_connection import FlaggedMachine

__all__ = ["AgentMachine", "BoardMachine", "Counters", "Machine"]


@dataclass(slots=True, kw_only=True)
class Counters:
    """What a connection has seen, since it was made.

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
        bad_bodies: sound frames whose payload makes no sense.
        unknown: sound frames with an unknown id.
        pings: board: sent; agent: answered.
        silences: agent: times that the board was silent for too long.
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
    unknown: int = 0
    pings: int = 0
    silences: int = 0
    ignored: int = 0


class Machine(FlaggedMachine[State, Trigger, Action, Timer, Event, Counters]):
    """One end of the line."""

    def __init__(self, table: Table, state: State, frames: FramingOptions) -> None:
        super().__init__(table, state, Counters(), timer_states=TIMER_STATES)
        self._frames = frames

    @abstractmethod
    def take_message(self, message: Message | UnknownMessage) -> None:
        """Handles a message of the other end."""

    def take_frame(self, frame: Frame) -> None:
        """Handles a sound frame."""
        try:
            message = decode_message(frame.payload)
        except RemoteProtocolError:
            self.drop(Dropped(reason=DropReason.BAD_BODY, data=frame.raw))
            return
        self.counters.unknown += isinstance(message, UnknownMessage)
        self.take_message(message)

    def encode(self, message: Message | UnknownMessage) -> bytes:
        """The whole frame of a message."""
        return encode_frame(encode_message(message), self._frames)


class BoardMachine(Machine):
    """Asks after a reset whether an agent is there."""

    def __init__(self, options: BoardOptions, table: Table | None, epoch_ns: int) -> None:
        super().__init__(BOARD_TABLE if table is None else table, BoardState.SEEKING, options.frames)
        self._options = options
        self.now_ns = epoch_ns
        self._timers[Timer.PING] = epoch_ns

    def take_message(self, message: Message | UnknownMessage) -> None:
        """Handles a message of the agent."""
        if not isinstance(message, AgentOnline):
            self.events.append(MessageReceived(message=message))
        elif self._options.reconnects or self.state is not BoardState.ABSENT:
            self.fire(BoardTrigger.AGENT_ONLINE)

    def trigger_of(self, timer: Timer) -> Trigger:  # noqa: ARG002 - there is but one
        """The trigger of the timer of pings."""
        return BoardTrigger.PING_DUE if self.counters.pings < self._options.pings else BoardTrigger.GIVE_UP

    def act(self, action: Action, trigger: Trigger) -> None:  # noqa: ARG002 - none depends on it
        """Carries out one action of an edge."""
        match action:
            case Action.SEND_PING:
                self.counters.pings += 1
                self.transmit(self.encode(AgentPing()))
                self.start(Timer.PING, self._options.ping_s)
            case Action.REPORT_AGENT:
                self.events.append(AgentFound())
            case Action.REPORT_NO_AGENT:
                self.events.append(AgentAbsent())


class AgentMachine(Machine):
    """Says that it is there, and notices when the board falls silent."""

    def __init__(self, options: AgentOptions, table: Table | None) -> None:
        super().__init__(AGENT_TABLE if table is None else table, AgentState.CLOSED, options.frames)
        self._options = options

    def take_message(self, message: Message | UnknownMessage) -> None:
        """Handles a message of the board."""
        if isinstance(message, AgentPing):
            self.fire(AgentTrigger.PING)
            return
        self.fire(AgentTrigger.FRAME)
        self.events.append(MessageReceived(message=message))

    def trigger_of(self, timer: Timer) -> Trigger:  # noqa: ARG002 - there is but one
        """The trigger of the timer of silence."""
        return AgentTrigger.SILENCE

    def act(self, action: Action, trigger: Trigger) -> None:
        """Carries out one action of an edge."""
        match action:
            case Action.SAY_ONLINE:
                self.counters.pings += trigger is AgentTrigger.PING
                self.transmit(self.encode(AgentOnline()))
            case Action.FEED_SILENCE:
                self.start(Timer.SILENCE, self._options.silence_s)
            case Action.REPORT_FOUND:
                self.events.append(BoardFound())
            case Action.REPORT_LOST:
                self.counters.silences += trigger is AgentTrigger.SILENCE
                down = trigger is AgentTrigger.LINE_DOWN
                self.events.append(BoardLost(reason=LossReason.LINE_DOWN if down else LossReason.SILENCE))
