"""What a connection reports, in the order in which it happened.

`Transmit` carries the bytes that the machine itself wants on the line; they stand among the other events, so that the
order is the true one. Do not subclass these.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass

from protocols.autoware.messages import Message
from protocols.autoware.payload import UnknownMessage
from protocols.common.events import FrameDropped, StateChanged, Transmit

__all__ = [
    "AgentAbsent",
    "AgentFound",
    "BoardFound",
    "BoardLost",
    "Event",
    "FrameDropped",
    "LossReason",
    "MessageReceived",
    "StateChanged",
    "Transmit",
]


class LossReason(enum.Enum):
    """Why an agent lost its board."""

    SILENCE = "no frame for too long"
    LINE_DOWN = "the line went down"

    def __str__(self) -> str:
        return self.value


@dataclass(frozen=True, slots=True, kw_only=True)
class MessageReceived:
    """A message of the other end, of an unknown id too; never a ping or its answer, which the machine handles."""

    message: Message | UnknownMessage


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentFound:
    """Board: an agent has said that it is there."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentAbsent:
    """Board: nobody has answered the pings after a reset."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BoardFound:
    """Agent: the first frame of the board since the line was opened, or since the board was lost."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BoardLost:
    """Agent: nothing comes from the board."""

    reason: LossReason


Event = Transmit | StateChanged | FrameDropped | MessageReceived | AgentFound | AgentAbsent | BoardFound | BoardLost
