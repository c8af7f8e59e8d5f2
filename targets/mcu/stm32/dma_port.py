"""One of the two AHB ports of a DMA controller: it serves one stream at a time, the most important that asks.

An access begins when a stream wants one and nothing is under way, and happens at its end. Among the streams that asked
by the beginning, the highest priority wins, then the lowest number (RM0410 section 8.3.5).
"""

from __future__ import annotations

from collections.abc import Callable

from targets.mcu.timebase import Event, Timebase

__all__ = ["Port"]


class Port:
    """See the module.

    Args:
        time: cycles and events.
        bus_cycle: returns how many cycles of `time` one of the bus takes; 0, in Stop mode, counts as 1.
        cycles: how long an access of one beat takes, in cycles of the bus; each further beat takes one more.
        priority: returns what to sort the streams by; the greatest wins.
        serve: makes the access of a stream, and returns how many beats it had.
    """

    def __init__(
        self,
        time: Timebase,
        bus_cycle: Callable[[], int],
        cycles: int,
        priority: Callable[[int], tuple[int, int]],
        serve: Callable[[int], int],
    ) -> None:
        self._time = time
        self._bus_cycle = bus_cycle
        self._cycles = cycles
        self._priority = priority
        self._serve = serve
        self._since: dict[int, int] = {}
        self._event: Event | None = None
        self._begun = 0
        self._serving = False
        self._held_until = 0

    def reset(self) -> None:
        """Forget everything."""
        self._time.cancel(self._event)
        self._event = None
        self._held_until = 0
        self._since.clear()

    def idle_at(self, now: int) -> bool:
        """Say whether at the present cycle no stream asks and no access is under way."""
        return not self._since and self._event is None and not self._serving and self._held_until <= now

    @property
    def access_cycles(self) -> int:
        """How long an access of one beat takes, in cycles of `time`."""
        return self._cycles * (self._bus_cycle() or 1)

    def hold(self, until: int) -> None:
        """Begin no access before cycle `until`: one that ends then was made already."""
        self._held_until = until

    def ask(self, stream: int, wants: bool) -> None:
        """A stream wants an access, or does not any more."""
        since = self._since
        if not wants:
            if stream in since:
                del since[stream]
        elif stream not in since:
            since[stream] = self._time.now
            self._proceed()

    def _proceed(self) -> None:
        if self._event is None and not self._serving and self._since:
            now = self._begun = self._time.now
            if now < self._held_until:
                self._event = self._time.at(self._held_until, self._free)
            else:
                self._event = self._time.at(now + self.access_cycles, self._finish)

    def _finish(self) -> None:
        since, begun = self._since, self._begun
        asking = [stream for stream, asked in since.items() if asked <= begun]
        beats = 1
        if asking:
            best = asking[0] if len(asking) == 1 else max(asking, key=self._priority)
            del since[best]
            self._serving = True
            beats = self._serve(best)
            self._serving = False
        if beats > 1:
            self._event = self._time.after((beats - 1) * (self._bus_cycle() or 1), self._free)
        else:
            self._free()

    def _free(self) -> None:
        self._event = None
        self._proceed()
