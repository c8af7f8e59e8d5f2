"""The state machines of both roles, as tables.

Two rules, kept so that this file can be read, drawn and mutated alone:

1. Everything that decides which state follows which stands in this file. The machines in `server.py` and `client.py`
   turn frames and timers into triggers, look up (state, trigger) and carry out the actions; they decide nothing else.
2. This file knows no bytes, no times and no counters. Where a trigger depends on one, there are two triggers: an
   answer that did not come is a `TIMEOUT` while tries are left and a `GAVE_UP` after the last.

How to read the tables:

- A table maps (state, trigger) to a `Transition`: the next state and the actions, carried out in their order. A pair
  that is absent changes nothing and answers nothing; the connection counts it.
- An edge back to the same state is an edge like any other.
- `TIMER_STATES` has the timers and the states in which they run; leaving these states ends them, and the step timer
  ends with every change of state. The actions whose text says so start them.
- `SERVER_TABLE` and `CLIENT_TABLE` are the machines by default. `server_table` and `client_table` make them for other
  options; only a few cells differ.
- The values of all enumerations are texts for people: for diagrams, dashboards, reports.

The server (Pioneer 2 Operations Manual, client-server chapter). The same bytes mean different things by state: 0, 1
and 2 are SYNC0 to SYNC2 before the session and PULSE, OPEN and CLOSE in it. A SYNC never carries an argument, so an
OPEN 1 or CLOSE 1 of ARIA before its time is no SYNC and is ignored like any command. SYNC0 restarts from anywhere; a
repeat of the last SYNC is answered again, or the retry of a client that missed the answer would never end.

The client. It walks SYNC0, SYNC1, SYNC2, pauses, opens, asks for the configuration, and is then in session. A session
counts as begun with its first SIP or CONFIG: until then OPEN is sent again and again (which a session takes for a
command without a meaning) and no PULSE is, and a robot that sends neither could not be connected to. A bare echo behind
OPEN says that the server is in the handshake, still or again: it took a PULSE for a SYNC0. A wrong answer leads to a
short pause and back to SYNC0; a SIP where an echo is due tells of an old session, which is closed and must fall silent
first, whether its robot stands (32 hex) or moves (33 hex, which ARIA cannot take over). It does better than ARIA there,
where a step stays unanswered (it goes back to SYNC0), and where OPEN is lost on the way. (AriaCoda ArRobot.cpp; Player
p2os.cc.)
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from protocols.p2os.options import WrongOrder

__all__ = [
    "CLIENT_TABLE",
    "IN_SESSION",
    "MAY_SEND",
    "SERVER_TABLE",
    "TIMER_STATES",
    "Action",
    "ClientState",
    "ClientTrigger",
    "Role",
    "ServerState",
    "ServerTrigger",
    "State",
    "Table",
    "Timer",
    "Transition",
    "Trigger",
    "client_table",
    "server_table",
]


class Role(enum.Enum):
    """Which end of the line a connection is."""

    CLIENT = "client"
    SERVER = "server"


class ServerState(enum.Enum):
    """Where the server is."""

    WAIT = "waits for SYNC0"
    WAIT1 = "waits for SYNC1"
    WAIT2 = "waits for SYNC2"
    READY = "waits for OPEN"
    OPEN = "in session"


class ServerTrigger(enum.Enum):
    """What happens to the server."""

    SYNC0_PULSE = "0 without argument: SYNC0, PULSE"
    SYNC1_OPEN = "1 without argument: SYNC1, OPEN"
    SYNC2_CLOSE = "2 without argument: SYNC2, CLOSE"
    OPEN_1 = "OPEN with an argument"
    CLOSE_1 = "CLOSE with an argument"
    COMMAND = "any other command"
    UNREADABLE = "sound frame without a readable command"
    WATCHDOG = "watchdog ran out"
    HANDSHAKE_LIMIT = "handshake took too long"
    LINE_DOWN = "line went down"


class ClientState(enum.Enum):
    """Where the client is."""

    IDLE = "not connected yet"
    SYNC0_SENT = "waits for the echo of SYNC0"
    SYNC1_SENT = "waits for the echo of SYNC1"
    SYNC2_SENT = "waits for the identification"
    RESTARTING = "lets late answers pass before SYNC0"
    CLOSING_OLD = "waits for an old session to fall silent"
    OPENING = "identified, pauses before OPEN"
    CONFIGURING = "opened, waits for SIPs and CONFIG"
    OPEN = "in session"
    CLOSING = "motors off, pauses before CLOSE"
    CLOSED = "disconnected"
    FAILED = "could not connect"
    LOST = "connection lost"


class ClientTrigger(enum.Enum):
    """What happens to the client."""

    CONNECT = "user connects"
    DISCONNECT = "user disconnects"
    ECHO0 = "echo of SYNC0"
    ECHO1 = "echo of SYNC1"
    IDENTIFIED = "identification, robot known"
    UNKNOWN_ROBOT = "identification, robot unknown and refused"
    BROKEN_IDENTIFICATION = "identification that cannot be read"
    SYNC_ERROR = "SYNC count error"
    SIP = "SIP"
    CONFIG = "CONFIG packet"
    PACKET = "any other packet"
    RESET = "controller reset"
    TIMEOUT = "time is up, tries left"
    STEP_BACK = "time is up, tries of this step used"
    UNOPENED = "time is up, no SIP yet"
    NEXT_BAUD = "time is up, tries at this rate used"
    GAVE_UP = "time is up, no tries left"
    KEEPALIVE = "nothing sent for a while"
    SIP_LOST = "no SIP for too long"
    LINE_DOWN = "line went down"


class Action(enum.Enum):
    """What a connection does on an edge."""

    # server
    ECHO = "send the SYNC back"
    IDENTIFY = "send the identification"
    REFUSE = "send FF, SYNC count error"
    ECHO_0 = "send SYNC0, the one expected"
    ECHO_1 = "send SYNC1, the one expected"
    LIMIT_HANDSHAKE = "start the limit of the handshake"
    OPEN_SESSION = "report the session open, start the watchdog"
    CLOSE_SESSION = "report the session closed"
    FEED_WATCHDOG = "restart the watchdog, report its revival"
    REPORT_WATCHDOG = "report that the watchdog ran out"
    DELIVER_COMMAND = "report the command"
    # client
    BEGIN = "forget earlier tries"
    SEND_SYNC0 = "send SYNC0"
    SEND_SYNC1 = "send SYNC1"
    SEND_SYNC2 = "send SYNC2"
    PAUSE = "start the pause before SYNC0"
    SEND_CLOSE_OLD = "send CLOSE, wait for silence"
    CHANGE_BAUD = "ask for the next rate"
    ACCEPT = "start the pause before OPEN"
    SEND_OPEN = "send OPEN, start the SIP timer and the wait for a SIP"
    REPEAT_OPEN = "send OPEN again, wait on for a SIP"
    REQUEST_CONFIG = "send CONFIG"
    REPORT_CONNECTED = "report the connection"
    FEED_SIP_TIMER = "restart the SIP timer"
    DELIVER_PACKET = "report the packet"
    SEND_PULSE = "send PULSE"
    SEND_DISABLE = "send ENABLE 0, start the pause before CLOSE"
    SEND_CLOSE = "send CLOSE"
    REPORT_DISCONNECTED = "report the end"
    REPORT_FAILED = "report the failure"
    REPORT_LOST = "report the loss"


class Timer(enum.Enum):
    """What a connection waits for; where it runs out, the trigger that is named."""

    HANDSHAKE = "the handshake must end: HANDSHAKE_LIMIT"
    WATCHDOG = "the client must speak: WATCHDOG"
    STEP = "this step of the client must end: TIMEOUT, STEP_BACK, NEXT_BAUD, UNOPENED or GAVE_UP"
    KEEPALIVE = "the client must speak: KEEPALIVE"
    SIP = "the server must send a SIP: SIP_LOST"


State = ServerState | ClientState
Trigger = ServerTrigger | ClientTrigger


@dataclass(frozen=True, slots=True)
class Transition:
    """An edge: where to, and what is done on it, in this order."""

    next_state: State
    actions: tuple[Action, ...] = ()


Table = Mapping[tuple[State, Trigger], Transition]
"""A machine: absent pairs change nothing."""

_S, _ST = ServerState, ServerTrigger
_C, _CT = ClientState, ClientTrigger
_A = Action

_RESTART = Transition(_S.WAIT1, (_A.ECHO, _A.LIMIT_HANDSHAKE))
_IN_SESSION = Transition(_S.OPEN, (_A.FEED_WATCHDOG, _A.DELIVER_COMMAND))
_START = Transition(_S.OPEN, (_A.OPEN_SESSION,))
_END = Transition(_S.WAIT, (_A.CLOSE_SESSION,))

_SERVER: dict[tuple[State, Trigger], Transition] = {
    # SYNC0 starts and restarts the handshake wherever it is
    (_S.WAIT, _ST.SYNC0_PULSE): _RESTART,
    (_S.WAIT1, _ST.SYNC0_PULSE): _RESTART,
    (_S.WAIT2, _ST.SYNC0_PULSE): _RESTART,
    (_S.READY, _ST.SYNC0_PULSE): _RESTART,
    # the next one in order, and its repeats
    (_S.WAIT1, _ST.SYNC1_OPEN): Transition(_S.WAIT2, (_A.ECHO,)),
    (_S.WAIT2, _ST.SYNC1_OPEN): Transition(_S.WAIT2, (_A.ECHO,)),
    (_S.WAIT2, _ST.SYNC2_CLOSE): Transition(_S.READY, (_A.IDENTIFY,)),
    (_S.READY, _ST.SYNC2_CLOSE): Transition(_S.READY, (_A.IDENTIFY,)),
    # the session
    (_S.READY, _ST.SYNC1_OPEN): _START,
    (_S.READY, _ST.OPEN_1): _START,
    (_S.OPEN, _ST.SYNC0_PULSE): _IN_SESSION,
    (_S.OPEN, _ST.SYNC1_OPEN): _IN_SESSION,
    (_S.OPEN, _ST.OPEN_1): _IN_SESSION,
    (_S.OPEN, _ST.COMMAND): _IN_SESSION,
    (_S.OPEN, _ST.UNREADABLE): Transition(_S.OPEN, (_A.FEED_WATCHDOG,)),
    (_S.OPEN, _ST.SYNC2_CLOSE): _END,
    (_S.OPEN, _ST.CLOSE_1): _END,
    (_S.OPEN, _ST.WATCHDOG): Transition(_S.OPEN, (_A.REPORT_WATCHDOG,)),
    # the client is gone
    (_S.WAIT1, _ST.HANDSHAKE_LIMIT): Transition(_S.WAIT),
    (_S.WAIT2, _ST.HANDSHAKE_LIMIT): Transition(_S.WAIT),
    (_S.READY, _ST.HANDSHAKE_LIMIT): Transition(_S.WAIT),
    (_S.WAIT1, _ST.LINE_DOWN): Transition(_S.WAIT),
    (_S.WAIT2, _ST.LINE_DOWN): Transition(_S.WAIT),
    (_S.READY, _ST.LINE_DOWN): Transition(_S.WAIT),
    (_S.OPEN, _ST.LINE_DOWN): _END,
}

_OUT_OF_ORDER: dict[WrongOrder, dict[tuple[State, Trigger], Transition]] = {
    # Before the first SYNC0 a bare 1 is as likely an OPEN that comes too early, which must have no answer.
    WrongOrder.REFUSE: {(_S.WAIT1, _ST.SYNC2_CLOSE): Transition(_S.WAIT1, (_A.REFUSE,))},
    WrongOrder.ADOPT: {
        (_S.WAIT, _ST.SYNC1_OPEN): Transition(_S.WAIT2, (_A.ECHO, _A.LIMIT_HANDSHAKE)),
        (_S.WAIT, _ST.SYNC2_CLOSE): Transition(_S.READY, (_A.IDENTIFY, _A.LIMIT_HANDSHAKE)),
        (_S.WAIT1, _ST.SYNC2_CLOSE): Transition(_S.READY, (_A.IDENTIFY,)),
    },
    WrongOrder.REECHO: {
        (_S.WAIT, _ST.SYNC1_OPEN): Transition(_S.WAIT, (_A.ECHO_0,)),
        (_S.WAIT, _ST.SYNC2_CLOSE): Transition(_S.WAIT, (_A.ECHO_0,)),
        (_S.WAIT1, _ST.SYNC2_CLOSE): Transition(_S.WAIT1, (_A.ECHO_1,)),
    },
    WrongOrder.RESTART: {(_S.WAIT1, _ST.SYNC2_CLOSE): Transition(_S.WAIT)},
    WrongOrder.IGNORE: {},
}


def server_table(wrong_order: WrongOrder = WrongOrder.REFUSE) -> Table:
    """The server's machine with this answer to SYNCs out of order."""
    return MappingProxyType(_SERVER | _OUT_OF_ORDER[wrong_order])


