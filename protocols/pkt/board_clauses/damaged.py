"""Frames that are wrong, and the longest one that is right."""

from __future__ import annotations

from protocols.pkt.board_clauses._common import ALL, LEN, SUITE
from protocols.pkt.clause import DECODER, DOCUMENT, Clause

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="P05",
        suite=SUITE,
        level="must",
        title="A wrong CRC is rejected",
        text="50 4B 54 21 01 01 00 00 0A: 0/1/0/3, LED not changed.",
        sources=(DOCUMENT, f"{DECODER} handle_pkt_state_expecting_crc2"),
        profiles=LEN,
        needs=("server",),
    ),
    Clause(
        id="P06",
        suite=SUITE,
        level="must",
        title="A wrong terminator is rejected",
        text="LED_ON with 58 in place of its newline: 0/1/0/4, LED not changed though the CRC was right.",
        sources=(f"{DECODER} handle_pkt_state_expecting_terminator",),
        profiles=LEN,
        needs=("server",),
    ),
    Clause(
        id="P07",
        suite=SUITE,
        level="must",
        title="A length of zero is rejected",
        text="50 4B 54 21 00: 0/1/0/2.",
        sources=(f"{DECODER} handle_pkt_state_expecting_length",),
        profiles=LEN,
        needs=("server",),
    ),
    Clause(
        id="P08",
        suite=SUITE,
        level="must",
        title="A length beyond 96 is rejected",
        text="50 4B 54 21 61: 0/1/0/2; the same with FF.",
        sources=(f"{DECODER} handle_pkt_state_expecting_length; protocol.h PAYLOAD_BUFFER_SIZE",),
        profiles=LEN,
        needs=("server",),
    ),
    Clause(
        id="P09",
        suite=SUITE,
        level="must",
        title="96 bytes are a payload",
        text="Length 60, payload 01 and 95 zeros, CRC right: 1/0/1/0; what follows the opcode is ignored.",
        sources=(f"{DECODER} handle_pkt_state_expecting_length; protocol.h PAYLOAD_BUFFER_SIZE",),
        profiles=LEN,
        needs=("server",),
    ),
    Clause(
        id="P10",
        suite=SUITE,
        level="must",
        title="A broken sync word is rejected",
        text="50 4B 58 21: 0/1/0/1, once.",
        sources=(DOCUMENT, f"{DECODER} handle_pkt_state_expecting_start_sync2"),
        profiles=ALL,
        needs=("server",),
    ),
)
