"""What a session reports, in the order in which it happened.

`Transmit` carries the bytes that the machine itself wants on the line; they stand among the other events, so that the
order is the true one. Do not subclass these.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass

from protocols.common.events import FrameDropped, StateChanged, Transmit
from protocols.xrce.codes import Status
from protocols.xrce.objects import Agent, Client
from protocols.xrce.submessages import Submessage

__all__ = [
    "AgentTime",
    "CloseReason",
    "Event",
    "FrameDropped",
    "MessagesLost",
    "Pong",
    "Received",
    "Senseless",
    "SessionClosed",
    "SessionOpened",
    "StateChanged",
    "StreamsReset",
    "Transmit",
]


class CloseReason(enum.Enum):
    """Why there is no session any more."""

    DELETED = "the client has ended it"
    REFUSED = "the agent has refused it"
    NO_ANSWER = "the agent does not answer"
    REPLACED = "another client has begun one"
    SILENCE = "the client was silent for too long"
    FORGOTTEN = "the agent's user has ended it"
    LINE_DOWN = "the line went down"

    def __str__(self) -> str:
        return self.value


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionOpened:
    """There is a session; all streams begin at 0.

    Attributes:
        peer: what the other end says of itself.
        again: agent: the same client had one already, and may count on the objects that it has created.
    """

    peer: Client | Agent
    again: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionClosed:
    """There is no session; what was unacknowledged is lost.

    Attributes:
        reason: why.
        status: what the agent said, if it has refused the session.
    """

    reason: CloseReason
    status: Status | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Received:
    """A submessage for the program, never one that the machine handles; of a reliable stream each once, in order."""

    stream_id: int
    submessage: Submessage


@dataclass(frozen=True, slots=True, kw_only=True)
class StreamsReset:
    """The other end wants all streams to begin anew; what was unacknowledged is lost."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MessagesLost:
    """The other end does not have messages of a reliable stream that never came."""

    stream_id: int
    count: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Pong:
    """Client: the agent is there.

    Attributes:
        in_session: it has a session with somebody at this line.
    """

    in_session: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentTime:
    """Client: what the agent's clock says.

    Attributes:
        ahead_ns: how far it is ahead of this side's, in ns, if both ways take equally long.
        round_trip_ns: how long both ways took, in ns.
    """

    ahead_ns: int
    round_trip_ns: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Senseless:
    """A submessage in a sound message that makes no sense; those before and behind it are handled."""

    stream_id: int
    why: str


Event = (
    Transmit
    | StateChanged
    | FrameDropped
    | SessionOpened
    | SessionClosed
    | Received
    | StreamsReset
    | MessagesLost
    | Pong
    | AgentTime
    | Senseless
)