SERVER_TABLE: Table = server_table()
"""The server's machine by default."""

_RETURN = Transition(_C.RESTARTING, (_A.PAUSE,))
_TAKE_OVER = Transition(_C.CLOSING_OLD, (_A.SEND_CLOSE_OLD,))
_FAIL = Transition(_C.FAILED, (_A.REPORT_FAILED,))
_LEAVE = Transition(_C.CLOSED, (_A.REPORT_DISCONNECTED,))
_LOSE = Transition(_C.LOST, (_A.REPORT_LOST,))
_BEGIN = Transition(_C.SYNC0_SENT, (_A.BEGIN, _A.SEND_SYNC0))
_AGAIN0 = Transition(_C.SYNC0_SENT, (_A.SEND_SYNC0,))

_CONNECTING = (_C.SYNC0_SENT, _C.SYNC1_SENT, _C.SYNC2_SENT, _C.RESTARTING, _C.CLOSING_OLD, _C.OPENING)

_CLIENT: dict[tuple[State, Trigger], Transition] = {
    **{(state, _CT.CONNECT): _BEGIN for state in (_C.IDLE, _C.CLOSED, _C.FAILED, _C.LOST)},
    # the three steps
    (_C.SYNC0_SENT, _CT.ECHO0): Transition(_C.SYNC1_SENT, (_A.SEND_SYNC1,)),
    (_C.SYNC1_SENT, _CT.ECHO1): Transition(_C.SYNC2_SENT, (_A.SEND_SYNC2,)),
    (_C.SYNC2_SENT, _CT.IDENTIFIED): Transition(_C.OPENING, (_A.ACCEPT,)),
    (_C.SYNC2_SENT, _CT.UNKNOWN_ROBOT): Transition(_C.FAILED, (_A.SEND_CLOSE, _A.REPORT_FAILED)),
    # no answer
    (_C.SYNC0_SENT, _CT.TIMEOUT): _AGAIN0,
    (_C.SYNC0_SENT, _CT.NEXT_BAUD): Transition(_C.SYNC0_SENT, (_A.CHANGE_BAUD, _A.SEND_SYNC0)),
    (_C.SYNC1_SENT, _CT.TIMEOUT): Transition(_C.SYNC1_SENT, (_A.SEND_SYNC1,)),
    (_C.SYNC2_SENT, _CT.TIMEOUT): Transition(_C.SYNC2_SENT, (_A.SEND_SYNC2,)),
    (_C.SYNC1_SENT, _CT.STEP_BACK): _AGAIN0,
    (_C.SYNC2_SENT, _CT.STEP_BACK): _AGAIN0,
    # a wrong answer
    (_C.SYNC0_SENT, _CT.ECHO1): _RETURN,
    (_C.SYNC0_SENT, _CT.IDENTIFIED): _RETURN,
    (_C.SYNC0_SENT, _CT.UNKNOWN_ROBOT): _RETURN,
    (_C.SYNC0_SENT, _CT.BROKEN_IDENTIFICATION): _RETURN,
    (_C.SYNC0_SENT, _CT.SYNC_ERROR): _RETURN,
    (_C.SYNC1_SENT, _CT.ECHO0): _RETURN,
    (_C.SYNC1_SENT, _CT.IDENTIFIED): _RETURN,
    (_C.SYNC1_SENT, _CT.UNKNOWN_ROBOT): _RETURN,
    (_C.SYNC1_SENT, _CT.BROKEN_IDENTIFICATION): _RETURN,
    (_C.SYNC1_SENT, _CT.SYNC_ERROR): _RETURN,
    (_C.SYNC2_SENT, _CT.ECHO0): _RETURN,
    (_C.SYNC2_SENT, _CT.ECHO1): _RETURN,
    (_C.SYNC2_SENT, _CT.BROKEN_IDENTIFICATION): _RETURN,
    (_C.SYNC2_SENT, _CT.SYNC_ERROR): _RETURN,
    (_C.RESTARTING, _CT.TIMEOUT): _AGAIN0,
    # an old session
    **{(s, _CT.SIP): _TAKE_OVER for s in (_C.SYNC0_SENT, _C.SYNC1_SENT, _C.SYNC2_SENT, _C.RESTARTING, _C.CLOSING_OLD)},
    (_C.CLOSING_OLD, _CT.TIMEOUT): _AGAIN0,
    # the session begins
    (_C.OPENING, _CT.TIMEOUT): Transition(_C.CONFIGURING, (_A.SEND_OPEN, _A.REQUEST_CONFIG)),
    (_C.CONFIGURING, _CT.TIMEOUT): Transition(_C.CONFIGURING, (_A.REQUEST_CONFIG,)),
    (_C.CONFIGURING, _CT.UNOPENED): Transition(_C.CONFIGURING, (_A.REPEAT_OPEN, _A.REQUEST_CONFIG)),
    (_C.CONFIGURING, _CT.CONFIG): Transition(_C.OPEN, (_A.DELIVER_PACKET, _A.REPORT_CONNECTED)),
    (_C.CONFIGURING, _CT.GAVE_UP): Transition(_C.OPEN, (_A.REPORT_CONNECTED,)),
    (_C.CONFIGURING, _CT.SIP_LOST): _FAIL,
    **{(_C.CONFIGURING, echo): _RETURN for echo in (_CT.ECHO0, _CT.ECHO1)},
    # the session
    (_C.OPEN, _CT.CONFIG): Transition(_C.OPEN, (_A.DELIVER_PACKET,)),
    **{(s, _CT.SIP): Transition(s, (_A.FEED_SIP_TIMER, _A.DELIVER_PACKET)) for s in (_C.CONFIGURING, _C.OPEN)},
    **{(s, _CT.PACKET): Transition(s, (_A.DELIVER_PACKET,)) for s in (_C.CONFIGURING, _C.OPEN)},
    **{(s, _CT.KEEPALIVE): Transition(s, (_A.SEND_PULSE,)) for s in (_C.CONFIGURING, _C.OPEN)},
    # the session ends
    **{(s, _CT.RESET): _LOSE for s in (_C.CONFIGURING, _C.OPEN)},
    (_C.OPEN, _CT.SIP_LOST): _LOSE,
    **{(_C.OPEN, echo): _LOSE for echo in (_CT.ECHO0, _CT.ECHO1)},
    **{(s, _CT.LINE_DOWN): _LOSE for s in (_C.CONFIGURING, _C.OPEN)},
    **{(s, _CT.DISCONNECT): Transition(_C.CLOSING, (_A.SEND_DISABLE,)) for s in (_C.CONFIGURING, _C.OPEN)},
    (_C.CLOSING, _CT.TIMEOUT): Transition(_C.CLOSED, (_A.SEND_CLOSE, _A.REPORT_DISCONNECTED)),
    (_C.CLOSING, _CT.LINE_DOWN): _LEAVE,
    # the end before the session
    **{(s, _CT.GAVE_UP): _FAIL for s in (_C.SYNC0_SENT, _C.SYNC1_SENT, _C.SYNC2_SENT, _C.RESTARTING, _C.CLOSING_OLD)},
    **{(s, _CT.DISCONNECT): _LEAVE for s in _CONNECTING},
    **{(s, _CT.LINE_DOWN): _FAIL for s in _CONNECTING},
}

