"""MANUAL: how often its frames come, and what it does with statuses, or without."""

from __future__ import annotations

from protocols.carla.board_clauses._common import NOT_V1, STACK, SUITE, V1_ALONE
from protocols.carla.clause import HEADER, TASK, V0, Clause

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="VB19",
        suite=SUITE,
        level="must",
        title="MANUAL at 20 Hz",
        text=(
            "In MANUAL with statuses at 20 Hz, each with other figures, a frame of mode 4 goes out every 60 ms and no "
            "other, and each time the newest status is reported to the driving stack."
        ),
        sources=(f"{V0}, taksControle.c", f"{HEADER} MANUAL_CONTROL_TIME_COMMAND"),
        profiles=NOT_V1,
        needs=STACK,
    ),
    Clause(
        id="VB20",
        suite=SUITE,
        level="must",
        title="MANUAL at 10 Hz",
        text="In MANUAL with statuses at 10 Hz a frame of mode 4 goes out every 100 ms.",
        sources=(f"{V0}, taksControle.c",),
        profiles=NOT_V1,
        needs=STACK,
    ),
    Clause(
        id="VB21",
        suite=SUITE,
        level="must",
        title="The emergency in MANUAL",
        text=(
            "In MANUAL, the joystick at its upper ends if somebody holds it, statuses stop: ten more frames, 160 ms "
            "apart, then F3, 1.6 s after the first that no status followed, and F3 every 100 ms."
        ),
        sources=(f"{V0}, taksControle.c: each miss costs the wait and the pause",),
        profiles=NOT_V1,
        needs=STACK,
    ),
    Clause(
        id="VB22",
        suite=SUITE,
        level="must",
        title="The false emergency of V1",
        text=(
            "In MANUAL with statuses at 20 Hz a frame of mode 4 goes out every 160 ms, one F3 every 1.6 s, and the "
            "status reported to the driving stack does not change."
        ),
        sources=(f"{TASK}, MANUAL block: osEventFlagsWait with UART_NEW_DATA_FLAG, which is a thread flag",),
        profiles=V1_ALONE,
        twin="VB19",
        needs=STACK,
    ),
    Clause(
        id="VB45",
        suite=SUITE,
        level="must",
        title="Any status begins the count again in MANUAL",
        text=(
            "In MANUAL nine statuses missed, one status, nine missed, one status: the mode stays MANUAL. Behind an "
            "emergency, too: one status, nine missed."
        ),
        sources=(f"{V0}, taksControle.c",),
        profiles=NOT_V1,
        needs=STACK,
    ),
)
