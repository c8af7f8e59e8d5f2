"""Lamps: the light of each mode, turn indicators and hazard lights."""

from __future__ import annotations

from protocols.carla.board_clauses._common import ALL, HARDENED, SUITE
from protocols.carla.clause import CHOICE, REPORT, TASK, Clause

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="VB43",
        suite=SUITE,
        level="must",
        title="Turn indicators and hazard lights",
        text=(
            "Turn indicators left, right, off, then hazard lights: the left lamp blinks, the right one, none, both, 60 "
            "to 120 times a minute; each status is reported to the driving stack. A command of NO_COMMAND "
            "changes nothing; hazard lights end on command."
        ),
        sources=(f"{REPORT}: lights and indicators are required", f"{CHOICE}: UN Regulation 6, 60 to 120 a minute"),
        profiles=HARDENED,
        needs=("board", "stack", "indicators"),
        by_hand=True,
    ),
    Clause(
        id="VB54",
        suite=SUITE,
        level="must",
        title="Each mode has its light",
        text="In AUTOWARE the amber light is lit, in MANUAL the green one, in EMERGENCY the red one, and no other.",
        sources=(TASK, REPORT),
        profiles=ALL,
        needs=("board", "stack", "lamps"),
        by_hand=True,
    ),
)
