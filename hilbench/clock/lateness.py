"""How late the host was for what was due."""

from __future__ import annotations


class LatenessMeter:
    """How late the host was, in buckets of an eighth of an octave (an answer is never low, and high by at most 1/8).

    Args:
        last_ns: `BUCKETS` numbers to keep the times in, which others may look at; its own by default.
    """

    __slots__ = ("_counts", "_last_ns", "count", "max_ns")

    _STEPS_BITS = 3
    BUCKETS = 64 << _STEPS_BITS

    def __init__(self, last_ns: list[int] | memoryview[int] | None = None) -> None:
        self._counts = [0] * self.BUCKETS
        self._last_ns = [-1] * self.BUCKETS if last_ns is None else last_ns
        self.count = 0
        self.max_ns = 0

    def record(self, late_ns: int, at_ns: int) -> None:
        """Count a wake-up that was `late_ns` (0 or more) late for an entry due at bench time `at_ns`."""
        shift = max(0, late_ns.bit_length() - self._STEPS_BITS - 1)
        bucket = (shift << self._STEPS_BITS) + (late_ns >> shift)
        self._counts[bucket] += 1
        self._last_ns[bucket] = at_ns
        self.count += 1
        self.max_ns = max(self.max_ns, late_ns)

    def max_since_ns(self, since_ns: int) -> int:
        """Return the greatest lateness of entries due at bench time `since_ns` or later; 0 if there were none."""
        for bucket in range(len(self._counts) - 1, -1, -1):
            if self._last_ns[bucket] >= since_ns:
                return min(self.max_ns, self._upper_edge_ns(bucket))
        return 0

    def quantile_ns(self, share: float) -> int:
        """Return the lateness that `share` (0 to 1) of all wake-ups did not exceed; 0 if there were none."""
        wanted = share * self.count
        seen = 0
        for bucket, count in enumerate(self._counts):
            seen += count
            if count and seen >= wanted:
                return min(self.max_ns, self._upper_edge_ns(bucket))
        return 0

    def _upper_edge_ns(self, bucket: int) -> int:
        steps = 1 << self._STEPS_BITS
        if bucket < 2 * steps:
            return bucket
        shift = (bucket >> self._STEPS_BITS) - 1
        return ((bucket - (shift << self._STEPS_BITS) + 1) << shift) - 1
