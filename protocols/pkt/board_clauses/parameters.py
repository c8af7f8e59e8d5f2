"""Parameters: missing ones, flags, and a throttle beyond one."""

from __future__ import annotations

from protocols.pkt.board_clauses._common import BY_REPORT, DOCUMENTED, G2_ALONE, SHIPPED, SUITE, V2
from protocols.pkt.clause import CHOICE, DOCUMENT, G0, G2, G2_MOTORS, MANUAL, Clause

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="P22",
        suite=SUITE,
        level="must",
        title="Missing parameters are taken from earlier frames",
        text="A payload of 03 alone: 1/0/3/0, the throttles are stale bytes of the buffer.",
        sources=(f"{G2} set_motor_throttles", f"{G0} update_motor_speeds"),
        profiles=SHIPPED,
        twin="P22D",
        needs=("server",),
    ),
    Clause(
        id="P22D",
        suite=SUITE,
        level="must",
        title="Missing parameters are an error",
        text="After 0x03 with 0.5 and -0.25, a payload of 03 alone changes no throttle: ACC 2, REJ 0, OP 3, ERR not 0.",
        sources=(f"{DOCUMENT}, 0x80: LAST_ERROR is the error of the last command", CHOICE + " which error; ours is 2"),
        profiles=DOCUMENTED,
        needs=("server",),
    ),
    Clause(
        id="P27",
        suite=SUITE,
        level="must",
        title="Flags choose the motors",
        text="0x03 with 0.5 and -0.25 and flags 01: A alone changes; flags 00: none does; ACC + 1 both times.",
        sources=(f"{DOCUMENT}, 0x03", f"{MANUAL}, 0x03", f"{G2_MOTORS} set_motor_throttles"),
        profiles=V2,
        needs=("server",),
    ),
    Clause(
        id="P28",
        suite=SUITE,
        level="must",
        title="A throttle beyond 1 is kept",
        text="0x03 with 1.5: 0x83 shows 1.5, the duty is 1.",
        sources=(f"{G2} set_motor_throttles", f"{G2_MOTORS} write_throttle"),
        profiles=G2_ALONE,
        twin="P28D",
        needs=("server", "duty"),
        stand_ins=BY_REPORT,
    ),
    Clause(
        id="P28D",
        suite=SUITE,
        level="must",
        title="A throttle stays between -1 and 1",
        text="0x03 with 1.5, -2 or NaN: 0x83 never shows a throttle outside -1 to 1, and no NaN.",
        sources=(f"{MANUAL}, 0x03", "whether it is refused or limited is left open"),
        profiles=DOCUMENTED,
        needs=("server",),
    ),
    Clause(
        id="P66",
        suite=SUITE,
        level="must",
        title="Missing parameters of the speed control are an error",
        text=(
            "After 0x04 with 30 and -20 rpm, payloads of 04 alone, of 04 and 8 bytes, of 05 alone and of 05 and 8 "
            "bytes are each accepted with an error, and followed by one 0x81 with their opcode and a status other than "
            "0; 0x83 still shows setpoints of 30 and -20."
        ),
        sources=(f"{DOCUMENT}, 0x80: LAST_ERROR is the error of the last command", CHOICE + " which error; ours is 2"),
        profiles=DOCUMENTED,
        needs=("server",),
    ),
)
