"""Why a mutant survives: as far as it can be told, by rule; the others one by one.

A reason begins with one of three words. "equivalent": nothing outside can tell the mutant from the right device.
"unasked": it can be told, but no clause asks for what would. "elsewhere": another suite or a unit test finds it.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import msgspec

from measure.mutants.catalogue import all_mutants
from measure.mutants.mutant import Family, Mutant
from measure.mutants.record import Entry, Record
from protocols.p2os.states import Action, ServerTrigger, State, Trigger

EQUIVALENT = "equivalent"
UNTAKEN = "unasked: no case goes along this edge"

_NEXT_SIP = "unasked: the next SIP, 100 ms later, makes up for it; no clause asks for CLOSE at the first"
_NOT_HANDED_ON = "unasked: C14 asks that an unknown packet does no harm, not that it is handed on"
_ONE_CLOSE = "unasked: the first CLOSE is obeyed, and no clause has a robot that misses it"
_OUT_OF_ORDER = "unasked: what it does to a SYNC out of order is one of the answers that S14 allows"
_RECOVERS = "unasked: the answer that does not come is asked for again, as C05 and C11 allow"
_TWICE = "unasked: the first try fails and the next succeeds; no clause limits the tries"
_STATE = "unasked: the failure is reported and the client is silent; only that it cannot connect again would show"
_OPEN_AGAIN = "unasked: OPEN and CONFIG are sent again until an answer comes; no clause limits how soon"
_ECHO_TELLS = "unasked: the echo of the next PULSE tells that the session is gone; no clause limits how soon"
_REPORT = "unasked: shows to the user only, in a report that no clause asks for"

REASONS: Mapping[str, str] = MappingProxyType(
    {
        "count-limit": "unasked: S17 asks that a long packet is swallowed whole, not that it is obeyed",
        "hostbaud-ignored": "unasked: HOSTBAUD is not of P2OS but of later firmware",
        "y-stuck": "elsewhere: m-y-stuck; here a case is inconclusive, so that the check does not pass either",
        "server:WAIT2/SYNC0_PULSE:to-WAIT2": _OUT_OF_ORDER,
        "server:WAIT1/SYNC2_CLOSE:to-WAIT": _OUT_OF_ORDER,
        "server:WAIT1/SYNC2_CLOSE:to-READY": _OUT_OF_ORDER,
        "server:OPEN/SYNC0_PULSE:no-DELIVER_COMMAND": (
            "unasked: PULSE means nothing to the robot but that it confirms a HOSTBAUD, which is of later firmware"
        ),
        "client:SYNC0_SENT/NEXT_BAUD:SEND_SYNC0-SEND_SYNC1": _TWICE,
        "client:SYNC2_SENT/TIMEOUT:SEND_SYNC2-SEND_SYNC0": _RECOVERS,
        "client:SYNC1_SENT/STEP_BACK:to-SYNC1_SENT": _RECOVERS,
        "client:SYNC1_SENT/STEP_BACK:SEND_SYNC0-SEND_SYNC1": _RECOVERS,
        "client:SYNC1_SENT/STEP_BACK:no-SEND_SYNC0": _RECOVERS,
        "client:SYNC0_SENT/SYNC_ERROR:removed": _RECOVERS,
        "client:SYNC0_SENT/SYNC_ERROR:to-SYNC0_SENT": _RECOVERS,
        "client:SYNC0_SENT/SYNC_ERROR:no-PAUSE": _RECOVERS,
        "client:SYNC1_SENT/ECHO0:removed": _RECOVERS,
        "client:SYNC1_SENT/ECHO0:to-SYNC1_SENT": _RECOVERS,
        "client:SYNC2_SENT/BROKEN_IDENTIFICATION:removed": _RECOVERS,
        "client:SYNC2_SENT/BROKEN_IDENTIFICATION:to-SYNC2_SENT": _RECOVERS,
        "client:SYNC0_SENT/SIP:to-SYNC0_SENT": _NEXT_SIP,
        "client:SYNC0_SENT/SIP:no-SEND_CLOSE_OLD": _NEXT_SIP,
        "client:SYNC0_SENT/SIP:SEND_CLOSE_OLD-SEND_PULSE": _NEXT_SIP,
        "client:CLOSING_OLD/SIP:removed": _ONE_CLOSE,
        "client:CLOSING_OLD/SIP:no-SEND_CLOSE_OLD": _ONE_CLOSE,
        "client:CLOSING_OLD/SIP:SEND_CLOSE_OLD-SEND_PULSE": _ONE_CLOSE,
        "client:CLOSING_OLD/TIMEOUT:SEND_SYNC0-SEND_SYNC1": _TWICE,
        "client:OPENING/TIMEOUT:no-SEND_OPEN": _OPEN_AGAIN,
        "client:OPENING/TIMEOUT:no-REQUEST_CONFIG": _OPEN_AGAIN,
        "client:OPENING/TIMEOUT:REQUEST_CONFIG-SEND_PULSE": _OPEN_AGAIN,
        "client:CONFIGURING/RESET:removed": _ECHO_TELLS,
        "client:CONFIGURING/RESET:to-CONFIGURING": _ECHO_TELLS,
        "client:OPEN/RESET:removed": _ECHO_TELLS,
        "client:OPEN/RESET:to-OPEN": _ECHO_TELLS,
        "client:OPEN/SIP_LOST:to-OPEN": _STATE,
        "client:CONFIGURING/CONFIG:to-CONFIGURING": "unasked: the session begins a second late, as C17 allows",
        "client:CONFIGURING/GAVE_UP:no-REPORT_CONNECTED": _REPORT,
        "client:CONFIGURING/GAVE_UP:REPORT_CONNECTED-REPORT_FAILED": _REPORT,
        "client:CONFIGURING/SIP:removed": "unasked: no clause asks for the SIPs that come before CONFIG",
        "client:CONFIGURING/SIP:no-FEED_SIP_TIMER": "unasked: OPEN is sent once more, which a session ignores",
        "client:CONFIGURING/SIP:no-DELIVER_PACKET": "unasked: no clause asks for the SIPs that come before CONFIG",
        "client:OPEN/PACKET:removed": _NOT_HANDED_ON,
        "client:OPEN/PACKET:no-DELIVER_PACKET": _NOT_HANDED_ON,
        "client:OPEN/KEEPALIVE:SEND_PULSE-SEND_DISABLE": "unasked: C22 asks for any packet",
        "client:CLOSING/TIMEOUT:no-REPORT_DISCONNECTED": _REPORT,
        "client:CLOSING/TIMEOUT:REPORT_DISCONNECTED-REPORT_LOST": _REPORT,
        "client:SYNC0_SENT/GAVE_UP:to-SYNC0_SENT": _STATE,
        "client:SYNC0_SENT/GAVE_UP:to-LOST": "unasked: the failure is reported, and LOST leads on as FAILED does",
        "client:RESTARTING/GAVE_UP:to-RESTARTING": _STATE,
        "client:RESTARTING/GAVE_UP:to-LOST": "unasked: the failure is reported, and LOST leads on as FAILED does",
    }
)
"""By mutant."""


def explained(record: Record, taken: frozenset[tuple[State, Trigger]]) -> Record:
    """Return the record with a reason for each survivor that has one.

    Args:
        record: what was found.
        taken: the edges of the state tables that the suites take on the right device.
    """
    by_id = {mutant.id: mutant for mutant in all_mutants()}
    mutants = {id_: _explained(by_id[id_], entry, taken) for id_, entry in record.mutants.items()}
    return msgspec.structs.replace(record, mutants=mutants)


def _explained(mutant: Mutant, entry: Entry, taken: frozenset[tuple[State, Trigger]]) -> Entry:
    why = "" if entry.killed else REASONS.get(mutant.id, "") or _by_rule(mutant, taken)
    return msgspec.structs.replace(entry, survives=why)


def _by_rule(mutant: Mutant, taken: frozenset[tuple[State, Trigger]]) -> str:
    if mutant.family not in (Family.SERVER_TABLE, Family.CLIENT_TABLE):
        return ""
    (edge,) = mutant.edges
    if edge.trigger is ServerTrigger.HANDSHAKE_LIMIT or Action.LIMIT_HANDSHAKE.name in mutant.id:
        return f"{EQUIVALENT}: the handshake of a P2OS robot has no limit, so its timer never runs"
    if (edge.state, edge.trigger) not in taken:
        return UNTAKEN
    return ""
