"""The catalogue of what both ends of the simulator's line must do.

VB01 to VB30 and VS01 to VS25 describe the originals and what is asked of everyone, the numbers behind them what we
found besides. An H behind an id marks the twin of a clause in which shipped behaviour is a hazard.
"""

from __future__ import annotations

from protocols.carla.board_clauses import BOARD_CLAUSES
from protocols.carla.clause import Clause
from protocols.carla.host_clauses import HOST_CLAUSES

__all__ = ["BOARD_CLAUSES", "CLAUSES", "HOST_CLAUSES", "Clause"]

CLAUSES: tuple[Clause, ...] = (*BOARD_CLAUSES, *HOST_CLAUSES)
"""All clauses, in the order of their ids within each suite."""
