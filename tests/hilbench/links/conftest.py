from __future__ import annotations

import pytest

from hilbench.clock import MonotonicHostClock, Scheduler


@pytest.fixture
def locked():
    """A scheduler that follows the real host clock."""
    host = MonotonicHostClock()
    scheduler = Scheduler()
    scheduler.lock(host)
    yield scheduler
    assert scheduler._sources == [], "a port was not closed"
    host.close()
