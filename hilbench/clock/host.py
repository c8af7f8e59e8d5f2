"""The host's clock, and what a bench in real time waits for; nothing else in the product knows the time of day."""

from __future__ import annotations

import datetime
import select
import selectors
import time
from collections.abc import Sequence
from typing import Protocol

from hilbench.clock.ticks import NS_PER_S


class InputSource(Protocol):
    """A real input that a locked scheduler watches."""

    def fileno(self) -> int:
        """Return the descriptor to watch for readability."""

    def on_readable(self, at_ns: int) -> None:
        """Take what is there and schedule its delivery at `at_ns` (bench time; never before the scheduler's now)."""


class HostClock(Protocol):
    """The host's monotonic clock, and waiting on it."""

    def monotonic_ns(self) -> int:
        """Return the host's monotonic time in nanoseconds."""

    def wait_until(self, host_ns: int | None) -> Sequence[InputSource]:
        """Wait until `host_ns` (None: for ever) or until an input is readable; return the readable ones.

        A moment that has passed makes this a poll.
        """

    def watch(self, source: InputSource) -> None:
        """Begin to watch `source`."""

    def unwatch(self, source: InputSource) -> None:
        """Stop watching `source`."""


class MonotonicHostClock:
    """The real host clock. Inputs are watched with epoll (kqueue elsewhere), waits end within some 0.1 ms."""

    def __init__(self) -> None:
        self._selector = selectors.DefaultSelector()
        # The descriptor of epoll and kqueue is itself selectable. epoll alone rounds its timeout up to a millisecond.
        self._gate: int | None = getattr(self._selector, "fileno", lambda: None)()

    def monotonic_ns(self) -> int:
        """Return the host's monotonic time in nanoseconds."""
        return time.monotonic_ns()

    def wait_until(self, host_ns: int | None) -> Sequence[InputSource]:
        """Wait until `host_ns` or until an input is readable; return the readable ones."""
        timeout_s = None if host_ns is None else max(0, host_ns - time.monotonic_ns()) / NS_PER_S
        if timeout_s and self._gate is not None:
            select.select((self._gate,), (), (), timeout_s)
            timeout_s = 0
        return [key.data for key, _ in self._selector.select(timeout_s)]

    def watch(self, source: InputSource) -> None:
        """Begin to watch `source`."""
        self._selector.register(source.fileno(), selectors.EVENT_READ, source)

    def unwatch(self, source: InputSource) -> None:
        """Stop watching `source`; its descriptor must still be open."""
        self._selector.unregister(source.fileno())

    def close(self) -> None:
        """Release the descriptor the clock watches with."""
        self._selector.close()


class ScaledHostClock:
    """Another host clock that passes at a multiple of its speed, so that a bench does.

    Args:
        host: the clock.
        factor: how many seconds it tells for one of the host's; above 0.
    """

    def __init__(self, host: HostClock, factor: float) -> None:
        self._host = host
        self._factor = factor
        self._start_ns = host.monotonic_ns()

    def monotonic_ns(self) -> int:
        """Return the scaled time in nanoseconds; at the beginning it is the host's."""
        return self._start_ns + round((self._host.monotonic_ns() - self._start_ns) * self._factor)

    def wait_until(self, host_ns: int | None) -> Sequence[InputSource]:
        """Wait until the scaled time `host_ns` or until an input is readable; return the readable ones."""
        if host_ns is None:
            return self._host.wait_until(None)
        return self._host.wait_until(self._start_ns + round((host_ns - self._start_ns) / self._factor))

    def watch(self, source: InputSource) -> None:
        """Begin to watch `source`."""
        self._host.watch(source)

    def unwatch(self, source: InputSource) -> None:
        """Stop watching `source`."""
        self._host.unwatch(source)


class Stopwatch:
    """Host time since it was made; for reports, never for verdicts."""

    def __init__(self, host: HostClock | None = None) -> None:
        self._read_ns = host.monotonic_ns if host else time.monotonic_ns
        self._start_ns = self._read_ns()

    def elapsed_s(self) -> float:
        """Return the host seconds since the stopwatch was made."""
        return (self._read_ns() - self._start_ns) / NS_PER_S


def wall_time_iso() -> str:
    """Return the date and time of day in UTC, as ISO 8601, for the heading of a report."""
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")


def wall_time_ns() -> int:
    """Return the time since 1970 in UTC, in ns, for what tells others the time of day; never for verdicts."""
    return time.time_ns()
