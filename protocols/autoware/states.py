"""The state machines of both ends of the stand-in link, as tables.

Two rules, kept so that this file can be read, drawn and mutated alone:

1. Everything that decides which state follows which stands in this file. The machines turn frames and timers into
   triggers, look up (state, trigger) and carry out the actions.
2. This file knows no bytes, no times and no counters.

The link has no session: messages are taken and sent in every state. What an end keeps is whether the other is there.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

__all__ = [
    "AGENT_TABLE",
    "BOARD_TABLE",
    "TIMER_STATES",
    "Action",
    "AgentState",
    "AgentTrigger",
    "BoardState",
    "BoardTrigger",
    "Role",
    "State",
    "Table",
    "Timer",
    "Transition",
    "Trigger",
]


class Role(enum.Enum):
    """Which end of the line a connection is."""

    AGENT = "agent"
    BOARD = "board"


class BoardState(enum.Enum):
    """What the board knows of the agent."""

    SEEKING = "asks whether an agent is there"
    ONLINE = "an agent has answered"
    ABSENT = "nobody answered"


class BoardTrigger(enum.Enum):
    """What happens to the board."""

    PING_DUE = "it is time to ask"
    GIVE_UP = "the last ping was not answered in time"
    AGENT_ONLINE = "the agent says that it is there"


class AgentState(enum.Enum):
    """What the agent knows of the board."""

    CLOSED = "not opened yet, or closed"
    ALONE = "no frame of the board"
    HEARD = "the board is heard"


class AgentTrigger(enum.Enum):
    """What happens to the agent."""

    CONNECT = "the user opens the line"
    DISCONNECT = "the user closes it"
    LINE_DOWN = "the line is gone"
    FRAME = "a sound frame of the board"
    PING = "the board asks whether an agent is there"
    SILENCE = "no sound frame for too long"


class Timer(enum.Enum):
    """What is waited for."""

    PING = "the next ping, or the end of the last one"
    SILENCE = "the next frame of the board"


class Action(enum.Enum):
    """What is done on an edge."""

    SEND_PING = "send AgentPing"
    SAY_ONLINE = "send AgentOnline"
    FEED_SILENCE = "wait for the next frame"
    REPORT_AGENT = "tell the user that the agent is there"
    REPORT_NO_AGENT = "tell the user that nobody answered"
    REPORT_FOUND = "tell the user that the board is there"
    REPORT_LOST = "tell the user that the board is lost"


State = BoardState | AgentState
Trigger = BoardTrigger | AgentTrigger


@dataclass(frozen=True, slots=True)
class Transition:
    """What follows from a trigger in a state."""

    next_state: State
    actions: tuple[Action, ...] = ()


Table = Mapping[tuple[State, Trigger], Transition]

_B, _BT, _A, _AT = BoardState, BoardTrigger, AgentState, AgentTrigger

BOARD_TABLE: Table = MappingProxyType(
    {
        (_B.SEEKING, _BT.PING_DUE): Transition(_B.SEEKING, (Action.SEND_PING,)),
        (_B.SEEKING, _BT.GIVE_UP): Transition(_B.ABSENT, (Action.REPORT_NO_AGENT,)),
        (_B.SEEKING, _BT.AGENT_ONLINE): Transition(_B.ONLINE, (Action.REPORT_AGENT,)),
        (_B.ABSENT, _BT.AGENT_ONLINE): Transition(_B.ONLINE, (Action.REPORT_AGENT,)),
    }
)
"""The board's end."""

AGENT_TABLE: Table = MappingProxyType(
    {
        (_A.CLOSED, _AT.CONNECT): Transition(_A.ALONE, (Action.SAY_ONLINE,)),
        (_A.ALONE, _AT.FRAME): Transition(_A.HEARD, (Action.REPORT_FOUND, Action.FEED_SILENCE)),
        (_A.ALONE, _AT.PING): Transition(_A.HEARD, (Action.REPORT_FOUND, Action.FEED_SILENCE, Action.SAY_ONLINE)),
        (_A.ALONE, _AT.DISCONNECT): Transition(_A.CLOSED),
        (_A.ALONE, _AT.LINE_DOWN): Transition(_A.CLOSED),
        (_A.HEARD, _AT.FRAME): Transition(_A.HEARD, (Action.FEED_SILENCE,)),
        (_A.HEARD, _AT.PING): Transition(_A.HEARD, (Action.FEED_SILENCE, Action.SAY_ONLINE)),
        (_A.HEARD, _AT.SILENCE): Transition(_A.ALONE, (Action.REPORT_LOST,)),
        (_A.HEARD, _AT.DISCONNECT): Transition(_A.CLOSED),
        (_A.HEARD, _AT.LINE_DOWN): Transition(_A.CLOSED, (Action.REPORT_LOST,)),
    }
)
"""The driving stack's end."""

TIMER_STATES: Mapping[Timer, tuple[State, ...]] = MappingProxyType(
    {Timer.PING: (_B.SEEKING,), Timer.SILENCE: (_A.HEARD,)}
)
"""In which states each timer runs."""
