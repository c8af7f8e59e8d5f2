"""Records how far off the times of a bench may be that speaks with something real, for whoever judges by them later."""

from __future__ import annotations

from hilbench.bench import LOCKED_FLOOR_S, Bench
from hilbench.clock import NS_PER_S

__all__ = ["LatenessLog"]

_SPAN_NS = NS_PER_S
"""Over so long the lateness of the host is looked at (choice): few limits on a line are longer, and are less exact."""


class LatenessLog:
    """Writes an event ``host-lateness`` where times are further off than is taken for granted of any line.

    Args:
        bench: whose times they are.
        source: who says so.
    """

    def __init__(self, bench: Bench, source: str) -> None:
        self._bench = bench
        self._source = source
        self._before_s = 0.0

    def look(self) -> None:
        """Record how far off times of the last second may be, if that is new; to be called again and again."""
        late_s = float(self._bench.uncertainty_s(max(0, self._bench.now_ns - _SPAN_NS)))
        if late_s > LOCKED_FLOOR_S and late_s != self._before_s:
            self._bench.record("host-lateness", self._source, uncertainty_s=late_s)
        self._before_s = late_s
