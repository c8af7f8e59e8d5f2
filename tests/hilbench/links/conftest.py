from __future__ import annotations

import os
import time
from types import SimpleNamespace

import pytest
import serial.rfc2217
import serial.urlhandler.protocol_socket

from hilbench.clock import NS_PER_S, MonotonicHostClock, ScaledHostClock, Scheduler

HURRY = 20


@pytest.fixture
def pace():
    """How many seconds of bench time pass in one of the host's.

    More than one where nobody at the far end has to answer in time: what a port may take to write is bench time.
    """
    return 1


@pytest.fixture
def locked(pace):
    """A scheduler that follows the real host clock."""
    host = MonotonicHostClock()
    scheduler = Scheduler()
    scheduler.lock(ScaledHostClock(host, pace))
    yield scheduler
    assert scheduler._sources == [], "a port was not closed"
    host.close()


def until(scheduler, condition):
    """Run until `condition` holds; the limit, a minute of the host's or more, is only there for what hangs."""
    assert scheduler.run_until(condition, scheduler.now_ns + 60 * HURRY * NS_PER_S), "it never happened"


@pytest.fixture(autouse=True)
def brisk_pyserial(monkeypatch):
    """Have pyserial look every millisecond for what it waits for, and not sleep 0.3 s after each closing."""
    brisk = SimpleNamespace(sleep=lambda _duration_s: time.sleep(0.001))
    monkeypatch.setattr(serial.rfc2217, "time", brisk)
    monkeypatch.setattr(serial.urlhandler.protocol_socket, "time", brisk)


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
