"""The catalogue of what the peers of this protocol must do.

S01 to S91 for the robot's end, C01 to C33 for the client's, M01 to M24 for the robot in its world.
"""

from __future__ import annotations

from protocols.p2os.clause import Clause
from protocols.p2os.client_clauses import CLIENT_CLAUSES
from protocols.p2os.motion_clauses import MOTION_CLAUSES
from protocols.p2os.server_clauses import SERVER_CLAUSES

__all__ = ["CLAUSES", "CLIENT_CLAUSES", "MOTION_CLAUSES", "SERVER_CLAUSES", "Clause"]

CLAUSES: tuple[Clause, ...] = (*SERVER_CLAUSES, *CLIENT_CLAUSES, *MOTION_CLAUSES)
"""All clauses, in the order of their ids within each suite."""
