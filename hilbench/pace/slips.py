"""Says that a bench in real time slips, when it does."""

from __future__ import annotations

from collections.abc import Callable

from hilbench.clock import NS_PER_MS, NS_PER_S, PaceListener

__all__ = ["SAID_EVERY_NS", "SlipsSaid"]

SAID_EVERY_NS = 10 * NS_PER_S
"""So long nothing more is said after a line (choice): a host that is late all the time fills no screen."""


class SlipsSaid:
    """A `hilbench.clock.PaceListener` that says that bench time has slipped, and by how much.

    A slip is said at once, unless a line was said less than `SAID_EVERY_NS` of the host's time ago; then it is said
    with the others since that line as soon as this time is up. The host's, for bench time stands still as it slips.

    Args:
        say: takes a line meant for a person; it must not wait.
        now_ns: the host's time, in ns.
        listener: who is notified of it.
    """

    def __init__(self, say: Callable[[str], None], now_ns: int, listener: PaceListener | None = None) -> None:
        self._say = say
        self._listener = listener
        self._said_ns = now_ns
        self._next_ns = now_ns  # before that nothing is said
        self._from_ns = now_ns  # where the stretch begins that the next line is about
        self._slips = 0  # that were not said yet, as the following
        self._slipped_ns = 0

    def due(self, host_ns: int) -> None:
        """Tell the other when the next entry is due."""
        if self._listener is not None:
            self._listener.due(host_ns)

    def ran(self, due_ns: int, began_ns: int, done_ns: int, *, spoke: int) -> None:
        """Learn that the host's time is `done_ns`."""
        if self._listener is not None:
            self._listener.ran(due_ns, began_ns, done_ns, spoke=spoke)
        if self._slips and done_ns >= self._next_ns:
            self._tell(done_ns)

    def slipped(self, slip_ns: int, host_ns: int) -> None:
        """Learn that bench time stood still for so long until now."""
        if self._listener is not None:
            self._listener.slipped(slip_ns, host_ns)
        if not self._slips:
            self._from_ns = max(self._said_ns, host_ns - slip_ns - SAID_EVERY_NS)
        self._slips += 1
        self._slipped_ns += slip_ns
        if host_ns >= self._next_ns:
            self._tell(host_ns)

    def _tell(self, host_ns: int) -> None:
        span_ns = max(host_ns - self._from_ns, self._slipped_ns)
        times = f" in {self._slips} slips" if self._slips > 1 else ""
        self._say(
            f"this host is late: bench time stood still for {self._slipped_ns / NS_PER_MS:.0f} ms{times}, "
            f"{(span_ns - self._slipped_ns) / span_ns:.3f} x real time in the last {span_ns / NS_PER_S:.1f} s"
        )
        self._said_ns = host_ns
        self._next_ns = host_ns + SAID_EVERY_NS
        self._slips = self._slipped_ns = 0
