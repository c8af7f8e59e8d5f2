"""The state machines of both ends of a session, as tables.

Two rules, kept so that this file can be read, drawn and mutated alone:

1. Everything that decides which state follows which stands in this file. The machines turn messages and timers into
   triggers, look up (state, trigger) and carry out the actions.
2. This file knows no bytes, no times and no counters.

What a message that came twice, or late, does to a stream is arithmetic and stands in `streams.py`.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

__all__ = [
    "AGENT_TABLE",
    "CLIENT_TABLE",
    "TIMER_STATES",
    "Action",
    "AgentState",
    "AgentTrigger",
    "ClientState",
    "ClientTrigger",
    "Role",
    "State",
    "Table",
    "Timer",
    "Transition",
    "Trigger",
]


class Role(enum.Enum):
    """Which end of the line a session is."""

    CLIENT = "client"
    AGENT = "agent"


class ClientState(enum.Enum):
    """What the client knows of its session."""

    CLOSED = "no session"
    CONNECTING = "asks for a session"
    OPEN = "there is a session"
    CLOSING = "asks for the end of the session"


class ClientTrigger(enum.Enum):
    """What happens to the client."""

    CONNECT = "the user wants a session"
    DISCONNECT = "the user wants no session"
    LINE_DOWN = "the line is gone"
    RESET_WANTED = "the user wants new streams"
    ACCEPTED = "STATUS_AGENT without an error"
    REFUSED = "STATUS_AGENT with an error"
    GONE = "STATUS of the client's deletion"
    RETRY = "no answer in time"
    GIVE_UP = "no answer in time, once too often"
    RESET = "RESET of the agent"
    HEARTBEAT_DUE = "messages are unacknowledged for too long"
    PONG = "INFO about the agent"
    TIME_TOLD = "TIMESTAMP_REPLY"


class AgentState(enum.Enum):
    """What the agent knows of the client at the other end."""

    LISTENING = "no session"
    OPEN = "there is a session"


class AgentTrigger(enum.Enum):
    """What happens to the agent."""

    CREATE = "CREATE_CLIENT that can be accepted"
    BAD_CREATE = "CREATE_CLIENT with another cookie, version or no key"
    DELETE = "DELETE of the client"
    STRAY_DELETE = "DELETE of the client, but not in the session that there is"
    MESSAGE = "any message of the session"
    PING = "GET_INFO about the agent"
    TIME_ASKED = "TIMESTAMP"
    SILENCE = "no message for too long"
    DISCONNECT = "the user forgets the client"
    LINE_DOWN = "the line is gone"
    RESET_WANTED = "the user wants new streams"
    RESET = "RESET of the client"
    HEARTBEAT_DUE = "messages are unacknowledged for too long"


class Timer(enum.Enum):
    """What is waited for."""

    RETRY = "the answer to CREATE_CLIENT or DELETE"
    HEARTBEAT = "an ACKNACK"
    SILENCE = "any message of the client"


class Action(enum.Enum):
    """What is done on an edge."""

    RESET_STREAMS = "restart all streams"
    SEND_HEARTBEATS = "send HEARTBEAT for each stream that waits for too long"
    SEND_RESET = "send RESET"
    REPORT_OPENED = "tell the user that there is a session"
    REPORT_CLOSED = "tell the user that there is no session, and why"
    REPORT_RESET = "report to the user that all streams restart"
    # client
    SEND_CREATE = "send CREATE_CLIENT"
    SEND_DELETE = "send DELETE of the client"
    REPORT_PONG = "tell the user that the agent is there"
    REPORT_TIME = "tell the user how far the agent's clock is ahead"
    # agent
    ADOPT = "take key, session id and mtu of the client"
    ACCEPT = "send STATUS_AGENT with OK"
    REFUSE = "send STATUS_AGENT with what is wrong"
    CONFIRM = "send STATUS of the deletion with OK"
    FEED_SILENCE = "wait for the next message"
    ANSWER_PING = "send INFO about the agent"
    ANSWER_TIME = "send TIMESTAMP_REPLY"


State = ClientState | AgentState
Trigger = ClientTrigger | AgentTrigger


@dataclass(frozen=True, slots=True)
class Transition:
    """What follows from a trigger in a state."""

    next_state: State
    actions: tuple[Action, ...] = ()


Table = Mapping[tuple[State, Trigger], Transition]

_C, _CT, _A, _AT, _DO = ClientState, ClientTrigger, AgentState, AgentTrigger, Action

_CLIENT_ENDS = Transition(_C.CLOSED, (_DO.REPORT_CLOSED,))
_ASKING = (_C.CONNECTING, _C.CLOSING)

CLIENT_TABLE: Table = MappingProxyType(
    {
        (_C.CLOSED, _CT.CONNECT): Transition(_C.CONNECTING, (_DO.SEND_CREATE,)),
        (_C.CONNECTING, _CT.RETRY): Transition(_C.CONNECTING, (_DO.SEND_CREATE,)),
        (_C.CONNECTING, _CT.ACCEPTED): Transition(_C.OPEN, (_DO.REPORT_OPENED,)),
        (_C.CONNECTING, _CT.REFUSED): _CLIENT_ENDS,
        (_C.CONNECTING, _CT.DISCONNECT): Transition(_C.CLOSING, (_DO.SEND_DELETE,)),
        (_C.OPEN, _CT.HEARTBEAT_DUE): Transition(_C.OPEN, (_DO.SEND_HEARTBEATS,)),
        (_C.OPEN, _CT.TIME_TOLD): Transition(_C.OPEN, (_DO.REPORT_TIME,)),
        (_C.OPEN, _CT.RESET): Transition(_C.OPEN, (_DO.RESET_STREAMS, _DO.REPORT_RESET)),
        (_C.OPEN, _CT.RESET_WANTED): Transition(_C.OPEN, (_DO.SEND_RESET, _DO.RESET_STREAMS)),
        (_C.OPEN, _CT.DISCONNECT): Transition(_C.CLOSING, (_DO.RESET_STREAMS, _DO.SEND_DELETE)),
        (_C.OPEN, _CT.LINE_DOWN): Transition(_C.CLOSED, (_DO.RESET_STREAMS, _DO.REPORT_CLOSED)),
        (_C.CLOSING, _CT.RETRY): Transition(_C.CLOSING, (_DO.SEND_DELETE,)),
        (_C.CLOSING, _CT.GONE): _CLIENT_ENDS,
        **{(state, _CT.GIVE_UP): _CLIENT_ENDS for state in _ASKING},
        **{(state, _CT.LINE_DOWN): _CLIENT_ENDS for state in _ASKING},
        **{(state, _CT.PONG): Transition(state, (_DO.REPORT_PONG,)) for state in _C},
    }
)
"""The microcontroller's end."""

