"""The start: with the driving stack there, without it, and when it comes late; and after a hang."""

from __future__ import annotations

from protocols.carla.board_clauses._common import ALL, HARDENED, SHIPPED, STICK, SUITE
from protocols.carla.clause import CHOICE, EXTI, MICRO_ROS, REPORT, TASK, V0, Clause

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="VB03",
        suite=SUITE,
        level="must",
        title="Without an agent MANUAL, after 20 s",
        text=(
            "Without an agent pings come 1.0 s apart, and the first frame 20.0 s after the first of them; it has mode "
            "4."
        ),
        sources=(f"{TASK}, TIMEOUT_MICRO_ROS_AGENT", f"{MICRO_ROS} rmw_uros_ping_agent(1000, 20)"),
        profiles=ALL,
        needs=("board", "stack", "boot"),
        by_hand=True,
    ),
    Clause(
        id="VB04",
        suite=SUITE,
        level="must",
        title="Frames that nobody filled",
        text=(
            "With the agent there and no command, the board sends nine times 30 bytes of anything, 110 ms apart, then "
            "mode 4 from 1.1 s after the way to it is there on: the first ping, or with micro-ROS the last object."
        ),
        sources=(f"{TASK}: ucTxMsgToCarla has no value yet",),
        profiles=SHIPPED,
        twin="VB04H",
        needs=("board", "stack", "boot"),
    ),
    Clause(
        id="VB04H",
        suite=SUITE,
        level="must",
        title="Nothing before there is something to say",
        text=(
            "With the agent there and no command, the first frame comes 1.1 s after the way to it is there (the first "
            "ping, or with micro-ROS the last object) and has mode 4."
        ),
        sources=(CHOICE,),
        profiles=HARDENED,
        needs=("board", "stack", "boot"),
    ),
    Clause(
        id="VB14",
        suite=SUITE,
        level="must",
        title="The first second is blind",
        text=(
            "The switch, let go of 0.99 s after the first ping, changes nothing; let go of again at 1.01 s, it leads "
            "to MANUAL."
        ),
        sources=(f"{EXTI}: the press before counts from tick 0",),
        profiles=ALL,
        needs=(*STICK, "boot"),
    ),
    Clause(
        id="VB58",
        suite=SUITE,
        level="must",
        title="An agent is waited for",
        text=(
            "An agent comes 18 s after power-on, with commands: nothing is sent before, and within 1.5 s a frame of "
            "mode 1 with the command; the mode is reported."
        ),
        sources=(f"{TASK}, TIMEOUT_MICRO_ROS_AGENT", f"{MICRO_ROS} rmw_uros_ping_agent(1000, 20)"),
        profiles=ALL,
        needs=("board", "stack", "boot"),
    ),
    Clause(
        id="VB42",
        suite=SUITE,
        level="must",
        title="An agent that comes late is not heard",
        text="The agent comes 25 s after the start: no report, no answer to a request; MANUAL stays.",
        sources=(f"{MICRO_ROS}: the session is made at boot alone", f"{REPORT}, known problems"),
        profiles=SHIPPED,
        twin="VB42H",
        needs=("board", "stack", "boot"),
    ),
    Clause(
        id="VB42H",
        suite=SUITE,
        level="must",
        title="An agent may come late",
        text=(
            "The agent comes 25 s after the start: the mode is reported, also while for 4 s only clock messages come; "
            "then, with commands, a request for AUTOWARE is granted and obeyed."
        ),
        sources=(CHOICE,),
        profiles=HARDENED,
        needs=("board", "stack", "boot"),
        by_hand=True,
    ),
    Clause(
        id="VB56",
        suite=SUITE,
        level="should",
        title="A program that hangs is gone for good",
        text="In AUTOWARE the program hangs, as in an endless loop with interrupts off: for 5 s no frame comes.",
        sources=(f"{V0}, main.c: no watchdog is started", "LMA-FEM-UNICAMP/microAutoware, main.c: likewise"),
        profiles=SHIPPED,
        twin="VB56H",
        needs=("board", "stack", "hang"),
    ),
    Clause(
        id="VB56H",
        suite=SUITE,
        level="must",
        title="A program that hangs starts again",
        text=(
            "In AUTOWARE, with commands and statuses, the program hangs, as in an endless loop with interrupts off: "
            "within 1 s frames of mode 1 come again; so from MANUAL."
        ),
        sources=(CHOICE,),
        profiles=HARDENED,
        needs=("board", "stack", "hang"),
    ),
)
