"""What a client must do, faced with a scripted server.

The sources grade no client; a clause is a must unless a client that real robots were driven with does otherwise, or the
clause is plainly advice: then it is a should, and the text says why.
"""

from __future__ import annotations

from protocols.p2os.clause import ARDUINO, ARIA, CHOICE, CONFIG_READER, FRAMING, MANUAL, PLAYER, SERIAL, THESIS, Clause

__all__ = ["CLIENT_CLAUSES"]

_SUITE = "p2os-client"

CLIENT_CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="C01",
        suite=_SUITE,
        level="must",
        title="Gives up on silence",
        text=(
            "Nothing answers: SYNC0 is repeated several times, then the client stops and reports the failure within a "
            "set time (ARIA: 6.4 s)."
        ),
        sources=(ARIA, PLAYER),
        needs=("client",),
    ),
    Clause(
        id="C02",
        suite=_SUITE,
        level="must",
        title="Walks the handshake in order",
        text="SYNC0, SYNC1, SYNC2, OPEN are sent in this order, each only after the answer to the one before.",
        sources=(MANUAL, THESIS),
        needs=("client",),
    ),
    Clause(
        id="C03",
        suite=_SUITE,
        level="must",
        title="Waits for a slow echo",
        text="An echo 800 ms late still leads to a session.",
        sources=(ARIA,),
        needs=("client",),
    ),
    Clause(
        id="C04",
        suite=_SUITE,
        level="must",
        title="Takes an echo in pieces",
        text="An echo in two pieces 50 ms apart still leads to a session.",
        sources=(SERIAL,),
        needs=("client",),
    ),
    Clause(
        id="C05",
        suite=_SUITE,
        level="must",
        title="Recovers from a stale echo",
        text="SYNC1 answered with an echo of SYNC0: the client restarts or repeats, and succeeds.",
        sources=(ARIA,),
        needs=("client",),
    ),
    Clause(
        id="C06",
        suite=_SUITE,
        level="must",
        title="Restarts on a SYNC error",
        text="A SYNC answered with type FF: the client restarts at SYNC0 and succeeds.",
        sources=(ARIA,),
        needs=("client",),
    ),
    Clause(
        id="C07",
        suite=_SUITE,
        level="must",
        title="Takes over an old session at rest",
        text="SIPs of type 32 instead of an echo: the client sends CLOSE, waits, sends SYNC0, and succeeds.",
        sources=(ARIA, PLAYER),
        needs=("client",),
    ),
    Clause(
        id="C08",
        suite=_SUITE,
        level="should",
        title="Takes over an old session in motion",
        text=(
            "SIPs of type 33 instead of an echo: the client sends CLOSE, waits, sends SYNC0, and succeeds. ARIA fails "
            "here, hence no more than advice."
        ),
        sources=(PLAYER, ARIA),
        needs=("client",),
    ),
    Clause(
        id="C09",
        suite=_SUITE,
        level="must",
        title="Refuses a damaged identification",
        text=(
            "An answer to SYNC2 with a wrong checksum is not accepted, nor is an echo; the SYNC is repeated or the "
            "handshake restarted."
        ),
        sources=(MANUAL,),
        needs=("client",),
    ),
    Clause(
        id="C10",
        suite=_SUITE,
        level="must",
        title="Survives an unknown robot",
        text="An unknown subclass is reported or replaced by a default, without a crash.",
        sources=(ARIA, PLAYER),
        needs=("client",),
    ),
    Clause(
        id="C11",
        suite=_SUITE,
        level="must",
        title="Survives a broken identification",
        text="An answer to SYNC2 without its NULs or strings is not read past its end; the failure is reported.",
        sources=(ARIA,),
        needs=("client",),
    ),
    Clause(
        id="C12",
        suite=_SUITE,
        level="must",
        title="Drops damaged SIPs",
        text=(
            "SIPs with a wrong checksum, or with one by another rule, are dropped silently, the good ones between them "
            "are kept."
        ),
        sources=(MANUAL,),
        needs=("client", "client.report"),
    ),
    Clause(
        id="C13",
        suite=_SUITE,
        level="should",
        title="Loses no more than the damaged packet",
        text=(
            "Garbage and stray FA between SIPs cost at most the packet they damage. ARIA loses one more behind FA FA "
            "FB, hence advice."
        ),
        sources=(PLAYER,),
        needs=("client", "client.report"),
    ),
    Clause(
        id="C14",
        suite=_SUITE,
        level="must",
        title="Ignores unknown packets",
        text="Packets of the types 61, C0 and 7E leave the session as it is.",
        sources=(ARIA,),
        needs=("client",),
    ),
    Clause(
        id="C15",
        suite=_SUITE,
        level="must",
        title="Reads SIPs of any length",
        text=(
            "A SIP with no reading, with 16 readings, or with the tail of late firmware is read up to the digital "
            "outputs, the rest ignored."
        ),
        sources=(ARIA, ARDUINO),
        needs=("client", "client.report"),
    ),
    Clause(
        id="C16",
        suite=_SUITE,
        level="must",
        title="Drops a truncated SIP",
        text="A SIP whose sonar count reaches past its end is dropped and not read past its end.",
        sources=(FRAMING,),
        needs=("client",),
    ),
    Clause(
        id="C17",
        suite=_SUITE,
        level="must",
        title="Does without CONFIG",
        text="No answer to CONFIG: the client goes on after a bounded time.",
        sources=(ARIA,),
        needs=("client",),
    ),
    Clause(
        id="C18",
        suite=_SUITE,
        level="must",
        title="Takes a short CONFIG",
        text="A CONFIG packet that ends after the watchdog field is used as far as it goes.",
        sources=(ARIA,),
        needs=("client", "client.report"),
    ),
    Clause(
        id="C19",
        suite=_SUITE,
        level="must",
        title="Notices a dead robot",
        text="No SIP for 10 s: the client declares the connection lost (ARIA: after 8 s).",
        sources=(ARIA,),
        needs=("client",),
    ),
    Clause(
        id="C20",
        suite=_SUITE,
        level="must",
        title="Notices a controller reset",
        text=(
            "Type FF in the session, and nothing more, is a reset of the controller: the client drops the session, "
            "and says so within 2 s."
        ),
        sources=(ARIA,),
        needs=("client",),
    ),
    Clause(
        id="C21",
        suite=_SUITE,
        level="must",
        title="The pose does not jump at a wrap",
        text="x from 32767 or 65535 to 0 and the heading from 2047 to -2048 are steps of one unit.",
        sources=(ARIA,),
        needs=("client", "client.report"),
    ),
    Clause(
        id="C22",
        suite=_SUITE,
        level="must",
        title="Keeps the session alive",
        text="While its user is silent the client sends some packet at least every 1 s; the robot allows 2 s.",
        sources=(MANUAL, THESIS),
        needs=("client",),
    ),
    Clause(
        id="C23",
        suite=_SUITE,
        level="must",
        title="Negative arguments are sign and magnitude",
        text="-200 goes out as 1B C8 00.",
        sources=(MANUAL, ARIA),
        needs=("client", "client.commands"),
    ),
    Clause(
        id="C24",
        suite=_SUITE,
        level="must",
        title="VEL2 is packed right",
        text=(
            "Right wheel in the low byte, left in the high byte, in units of 20 mm/s, rounded toward zero or to the "
            "nearest, within -127..127."
        ),
        sources=(ARIA, PLAYER),
        needs=("client", "client.commands"),
    ),
    Clause(
        id="C25",
        suite=_SUITE,
        level="must",
        title="Packets keep to their limits",
        text="No count exceeds 200, and a string has its length byte.",
        sources=(MANUAL,),
        needs=("client", "client.commands"),
    ),
    Clause(
        id="C26",
        suite=_SUITE,
        level="must",
        title="Takes leave",
        text=(
            "When its user disconnects the client sets the speed or the motors to 0, sends CLOSE, and then closes the "
            "port."
        ),
        sources=(ARIA, PLAYER),
        needs=("client", "client.disconnect"),
    ),
    Clause(
        id="C27",
        suite=_SUITE,
        level="should",
        title="Finds the rate of the line",
        text=(
            "Silence at the first rate, answers at 38400: the scan succeeds and sends no burst of CLOSE into the "
            "session. A client with a fixed rate is no worse for it, hence advice."
        ),
        sources=(ARIA, PLAYER),
        needs=("client", "baud"),
    ),
    Clause(
        id="C28",
        suite=_SUITE,
        level="must",
        title="Reads the packet of a real robot",
        text=(
            "A SIP captured from a Pioneer 2-DX: 14.4 V, no bumper pressed although all its bits are set, sonars 4 "
            "and 7 at 8576 mm."
        ),
        sources=(ARDUINO,),
        needs=("client", "client.report"),
    ),
    Clause(
        id="C29",
        suite=_SUITE,
        level="must",
        title="Reads a moving SIP",
        text=(
            "A SIP with all fields in use is read to its values: position, heading, wheel speeds, battery, stall, "
            "bumper, sonars, analog and digital inputs."
        ),
        sources=(ARIA, PLAYER),
        needs=("client", "client.report"),
    ),
    Clause(
        id="C30",
        suite=_SUITE,
        level="must",
        title="Tells the stalled wheel",
        text="Bit 0 of byte 15 is a stall of the left wheel, bit 0 of byte 16 of the right.",
        sources=(MANUAL, ARIA),
        needs=("client", "client.report"),
    ),
    Clause(
        id="C31",
        suite=_SUITE,
        level="must",
        title="Reads each figure of CONFIG",
        text="CONFIG with another number in each field up to TransKI, and twice more with others: each is understood.",
        sources=(ARIA, f"{CONFIG_READER}: the fields in their order"),
        needs=("client", "client.report", "client.commands"),
    ),
    Clause(
        id="C32",
        suite=_SUITE,
        level="must",
        title="Reads each SIP by itself",
        text="Two SIPs in turn that differ in each field, for a second: each is understood with its own figures.",
        sources=(MANUAL, ARIA),
        needs=("client", "client.report"),
    ),
    Clause(
        id="C33",
        suite=_SUITE,
        level="must",
        title="Each of many commands is its own",
        text=(
            "ENABLE 1, then VEL, RVEL, SETA, SETRA, HEAD and MOVE each with two arguments of either sign, CONFIG 1 "
            "and 2, ENABLE 0, two SAY and two VEL2, one after another: each goes out once, to the byte, within 0.35 s; "
            "VEL, RVEL and HEAD may be said again until the next one."
        ),
        sources=(MANUAL, ARIA, PLAYER, CHOICE + " how soon: three cycles of ARIA's"),
        needs=("client", "client.commands"),
    ),
)
