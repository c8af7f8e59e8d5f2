"""What the robot sends: SIPs, CONFIG, encoders, inputs and outputs, and what stands around it."""

from __future__ import annotations

from protocols.p2os.clause import (
    AMRISIM,
    ARIA,
    CHOICE,
    CONFIG_READER,
    H8,
    MANUAL,
    PLAYER,
    Clause,
)

__all__ = ["CLAUSES"]

_SUITE = "p2os-server"

CLAUSES: tuple[Clause, ...] = (
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
        text="POLLING with the bytes 1 and 5, then 3 and 7: only discs 0 and 4 are reported, then 2 and 6.",
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
            "IOREQUEST 2, DIGOUT and ADSEL 1 to 5: the SIP has the outputs and the port that were set; its outputs, "
            "inputs and analog value are among those of the IO packet, whose analog values have ten bits; these may be "
            "off by 2 of 256, but not each time to the same side. Behind one DIGOUT at least, each IO packet has the "
            "outputs of the SIP before it or behind it."
        ),
        sources=(
            ARIA,
            f"{MANUAL}: ADSEL selects the port that a SIP shows, and the SIP says which",
            CHOICE + " how old the outputs of an IO packet may be",
        ),
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
            "StallCount, JoyVel and JoyRVel that were written, and all else as it was."
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
    Clause(
        id="S94",
        suite=_SUITE,
        level="should",
        title="CONFIG has the rate of the line",
        text="HostBaud in CONFIG is the code of the line's rate: 9600, 19200, 38400, 57600 or 115200 bit/s, from 0 on.",
        sources=(H8, CONFIG_READER),
        needs=("server", "uart"),
    ),
)
