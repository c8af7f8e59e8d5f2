"""What the driving stack is told of the modes and of the vehicle."""

from __future__ import annotations

from protocols.carla.board_clauses._common import ALL, HARDENED, SHIPPED, STACK, SUITE, V0_ALONE, V1_ALONE
from protocols.carla.clause import CHOICE, MICRO_ROS, TASK, V0, Clause

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="VB32",
        suite=SUITE,
        level="must",
        title="An old status is reported as if it were new",
        text="Statuses stop in AUTOWARE: the last one is reported to the driving stack again at each miss.",
        sources=(f"{TASK}: VEHICLE_NEW_DATA_FLAG at osFlagsErrorTimeout",),
        profiles=SHIPPED,
        twin="VB32H",
        needs=STACK,
    ),
    Clause(
        id="VB32H",
        suite=SUITE,
        level="must",
        title="No status, no report",
        text="Statuses stop, in AUTOWARE and in MANUAL: nothing more is reported to the driving stack but the mode.",
        sources=(CHOICE,),
        profiles=HARDENED,
        needs=STACK,
    ),
    Clause(
        id="VB36",
        suite=SUITE,
        level="must",
        title="EMERGENCY is kept from the driving stack",
        text="From AUTOWARE to EMERGENCY the control-mode report goes on saying 1.",
        sources=(f"{V0}, microAutoware.c: the flag is not in the mask",),
        profiles=V0_ALONE,
        twin="VB36H",
        needs=STACK,
    ),
    Clause(
        id="VB36H",
        suite=SUITE,
        level="must",
        title="EMERGENCY is reported",
        text="In EMERGENCY the control-mode report says 6, NOT_READY.",
        sources=("autoware_auto_vehicle_msgs, ControlModeReport", CHOICE),
        profiles=HARDENED,
        needs=STACK,
    ),
    Clause(
        id="VB37",
        suite=SUITE,
        level="must",
        title="EMERGENCY is reported as MANUAL",
        text="In EMERGENCY the control-mode report says 4.",
        sources=(f"{MICRO_ROS}: MA_TO_EMERGENCY_MODE_FLAG",),
        profiles=V1_ALONE,
        twin="VB36H",
        needs=STACK,
    ),
    Clause(
        id="VB48",
        suite=SUITE,
        level="must",
        title="The mode is reported",
        text=(
            "In AUTOWARE the control-mode report says 1, in MANUAL 4, and no other, 20 times in 2 s, 2 more or less; "
            "asked for MANUAL, 4 within 0.1 s of the first frame of mode 4."
        ),
        sources=(MICRO_ROS, f"{CHOICE}: every 100 ms"),
        profiles=ALL,
        needs=STACK,
    ),
    Clause(
        id="VB49",
        suite=SUITE,
        level="must",
        title="Reports are stamped",
        text="The clock is sent twice: reports of mode, velocity and steering have the latest as their stamp.",
        sources=(MICRO_ROS,),
        profiles=ALL,
        needs=STACK,
    ),
    Clause(
        id="VB52",
        suite=SUITE,
        level="must",
        title="Without a clock stamps are 0",
        text="Before the first clock message, the stamps of reports of mode, velocity and steering are 0.",
        sources=(f"{MICRO_ROS}: the time of the clock is kept in a variable", CHOICE),
        profiles=ALL,
        needs=("board", "stack", "boot"),
    ),
    Clause(
        id="VB53",
        suite=SUITE,
        level="must",
        title="The newest status is reported",
        text=(
            "In AUTOWARE 100 statuses come at 20 Hz, each with other figures: each is reported once, within 40 ms, as "
            "soon as a command has come, and what is reported is the newest then."
        ),
        sources=(TASK, MICRO_ROS),
        profiles=ALL,
        needs=STACK,
    ),
)
