"""How the adapter reads its wires (bluepill_comm.cpp): bursts for the motor words, a window for the connection."""

from __future__ import annotations

from collections.abc import Sequence

from targets.parts.part import DigitalInput

__all__ = ["ConnectionSampler", "read_burst"]


def read_burst(wires: Sequence[DigitalInput], at_ns: int, *, reads: int, spacing_ns: int) -> tuple[bool, ...]:
    """Read each wire `reads` times, the last time at `at_ns`: high if more than half of the reads were."""
    times_ns = [max(0, at_ns - number * spacing_ns) for number in range(reads)]
    return tuple(2 * sum(wire.level_at(time_ns) for time_ns in times_ns) > reads for wire in wires)


class ConnectionSampler:
    """One read in each pass; after a window has passed, high if more than half of them were (whole numbers, as in C).

    Args:
        wire: p2dx_con.
        window_ns: how long reads are collected.
        now_ns: when it begins.

    Attributes:
        high: the verdict on the last window.
    """

    def __init__(self, wire: DigitalInput, window_ns: int, now_ns: int) -> None:
        self.high = False
        self._wire = wire
        self._window_ns = window_ns
        self._since_ns = now_ns
        self._sum = self._count = 0

    def sample(self, at_ns: int, *, may_end: bool) -> None:
        """Read once, or, if the window is over and `may_end`, decide and begin the next."""
        if at_ns - self._since_ns < self._window_ns or not may_end:
            self._sum += self._wire.level_at(at_ns)
            self._count += 1
            return
        self.high = self._sum > self._count // 2
        self._sum = self._count = 0
        self._since_ns = at_ns
