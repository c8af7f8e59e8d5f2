"""What a robot must do: stimulus and required response.

Hexadecimal bytes without further words stand as on the wire.
"""

from __future__ import annotations

from protocols.p2os.clause import Clause
from protocols.p2os.server_clauses import framing, motion, packets, session

__all__ = ["SERVER_CLAUSES"]

_FILES = (session, framing, motion, packets)

SERVER_CLAUSES: tuple[Clause, ...] = tuple(
    sorted((clause for file in _FILES for clause in file.CLAUSES), key=lambda clause: clause.id)
)
"""By their ids."""
