"""What a vehicle-interface board must do: stimulus and required response, profile by profile.

F1 to F7 are the frames of vectors.py. "Status" is a frame like F4; "command" is what the driving stack commands, at 30
Hz where nothing is said, as are statuses at 20 Hz; a "miss" is a deadline without it, 110 ms for commands and 100 ms
for statuses. In every clause but VB04 a NUL stands behind each frame, and nothing else between frames; W and J of mode
4 are 0, V and A are not below 0, nor both above, and each of S, V and A is 0 or, without its sign, what readings of 16
bits or their mean make: 1e-9 to 1.04. Times hold within one tick, 1 ms, beside what the bench cannot tell apart. A
clause with H at the end of its id is the twin of one in which shipped behaviour is a hazard.
"""

from __future__ import annotations

from protocols.carla.board_clauses import (
    autoware,
    emergency,
    families,
    joystick,
    lamps,
    manual,
    reports,
    requests,
    stand_in,
    start,
    statuses,
)
from protocols.carla.clause import Clause

__all__ = ["BOARD_CLAUSES"]

_FILES = (autoware, emergency, families, joystick, lamps, manual, reports, requests, stand_in, start, statuses)

BOARD_CLAUSES: tuple[Clause, ...] = tuple(
    sorted((clause for file in _FILES for clause in file.CLAUSES), key=lambda clause: clause.id)
)
"""All of them, in order of their ids."""
