"""The state machines of the decoder and of both roles, as tables.

Two rules, kept so that this file can be read, drawn and mutated alone:

1. Everything that decides which state follows which stands in this file. `FrameReader`, `ServerMachine` and
   `ClientMachine` turn bytes, frames and timers into triggers, look up (state, trigger) and carry out the actions.
2. This file knows no bytes, no times and no counters. Where a trigger depends on one, there are two triggers.

How to read the tables: they map (state, trigger) to a transition, the next state and the actions, carried out in
their order. A pair that is absent changes nothing and answers nothing. The values of all enumerations are texts for
people.

The decoder. With a length byte it is that of all firmware (nhorro/ceai2020 and nhorro/rover-firmware, protocol.cpp);
without, that of the document's diagram (intro_se/rover-serial-protocol.png), whose names are given, with its transient
states VALIDAR_Y_DESPACHAR and ERROR as actions. `frame_table` makes the table for other options.

The roles. The protocol has no session: a rover takes commands from the first byte on, and what a role keeps is whether
the other end is heard. Only the rover's hook for a lost connection is in the sources (protocol.cpp `check_timeouts`);
the host's states are ours.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from protocols.pkt.options import Framing, FramingOptions, Resync

__all__ = [
    "CLIENT_TABLE",
    "LEN_TABLE",
    "SERVER_TABLE",
    "TERM_TABLE",
    "TIMER_STATES",
    "Action",
    "ClientState",
    "ClientTrigger",
    "FrameAction",
    "FrameState",
    "FrameTable",
    "FrameTransition",
    "FrameTrigger",
    "Role",
    "ServerState",
    "ServerTrigger",
    "State",
    "Table",
    "Timer",
    "Transition",
    "Trigger",
    "frame_table",
]


class Role(enum.Enum):
    """Which end of the line a connection is."""

    CLIENT = "client"
    SERVER = "server"


class FrameState(enum.Enum):
    """Where the decoder is in a frame."""

    IDLE = "waits for P (LIBRE)"
    SYNC1 = "waits for K (ESPERA_K)"
    SYNC2 = "waits for T (ESPERA_T)"
    SYNC3 = "waits for ! (ESPERA_!)"
    LENGTH = "waits for the length"
    PAYLOAD = "reads the payload"
    CRC1 = "waits for the high byte of the CRC"
    CRC2 = "waits for the low byte of the CRC"
    TERMINATOR = "waits for the newline"
    BODY = "reads payload and CRC up to the newline (LEER_C)"


class FrameTrigger(enum.Enum):
    """What the decoder sees."""

    EXPECTED = "the byte waited for"
    WRONG = "another byte"
    WRONG_P = "another byte, and it is P"
    GOOD_LENGTH = "a length within the limit"
    BAD_LENGTH = "0, or a length beyond the limit"
    COMPLETE = "the last byte of the payload"
    CRC_HIGH = "any byte"
    GOOD_CRC = "the byte that makes the CRC right"
    BAD_CRC = "a byte that makes the CRC wrong"
    GOOD_END = "a newline, CRC right"
    BAD_END = "a newline, CRC wrong or no room for one"
    TOO_LONG = "one byte too many"
    TOO_LONG_AFTER_END = "one byte too many, behind a newline"
    TIME_UP = "the time of an unfinished frame is up"


class FrameAction(enum.Enum):
    """What the decoder does on an edge."""

    BEGIN = "begin a frame with this byte"
    DISPATCH = "deliver the frame"
    FAIL_SYNC = "report bad_sync"
    FAIL_LENGTH = "report invalid_length"
    FAIL_CRC = "report bad_crc"
    FAIL_TERMINATOR = "report bad_terminator"
    ABANDON = "report the unfinished frame, which is no error"
    RESCAN = "search what the frame held for a sync word"


class ServerState(enum.Enum):
    """What the rover knows of the host."""

    WAITING = "no sound frame yet"
    LINKED = "the host is heard"
    LOST = "the host is silent, motors stopped"


class ServerTrigger(enum.Enum):
    """What happens to the rover."""

    REQUEST = "REQUEST_TMY"
    COMMAND = "a command that can be carried out"
    UNKNOWN = "a sound frame with an unknown opcode"
    SHORT = "a sound frame with too few parameters"
    BAD_FRAME = "a frame that the decoder rejects"
    GENERAL_DUE = "time for the periodic general report"
    REPORT_DUE = "time for another periodic report"
    SILENCE = "no sound frame for too long"


class ClientState(enum.Enum):
    """What the host knows of the rover."""

    IDLE = "listens, sends nothing of its own"
    WAITING = "asks, no report yet"
    LINKED = "reports come"
    LOST = "asks, no reports any more"


class ClientTrigger(enum.Enum):
    """What happens to the host."""

    CONNECT = "user connects"
    DISCONNECT = "user disconnects"
    REPORT = "a sound report"
    KEEPALIVE = "nothing sent for a while"
    SILENCE = "no report for too long"
    LINE_DOWN = "line went down"


class Action(enum.Enum):
    """What a role does on an edge."""

    # server
    FEED_WATCHDOG = "restart the watchdog"
    SEND_GENERAL = "send 0x80"
    ACCEPT = "count the packet as accepted"
    DELIVER_COMMAND = "report the command"
    DELIVER_REFUSAL = "report the command that is not carried out"
    NOTE_RESULT = "set LAST_ERROR and LAST_OPCODE"
    SEND_EXECUTION = "send 0x81, where the options want it"
    REJECT = "count the packet as rejected, set LAST_ERROR"
    ASK_REPORT = "ask the program for the report"
    STOP = "report that the motors must stop"
    # client
    SEND_REQUEST = "send REQUEST_TMY"
    FEED_SILENCE = "restart the wait for reports"
    DELIVER_REPORT = "report what came"
    REPORT_FOUND = "report that the rover is heard"
    REPORT_LOST = "report that the rover is not heard"
    SEND_STOP = "stop both motors, where the options want it"


class Timer(enum.Enum):
    """What a role waits for; where it runs out, the trigger that is named."""

    WATCHDOG = "the host must speak: SILENCE"
    KEEPALIVE = "the host must speak: KEEPALIVE"
    REPORTS = "the rover must speak: SILENCE"


State = ServerState | ClientState
Trigger = ServerTrigger | ClientTrigger


@dataclass(frozen=True, slots=True)
class FrameTransition:
    """An edge of the decoder."""

    next_state: FrameState
    actions: tuple[FrameAction, ...] = ()


@dataclass(frozen=True, slots=True)
class Transition:
    """An edge of a role."""

    next_state: State
    actions: tuple[Action, ...] = ()


FrameTable = Mapping[tuple[FrameState, FrameTrigger], FrameTransition]
Table = Mapping[tuple[State, Trigger], Transition]

_F, _FT, _FA = FrameState, FrameTrigger, FrameAction
_S, _ST = ServerState, ServerTrigger
_C, _CT = ClientState, ClientTrigger
_A = Action

_FrameEdges = dict[tuple[FrameState, FrameTrigger], FrameTransition]

_FRAME_BEGINS: _FrameEdges = {(_F.IDLE, _FT.EXPECTED): FrameTransition(_F.SYNC1, (_FA.BEGIN,))}


def _waits(state: FrameState, following: FrameTransition, fail: FrameAction) -> _FrameEdges:
    """The edges of a state in which one certain byte is waited for, and the offending byte is used up."""
    failed = FrameTransition(_F.IDLE, (fail,))
    return {(state, _FT.EXPECTED): following, (state, _FT.WRONG): failed, (state, _FT.WRONG_P): failed}


_SYNC_WORD: _FrameEdges = {
    **_FRAME_BEGINS,
    **_waits(_F.SYNC1, FrameTransition(_F.SYNC2), _FA.FAIL_SYNC),
    **_waits(_F.SYNC2, FrameTransition(_F.SYNC3), _FA.FAIL_SYNC),
}
_LEN: _FrameEdges = {
    **_SYNC_WORD,
    **_waits(_F.SYNC3, FrameTransition(_F.LENGTH), _FA.FAIL_SYNC),
    (_F.LENGTH, _FT.GOOD_LENGTH): FrameTransition(_F.PAYLOAD),
    (_F.LENGTH, _FT.BAD_LENGTH): FrameTransition(_F.IDLE, (_FA.FAIL_LENGTH,)),
    (_F.PAYLOAD, _FT.COMPLETE): FrameTransition(_F.CRC1),
    (_F.CRC1, _FT.CRC_HIGH): FrameTransition(_F.CRC2),
    (_F.CRC2, _FT.GOOD_CRC): FrameTransition(_F.TERMINATOR),
    (_F.CRC2, _FT.BAD_CRC): FrameTransition(_F.IDLE, (_FA.FAIL_CRC,)),
    **_waits(_F.TERMINATOR, FrameTransition(_F.IDLE, (_FA.DISPATCH,)), _FA.FAIL_TERMINATOR),
}
_TERM: _FrameEdges = {
    **_SYNC_WORD,
    **_waits(_F.SYNC3, FrameTransition(_F.BODY), _FA.FAIL_SYNC),
    (_F.BODY, _FT.GOOD_END): FrameTransition(_F.IDLE, (_FA.DISPATCH,)),
    (_F.BODY, _FT.BAD_END): FrameTransition(_F.IDLE, (_FA.FAIL_CRC,)),
    (_F.BODY, _FT.TOO_LONG): FrameTransition(_F.IDLE, (_FA.FAIL_LENGTH,)),
}
_TOLERANT: _FrameEdges = {
    (_F.BODY, _FT.BAD_END): FrameTransition(_F.BODY),
    (_F.BODY, _FT.TOO_LONG_AFTER_END): FrameTransition(_F.IDLE, (_FA.FAIL_CRC,)),
}
_FAILURES = frozenset((_FA.FAIL_SYNC, _FA.FAIL_LENGTH, _FA.FAIL_CRC, _FA.FAIL_TERMINATOR, _FA.ABANDON))


def _may_hold_a_frame(cell: tuple[FrameState, FrameTrigger]) -> bool:
    """More than a piece of a sync word has come, so that there may be another one in it."""
    return cell[0] not in (_F.SYNC1, _F.SYNC2, _F.SYNC3)


def frame_table(options: FramingOptions) -> FrameTable:
    """The decoder's machine with these options."""
    table = dict(_LEN if options.framing is Framing.LEN else _TERM)
    if options.tolerant_newline:
        table |= _TOLERANT
    given_up = FrameTransition(_F.IDLE, (_FA.ABANDON,))
    table |= {(state, _FT.TIME_UP): given_up for state, _ in tuple(table) if state is not _F.IDLE}
    if options.resync is not Resync.NONE:
        table |= {
            cell: FrameTransition(_F.SYNC1, (*edge.actions, _FA.BEGIN))
            for cell, edge in table.items()
            if cell[1] is _FT.WRONG_P
        }
    if options.resync is Resync.SCAN:
        table |= {
            cell: FrameTransition(_F.IDLE, (*(_FAILURES & set(edge.actions)), _FA.RESCAN))
            for cell, edge in table.items()
            if _FAILURES & set(edge.actions) and _may_hold_a_frame(cell)
        }
    return MappingProxyType(table)