_BEGINNING = (_DO.ADOPT, _DO.FEED_SILENCE, _DO.ACCEPT, _DO.REPORT_OPENED)
_AGENT_ENDS = Transition(_A.LISTENING, (_DO.RESET_STREAMS, _DO.REPORT_CLOSED))

AGENT_TABLE: Table = MappingProxyType(
    {
        **{(state, _AT.BAD_CREATE): Transition(state, (_DO.REFUSE,)) for state in _A},
        **{(state, _AT.PING): Transition(state, (_DO.ANSWER_PING,)) for state in _A},
        **{(state, _AT.STRAY_DELETE): Transition(state, (_DO.CONFIRM,)) for state in _A},
        (_A.LISTENING, _AT.CREATE): Transition(_A.OPEN, _BEGINNING),
        (_A.OPEN, _AT.CREATE): Transition(_A.OPEN, (_DO.RESET_STREAMS, *_BEGINNING)),
        (_A.OPEN, _AT.DELETE): Transition(_A.LISTENING, (_DO.CONFIRM, _DO.RESET_STREAMS, _DO.REPORT_CLOSED)),
        (_A.OPEN, _AT.MESSAGE): Transition(_A.OPEN, (_DO.FEED_SILENCE,)),
        (_A.OPEN, _AT.TIME_ASKED): Transition(_A.OPEN, (_DO.ANSWER_TIME,)),
        (_A.OPEN, _AT.HEARTBEAT_DUE): Transition(_A.OPEN, (_DO.SEND_HEARTBEATS,)),
        (_A.OPEN, _AT.RESET): Transition(_A.OPEN, (_DO.RESET_STREAMS, _DO.REPORT_RESET)),
        (_A.OPEN, _AT.RESET_WANTED): Transition(_A.OPEN, (_DO.SEND_RESET, _DO.RESET_STREAMS)),
        (_A.OPEN, _AT.SILENCE): _AGENT_ENDS,
        (_A.OPEN, _AT.DISCONNECT): _AGENT_ENDS,
        (_A.OPEN, _AT.LINE_DOWN): _AGENT_ENDS,
    }
)
"""The end that speaks DDS for it."""

TIMER_STATES: Mapping[Timer, tuple[State, ...]] = MappingProxyType(
    {Timer.RETRY: _ASKING, Timer.HEARTBEAT: (_C.OPEN, _A.OPEN), Timer.SILENCE: (_A.OPEN,)}
)
"""In which states each timer runs."""
