"""What a host must do, faced with a scripted rover."""

from __future__ import annotations

from protocols.pkt.clause import CLIENT, DOCUMENT, SERIAL, Clause

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
)
