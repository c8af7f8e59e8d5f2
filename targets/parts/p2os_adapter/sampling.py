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
    """A verdict on p2dx_con after each window: high if it was high for more than half of it.

    The original counts single reads, one in a pass of its program; with passes of one millisecond that makes nine reads
    in 10 ms, of which a pulse of 5 ms can be five. The exact mean is what reads without end would give (choice).

    Args:
        wire: p2dx_con.
        window_ns: how long a window is, at least; it ends with a pass.
        now_ns: when the first begins.

    Attributes:
        high: the verdict on the last window.
    """

    def __init__(self, wire: DigitalInput, window_ns: int, now_ns: int) -> None:
        self.high = False
        self._wire = wire
        self._window_ns = window_ns
        self._since_ns = now_ns

    def take_pass(self, at_ns: int) -> None:
        """End the window if it is over."""
        if at_ns - self._since_ns >= self._window_ns:
            self.high = self._wire.mean(self._since_ns, at_ns) > 1 / 2
            self._since_ns = at_ns
