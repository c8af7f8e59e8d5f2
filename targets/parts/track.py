"""What something moving does: a vector over time, straight between the ends of physics steps, behind a filter.

The filter is a first-order low pass followed by a pure delay. Over a straight piece its output has a closed form
(the response of a first-order lag to a ramp), so it is exact at any instant, whatever the length of the steps.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping, Sequence

__all__ = ["Track", "Vector"]

Vector = tuple[float, ...]

_PRUNE_AT = 512
"""So many entries are kept before old ones are looked for (choice)."""


class Track:
    """See the module.

    Args:
        start: what was seen for ever before time 0.
    """

    def __init__(self, start: Vector) -> None:
        self._times_ns = [0]
        self._seen: list[Vector] = [start]
        self._filtered: list[Vector] = [start]
        self._lag_ns = 0.0
        self._delay_ns = 0

    def set_filter(self, lag_s: float, delay_s: float) -> None:
        """Filter from now on as if it had always been like this: a change of filter has no transient (choice).

        Args:
            lag_s: time constant of the low pass; 0 for none.
            delay_s: of the pure delay.
        """
        self._lag_ns, self._delay_ns = lag_s * 1e9, round(delay_s * 1e9)
        self._filtered = self._filtered[:1]
        for index in range(1, len(self._times_ns)):
            self._filtered.append(self._lagged(index - 1, self._times_ns[index]))

    def step(self, from_ns: int, to_ns: int, before: Vector, after: Vector) -> None:
        """Add a physics step. What was seen last lasts until its beginning; where `before` differs, it jumps there."""
        if from_ns > self._times_ns[-1]:
            self._add(from_ns, self._seen[-1])
        if before != self._seen[-1]:
            self._add(self._times_ns[-1], before)
        self._add(to_ns, after)

    def follow(
        self, from_ns: int, to_ns: int, before: Mapping[str, float], after: Mapping[str, float], names: Sequence[str]
    ) -> None:
        """As `step`, of values by name; what is not told, or is no number, stays as it was."""
        start = _given(before, names, self.unfiltered_at(from_ns))
        self.step(from_ns, to_ns, start, _given(after, names, start))

    def forget(self, before_ns: int) -> None:
        """Forget what is not needed to answer for `before_ns` and later."""
        if len(self._times_ns) > _PRUNE_AT:
            cut = max(0, bisect_right(self._times_ns, before_ns) - 1)
            del self._times_ns[:cut], self._seen[:cut], self._filtered[:cut]

    def at(self, ns: int) -> Vector:
        """Return what comes out of the filter at `ns`."""
        inside_ns = ns - self._delay_ns
        index = bisect_right(self._times_ns, inside_ns) - 1
        return self._filtered[0] if index < 0 else self._lagged(index, inside_ns)

    def unfiltered_at(self, ns: int) -> Vector:
        """Return what is seen at `ns`."""
        index = max(0, bisect_right(self._times_ns, ns) - 1)
        slope, since_ns = self._slope(index), ns - self._times_ns[index]
        return tuple(x + k * since_ns for x, k in zip(self._seen[index], slope, strict=True))

    def _add(self, ns: int, seen: Vector) -> None:
        self._times_ns.append(max(ns, self._times_ns[-1]))
        self._seen.append(seen)
        self._filtered.append(self._lagged(len(self._times_ns) - 2, self._times_ns[-1]))

    def _slope(self, index: int) -> Vector:
        """Per ns, in the piece that begins with an entry; after the last entry nothing changes."""
        start = self._seen[index]
        span_ns = self._times_ns[index + 1] - self._times_ns[index] if index + 1 < len(self._times_ns) else 0
        if not span_ns:
            return (0.0,) * len(start)
        return tuple((b - a) / span_ns for a, b in zip(start, self._seen[index + 1], strict=True))

    def _lagged(self, index: int, ns: int) -> Vector:
        """What comes out of the low pass in the piece that begins with an entry."""
        since_ns, lag_ns = ns - self._times_ns[index], self._lag_ns
        slope = self._slope(index)
        if not lag_ns:
            return tuple(x + k * since_ns for x, k in zip(self._seen[index], slope, strict=True))
        rest = math.exp(-since_ns / lag_ns)
        return tuple(
            x + k * (since_ns - lag_ns) + (y - x + k * lag_ns) * rest
            for x, y, k in zip(self._seen[index], self._filtered[index], slope, strict=True)
        )


def _given(values: Mapping[str, float], names: Sequence[str], else_: Vector) -> Vector:
    found = (values.get(name, math.nan) for name in names)
    return tuple(value if math.isfinite(value) else last for value, last in zip(found, else_, strict=True))
