"""The tie between bench time and a host clock: what is due when, how late it was, and when bench time slipped."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Protocol

from hilbench.clock.host import HostClock, InputSource
from hilbench.clock.lateness import LatenessMeter
from hilbench.clock.ticks import NS_PER_MS, NS_PER_US

SLIP_THRESHOLD_NS = 50 * NS_PER_MS
HEARTBEAT_NS = 5 * NS_PER_MS
# While the loop is behind it looks at its inputs this often; a poll costs some microseconds.
_POLL_INTERVAL_NS = 500 * NS_PER_US
_SLIPS_KEPT = 1024


class PaceListener(Protocol):
    """Whoever is notified how a bench keeps up with the host's clock; all times are the host's, in ns."""

    def due(self, host_ns: int) -> None:
        """Learn when the next entry is due: until it has run, the bench is no further than that."""

    def ran(self, due_ns: int, began_ns: int, done_ns: int, *, spoke: int) -> None:
        """Learn when an entry was due, when it began, that it is done now, and where it sent anything: a bit a door."""

    def slipped(self, slip_ns: int, host_ns: int) -> None:
        """Learn that bench time stood still for so long until now."""


class Pace:
    """The tie between bench time and a host clock: epoch, slips, lateness."""

    def __init__(self, host: HostClock, now_ns: int, slip_threshold_ns: int, listener: PaceListener | None) -> None:
        self.host = host
        self.lateness = LatenessMeter()
        self._listener = listener
        self.spoke = 0
        self.slips = 0
        self.slipped_ns = 0
        self._slip_log: deque[tuple[int, int]] = deque(maxlen=_SLIPS_KEPT)  # (bench time, slipped before it)
        self._slip_threshold_ns = slip_threshold_ns
        self._start_bench_ns = now_ns
        self._start_host_ns = host.monotonic_ns()
        self._last_look_ns = self._began_ns = self._start_host_ns
        self._epoch_ns = self._start_host_ns - now_ns

    def aim(self, due_ns: int | None) -> None:
        """Learn which entry is the next."""
        if self._listener is not None and due_ns is not None:
            self._listener.due(due_ns + self._epoch_ns)

    def ran(self, late_ns: int, due_ns: int) -> None:
        """Take down how late an entry runs that was due at bench time `due_ns`."""
        self.lateness.record(late_ns, due_ns)
        self._began_ns = due_ns + self._epoch_ns + late_ns

    def done(self, due_ns: int) -> None:
        """Tell whoever listens that an entry has run that was due at bench time `due_ns`."""
        if self._listener is not None:
            due_ns += self._epoch_ns
            self._listener.ran(due_ns, self._began_ns, self.host.monotonic_ns(), spoke=self.spoke)
        self.spoke = 0

    def host_ns(self, bench_ns: int) -> int:
        """Return the host's time at bench time `bench_ns`, which has passed; never too late a time."""
        return bench_ns + self._epoch_ns - self.slipped_since_ns(bench_ns)

    def bench_ns(self, host_ns: int) -> int:
        """Return the bench time at `host_ns`, which has passed; that of a slip is the one at which time stood still."""
        epoch_ns, slipped_ns = self._epoch_ns, self.slipped_ns
        for at_ns, slipped_before_ns in reversed(self._slip_log):
            if host_ns - epoch_ns >= at_ns:
                break
            epoch_ns -= slipped_ns - slipped_before_ns
            slipped_ns = slipped_before_ns
            if host_ns - epoch_ns >= at_ns:
                return at_ns
        return host_ns - epoch_ns

    def look(self, due_ns: int | None) -> int:
        """Return the bench time the host has reached, slipping first if it is far beyond `due_ns`."""
        reached_ns = self.host.monotonic_ns() - self._epoch_ns
        if due_ns is not None and reached_ns - due_ns > self._slip_threshold_ns:
            self._slip(reached_ns - due_ns, due_ns)
            return due_ns
        return reached_ns

    def resume(self, now_ns: int) -> None:
        """Begin to run: a long pause since the last run was not bench time.

        It counts as lateness just before `now_ns`. A span measured from now on, after the pause, is not touched by it.
        """
        pause_ns = self.host.monotonic_ns() - self._epoch_ns - now_ns
        if pause_ns > self._slip_threshold_ns:
            self._slip(pause_ns, now_ns - 1)

    def _slip(self, slip_ns: int, at_ns: int) -> None:
        self.lateness.record(slip_ns, at_ns)
        self._slip_log.append((at_ns, self.slipped_ns))
        self.slips += 1
        self.slipped_ns += slip_ns
        self._epoch_ns += slip_ns
        if self._listener is not None:
            self._listener.slipped(slip_ns, at_ns + self._epoch_ns)

    def slipped_since_ns(self, since_ns: int) -> int:
        """Return the host time that slips since bench time `since_ns` took; never understated."""
        before_ns = self.slipped_ns
        for at_ns, slipped_before_ns in reversed(self._slip_log):
            if at_ns < since_ns:
                return self.slipped_ns - before_ns
            before_ns = slipped_before_ns
        return self.slipped_ns  # no slip before that is remembered

    def wait(self, until_ns: int | None) -> Sequence[InputSource]:
        """Wait until bench time `until_ns` or for an input."""
        ready = self.host.wait_until(None if until_ns is None else until_ns + self._epoch_ns)
        self._last_look_ns = self.host.monotonic_ns()
        return ready

    def poll_is_due(self, reached_ns: int) -> bool:
        """Say whether the inputs have not been looked at for a while, the host having reached `reached_ns`."""
        return reached_ns + self._epoch_ns - self._last_look_ns >= _POLL_INTERVAL_NS

    def real_time_factor(self, now_ns: int) -> float:
        """Return bench seconds per host second since the lock."""
        host_ns = self.host.monotonic_ns() - self._start_host_ns
        return (now_ns - self._start_bench_ns) / host_ns if host_ns > 0 else 1.0
