"""How much of the state tables of PKT! a run went through: of the rover, of the host, and of the decoder of both."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

from hilbench.bench.observing import coverage_of
from hilbench.judging.observations import Coverage
from protocols.pkt import CLIENT_TABLE, LEN_TABLE, SERVER_TABLE, TERM_TABLE, Connection, FrameState, Role

__all__ = ["RoverObserver"]

_TABLES: Mapping[str, Mapping[tuple[Any, Any], Any]] = {
    "rover": SERVER_TABLE,
    "host": CLIENT_TABLE,
    "decoder of frames with a length": LEN_TABLE,
    "decoder of lines": TERM_TABLE,
}


class RoverObserver:
    """Adds up what the connections of a run went through."""

    def __init__(self) -> None:
        self._visits: dict[str, Counter[tuple[Any, Any]]] = {}

    def take(self, connection: Connection) -> None:
        """Look at a connection whose case is over."""
        peer = "rover" if connection.role is Role.SERVER else "host"
        self._visits.setdefault(peer, Counter()).update(connection.visits)
        frames = connection.frame_visits
        if frames:
            lines = any(state is FrameState.BODY for state, _ in frames)
            decoder = "decoder of lines" if lines else "decoder of frames with a length"
            self._visits.setdefault(decoder, Counter()).update(frames)

    def coverage(self) -> tuple[Coverage, ...]:
        """Return the coverage of each table that was gone through."""
        return tuple(
            coverage_of(peer, table, self._visits[peer]) for peer, table in _TABLES.items() if peer in self._visits
        )
