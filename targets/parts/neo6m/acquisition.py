"""How a receiver finds its satellites: nothing, some, a position (NEO-6 data sheet table 2: times to first fix).

The times are drawn once for each start, normal about the typical one. They run while at least three satellites can be
received; else they begin anew. After a loss of at least that the hot time counts (choice). Satellites are found one
after the other, evenly over the search; the time of day is known after two thirds of a cold one, and at once if the
receiver remembers it (choices).
"""

from __future__ import annotations

from targets.parts.neo6m.settings import Neo6mSettings
from targets.parts.noise import gaussians

__all__ = ["LEAST_SATELLITES", "Acquisition"]

LEAST_SATELLITES = 3
"""For a position with a known height."""

_KINDS = ("cold", "warm", "hot")
_TIME_AFTER = 2 / 3
_MOST_SIGMAS = 3.0


class Acquisition:
    """See the module.

    Args:
        settings: the times.
        seed: of what is drawn.

    Attributes:
        time_known: the time of day is known.
        placed: it is known where the satellites stand.
        found: there is a position, as far as the satellites go.
        progress: of the search, 0..1.
        first_fix_ms: how long the first fix after the start took; 0 before.
    """

    def __init__(self, settings: Neo6mSettings, seed: int) -> None:
        self._settings = settings
        self._seed = seed
        self._starts = 0
        self._started_ns = 0
        self._needed_ns = 1
        self._since_ns: int | None = 0
        self._stopped = False
        self.start("cold", 0)

    def restart(self, kind: str, now_ns: int) -> str:
        """Start again; return how: no warmer than what is remembered allows."""
        allowed = min(kind, self._remembers, key=_KINDS.index)
        self.start(allowed, now_ns)
        return allowed

    def start(self, kind: str, now_ns: int) -> None:
        """Start ``cold``, ``warm`` or ``hot``."""
        self._remembers = kind
        self._starts += 1
        self._stopped = False
        self._started_ns = self._since_ns = now_ns
        self._need(kind)
        self.time_known = self.placed = kind != "cold"
        self.found = False
        self.progress = 0.0
        self.first_fix_ms = 0

    def stop(self) -> None:
        """Receive nothing until the next start."""
        self._stopped = True

    def step(self, receivable: int, now_ns: int) -> None:
        """Go on until `now_ns`, while so many satellites can be received."""
        if self._stopped or receivable < LEAST_SATELLITES:
            if self.found:
                self._starts += 1
                self._need("hot")
            self._since_ns, self.found, self.progress = None, False, 0.0
            return
        if self._since_ns is None:
            self._since_ns = now_ns
        self.progress = min(1.0, (now_ns - self._since_ns) / self._needed_ns)
        self.time_known |= self.progress >= _TIME_AFTER
        if self.progress >= 1.0:
            self.found = self.placed = True
            self._remembers = "hot"
            self.first_fix_ms = self.first_fix_ms or max(1, (now_ns - self._started_ns) // 1_000_000)

    def _need(self, kind: str) -> None:
        times_s = {"cold": self._settings.cold_s, "warm": self._settings.warm_s, "hot": self._settings.hot_s}
        drawn = max(-_MOST_SIGMAS, min(_MOST_SIGMAS, gaussians(self._seed, "first fix", self._starts)[0]))
        self._needed_ns = round(times_s[kind] * (1 + drawn * self._settings.spread_percent / 100) * 1e9)
