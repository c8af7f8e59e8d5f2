"""The handshake, and sessions: how they begin, end, and follow each other."""

from __future__ import annotations

from protocols.p2os.clause import (
    AMRISIM,
    ARIA,
    MANUAL,
    PLAYER,
    ROS,
    Clause,
)

__all__ = ["CLAUSES"]

_SUITE = "p2os-server"

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="S01",
        suite=_SUITE,
        level="must",
        title="SYNC0 is echoed",
        text="Before a session, SYNC0 (FA FB 03 00 00 00) is answered with the same six bytes within 200 ms.",
        sources=(MANUAL, ARIA),
        needs=("server",),
    ),
    Clause(
        id="S02",
        suite=_SUITE,
        level="must",
        title="SYNC1 is echoed",
        text="After SYNC0, SYNC1 (FA FB 03 01 00 01) is answered with the same six bytes.",
        sources=(MANUAL,),
        needs=("server",),
    ),
    Clause(
        id="S03",
        suite=_SUITE,
        level="must",
        title="SYNC2 is answered with the identification",
        text=(
            "After SYNC1, SYNC2 (FA FB 03 02 00 02) is answered with a packet of type 02 that holds three "
            "NUL-terminated strings: the name, the class Pioneer, a known subclass; count and checksum are right."
        ),
        sources=(MANUAL, PLAYER),
        needs=("server",),
    ),
    Clause(
        id="S04",
        suite=_SUITE,
        level="must",
        title="Silent unless spoken to",
        text=(
            "Before the session, with nothing sent for 3 s, also after SYNC0 and after the identification, not one "
            "byte comes."
        ),
        sources=(MANUAL,),
        needs=("server",),
    ),
    Clause(
        id="S05",
        suite=_SUITE,
        level="must",
        title="OPEN without argument opens",
        text="After the identification, OPEN without an argument starts the SIPs within 200 ms.",
        sources=(MANUAL, PLAYER, ROS),
        needs=("server",),
    ),
    Clause(
        id="S06",
        suite=_SUITE,
        level="must",
        title="OPEN 1 opens",
        text="After the identification, OPEN with the integer 1, as ARIA sends it, starts the SIPs within 200 ms.",
        sources=(ARIA,),
        needs=("server",),
    ),
    Clause(
        id="S07",
        suite=_SUITE,
        level="must",
        title="No commands before the session",
        text=(
            "Before the handshake VEL 200 or OPEN has no answer and starts no SIP, nor VEL 200 between it and OPEN. "
            "The session that follows begins at rest, with the motors off."
        ),
        sources=(MANUAL,),
        needs=("server",),
    ),
    Clause(
        id="S12",
        suite=_SUITE,
        level="must",
        title="A repeated SYNC is answered again",
        text=(
            "Two SYNC0 have two echoes; a repeated SYNC1 or SYNC2 has its answer again, too, so that a client that "
            "missed one can go on."
        ),
        sources=(ARIA, PLAYER),
        needs=("server",),
    ),
    Clause(
        id="S13",
        suite=_SUITE,
        level="must",
        title="SYNC0 restarts the handshake",
        text="SYNC0, SYNC1, SYNC0: the third is echoed as SYNC0, and the handshake can be repeated.",
        sources=(ARIA,),
        needs=("server",),
    ),
    Clause(
        id="S14",
        suite=_SUITE,
        level="should",
        title="SYNCs out of order do not block",
        text=(
            "SYNC0 and then SYNC2 is answered with the identification, with type FF, or with the SYNC that was "
            "expected; a full handshake works afterwards."
        ),
        sources=(AMRISIM, ARIA),
        needs=("server",),
    ),
    Clause(
        id="S39",
        suite=_SUITE,
        level="must",
        title="PULSE is not echoed in session",
        text="FA FB 03 00 00 00 in session has no echo, and the session goes on.",
        sources=(MANUAL,),
        needs=("server",),
    ),
    Clause(
        id="S40",
        suite=_SUITE,
        level="must",
        title="CLOSE ends the session",
        text="CLOSE without an argument: no SIP after 200 ms, and SYNC0 is echoed again.",
        sources=(MANUAL,),
        needs=("server",),
    ),
    Clause(
        id="S41",
        suite=_SUITE,
        level="must",
        title="A new session starts stopped",
        text="CLOSE, with or without an argument, while moving, then a new session: motors off, type 32, no motion.",
        sources=(ARIA,),
        needs=("server",),
    ),
    Clause(
        id="S55",
        suite=_SUITE,
        level="must",
        title="A vanished client does not lock the robot",
        text="When the line is cut without CLOSE the robot stops, and a new handshake works.",
        sources=(AMRISIM,),
        needs=("server", "hangup"),
    ),
    Clause(
        id="S61",
        suite=_SUITE,
        level="must",
        title="Each session has its SIPs once",
        text="Three sessions, one after the other with CLOSE between them: no more SIPs in a second than in the first.",
        sources=(f"{MANUAL}: one SIP in each cycle",),
        needs=("server",),
    ),
    Clause(
        id="S62",
        suite=_SUITE,
        level="must",
        title="A client that comes back has its SIPs once",
        text=(
            "The port is closed without CLOSE and opened again, and a new session begins: no more SIPs in a second "
            "than in the first."
        ),
        sources=(f"{MANUAL}: one SIP in each cycle",),
        needs=("server", "reopen"),
    ),
)
