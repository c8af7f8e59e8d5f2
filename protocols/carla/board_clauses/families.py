"""Families of stimuli: every byte within a float, every letter damaged, every mode that is none of the board's."""

from __future__ import annotations

from protocols.carla.board_clauses._common import ALL, HARDENED, STACK, SUITE
from protocols.carla.clause import CALLBACKS, CHOICE, ISR, Clause

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
)
