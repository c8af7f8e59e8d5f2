"""Why a derived mutant survives, by family.

A reason begins with one of three words. "equivalent": the specification permits it, in a sentence that is named.
"unasked": it is wrong, but no clause asks for what would show it. "elsewhere": a clause of another suite does, on
another bench.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from types import MappingProxyType

from measure.mutants.derived.trial import Outcome

__all__ = ["EQUIVALENT", "REASONS", "reason"]

EQUIVALENT = "equivalent"

_CONSTANT = "unasked: in no case of the suites does the field have two values"
_NEVER = "unasked: no case of the suites has a frame with which it does anything else than the right peer"
_EVENLY = "unasked: P30 counts the reports of 10 s; no clause asks how evenly they come, or in which order"
_ON_STAND = (
    "elsewhere: the rover of this bench stands on a stand, and its readings never change; R14 to R22 and R27 of "
    "rover-motion are for them, on a board with a body in a world, where these mutants were not run"
)
_FIRST_REQUEST = (
    "unasked: every case begins with requests until one is answered, and the state before the first frame is over then"
)

REASONS: Mapping[str, Sequence[tuple[str, str]]] = MappingProxyType(
    {
        "pkt-board": (
            (r"LED_ON:unused", f"{EQUIVALENT}: P09, 'what follows the opcode is ignored'"),
            (
                r"REQUEST_TMY:report_type",
                f"{EQUIVALENT}: the byte is 'always 0, and no firmware reads' it (rover_groundcontrol request_tmy)",
            ),
            (
                r"WAITING/SILENCE",
                f"{EQUIVALENT}: P24D, 'a motor command, then silence': before the first frame there is nothing to stop",
            ),
            (
                r"LINKED/SILENCE:stays",
                f"{EQUIVALENT}: P24D, motors at 0 'until one commands them': they are, and both states answer alike",
            ),
            (r"WAITING/", _FIRST_REQUEST),
            (
                r"LOST/REQUEST:stays",
                "unasked: a link on which requests alone come again is not missed a second time, but nothing runs then",
            ),
            (r"says:(ImuReport|GpsReport|MotionReport):(late|early|reordered)", _EVENLY),
            (r"says:.*:unused", "unasked: no clause asks what stands in bytes that are reserved"),
            (r"says:(ImuReport|GpsReport):", _ON_STAND),
            (r"says:MotionReport:ticks", "elsewhere: R09 of rover-motion holds the counts against the wheels' angles"),
            (r"says:MotionReport:rpm.*stale", "unasked: no clause asks how old a speed in 0x83 may be"),
            (
                r"says:MotionReport:rpm.*neighbour",
                "elsewhere: the wheels of the cases turn alike in pairs; R24 of rover-motion stalls one of them",
            ),
            (r"PID_CONTROLLER:kd", "unasked: no clause asks for the derivative gain; held wheels have none"),
            (
                r"PID_CONTROLLER:ki",
                "unasked: P45D and P46D alone ask for the gain of the sum, and are inconclusive where none gathers",
            ),
            (
                r"REQUEST_TMY:reordered",
                "unasked: what the checker asks for next is another request, and each gets its answer",
            ),
        ),
    }
)
"""By subject: what the ids of a family match, and its reason; the first that matches counts."""


def reason(subject: str, id_: str, outcome: Outcome) -> str:
    """Return why a mutant survives; empty if nobody knows."""
    for pattern, text in REASONS.get(subject, ()):
        if re.search(pattern, id_):
            return text
    if not outcome.cases:
        return _CONSTANT if id_.rpartition(":")[2] in ("stuck", "stale") else _NEVER
    return ""
