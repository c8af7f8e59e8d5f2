"""The joystick: what MANUAL makes of its readings."""

from __future__ import annotations

from protocols.carla.board_clauses._common import ALL, HARDENED, NOT_V1, SHIPPED, STICK, SUITE
from protocols.carla.clause import CHOICE, REPORT, TASK, UTILS, Clause

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="VB15",
        suite=SUITE,
        level="must",
        title="The joystick at rest",
        text="In MANUAL with readings 33970 and 33580: S is -0.0, 00 00 00 80, V and A are 0.",
        sources=(f"{TASK}: -fJoyXAxis",),
        profiles=ALL,
        needs=STICK,
        by_hand=True,
    ),
    Clause(
        id="VB16",
        suite=SUITE,
        level="must",
        title="The dead band has its edges",
        text="In MANUAL with readings 34470 and 34080, and with 33470 and 33080, S, V and A are still 0.",
        sources=(f"{UTILS} fGetJoyPostition", f"{REPORT}, equation 1"),
        profiles=ALL,
        needs=STICK,
    ),
    Clause(
        id="VB17",
        suite=SUITE,
        level="must",
        title="The joystick at its upper ends",
        text="In MANUAL with readings 65535 and 65535: S is -1, V is 1, A is 0.",
        sources=(f"{UTILS} fGetJoyPostition", TASK),
        profiles=ALL,
        needs=STICK,
        by_hand=True,
    ),
    Clause(
        id="VB18",
        suite=SUITE,
        level="must",
        title="The joystick at its lower ends",
        text="In MANUAL with readings 1057 and 1062: S is 1, V is 0, A is 1.",
        sources=(f"{UTILS} fGetJoyPostition", TASK),
        profiles=ALL,
        needs=STICK,
        by_hand=True,
    ),
    Clause(
        id="VB34",
        suite=SUITE,
        level="must",
        title="Beyond the calibration is beyond one",
        text="In MANUAL with readings 0 and 0: S and A are 1.0326 and 1.0327, a thirtieth too much.",
        sources=(f"{UTILS} fGetJoyPostition: no clamp",),
        profiles=SHIPPED,
        twin="VB34H",
        needs=STICK,
    ),
    Clause(
        id="VB34H",
        suite=SUITE,
        level="must",
        title="The joystick ends at one",
        text="In MANUAL with readings 0 and 0: S and A are 1.",
        sources=(CHOICE,),
        profiles=HARDENED,
        needs=STICK,
    ),
    Clause(
        id="VB46",
        suite=SUITE,
        level="must",
        title="The joystick between its ends",
        text=(
            "In MANUAL with readings at a quarter, a half and three quarters of the way to each end, and one step "
            "beyond the dead band, S, V and A are what the calibration says: at 34471 S is -1/31065."
        ),
        sources=(f"{UTILS} fGetJoyPostition", f"{REPORT}, equation 1"),
        profiles=ALL,
        needs=STICK,
    ),
    Clause(
        id="VB64",
        suite=SUITE,
        level="must",
        title="The next frame says where the joystick is",
        text=(
            "In MANUAL the joystick is moved 5 ms behind a frame, to its upper ends, its lower ends and to rest: the "
            "next frame of mode 4 says so in S, V and A."
        ),
        sources=(f"{TASK}: the joystick is read just before its frame is sent",),
        profiles=NOT_V1,
        needs=STICK,
    ),
)
