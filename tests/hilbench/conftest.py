from __future__ import annotations

import signal

import pytest

from tests.hilbench.forked import OF_OTHERS, Forkable
from tests.hilbench.hosts import SkippingHost


@pytest.fixture(autouse=True)
def keep_signals():
    """Put back what the command makes of the signals that end it."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture(scope="session")
def forkable():
    """Processes of the command that begin at once."""
    made = Forkable({"PYTHONPATH": "", "LC_ALL": "C.UTF-8"})
    yield made
    made.close()


@pytest.fixture(scope="session")
def forkable_pytest():
    """Processes of a pytest that has imported nothing of ours."""
    made = Forkable({"PYTHONPATH": "", "LC_ALL": "C.UTF-8"}, OF_OTHERS)
    yield made
    made.close()


@pytest.fixture
def skips(monkeypatch):
    """Benches with something attached skip what they would wait for; see `SkippingHost` for what that is good for."""
    monkeypatch.setattr("hilbench.bench.locked_providers.MonotonicHostClock", SkippingHost)
    # The kernel, which does not skip, would be late with the probe's byte.
    monkeypatch.setattr("hilbench.pace.pty_probe.PtyProbe._is_there", lambda _probe: True)
