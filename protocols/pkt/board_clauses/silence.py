"""Time: half a frame, a lost link, eleven bytes at once, and reports that come by themselves."""

from __future__ import annotations

from protocols.pkt.board_clauses._common import BY_REPORT, DOCUMENTED, G2_ALONE, SUITE, V2
from protocols.pkt.clause import CHOICE, DECODER, DOCUMENT, G0, G2, G2_CONFIG, MANUAL, SERIAL, Clause

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="P23",
        suite=SUITE,
        level="must",
        title="Half a frame waits for ever",
        text="LED_ON cut behind its sixth byte, the rest 30 s later: 1/0/1/0.",
        sources=("nhorro/ceai2020 at 6058e92, main.cpp and application.cpp: nothing calls check_timeouts",),
        profiles=G2_ALONE,
        twin="P23D",
        needs=("server",),
    ),
    Clause(
        id="P23D",
        suite=SUITE,
        level="must",
        title="Half a frame is forgotten after a second",
        text=(
            "LED_ON cut behind its sixth byte, the rest 30 s later, or 1.1 s: 0/0/0/0, an error of time is not "
            "counted. The rest 0.9 s later instead: 1/0/1/0."
        ),
        sources=(f"{G2_CONFIG} PACKET_TIMEOUT_IN_MS", f"{DECODER} check_timeouts and its comment", f"{G2} set_error"),
        profiles=DOCUMENTED,
        needs=("server",),
    ),
    Clause(
        id="P24",
        suite=SUITE,
        level="must",
        title="A lost link changes nothing",
        text="0x03 with 0.5 and -0.25, then silence for 10 s: 0x83 still shows 0.5 and -0.25.",
        sources=(f"{G2} handle_connection_lost: commented out, and nothing calls it",),
        profiles=G2_ALONE,
        twin="P24D",
        needs=("server",),
    ),
    Clause(
        id="P24D",
        suite=SUITE,
        level="must",
        title="A lost link stops the motors",
        text=(
            "A motor command, then silence: both motors are at 0 within 1.1 s, and stay there when frames come again "
            "until one commands them. REQUEST_TMY each 0.5 s keeps them running."
        ),
        sources=(
            f"{G2} handle_connection_lost, its comment: on a lost connection switch the vehicle off at once",
            f"{G2_CONFIG} HEARTBEAT_TIMEOUT_IN_MS",
            f"{G0} handle_connection_lost",
        ),
        profiles=("documented", "g0"),
        needs=("server", "duty"),
        stand_ins=BY_REPORT,
    ),
    Clause(
        id="P25",
        suite=SUITE,
        level="must",
        title="Eleven bytes at once are lost",
        text="A frame with the payload 01 00 00 in one look of the receiver: 0/0/0/0.",
        sources=(f"{G2} read_telecommands: compared with EAGAIN, 11, instead of its negative",),
        profiles=G2_ALONE,
        twin="P25D",
        needs=("server",),
    ),
    Clause(
        id="P25D",
        suite=SUITE,
        level="must",
        title="Eleven bytes are a frame like any other",
        text="A frame with the payload 01 00 00, eleven bytes at once: 1/0/1/0.",
        sources=(DOCUMENT, SERIAL),
        profiles=("documented", "g0"),
        needs=("server",),
    ),
    Clause(
        id="P30",
        suite=SUITE,
        level="must",
        title="Reports come by themselves",
        text="10 s without a command: 30 or 31 of 0x80, 40 or 41 of 0x83, 10 or 11 of 0x82 and of 0x84.",
        sources=(f"{MANUAL}, table of tasks", f"{G2} execute_periodic_tasks"),
        profiles=V2,
        needs=("server",),
    ),
    Clause(
        id="P61",
        suite=SUITE,
        level="must",
        title="Half a frame is forgotten wherever it ends",
        text="LED_ON cut behind each of its bytes but the last, and 1.2 s later LED_OFF: all eight are accepted, 8/0.",
        sources=(f"{G2_CONFIG} PACKET_TIMEOUT_IN_MS", f"{DECODER} check_timeouts and its comment"),
        profiles=DOCUMENTED,
        needs=("server",),
    ),
    Clause(
        id="P62",
        suite=SUITE,
        level="must",
        title="A lost link ends speed control",
        text=(
            "0x04 with 60 and -60 rpm, the wheels held, then silence: both motors are at 0 within 1.1 s, and stay "
            "there when frames come again; 0x83 shows throttles and setpoints of 0. 0x04 with 60 rpm and flags 01 then "
            "runs A alone. REQUEST_TMY each 0.5 s keeps them running."
        ),
        sources=(
            f"{G2} handle_connection_lost, its comment: on a lost connection switch the vehicle off at once",
            f"{G2_CONFIG} HEARTBEAT_TIMEOUT_IN_MS",
            CHOICE + " that the setpoints go too: none may come back with a command for the other pair",
        ),
        profiles=DOCUMENTED,
        needs=("server", "duty", "wheels"),
        stand_ins=BY_REPORT,
        by_hand=True,
    ),
    Clause(
        id="P80",
        suite=SUITE,
        level="must",
        title="Noise does not keep the motors running",
        text=(
            "A motor command, then nothing but bytes that are no sound frame (abcdefg and a newline, LED_ON with a "
            "wrong CRC, LED_ON without its newline), one of them each 0.1 s: both motors are at 0 within 1.1 s."
        ),
        sources=(
            f"{DECODER}: the time of the last sign of life is taken where a packet is handed on, and nowhere else",
            f"{G2_CONFIG} HEARTBEAT_TIMEOUT_IN_MS",
            f"{G0} handle_connection_lost",
        ),
        profiles=("documented", "g0"),
        needs=("server", "duty"),
        stand_ins=BY_REPORT,
    ),
    Clause(
        id="P76",
        suite=SUITE,
        level="must",
        title="Every lost link stops the motors",
        text=(
            "A motor command, then silence, three times: each time the motors obey, and both are at 0 within 1.1 s of "
            "the command."
        ),
        sources=(
            f"{G2} handle_connection_lost, its comment: on a lost connection switch the vehicle off at once",
            f"{G2_CONFIG} HEARTBEAT_TIMEOUT_IN_MS",
        ),
        profiles=DOCUMENTED,
        needs=("server", "duty"),
        stand_ins=BY_REPORT,
    ),
    Clause(
        id="P77",
        suite=SUITE,
        level="must",
        title="A request after a lost link is answered",
        text="A sound frame, 1.5 s of silence, then REQUEST_TMY: at once one 0x80; 0/0.",
        sources=(DOCUMENT, f"{G2} handle_packet, send_general_tmy_report"),
        profiles=DOCUMENTED,
        needs=("server",),
    ),
    Clause(
        id="P78",
        suite=SUITE,
        level="must",
        title="At power-up nothing has been counted",
        text="The first answer after power-up is 50 4B 54 21 06 80 00 00 00 00 00 DA 30 0A: 0/0/0/0, and no failure.",
        sources=(DOCUMENT, f"{G2} handle_packet, send_general_tmy_report"),
        profiles=DOCUMENTED,
        needs=("server", "boot"),
        by_hand=True,
    ),
    Clause(
        id="P85",
        suite=SUITE,
        level="must",
        title="Reports come evenly",
        text=(
            "From the first one on, 3.2 s without a command: each 0x83 comes 0.25 s and each 0x82 and 0x84 1 s behind "
            "the one before it, within 50 ms and the time that the reports before it take on the line."
        ),
        sources=(f"{MANUAL}, table of tasks: each report has its period", CHOICE + " how far off one may be"),
        profiles=DOCUMENTED,
        needs=("server",),
    ),
)
