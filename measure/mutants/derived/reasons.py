"""Why a derived mutant survives, by family.

A reason begins with one of three words. "equivalent": the specification permits it, in a sentence that is named.
"unasked": it is wrong, but no clause asks for what would show it. "elsewhere": a clause of another suite does, on
another bench. Beside them stands why a mutant shows at no port, whatever anybody does there: `HIDDEN`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from types import MappingProxyType

from measure.mutants.derived.trial import Outcome

__all__ = ["EQUIVALENT", "HIDDEN", "REASONS", "hidden", "reason"]

EQUIVALENT = "equivalent"

_CONSTANT = "unasked: in no case of the suites does the field have two values"
_NEVER = "unasked: no case of the suites has a frame with which it does anything else than the right peer"
_EVENLY = "unasked: P30 and P85 ask how many reports come, and how evenly: one may always be late by the same time"
_FIRST_REQUEST = (
    "unasked: every case begins with requests until one is answered, and the state before the first frame is over then"
)

REASONS: Mapping[str, Sequence[tuple[str, str]]] = MappingProxyType(
    {
        "pkt-board": (
            (r"hears:LED_ON:unused", f"{EQUIVALENT}: P09, 'what follows the opcode is ignored'"),
            (
                r"hears:.*:unused",
                f"{EQUIVALENT}: P70, with bytes behind its parameters a command is 'taken as without them'",
            ),
            (
                r"REQUEST_TMY:report_type",
                "unasked: no clause asks that the byte behind a request is not read (0 in rover_groundcontrol)",
            ),
            (
                r"WAITING/SILENCE",
                f"{EQUIVALENT}: P24D, 'a motor command, then silence': before the first frame there is nothing to stop",
            ),
            (
                r"LINKED/SILENCE:stays",
                f"{EQUIVALENT}: P24D, motors at 0 'until one commands them': they are, and both states answer alike",
            ),
            (
                r"hears:RESET_PID_CONTROLLER:kd",
                "unasked: no clause asks for the derivative gain: held wheels have none, and of others it is a spike",
            ),
            (r"WAITING/", _FIRST_REQUEST),
            (
                r"LOST/REQUEST:stays",
                "unasked: a link on which requests alone come again is not missed a second time, but nothing runs then",
            ),
            (r"says:(ImuReport|GpsReport|MotionReport):(late|early|reordered)", _EVENLY),
            (r"says:.*:unused", "unasked: no clause asks what stands in bytes that are reserved"),
            (r"says:MotionReport:ticks", "elsewhere: R09 of rover-motion holds the counts against the wheels' angles"),
            (
                r"says:MotionReport:rpm.*neighbour",
                "elsewhere: the wheels of the cases turn alike in pairs; R24 of rover-motion stalls one of them",
            ),
            (
                r"REQUEST_TMY:reordered",
                "unasked: what the checker asks for next is another request, and each gets its answer",
            ),
        ),
        "pkt-host": (
            (r"KEEPALIVE:halved", f"{EQUIVALENT}: P51, 'at least once a second'"),
            (r"REPORTS:halved", f"{EQUIVALENT}: P57, 'within five seconds of silence'"),
            (r"LINKED/SILENCE:idle", "unasked: P57 asks what the host says of its rover, not that it tells its user"),
            (r"WAITING/KEEPALIVE", "unasked: a host that asks once and is answered is not asked to go on asking"),
            (
                r"hears:.*:unused",
                "unasked: no field stands in these bytes, and no clause asks that a host does not look at them",
            ),
            (
                r"hears:.*:(doubled|reordered|late)",
                "unasked: no clause asks in which order or how often a host shows reports",
            ),
            (
                r"says:.*:(doubled|reordered|late|early)",
                "unasked: P53 asks for the bytes of a command, not when it is sent",
            ),
        ),
        "p2os-server": (
            (r"hears:BATTERYINFO:argument", "unasked: no source says what its argument means on P2OS"),
            (
                r"hears:(#200|STEP|LOADWORLD|BATTERYINFO):(argument|dropped|doubled|late|reordered)",
                f"{EQUIVALENT}: S48, BATTERYINFO and 'the commands 200, 63 and 64 leave the session as it is'",
            ),
            (r"hears:HOSTBAUD:", "unasked: HOSTBAUD is not of P2OS but of later firmware"),
            (
                r"hears:SETO:doubled",
                f"{EQUIVALENT}: S33, 'SETO makes here the origin', and the second one comes at the same place",
            ),
            (
                r"hears:DHEAD:doubled",
                "unasked: a second DHEAD at once, from the same heading (S29), turns no further",
            ),
            (r"says:EncoderPacket:reordered", "unasked: no clause asks in which order packets come"),
            (
                r"says:ConfigPacket:(four_motors|serial)",
                "unasked: a figure of the robot's FLASH that nothing else shows, and that S92 does not write",
            ),
            (r"hears:CONFIG:argument", "unasked: no source says what CONFIG does with another argument than 1"),
            (r"hears:\w+:(late|doubled|reordered)", "unasked: the case looks only at what is so in the end"),
        ),
        "p2os-client": (
            (r"SYNC1_SENT/ECHO0:stays", f"{EQUIVALENT}: C05, 'the client restarts or repeats, and succeeds'"),
            (r"KEEPALIVE:halved", f"{EQUIVALENT}: C22, 'some packet at least every 1 s'"),
            (
                r"SYNC0_SENT/SIP:(idle|stays)",
                f"{EQUIVALENT}: C07, 'SIPs of type 32 instead of an echo: the client sends CLOSE, waits, sends SYNC0'",
            ),
            (r"hears:ConfigPacket:doubled", f"{EQUIVALENT}: C31, 'each is understood', and the second says the same"),
        ),
        "carla-host": (
            (
                r"LINKED/SILENCE:stays",
                f"{EQUIVALENT}: VS26H, 'commanded to stop, once; the next frame, F2, is obeyed again': both do it",
            ),
        ),
        "carla-board": (
            (
                r"BoardState:(SEEKING/GIVE_UP|(ABSENT|SEEKING)/AGENT_ONLINE:idle)",
                f"{EQUIVALENT}: 'The link has no session: messages are taken and sent in every state' (its states.py)",
            ),
        ),
    }
)
"""By subject: what the ids of a family match, and its reason; the first that matches counts."""


_FLASH = (
    r"aux1_baud|front_sonar|gripper|host_baud|joy_\w+|low_battery_dv|p2mpacs|pwm_max|rear_sonar|revcount|sip_cycle_ms"
    r"|stall_\w+|watchdog_ms|(rot|trans)_(acc|vel)_top_\w+"
)
"""Figures of CONFIG that no command changes."""

_OFFSET = "an offset that its sensor may have by its data sheet"

HIDDEN: Mapping[str, Sequence[tuple[str, str]]] = MappingProxyType(
    {
        "pkt-board": (
            (
                r"ImuReport:acceleration\[\d\]:(plus|minus)",
                f"1 m/s^2 is {_OFFSET}: 80 mg, and 1.5 mg more for each K (PS-MPU-9250A-01, section 3.2)",
            ),
            (r"ImuReport:rate_deg_s\[\d\]:(plus|minus)", f"1 deg/s is {_OFFSET}: 5 deg/s (section 3.1)"),
            (
                r"ImuReport:field_mgauss\[\d\]:(plus|minus)",
                "1 mG is less than a step of the compass, 1.5 mG (section 3.3), and iron beside it makes far more",
            ),
            (
                r"ImuReport:temperature_c:(plus|minus)",
                "1 C is less than a chip is warmer than the air around it, and nobody else knows its temperature",
            ),
            (
                r"ImuReport:quaternion\[3\]:sign",
                "with the other sign of its scalar it leads from the earth and not to it, and no source says which",
            ),
            (
                r"(ImuReport|GpsReport):(late|early)",
                "no source says when in its second a report is made, nor how old its figures are then",
            ),
            (r"GpsReport:(first|second)_deg:stale", "the filter of a receiver may be late by 1 s"),
        ),
        "carla-board": (
            (
                r"says:MANUAL:(steer|throttle|brake):stale",
                "it is late by 60 ms, and when somebody moved the joystick nobody knows as exactly",
            ),
        ),
        "p2os-server": (
            (
                r"hears:DHEAD:doubled",
                "DHEAD turns from the heading that the robot has (S91), and it has the same at the second",
            ),
            (
                r"hears:(ADSEL|R?VEL|SETR?[AV]|SONAR|(ROT|TRANS)K[PIV]):doubled",
                "the second sets what the first has set",
            ),
            (r"hears:(OPEN|CLOSE):argument|ENABLE:unused", "no source gives these bytes a meaning"),
            (r"hears:SAY:argument", "what the robot plays is heard in its room"),
            (
                r"hears:(ROT|TRANS)K[PIV]:reordered",
                "CONFIG, which alone says it, is made in a cycle in which both commands are obeyed",
            ),
            (
                r"hears:(GETAUX|TTY2):(argument:(stale|stuck)|late)|says:SerAuxPacket:doubled",
                "it is not known that anything at the AUX port speaks",
            ),
            (r"says:Sip:digin:(stuck|stale)", "nothing is known to change the inputs"),
            (
                rf"says:ConfigPacket:({_FLASH}):(stuck|stale)",
                "what is in FLASH does not change while somebody is there",
            ),
            (
                r"says:ConfigPacket:(aux1_baud:plus|joy_\w+:minus|low_battery_dv:plus|p2mpacs:plus|stall_pwm:neighbour)",
                "it is in FLASH, and nothing else that the robot does tells it, or so exactly",
            ),
        ),
    }
)
"""By subject: what the ids of a family match, and why it shows at no port."""


def hidden(subject: str, id_: str) -> str:
    """Return why a mutant shows at no port; empty if it could."""
    return next((text for pattern, text in HIDDEN.get(subject, ()) if re.search(pattern, id_)), "")


def reason(subject: str, id_: str, outcome: Outcome) -> str:
    """Return why a mutant survives; empty if nobody knows. One without effect is not equivalent: nobody looked."""
    for pattern, text in REASONS.get(subject, ()):
        if re.search(pattern, id_) and (outcome.cases or not text.startswith(EQUIVALENT)):
            return text
    if not outcome.cases:
        return _CONSTANT if id_.rpartition(":")[2] in ("stuck", "stale") else _NEVER
    return ""