LEN_TABLE: FrameTable = frame_table(FramingOptions())
"""The decoder of all firmware."""
TERM_TABLE: FrameTable = frame_table(FramingOptions(framing=Framing.TERM))
"""The decoder of the document's diagram."""

_END = (_A.NOTE_RESULT, _A.SEND_EXECUTION)
_EVERYWHERE: dict[ServerTrigger, tuple[Action, ...]] = {
    _ST.REQUEST: (_A.FEED_WATCHDOG, _A.SEND_GENERAL),
    _ST.COMMAND: (_A.FEED_WATCHDOG, _A.ACCEPT, _A.DELIVER_COMMAND, *_END),
    _ST.UNKNOWN: (_A.FEED_WATCHDOG, _A.ACCEPT, _A.DELIVER_REFUSAL, *_END),
    _ST.SHORT: (_A.FEED_WATCHDOG, _A.ACCEPT, _A.DELIVER_REFUSAL, *_END),
}
_ASIDE: dict[ServerTrigger, tuple[Action, ...]] = {
    _ST.BAD_FRAME: (_A.REJECT,),
    _ST.GENERAL_DUE: (_A.SEND_GENERAL,),
    _ST.REPORT_DUE: (_A.ASK_REPORT,),
}

SERVER_TABLE: Table = MappingProxyType(
    {
        **{(s, trigger): Transition(_S.LINKED, actions) for s in _S for trigger, actions in _EVERYWHERE.items()},
        **{(s, trigger): Transition(s, actions) for s in _S for trigger, actions in _ASIDE.items()},
        **{(s, _ST.SILENCE): Transition(_S.LOST, (_A.STOP,)) for s in (_S.WAITING, _S.LINKED)},
    }
)
"""The rover."""

