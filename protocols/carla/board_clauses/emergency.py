"""EMERGENCY: what leads there, what is sent meanwhile, and what ends it."""

from __future__ import annotations

from protocols.carla.board_clauses._common import ALL, HARDENED, SHIPPED, STACK, STICK, SUITE, V0_ALONE
from protocols.carla.clause import CALLBACKS, CHOICE, HEADER, REPORT, TASK, Clause

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="VB07",
        suite=SUITE,
        level="must",
        title="Ten statuses missed are an emergency",
        text=(
            "Statuses stop, commands go on: ten more frames of mode 1, 100 ms apart, then F3, 1.0 s after the first of "
            "them, and F3 every 100 ms."
        ),
        sources=(f"{TASK}, {HEADER} TIMEOUT_GET_CARLA_RX, MAX_OF_LOST_MESSAGES",),
        profiles=ALL,
        needs=STACK,
    ),
    Clause(
        id="VB08",
        suite=SUITE,
        level="must",
        title="A status ends the emergency in MANUAL",
        text=(
            "In EMERGENCY, with the joystick at 33970 and 1062, one status comes: the next frame has mode 4, V 0 and "
            "A 1, the control-mode report says 4, the green lamp is lit; never AUTOWARE at once."
        ),
        sources=(TASK,),
        profiles=ALL,
        needs=(*STICK, "lamps"),
        by_hand=True,
    ),
    Clause(
        id="VB09",
        suite=SUITE,
        level="must",
        title="From there a press leads back",
        text="After an emergency, in MANUAL, a press of the joystick leads to AUTOWARE: frames of mode 1.",
        sources=(TASK,),
        profiles=ALL,
        needs=STICK,
        by_hand=True,
    ),
    Clause(
        id="VB10",
        suite=SUITE,
        level="must",
        title="A press in EMERGENCY does nothing",
        text="A press in EMERGENCY: F3 goes on; the press is not remembered: a status leads to MANUAL and it stays so.",
        sources=(f"{TASK}: the flag is taken, no branch is for EMERGENCY",),
        profiles=ALL,
        needs=STICK,
        by_hand=True,
    ),
    Clause(
        id="VB11",
        suite=SUITE,
        level="must",
        title="The driving stack can order AUTOWARE in EMERGENCY",
        text=(
            "In EMERGENCY, without statuses, AUTOWARE is asked for: granted, frames of mode 1 for at least 1 s, "
            "then F3."
        ),
        sources=(f"{TASK}, {CALLBACKS}; not in the diagram of {REPORT}",),
        profiles=SHIPPED,
        twin="VB11H",
        needs=STACK,
    ),
    Clause(
        id="VB11H",
        suite=SUITE,
        level="must",
        title="Nobody orders anything in EMERGENCY",
        text=(
            "In EMERGENCY AUTOWARE is asked for, and MANUAL: both are refused, F3 goes on; nor is it remembered: a "
            "status leads to MANUAL and it stays so."
        ),
        sources=(f"{REPORT}, diagram of the modes: EMERGENCY ends by a status alone", CHOICE),
        profiles=HARDENED,
        needs=STACK,
    ),
    Clause(
        id="VB33",
        suite=SUITE,
        level="must",
        title="Without commands nobody watches the simulator",
        text=(
            "Commands and statuses stop at once, in AUTOWARE: the last frame again for 1.1 s, MANUAL, and F3 "
            "some 2.7 s after both stopped."
        ),
        sources=(f"{TASK}: the status is waited for behind a command only",),
        profiles=V0_ALONE,
        twin="VB33H",
        needs=STACK,
    ),
    Clause(
        id="VB33H",
        suite=SUITE,
        level="must",
        title="The simulator is watched without commands, too",
        text="Commands and statuses stop at once, in AUTOWARE: F3 within 1.3 s after both stopped.",
        sources=(CHOICE,),
        profiles=HARDENED,
        needs=STACK,
    ),
)
