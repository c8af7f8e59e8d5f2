"""Turn indicators and hazard lights."""

from __future__ import annotations

from protocols.carla.board_clauses._common import HARDENED, SUITE
from protocols.carla.clause import CHOICE, REPORT, Clause

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="VB43",
        suite=SUITE,
        level="must",
        title="Turn indicators and hazard lights",
        text=(
            "Turn indicators left, right, off, then hazard lights: the left lamp blinks, the right one, none, both; "
            "with each status the driving stack is told so. A command of NO_COMMAND changes nothing."
        ),
        sources=(f"{REPORT}: lights and indicators are required", CHOICE),
        profiles=HARDENED,
        needs=("board", "stack", "indicators"),
    ),
)
