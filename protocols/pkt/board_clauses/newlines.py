"""Frames that end at a newline."""

from __future__ import annotations

from protocols.pkt.board_clauses._common import SUITE, TERM
from protocols.pkt.clause import DIAGRAM, DOCUMENT, Clause

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="P31",
        suite=SUITE,
        level="must",
        title="A newline in the payload ends the frame",
        text="0x03 with both speeds 10, 50 4B 54 21 03 00 0A 00 0A 03 77 F3 0A: 0/1/0/3, no motion, the rest ignored.",
        sources=(DIAGRAM, f"{DOCUMENT}, nominal sequence, step 5"),
        profiles=TERM,
        needs=("server",),
    ),
    Clause(
        id="P32",
        suite=SUITE,
        level="must",
        title="A newline in the CRC ends the frame",
        text=(
            "0x03 with both speeds 59, 50 4B 54 21 03 00 3B 00 3B 03 1B 0A 0A: 0/1/0/3; a receiver that reads on "
            "behind a wrong CRC executes it instead: 1/0/3/0."
        ),
        sources=(DIAGRAM, f"{DOCUMENT}, nominal sequence, step 5"),
        profiles=TERM,
        needs=("server",),
    ),
    Clause(
        id="P33",
        suite=SUITE,
        level="must",
        title="64 bytes are a payload",
        text="A payload of 01 and 63 zeros, CRC right: 1/0/1/0.",
        sources=(f"{DOCUMENT}: at most 64 bytes of payload", "its diagram counts the CRC too; the text is followed"),
        profiles=TERM,
        needs=("server",),
    ),
    Clause(
        id="P34",
        suite=SUITE,
        level="must",
        title="The limit ends a frame, once",
        text="50 4B 54 21 and 70 times 78 without a newline: 0/1/0/2; LED_ON behind it: 1/1/1/0.",
        sources=(DIAGRAM, f"{DOCUMENT}, chapter on errors"),
        profiles=TERM,
        needs=("server",),
    ),
    Clause(
        id="P35",
        suite=SUITE,
        level="must",
        title="A frame without room for a CRC has a wrong one",
        text="50 4B 54 21 0A: 0/1/0/3.",
        sources=(f"{DOCUMENT}, nominal sequence, step 6",),
        profiles=TERM,
        needs=("server",),
    ),
)
