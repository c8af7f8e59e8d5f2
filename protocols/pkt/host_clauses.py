"""What a host must do, faced with a scripted rover."""

from __future__ import annotations

from protocols.pkt.clause import CHOICE, CLIENT, DECODER, DOCUMENT, G2_CONFIG, MANUAL, SERIAL, Clause

__all__ = ["HOST_CLAUSES"]

_SUITE = "pkt-host"
_SPLITTING = ("g0", "g2")

HOST_CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="P36",
        suite=_SUITE,
        level="must",
        title="A client that splits lines loses reports",
        text=(
            "Of 0x82 with random floats, a client that ends its frames at newlines shows a share of (255/256)^58, "
            "79.7 %: one in five is lost."
        ),
        sources=(f"{CLIENT} run: pyserial's readline",),
        profiles=_SPLITTING,
        twin="P36D",
        needs=("client", "client.report"),
    ),
    Clause(
        id="P36D",
        suite=_SUITE,
        level="must",
        title="No report is lost",
        text="Of 0x82 with random floats behind a length byte, all are understood, newlines or not.",
        sources=(f"{CLIENT} get_packet_payload: the length is there to be used", SERIAL),
        profiles=("documented",),
        needs=("client", "client.report"),
    ),
    Clause(
        id="P37",
        suite=_SUITE,
        level="must",
        title="A client that splits lines never shows a ten",
        text="0x80 with ACC 10 is never shown.",
        sources=(f"{CLIENT} run: pyserial's readline",),
        profiles=_SPLITTING,
        twin="P37D",
        needs=("client", "client.report"),
    ),
    Clause(
        id="P37D",
        suite=_SUITE,
        level="must",
        title="A ten is shown",
        text="0x80 with ACC from 0 to 255 is shown with each of them.",
        sources=(f"{DOCUMENT}, 0x80", f"{CLIENT} get_packet_payload: the length is there to be used"),
        profiles=("documented",),
        needs=("client", "client.report"),
    ),
    Clause(
        id="P50",
        suite=_SUITE,
        level="must",
        title="A host speaks in frames",
        text=(
            "All that a host sends in five seconds is sound frames with opcodes and parameters that the rover has: "
            "0x03 and 0x04 have 9 bytes, 0x05 has 12, numbers are finite and have their lowest byte first, throttles "
            "are from -1 to 1."
        ),
        sources=(
            f"{DOCUMENT}, frames and commands",
            f"{MANUAL}, frames and commands",
            CHOICE + ": motor commands all below a thousandth, and not if read with the highest byte first, are wrong",
        ),
        profiles=("documented",),
        needs=("client",),
    ),
    Clause(
        id="P51",
        suite=_SUITE,
        level="must",
        title="A host is heard in time",
        text=(
            "A host that is connected sends a sound frame at least once a second, so that the rover does not stop its "
            "motors."
        ),
        sources=(
            f"{G2_CONFIG} HEARTBEAT_TIMEOUT_IN_MS",
            f"{DECODER} check_timeouts",
        ),
        profiles=("documented",),
        needs=("client",),
    ),
    Clause(
        id="P52",
        suite=_SUITE,
        level="should",
        title="A host that leaves stops the motors",
        text=("A host that takes its leave commands both motors to 0, and is silent from then on."),
        sources=(CHOICE + ": the rover goes on for a second otherwise, or for ever",),
        profiles=("documented",),
        needs=(
            "client",
            "client.disconnect",
        ),
    ),
    Clause(
        id="P53",
        suite=_SUITE,
        level="must",
        title="Commands are as the manual has them",
        text=(
            "LED_ON, LED_OFF, 0x03 with 0.5 and -0.25, 0x04 with 30 and 30, 0x05 with 0.01, 0.0001, 0.0001 are "
            "50 4B 54 21 01 01 F1 D1 0A, 50 4B 54 21 01 02 C1 B2 0A, "
            "50 4B 54 21 0A 03 00 00 00 3F 00 00 80 BE 03 8C 42 0A, "
            "50 4B 54 21 0A 04 00 00 F0 41 00 00 F0 41 03 A1 E8 0A and "
            "50 4B 54 21 0D 05 0A D7 23 3C 17 B7 D1 38 17 B7 D1 38 53 4C 0A; likewise 0x03, 0x04 and 0x05 with other "
            "numbers and flags behind these, each once; 0x03 and 0x04 may be said again."
        ),
        sources=(f"{MANUAL}, reference of the protocol",),
        profiles=("documented", "g2"),
        needs=(
            "client",
            "client.commands",
        ),
    ),
    Clause(
        id="P54",
        suite=_SUITE,
        level="must",
        title="A report with a wrong CRC is shown",
        text=("0x80 with its CRC turned is shown like any other."),
        sources=(f"{CLIENT} get_packet_payload: the CRC is never looked at",),
        profiles=_SPLITTING,
        twin="P54D",
        needs=(
            "client",
            "client.report",
        ),
    ),
    Clause(
        id="P54D",
        suite=_SUITE,
        level="must",
        title="A report with a wrong CRC is not shown",
        text="0x80 with a bit of its CRC turned, or with a CRC by another rule, is not shown; the one behind it is.",
        sources=(f"{DOCUMENT}, nominal sequence, step 6",),
        profiles=("documented",),
        needs=(
            "client",
            "client.report",
        ),
    ),
    Clause(
        id="P55",
        suite=_SUITE,
        level="must",
        title="Noise costs the report behind it",
        text=("0x80 behind 61 62 63 is not shown."),
        sources=(f"{CLIENT} get_packet_payload: a line begins with the sync word or is none",),
        profiles=_SPLITTING,
        twin="P55D",
        needs=(
            "client",
            "client.report",
        ),
    ),
    Clause(
        id="P55D",
        suite=_SUITE,
        level="must",
        title="Noise costs no report",
        text=("0x80 behind 61 62 63, behind 50 4B, or behind a frame that was cut is shown."),
        sources=(
            SERIAL,
            f"{DOCUMENT}, chapter on errors",
        ),
        profiles=("documented",),
        needs=(
            "client",
            "client.report",
        ),
    ),
    Clause(
        id="P56",
        suite=_SUITE,
        level="must",
        title="Reports come in pieces of any size",
        text=("0x83 is understood if its bytes come 20 ms apart, and so are ten of 0x80 without a gap."),
        sources=(SERIAL,),
        profiles=("documented",),
        needs=(
            "client",
            "client.report",
        ),
    ),
    Clause(
        id="P57",
        suite=_SUITE,
        level="should",
        title="A silent rover is noticed",
        text=(
            "A host that has heard its rover says within five seconds of silence that it is lost, and that it is there "
            "again when a report comes."
        ),
        sources=(CHOICE + " how soon; 0x80 comes three times a second",),
        profiles=("documented",),
        needs=(
            "client",
            "client.report",
        ),
    ),
    Clause(
        id="P58",
        suite=_SUITE,
        level="must",
        title="Reports of an unknown id are passed over",
        text=("A sound frame with the id 8F costs nothing: the 0x80 behind it is shown."),
        sources=(f"{DOCUMENT}, reports: the first byte says which",),
        profiles=("documented",),
        needs=(
            "client",
            "client.report",
        ),
    ),
    Clause(
        id="P59",
        suite=_SUITE,
        level="should",
        title="Counters that wrap go on",
        text=("0x80 with ACC 250, then 5: the host's total has gone up by 11."),
        sources=(f"{DOCUMENT}, 0x80: a byte",),
        profiles=("documented",),
        needs=(
            "client",
            "client.report",
        ),
    ),
    Clause(
        id="P79",
        suite=_SUITE,
        level="must",
        title="Each field is understood",
        text=(
            "0x80, 0x82, 0x83 and 0x84 with another number in each field, and before that with half of each: each "
            "field is shown with its number, and each report once."
        ),
        sources=(f"{DOCUMENT}, 0x80", f"{MANUAL}, 0x82, 0x83 and 0x84"),
        profiles=("documented",),
        needs=("client", "client.report"),
    ),
)
