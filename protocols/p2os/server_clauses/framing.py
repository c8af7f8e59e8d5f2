"""What a packet is and what is none, and commands as such: unknown, at once, late, too early."""

from __future__ import annotations

from protocols.p2os.clause import (
    AMRISIM,
    ARIA,
    CHOICE,
    FRAMING,
    MANUAL,
    PLAYER,
    SERIAL,
    THESIS,
    Clause,
)

__all__ = ["CLAUSES"]

_SUITE = "p2os-server"

CLAUSES: tuple[Clause, ...] = (
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
)
