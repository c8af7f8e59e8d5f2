"""What a robot must do: stimulus and required response.

Hexadecimal bytes without further words stand as on the wire.
"""

from __future__ import annotations

from protocols.p2os.clause import (
    AMRISIM,
    ARIA,
    CHOICE,
    CONFIG_READER,
    FRAMING,
    H8,
    MANUAL,
    PLAYER,
    ROS,
    SERIAL,
    THESIS,
    Clause,
)

__all__ = ["SERVER_CLAUSES"]

_SUITE = "p2os-server"

SERVER_CLAUSES: tuple[Clause, ...] = (
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
        id="S08",
        suite=_SUITE,
        level="must",
        title="The modem preamble is skipped",
        text=(
            "WMS2 and a carriage return (57 4D 53 32 0D), which ARIA sends first on a serial line, do not keep the "
            "SYNC0 behind them from being echoed."
        ),
        sources=(ARIA,),
        needs=("server",),
    ),
    Clause(
        id="S09",
        suite=_SUITE,
        level="must",
        title="A SYNC0 with a wrong checksum is not answered",
        text="SYNC0 with its last byte 01 has no answer; the next good SYNC0 is echoed.",
        sources=(MANUAL, AMRISIM),
        needs=("server",),
    ),
    Clause(
        id="S10",
        suite=_SUITE,
        level="should",
        title="A stray FA before a header does no harm",
        text="FA FA FB 03 00 00 00 is taken for SYNC0.",
        sources=(PLAYER,),
        needs=("server",),
    ),
    Clause(
        id="S11",
        suite=_SUITE,
        level="must",
        title="Single bytes make a packet",
        text="SYNC0 sent byte by byte, 20 ms apart, is echoed.",
        sources=(SERIAL,),
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
        id="S15",
        suite=_SUITE,
        level="must",
        title="Counts below three are ignored",
        text="A header with a count of 2, 1 or 0 is ignored; the good packet behind it works.",
        sources=(FRAMING,),
        needs=("server",),
    ),
    Clause(
        id="S16",
        suite=_SUITE,
        level="must",
        title="An overlong packet is ignored",
        text="A packet with a count of 250 and its 250 bytes is ignored; the SYNC0 behind it is answered.",
        sources=(MANUAL, THESIS),
        needs=("server",),
    ),
    Clause(
        id="S17",
        suite=_SUITE,
        level="should",
        title="The longest packet does not desynchronise",
        text=(
            "A SAY string of 195 bytes 01 (count exactly 200) is swallowed whole; the CONFIG request behind it is "
            "answered."
        ),
        sources=(MANUAL, THESIS),
        needs=("server",),
    ),
    Clause(
        id="S18",
        suite=_SUITE,
        level="must",
        title="SIPs come every cycle",
        text=(
            "In session, over 10 s, SIPs come every 100 ms (or 50 ms), each within 10 ms of its time, type 32 for a "
            "robot that stands, with right checksums and a count of 27 and 3 for each sonar reading."
        ),
        sources=(MANUAL, AMRISIM),
        needs=("server",),
    ),
    Clause(
        id="S19",
        suite=_SUITE,
        level="must",
        title="A session begins with motors off and sonar on",
        text="The first SIP has flag bit 0 (motors) clear and bit 1 (sonar) set.",
        sources=(MANUAL,),
        needs=("server",),
    ),
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
        id="S42",
        suite=_SUITE,
        level="should",
        title="CONFIG is answered",
        text=(
            "CONFIG with the integer 1 and without argument: one packet of type 20 each, readable to the last P2OS "
            "field."
        ),
        sources=(MANUAL, ARIA),
        needs=("server",),
    ),
    Clause(
        id="S43",
        suite=_SUITE,
        level="should",
        title="ENCODER sends one, a stream, none",
        text="ENCODER 1 brings one packet of type 90, 2 a stream, 0 ends it.",
        sources=(MANUAL, ARIA),
        needs=("server",),
    ),
    Clause(
        id="S44",
        suite=_SUITE,
        level="should",
        title="IOREQUEST sends one, a stream, none",
        text="IOREQUEST 1 brings one packet of type F0, 2 a stream, 0 ends it.",
        sources=(ARIA,),
        needs=("server",),
    ),
    Clause(
        id="S45",
        suite=_SUITE,
        level="must",
        title="SONAR switches the sonar",
        text="SONAR 0 clears flag bit 1 and ends the readings; SONAR 1 brings both back.",
        sources=(MANUAL, PLAYER),
        needs=("server",),
    ),
    Clause(
        id="S46",
        suite=_SUITE,
        level="should",
        title="POLLING picks the discs",
        text="POLLING with the bytes 1 and 5: only discs 0 and 4 are reported.",
        sources=(MANUAL,),
        needs=("server",),
    ),
    Clause(
        id="S47",
        suite=_SUITE,
        level="should",
        title="DIGOUT sets the outputs",
        text="DIGOUT with mask FF and value 0F, packed as ARIA does (1B F1 00), shows as 0F in the SIP.",
        sources=(ARIA,),
        needs=("server",),
    ),
    Clause(
        id="S48",
        suite=_SUITE,
        level="must",
        title="Unknown commands do no harm",
        text="BATTERYINFO 1 and 0 and the commands 200, 63 and 64 leave the session as it is.",
        sources=(ARIA,),
        needs=("server",),
    ),
    Clause(
        id="S49",
        suite=_SUITE,
        level="must",
        title="A command with a wrong checksum is not obeyed",
        text="VEL 100 with a wrong checksum does not move the robot.",
        sources=(MANUAL,),
        needs=("server",),
    ),
    Clause(
        id="S50",
        suite=_SUITE,
        level="must",
        title="A burst is obeyed in order",
        text="Ten commands in one write are all obeyed, in their order.",
        sources=(ARIA,),
        needs=("server",),
    ),
    Clause(
        id="S51",
        suite=_SUITE,
        level="must",
        title="Strings with and without NUL",
        text="SAY is accepted with ARIA's uncounted NUL behind the string and without it.",
        sources=(MANUAL, ARIA),
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
        id="S54",
        suite=_SUITE,
        level="must",
        title="Sonar readings are numbered from 0 and scaled",
        text=(
            "Before a wall the readings carry disc numbers from 0, ranges of the distance divided by the range unit "
            "within 1, at most 16 in a SIP."
        ),
        sources=(ARIA,),
        needs=("server", "scene", "rays"),
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
        id="S56",
        suite=_SUITE,
        level="should",
        title="BUMPSTALL stops at a contact",
        text="BUMPSTALL 3 and a bumper contact: the wheels stand and the stall bits are set.",
        sources=(MANUAL,),
        needs=("server", "scene", "bumpers"),
    ),
    Clause(
        id="S57",
        suite=_SUITE,
        level="should",
        title="HOSTBAUD falls back",
        text="HOSTBAUD 2 and then silence for more than 500 ms: the old rate is back.",
        sources=(H8,),
        needs=("server", "baud"),
    ),
    Clause(
        id="S58",
        suite=_SUITE,
        level="should",
        title="AUX data come back on request",
        text=(
            "TTY2 AT with the AUX port looped back and GETAUX 2: one packet B0 with 41 54 when both bytes are in; then "
            "others with two other bytes."
        ),
        sources=(MANUAL, PLAYER),
        needs=("server", "aux-loopback"),
    ),
    Clause(
        id="S59",
        suite=_SUITE,
        level="must",
        title="Each bit of a checksum counts",
        text=(
            "ENABLE 1 with one bit of its body or checksum turned, with another value in one byte of the checksum, or "
            "with a checksum by another rule, leaves flag bit 0 clear; CONFIG 1 with a wrong byte has no answer. "
            "ENABLE 1 as it should be is obeyed then."
        ),
        sources=(MANUAL, FRAMING),
        needs=("server",),
    ),
    Clause(
        id="S60",
        suite=_SUITE,
        level="should",
        title="No byte is special inside a packet",
        text=(
            "DIGOUT with XON or XOFF (11, 13), a byte of a header (FA, FB, and both), an argument's type or any other "
            "value as its mask, its value or a byte of its checksum: the outputs are as it says."
        ),
        sources=(f"{FRAMING}: no byte is escaped, no flow control", f"{PLAYER}: two bytes as they are"),
        needs=("server",),
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
    Clause(
        id="S63",
        suite=_SUITE,
        level="should",
        title="Bytes behind an argument are ignored",
        text=(
            "ENABLE and SONAR with 1 and with 0, each with any number of bytes behind the argument up to a count of "
            "200: the flag follows the argument within two SIPs."
        ),
        sources=(f"{AMRISIM} handleCommand: reads the argument and does not look how many bytes there are",),
        needs=("server",),
    ),
    Clause(
        id="S64",
        suite=_SUITE,
        level="must",
        title="Two commands at once are obeyed in their order",
        text=(
            "Two of ENABLE 1 and 0, SONAR 1 and 0, DIGOUT 0F and F0 with mask FF and CONFIG without a gap, in each "
            "order, and each twice: flags and outputs are what the later one of each kind says, and CONFIG is answered."
        ),
        sources=(ARIA, SERIAL),
        needs=("server",),
    ),
    Clause(
        id="S65",
        suite=_SUITE,
        level="must",
        title="A late command is obeyed, and a late stop revives nothing",
        text=(
            "ENABLE, SONAR, DIGOUT and CONFIG, each as the first packet behind 2.3 s of silence, are obeyed and "
            "answered as ever. Behind VEL 200 and 3.2 s of silence STOP, VEL 0, E_STOP or ENABLE 0 leaves the robot "
            "standing."
        ),
        sources=(MANUAL, f"{CHOICE} that the packet which revives a robot counts before it moves"),
        needs=("server",),
    ),
    Clause(
        id="S66",
        suite=_SUITE,
        level="must",
        title="No command is taken too early",
        text=(
            "A command of motors, sonar, outputs, motion or packets, before the handshake or between the "
            "identification and OPEN, has no answer. The session that follows begins at rest, motors off, sonar on, "
            "outputs as they were."
        ),
        sources=(MANUAL,),
        needs=("server",),
    ),
    Clause(
        id="S80",
        suite=_SUITE,
        level="must",
        title="The battery is one that a robot can have",
        text=(
            "The robot stands, motors off, for 2 s: byte 14 of each SIP, in tenths of a volt, is from 9 to 16 V (of a "
            "PowerBot, which has 24 V: not 0), and two SIPs in a row differ by 1 V at most. One that never changes "
            "is right."
        ),
        sources=(
            f"{MANUAL}: the battery in tenths of a volt",
            f"{H8}: servers shut down below about 11 V, a charger goes up to 14.7 V",
            CHOICE + " how far beyond these, and how far from SIP to SIP",
        ),
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
        id="S82",
        suite=_SUITE,
        level="should",
        title="CONFIG shows what a client has set",
        text=(
            "SETV, SETRV, SETA and SETRA of both signs, and the gains 82 to 87, all at once and then one after the "
            "other: the next CONFIG has what was set, to the unit, and all else as it was."
        ),
        sources=(
            f"{H8}: CONFIG has the working values, as changed by client commands such as SETV and ROTKV",
            f"{MANUAL}: the gains from 1.J on",
        ),
        needs=("server",),
    ),
    Clause(
        id="S83",
        suite=_SUITE,
        level="should",
        title="Nothing is set above its top",
        text=(
            "SETV, SETRV, SETA and SETRA of both signs with 32767: CONFIG has RotVelTop, TransVelTop, RotAccTop and "
            "TransAccTop as they were, and what was set is equal to its top."
        ),
        sources=(f"{CONFIG_READER}: the absolute maximum, above which nothing can be set through software", H8),
        needs=("server",),
    ),
    Clause(
        id="S84",
        suite=_SUITE,
        level="should",
        title="What a client has set goes with it",
        text=(
            "SETV, SETRV, SETA, SETRA and the gains, then CLOSE and a new session: CONFIG is that of the first session "
            "before them."
        ),
        sources=(f"{H8}: limits and gains go back to the stored ones when the client leaves",),
        needs=("server",),
    ),
    Clause(
        id="S85",
        suite=_SUITE,
        level="should",
        title="CONFIG agrees with the robot",
        text=(
            "Type, subtype and name in CONFIG are those of the identification; SIPcycle is the mean time between SIPs "
            "within 0.5 ms; FrontSonar and RearSonar are 1 where readings of discs 0 to 7, or 8 to 15, come, else 0."
        ),
        sources=(
            f"{CONFIG_READER}: the cycle time in ms, whether the robot has front sonar and rear sonar",
            CHOICE + " how near the cycle is",
        ),
        needs=("server",),
    ),
    Clause(
        id="S86",
        suite=_SUITE,
        level="should",
        title="CONFIG has figures that a robot can have",
        text=(
            "In CONFIG flags are 0 or 1, and 4Mots is 1 on an AT alone; rates are codes from 0 to 4; LowBattery is a "
            "voltage of a battery (S80); Watchdog is from 1900 to 2000 ms (S36, S38), StallCount at most 10 s; PWMMax "
            "at most 500; nothing is above its top, nor StallVal above PWMMax; tops, PWMMax, StallVal and RevCount "
            "are not 0."
        ),
        sources=(
            f"{H8}, CONFIG: rates 0 to 4, PWM 500 is fully on, 4Mots is 1 if AT",
            f"{CONFIG_READER}: flags; tops; the stall value cannot be above the maximum PWM",
            CHOICE + " how long a stalled robot may rest",
        ),
        needs=("server",),
    ),
    Clause(
        id="S87",
        suite=_SUITE,
        level="should",
        title="The encoders follow the wheels",
        text=(
            "ENCODER 2, then VEL 200 and STOP: both counts rise alike within 20 %, and each packet is in step with the "
            "x of the SIP before it within 60 ms. RVEL 60: the left count falls as the right one rises, within 20 %."
        ),
        sources=(
            f"{ARIA}: the ticks of the left and of the right wheel, as they have added up",
            CHOICE + " how alike, and how far in step",
        ),
        needs=("server",),
    ),
    Clause(
        id="S88",
        suite=_SUITE,
        level="should",
        title="Inputs and outputs agree in SIP and IO packet",
        text=(
            "DIGOUT, ADSEL 1 to 5 and IOREQUEST 1: the SIP has the outputs and the port that were set; its outputs, "
            "inputs and analog value are among those of the IO packet, whose analog values have ten bits; these may be "
            "off by 2 of 256, but not each time to the same side."
        ),
        sources=(ARIA, f"{MANUAL}: ADSEL selects the port that a SIP shows, and the SIP says which"),
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
    Clause(
        id="S92",
        suite=_SUITE,
        level="should",
        title="CONFIG shows what is in FLASH",
        text=(
            "Figures are written into FLASH and the robot is switched on again, twice: CONFIG has the tops, PWMMax, "
            "SIPcycle, Aux1Baud, Gripper, FrontSonar, RearSonar, LowBattery, RevCount, WatchDog, P2MPACS, StallVal, "
            "StallCount, JoyVel and JoyRVel that were written, and all else as it was. HostBaud is the code of the "
            "line's rate."
        ),
        sources=(f"{H8}: CONFIG has the values that are in FLASH", CONFIG_READER),
        needs=("server", "flash"),
    ),
    Clause(
        id="S93",
        suite=_SUITE,
        level="must",
        title="Inputs are those of the connector",
        text=(
            "Levels and voltages at the inputs of the user I/O connector are changed, and ADSEL with them: the next "
            "SIP has the byte of the levels and the voltage of that port, 0 to 255 for 5 V; the next IO packet the "
            "byte, and the voltages of all ports with ten bits."
        ),
        sources=(f"{MANUAL}: DIGIN, ANALOG and ADSEL", ARIA),
        needs=("server", "user-io"),
    ),
)
