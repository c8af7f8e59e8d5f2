from __future__ import annotations

import os

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


@pytest.fixture
def opens(monkeypatch):
    """Have something of pyserial's kind opened in the place of whatever a `SerialPort` is to open."""

    def instead(made):
        monkeypatch.setattr("hilbench.links.serialport.open_serial", lambda target, write_timeout_s: made)
        return made

    return instead


@pytest.fixture
def terminal():
    """A pseudo-terminal: the descriptor of its far end, and its name."""
    master, slave = os.openpty()
    yield master, os.ttyname(slave)
    os.close(master)
    os.close(slave)
