"""Host clocks for benches that are locked, in tests that nobody else takes part in."""

from __future__ import annotations

from hilbench.clock import MonotonicHostClock


class SkippingHost(MonotonicHostClock):
    """A host whose time passes when something is waited for, and then at once.

    For lines where what is to be seen is there as soon as it was done: a port at which nobody answers, one that is
    pulled out. What another process, a thread or the kernel still has to carry would come too late.
    """

    def __init__(self):
        super().__init__()
        self._now_ns = super().monotonic_ns()

    def monotonic_ns(self):
        return self._now_ns

    def pass_time(self, duration_ns):
        """Let time pass in which the bench does nothing."""
        self._now_ns += duration_ns

    def wait_until(self, host_ns):
        ready = super().wait_until(None if host_ns is None else 0)
        if not ready and host_ns is not None:
            self._now_ns = max(self._now_ns, host_ns)
        return ready