_WITHOUT_CONFIG: dict[tuple[State, Trigger], Transition] = {
    (_C.OPENING, _CT.TIMEOUT): Transition(_C.CONFIGURING, (_A.SEND_OPEN,)),
    (_C.CONFIGURING, _CT.UNOPENED): Transition(_C.CONFIGURING, (_A.REPEAT_OPEN,)),
    (_C.CONFIGURING, _CT.SIP): Transition(_C.OPEN, (_A.FEED_SIP_TIMER, _A.REPORT_CONNECTED, _A.DELIVER_PACKET)),
}
_ONLY_BEHIND_A_SIP = {(_C.CONFIGURING, trigger) for trigger in (_CT.TIMEOUT, _CT.GAVE_UP, _CT.KEEPALIVE)}
"""What waits for CONFIG between the first SIP and the report; without CONFIG there is nothing between them."""


def client_table(*, request_config: bool = True) -> Table:
    """The client's machine, with or without asking for the configuration before it reports the connection."""
    if request_config:
        return MappingProxyType(_CLIENT)
    kept = {cell: edge for cell, edge in _CLIENT.items() if cell not in _ONLY_BEHIND_A_SIP}
    return MappingProxyType(kept | _WITHOUT_CONFIG)


CLIENT_TABLE: Table = client_table()
"""The client's machine by default."""

IN_SESSION: frozenset[State] = frozenset((_S.OPEN, _C.CONFIGURING, _C.OPEN, _C.CLOSING))
"""The states in which a session is open, so that packet types have the meaning they have there."""

MAY_SEND: frozenset[State] = frozenset((_S.OPEN, _C.OPEN))
"""The states in which the program may send messages of its own."""

TIMER_STATES: Mapping[Timer, frozenset[State]] = MappingProxyType(
    {
        Timer.HANDSHAKE: frozenset((_S.WAIT1, _S.WAIT2, _S.READY)),
        Timer.WATCHDOG: frozenset((_S.OPEN,)),
        Timer.STEP: frozenset((*_CONNECTING, _C.CONFIGURING, _C.CLOSING)),
        Timer.KEEPALIVE: frozenset((_C.CONFIGURING, _C.OPEN)),
        Timer.SIP: frozenset((_C.CONFIGURING, _C.OPEN)),
    }
)
"""The states in which each timer runs."""
