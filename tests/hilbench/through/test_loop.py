from __future__ import annotations

import pytest

from hilbench.through import loop
from hilbench.through.loop import Loop

MS = 1_000_000


class Host:
    """A host whose clock goes on while it is waited, and stands still for a while when it is told to."""

    def __init__(self):
        self.now_ns = 10**12
        self.stall_ns = 0
        self.waits_ns = []

    def monotonic_ns(self):
        return self.now_ns

    def wait_until(self, host_ns):
        self.waits_ns.append(host_ns - self.now_ns)
        self.now_ns = host_ns + self.stall_ns
        return []

    def watch(self, source):
        pass

    def unwatch(self, source):
        pass

    def close(self):
        pass


@pytest.fixture
def host(monkeypatch):
    host = Host()
    monkeypatch.setattr(loop, "MonotonicHostClock", lambda: host)
    return host


@pytest.mark.parametrize("stall_ms", [0, 1, 49, 51, 300, 10_000])
def test_a_host_that_stands_still_delays_nothing_later(host, stall_ms):
    each = Loop()
    host.stall_ns = stall_ms * MS
    assert not each.run_until(lambda: False)
    host.stall_ns = 0
    host.now_ns += 3600 * 1000 * MS  # a long time for the bench whose bytes they are
    host.waits_ns.clear()
    done = []
    each.scheduler.after(0, lambda: done.append(True))
    assert each.run_until(lambda: bool(done))
    assert max(host.waits_ns, default=0) <= 2 * MS
    assert each.scheduler.slips == 0
    each.close()


def test_time_stands_still_between_runs(host):
    each = Loop()
    each.run_until(lambda: False)
    before_ns = each.scheduler.now_ns
    host.now_ns += 60_000 * MS
    each.run_until(lambda: True)
    assert each.scheduler.now_ns == before_ns == 2 * MS
    each.close()
