"""The catalogue of what the peers of this protocol must do.

P36, P37 and P50 to P59 are for the host's end, the others for the rover's. A D behind an id marks the twin of a clause
in which shipped behaviour is a defect.
"""

from __future__ import annotations

from protocols.pkt.board_clauses import BOARD_CLAUSES
from protocols.pkt.clause import Clause
from protocols.pkt.host_clauses import HOST_CLAUSES

__all__ = ["BOARD_CLAUSES", "CLAUSES", "HOST_CLAUSES", "Clause"]

CLAUSES: tuple[Clause, ...] = (*BOARD_CLAUSES, *HOST_CLAUSES)
"""All clauses, in the order of their ids within each suite."""
