"""Families of stimuli: every byte within a float, every letter damaged, every mode that is none of the board's."""

from __future__ import annotations

from protocols.carla.board_clauses._common import ALL, HARDENED, STACK, SUITE
from protocols.carla.clause import CALLBACKS, CHOICE, ISR, LINE, TASK, Clause

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="VB59",
        suite=SUITE,
        level="must",
        title="No byte is special within a float",
        text=(
            "In AUTOWARE statuses with XON or XOFF (11, 13), a letter or delimiter of frames, or a control character "
            "at each place of each float are accepted: all their figures are reported."
        ),
        sources=(f"{ISR}: data bytes are not looked at",),
        profiles=ALL,
        needs=STACK,
    ),
    Clause(
        id="VB60",
        suite=SUITE,
        level="must",
        title="Each bit of a letter counts",
        text=(
            "A status with one bit of #, A, B, C, D or $ turned, each of the 48, or with another byte in its place, "
            "50 ms before a sound one: it is not reported, the sound one is, the mode stays AUTOWARE."
        ),
        sources=(CHOICE,),
        profiles=HARDENED,
        needs=STACK,
    ),
    Clause(
        id="VB61",
        suite=SUITE,
        level="must",
        title="No other mode is granted",
        text="In AUTOWARE requests for modes other than 1 and 4 are answered with success false; the mode stays.",
        sources=(CALLBACKS,),
        profiles=ALL,
        needs=STACK,
    ),
    Clause(
        id="VB62",
        suite=SUITE,
        level="must",
        title="A late status is one, and nothing else ends an emergency",
        text=(
            "In AUTOWARE a status that comes 50 to 700 ms behind the last one is reported, and the mode stays. In "
            "EMERGENCY a command, the clock, indicators, hazard lights, a sign of the agent, a part of a status, one "
            "with a NaN or 22 hashes change nothing: F3 goes on. A status leads to MANUAL then."
        ),
        sources=(f"{TASK}: MAX_OF_LOST_MESSAGES, and the branches of EMERGENCY", CHOICE),
        profiles=HARDENED,
        needs=STACK,
    ),
    Clause(
        id="VB63",
        suite=SUITE,
        level="must",
        title="Of two at once the later one counts",
        text=(
            "In AUTOWARE two statuses without a gap, or two commands, in each order and each twice: what is reported, "
            "or handed on, last is the later of them; one with a NaN counts for nothing, wherever it stands."
        ),
        sources=(LINE, CHOICE),
        profiles=HARDENED,
        needs=STACK,
    ),
)