_ASKING = (_C.WAITING, _C.LINKED, _C.LOST)
_FOUND = Transition(_C.LINKED, (_A.FEED_SILENCE, _A.REPORT_FOUND, _A.DELIVER_REPORT))
_GONE = Transition(_C.LOST, (_A.REPORT_LOST,))

CLIENT_TABLE: Table = MappingProxyType(
    {
        (_C.IDLE, _CT.CONNECT): Transition(_C.WAITING, (_A.SEND_REQUEST, _A.FEED_SILENCE)),
        (_C.IDLE, _CT.REPORT): Transition(_C.IDLE, (_A.DELIVER_REPORT,)),
        (_C.WAITING, _CT.REPORT): _FOUND,
        (_C.LINKED, _CT.REPORT): Transition(_C.LINKED, (_A.FEED_SILENCE, _A.DELIVER_REPORT)),
        (_C.LOST, _CT.REPORT): _FOUND,
        (_C.WAITING, _CT.SILENCE): _GONE,
        (_C.LINKED, _CT.SILENCE): _GONE,
        (_C.WAITING, _CT.LINE_DOWN): _GONE,
        (_C.LINKED, _CT.LINE_DOWN): _GONE,
        **{(s, _CT.KEEPALIVE): Transition(s, (_A.SEND_REQUEST,)) for s in _ASKING},
        **{(s, _CT.DISCONNECT): Transition(_C.IDLE, (_A.SEND_STOP,)) for s in _ASKING},
    }
)
"""The host."""

TIMER_STATES: Mapping[Timer, frozenset[State]] = MappingProxyType(
    {
        Timer.WATCHDOG: frozenset((_S.WAITING, _S.LINKED)),
        Timer.KEEPALIVE: frozenset(_ASKING),
        Timer.REPORTS: frozenset((_C.WAITING, _C.LINKED)),
    }
)
"""The states in which each timer runs; leaving these states ends it."""
