"""What many samples of a time say: mean with its uncertainty, spread, and how far off what is expected."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["Spread", "spread_of"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Some times, in s.

    Attributes:
        count: how many.
        least_s: the shortest.
        mean_s: of all.
        most_s: the longest.
        deviation_s: the standard deviation.
        uncertainty_s: of the mean, 95 %: two standard errors, and how exactly each time is known.
    """

    count: int
    least_s: float
    mean_s: float
    most_s: float
    deviation_s: float
    uncertainty_s: float

    def within(self, least_s: float, most_s: float, tolerance_s: float) -> bool:
        """All times are between these, give or take a tolerance."""
        return least_s - tolerance_s <= self.least_s and self.most_s <= most_s + tolerance_s


def spread_of(times_s: Sequence[float], resolution_s: float) -> Spread:
    """What these times say, each of them known to within a resolution; there are two or more."""
    deviation_s = statistics.stdev(times_s)
    return Spread(
        count=len(times_s),
        least_s=min(times_s),
        mean_s=statistics.fmean(times_s),
        most_s=max(times_s),
        deviation_s=deviation_s,
        uncertainty_s=2 * deviation_s / math.sqrt(len(times_s)) + resolution_s,
    )
