"""Commands: what each does, and how it is counted and reported."""

from __future__ import annotations

from protocols.pkt.board_clauses._common import ALL, DOCUMENTED, LEN, SHIPPED, SUITE
from protocols.pkt.clause import DOCUMENT, G0, G2, MANUAL, Clause

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="P01",
        suite=SUITE,
        level="must",
        title="REQUEST_TMY is answered",
        text=(
            "50 4B 54 21 01 00 E1 F0 0A is answered at once with one 0x80, 50 4B 54 21 06 80 00 00 00 00 00 DA 30 0A, "
            "and changes nothing: 0/0/0/0. Without a length byte: 50 4B 54 21 00 E1 F0 0A and "
            "50 4B 54 21 80 00 00 00 00 33 DC 0A."
        ),
        sources=(DOCUMENT, f"{G2} handle_packet, send_general_tmy_report"),
        profiles=ALL,
        needs=("server",),
    ),
    Clause(
        id="P02",
        suite=SUITE,
        level="must",
        title="LED_ON without a report",
        text="50 4B 54 21 01 01 F1 D1 0A switches the LED on: 1/0/1/0. No 0x81 follows.",
        sources=(f"{G2} handle_packet: the flag tested is that of opcode 0", f"{G0} handle_packet"),
        profiles=SHIPPED,
        twin="P02D",
        needs=("server", "led"),
        by_hand=True,
    ),
    Clause(
        id="P02D",
        suite=SUITE,
        level="must",
        title="LED_ON with its report",
        text=(
            "LED_ON switches the LED on: 1/0/1/0, and is followed by one 0x81 with its opcode and status 0: "
            "50 4B 54 21 03 81 01 00 F3 C7 0A, without a length byte 50 4B 54 21 81 01 00 F3 C7 0A."
        ),
        sources=(f"{DOCUMENT}, 0x81", f"{MANUAL}, 0x81"),
        profiles=("documented", "term-doc"),
        needs=("server", "led"),
        by_hand=True,
    ),
    Clause(
        id="P03",
        suite=SUITE,
        level="must",
        title="Each packet counts",
        text="LED_OFF twice: 2/0/2/0.",
        sources=(f"{DOCUMENT}, 0x80", f"{G2} handle_packet"),
        profiles=ALL,
        needs=("server",),
    ),
    Clause(
        id="P04",
        suite=SUITE,
        level="must",
        title="An unknown opcode is accepted, with an error",
        text="50 4B 54 21 01 7F 6E 88 0A: 1/0/7F/5, not rejected.",
        sources=(f"{G2} handle_packet", f"{G0} handle_packet"),
        profiles=LEN,
        needs=("server",),
    ),
    Clause(
        id="P04D",
        suite=SUITE,
        level="must",
        title="An unknown opcode is reported",
        text="50 4B 54 21 01 7F 6E 88 0A is followed by one 0x81 with opcode 7F and status 5.",
        sources=(f"{DOCUMENT}, 0x81: sent after the execution of a command", f"{G2} handle_packet, behind the test"),
        profiles=DOCUMENTED,
        needs=("server",),
    ),
    Clause(
        id="P64",
        suite=SUITE,
        level="must",
        title="Each command has its report",
        text=(
            "LED_ON, LED_OFF, 0x03, 0x04 and 0x05 are each followed by one 0x81 with their opcode and status 0; a "
            "payload of 03 alone by one with 03 and another status."
        ),
        sources=(f"{DOCUMENT}, 0x81: sent after the execution of a command", f"{MANUAL}, 0x81"),
        profiles=DOCUMENTED,
        needs=("server",),
    ),
)
