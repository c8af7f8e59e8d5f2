"""What a rover must do: stimulus and required response, profile by profile.

Hexadecimal bytes without further words stand as on the wire. State after a stimulus is written ACC/REJ/OP/ERR, as in
bytes 1 to 4 of the general report, from a fresh rover. A clause whose id ends with D is the twin of one in which
shipped behaviour is a defect: what document, manual or the firmware's own comments promise instead.
"""

from __future__ import annotations

from protocols.pkt.board_clauses import (
    behind_something,
    commands,
    damaged,
    families,
    newlines,
    parameters,
    published,
    sensors,
    silence,
    speed_control,
)
from protocols.pkt.clause import Clause

__all__ = ["BOARD_CLAUSES"]

_FILES = (
    behind_something,
    commands,
    damaged,
    families,
    newlines,
    parameters,
    published,
    sensors,
    silence,
    speed_control,
)

BOARD_CLAUSES: tuple[Clause, ...] = tuple(
    sorted((clause for file in _FILES for clause in file.CLAUSES), key=lambda clause: clause.id)
)
"""All of them, in order of their ids."""
