"""Statuses of the simulator: whole, cut, damaged, or behind what is none."""

from __future__ import annotations

from protocols.carla.board_clauses._common import ALL, HARDENED, SHIPPED, STACK, SUITE
from protocols.carla.clause import CHOICE, HAL, ISR, LINE, MICRO_ROS, TASK, Clause

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="VB24",
        suite=SUITE,
        level="must",
        title="Delimiters within a float are data",
        text="F6 is accepted: the longitudinal speed reported is 0.641665 m/s, the other figures are its own, too.",
        sources=(f"{ISR}: data bytes are not looked at",),
        profiles=ALL,
        needs=STACK,
    ),
    Clause(
        id="VB25",
        suite=SUITE,
        level="must",
        title="One stray byte is for ever",
        text=(
            "One byte, 00, then sound statuses at 20 Hz: none is accepted any more; EMERGENCY after 1.0 s, and still "
            "after 60 s."
        ),
        sources=(f"{ISR}: blocks of 22 bytes",),
        profiles=SHIPPED,
        twin="VB25H",
        needs=STACK,
    ),
    Clause(
        id="VB25H",
        suite=SUITE,
        level="must",
        title="Stray bytes cost no status",
        text=(
            "1 to 30 bytes 00, each beginning and each end of a status, ##, #A#, 22 and 30 times #, each 10 ms before "
            "a sound status: it is accepted; the mode stays AUTOWARE."
        ),
        sources=(LINE, CHOICE),
        profiles=HARDENED,
        needs=STACK,
    ),
    Clause(
        id="VB26",
        suite=SUITE,
        level="must",
        title="A frame may come in pieces",
        text="A status in two pieces of 10 and 12 bytes, 50 ms apart, is accepted: all its figures are reported.",
        sources=(ISR, LINE),
        profiles=ALL,
        needs=STACK,
    ),
    Clause(
        id="VB27",
        suite=SUITE,
        level="must",
        title="Missing fields keep their old values",
        text="#, the field A, $ and 15 bytes 00 are accepted: A is new, the other fields are as before.",
        sources=(f"{ISR}: $ is the end, whatever came before",),
        profiles=SHIPPED,
        twin="VB27H",
        needs=STACK,
    ),
    Clause(
        id="VB27H",
        suite=SUITE,
        level="must",
        title="A frame that lacks a field is none",
        text="#, the field A, $ and 15 bytes 00 are not accepted; nor is a status whose B is a second A.",
        sources=(CHOICE,),
        profiles=HARDENED,
        needs=STACK,
    ),
    Clause(
        id="VB28",
        suite=SUITE,
        level="must",
        title="22 times # is no status",
        text="22 bytes 23 are not accepted.",
        sources=(f"{ISR}: a second # ends the frame",),
        profiles=ALL,
        needs=STACK,
    ),
    Clause(
        id="VB29",
        suite=SUITE,
        level="must",
        title="A NaN is handed on",
        text="A status with NaN in C is reported to the driving stack with its NaN.",
        sources=(ISR, MICRO_ROS),
        profiles=SHIPPED,
        twin="VB29H",
        needs=STACK,
    ),
    Clause(
        id="VB29H",
        suite=SUITE,
        level="must",
        title="A NaN is no figure",
        text="A status with NaN or an infinity in any field is dropped: nothing of it is reported.",
        sources=(CHOICE,),
        profiles=HARDENED,
        needs=STACK,
    ),
    Clause(
        id="VB35",
        suite=SUITE,
        level="must",
        title="Damaged figures are believed",
        text="A status whose longitudinal speed is 1e30 m/s, a turned bit, is reported to the driving stack.",
        sources=(f"{ISR}: no checksum, no limits",),
        profiles=SHIPPED,
        twin="VB35H",
        needs=STACK,
    ),
    Clause(
        id="VB35H",
        suite=SUITE,
        level="must",
        title="What cannot be is dropped",
        text=(
            "A status with 101 % of the limit, + or -, in any field is dropped: nothing of it is reported. One that "
            "has 99 % of it in each is reported."
        ),
        sources=(CHOICE + ": the limits are 150 m/s, 20 rad/s, 2 rad",),
        profiles=HARDENED,
        needs=STACK,
    ),
    Clause(
        id="VB39",
        suite=SUITE,
        level="should",
        title="A line error ends reception",
        text="One framing error, then sound statuses: none is accepted any more; EMERGENCY after 1.0 s, and it stays.",
        sources=(HAL, f"{ISR}: there is no HAL_UART_ErrorCallback"),
        profiles=SHIPPED,
        twin="VB39H",
        needs=("board", "stack", "line errors"),
    ),
    Clause(
        id="VB39H",
        suite=SUITE,
        level="must",
        title="A line error costs a status",
        text=(
            "One framing error, then sound statuses: the second of them is accepted at the latest, in AUTOWARE and in "
            "MANUAL; in EMERGENCY they lead to MANUAL within 0.5 s."
        ),
        sources=(CHOICE,),
        profiles=HARDENED,
        needs=("board", "stack", "line errors"),
    ),
    Clause(
        id="VB57",
        suite=SUITE,
        level="must",
        title="An old status is an answer",
        text=(
            "In AUTOWARE statuses and commands stop; behind a missed command comes one status, and 0.5 s later one "
            "command: the status is taken for the answer to it, and reported within 50 ms."
        ),
        sources=(f"{TASK}: a flag has no age",),
        profiles=SHIPPED,
        twin="VB57H",
        needs=STACK,
    ),
    Clause(
        id="VB57H",
        suite=SUITE,
        level="must",
        title="An old status is no answer",
        text=(
            "The same with the command 105 ms behind the status: the command is sent, the status is not reported, as "
            "it waited for longer than the 100 ms for which one is waited for; one that comes 50 ms later is."
        ),
        sources=(CHOICE,),
        profiles=HARDENED,
        needs=STACK,
    ),
    Clause(
        id="VB47",
        suite=SUITE,
        level="must",
        title="Half a status is given up",
        text="A status in two pieces, 0.15 s apart, is not accepted, wherever it is cut; the next one is.",
        sources=(CHOICE,),
        profiles=HARDENED,
        needs=STACK,
    ),
)
