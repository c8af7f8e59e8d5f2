"""What moves the robot, what stops it, and where it says that it is."""

from __future__ import annotations

from protocols.p2os.clause import (
    AMRISIM,
    ARIA,
    MANUAL,
    PLAYER,
    ROS,
    SERIAL,
    Clause,
)

__all__ = ["CLAUSES"]

_SUITE = "p2os-server"

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="S20",
        suite=_SUITE,
        level="must",
        title="No motion with motors off",
        text="VEL 200 with motors off leaves position and speeds at 0 and the type at 32.",
        sources=(MANUAL,),
        needs=("server",),
    ),
    Clause(
        id="S21",
        suite=_SUITE,
        level="must",
        title="ENABLE 1 turns the motors on",
        text="After ENABLE 1 flag bit 0 is set within two SIPs.",
        sources=(MANUAL, ARIA),
        needs=("server",),
    ),
    Clause(
        id="S22",
        suite=_SUITE,
        level="must",
        title="VEL drives forward",
        text=(
            "ENABLE 1 and VEL 200: type 33, both wheel speeds rise to 200 mm/s within 5 mm/s with the slope of SETA, "
            "the heading stays."
        ),
        sources=(MANUAL,),
        needs=("server",),
    ),
    Clause(
        id="S23",
        suite=_SUITE,
        level="must",
        title="A negative VEL drives backward",
        text=(
            "VEL -200 as sign and magnitude (1B C8 00): both wheels at -200 mm/s, x falls and wraps at 15 bits below 0."
        ),
        sources=(MANUAL, ARIA),
        needs=("server",),
    ),
    Clause(
        id="S24",
        suite=_SUITE,
        level="must",
        title="RVEL turns both ways",
        text="RVEL 30 raises the heading with the right wheel faster, RVEL -30 lowers it with the left wheel faster.",
        sources=(MANUAL,),
        needs=("server",),
    ),
    Clause(
        id="S25",
        suite=_SUITE,
        level="must",
        title="VEL and RVEL act together",
        text="VEL 100 and then RVEL 20: the mean wheel speed stays 100 mm/s while the robot turns.",
        sources=(MANUAL,),
        needs=("server",),
    ),
    Clause(
        id="S26",
        suite=_SUITE,
        level="must",
        title="VEL2 sets each wheel",
        text=(
            "VEL2 with the bytes 0A 05 (right 200, left 100 mm/s) gives these wheel speeds, and so does one behind it "
            "for -100 mm/s on both."
        ),
        sources=(ARIA, PLAYER),
        needs=("server",),
    ),
    Clause(
        id="S27",
        suite=_SUITE,
        level="must",
        title="VEL2 is read alike from both senders",
        text=(
            "VEL2 for -100 mm/s on both wheels gives the same motion as ARIA packs it (1B 05 04) and as Player does "
            "(3B FB FB)."
        ),
        sources=(ARIA, PLAYER),
        needs=("server",),
    ),
    Clause(
        id="S28",
        suite=_SUITE,
        level="must",
        title="HEAD turns to a heading",
        text="HEAD 90 from 0 settles at 1024 units within 12, then HEAD -90 at -1024.",
        sources=(MANUAL, ARIA),
        needs=("server",),
    ),
    Clause(
        id="S29",
        suite=_SUITE,
        level="should",
        title="DHEAD and DCHEAD turn by an angle",
        text="DHEAD -45 changes the heading by -512 units; DCHEAD 30 by 341 from the heading last asked for.",
        sources=(MANUAL,),
        needs=("server",),
    ),
    Clause(
        id="S30",
        suite=_SUITE,
        level="should",
        title="MOVE travels a distance",
        text="MOVE 1000 raises x by 1000 mm within 1 %, then the type is 32.",
        sources=(MANUAL, ARIA),
        needs=("server",),
    ),
    Clause(
        id="S31",
        suite=_SUITE,
        level="should",
        title="SETV limits MOVE",
        text="SETV 100 and MOVE 1000: no wheel is ever faster than 100 mm/s.",
        sources=(MANUAL,),
        needs=("server",),
    ),
    Clause(
        id="S32",
        suite=_SUITE,
        level="should",
        title="SETA sets the slope",
        text="With SETV 500, and SETA 1000 and -1000, VEL 500 is reached and left with that slope.",
        sources=(MANUAL,),
        needs=("server",),
    ),
    Clause(
        id="S33",
        suite=_SUITE,
        level="must",
        title="SETO makes here the origin",
        text=(
            "SETO without an argument, and with a type byte only as Player sends it (07 3B): x, y and heading are 0 "
            "in the next SIP."
        ),
        sources=(PLAYER, ROS, MANUAL),
        needs=("server",),
    ),
    Clause(
        id="S34",
        suite=_SUITE,
        level="must",
        title="STOP stops with the normal deceleration",
        text="STOP while moving: speeds fall with the slope of SETA, the motors stay enabled, the type becomes 32.",
        sources=(MANUAL,),
        needs=("server",),
    ),
    Clause(
        id="S35",
        suite=_SUITE,
        level="must",
        title="E_STOP stops at once",
        text="E_STOP while moving stops several times faster than STOP.",
        sources=(MANUAL, AMRISIM),
        needs=("server",),
    ),
    Clause(
        id="S36",
        suite=_SUITE,
        level="must",
        title="The watchdog stops the robot",
        text="VEL 200 and then silence: the robot stands after 2.0 s and the deceleration; the SIPs never pause.",
        sources=(MANUAL,),
        needs=("server",),
    ),
    Clause(
        id="S37",
        suite=_SUITE,
        level="must",
        title="The next packet revives",
        text="PULSE after the watchdog stop: the speed returns to 200 mm/s.",
        sources=(MANUAL,),
        needs=("server",),
    ),
    Clause(
        id="S38",
        suite=_SUITE,
        level="must",
        title="Any packet feeds the watchdog",
        text="VEL 200 and SONAR 1, no PULSE, every 1.9 s: the robot never stops.",
        sources=(MANUAL, ROS),
        needs=("server",),
    ),
    Clause(
        id="S52",
        suite=_SUITE,
        level="must",
        title="The position counter wraps cleanly",
        text="Over 40 m in a line x wraps at 32768 (or 65536) and no step between two SIPs exceeds 100 mm.",
        sources=(ARIA, PLAYER),
        needs=("server",),
    ),
    Clause(
        id="S53",
        suite=_SUITE,
        level="must",
        title="The heading wraps cleanly",
        text="Over five turns the heading stays within -2048..2047 and wraps.",
        sources=(MANUAL,),
        needs=("server",),
    ),
    Clause(
        id="S81",
        suite=_SUITE,
        level="must",
        title="ENABLE 0 turns the motors off",
        text="After ENABLE 1 and then ENABLE 0 flag bit 0 is clear within two SIPs.",
        sources=(MANUAL, ARIA),
        needs=("server",),
    ),
    Clause(
        id="S89",
        suite=_SUITE,
        level="must",
        title="A stop and a start at once count in their order",
        text=(
            "VEL, RVEL, VEL2, DHEAD or MOVE and STOP behind it without a gap: the robot stands. STOP and one of them "
            "behind it: it moves."
        ),
        sources=(MANUAL, SERIAL),
        needs=("server",),
    ),
    Clause(
        id="S90",
        suite=_SUITE,
        level="must",
        title="A robot that stands says so in every field",
        text=(
            "With the motors off, for a second: type 32, speeds 0, no stall bit; x, y, heading and setpoint stay "
            "within a unit, over their wraps, too."
        ),
        sources=(MANUAL,),
        needs=("server",),
    ),
    Clause(
        id="S91",
        suite=_SUITE,
        level="should",
        title="The SIP shows the heading that was asked for",
        text=(
            "SETO, HEAD, DHEAD from there, DCHEAD on that, each once to either side: bytes 17 and 18 are the angle "
            "that is turned to, within 2 units, or a whole turn off it, while the robot turns and behind that. DHEAD "
            "begins at the heading at which the robot rests. Always 0 is not judged."
        ),
        sources=(f"{MANUAL}: the server's angular position servo setpoint", f"{AMRISIM}: 0"),
        needs=("server",),
    ),
)
