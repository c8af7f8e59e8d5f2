"""The stand-in link to the driving stack: messages that are damaged, and an agent that falls silent."""

from __future__ import annotations

from protocols.carla.board_clauses._common import ALL, HARDENED, SHIPPED, STACK, STICK, SUITE
from protocols.carla.clause import CHOICE, MICRO_ROS, Clause

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="VB50",
        suite=SUITE,
        level="must",
        title="Damaged messages of the stand-in link are none",
        text=(
            "On the stand-in link, a request for MANUAL with one bit turned over, each bit of its payload and CRC in "
            "turn, is not answered, and changes nothing; a command likewise is not handed on."
        ),
        sources=(f"{CHOICE}; the frame is that of the Micro XRCE-DDS serial transport, whose CRC is over the payload",),
        profiles=ALL,
        needs=STACK,
    ),
    Clause(
        id="VB55",
        suite=SUITE,
        level="must",
        title="Nobody misses a silent driving stack",
        text="In MANUAL the driving stack says nothing for 6 s: a press lights the amber lamp all the same.",
        sources=(f"{MICRO_ROS}: the agent is pinged at boot alone",),
        profiles=SHIPPED,
        twin="VB55H",
        needs=(*STICK, "lamps"),
    ),
    Clause(
        id="VB55H",
        suite=SUITE,
        level="must",
        title="A silent driving stack is lost",
        text=(
            "In MANUAL the driving stack says nothing for 2.8 s: a press leads to AUTOWARE. After 3.2 s it does not, "
            "and the mode is not reported. It says that it is there: a press leads to AUTOWARE again."
        ),
        sources=(f"{CHOICE}: 3 s",),
        profiles=HARDENED,
        needs=(*STICK, "lamps"),
    ),
)
