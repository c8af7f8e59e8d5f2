"""What only hardware can prove; docs/hardware-tests.md says how to run it.

HILBENCH_HARDWARE_PORT names the port, as after ``--target``; HILBENCH_HARDWARE_WITH says what is attached, of ``plug``
(TX joined to RX), ``modem-plug`` (beside it RTS to CTS, and DTR to DSR), ``echo`` (firmware that echoes), ``greeting``
(a board that says something when it starts), ``person`` (somebody who pulls and plugs), joined by commas.
"""

from __future__ import annotations

import contextlib
import os
import sys

import pytest

from hilbench.clock import MonotonicHostClock, Scheduler
from hilbench.files.host import this_host
from hilbench.links import ReconnectingPort, SerialPort
from hilbench.links.serial_target import located, parse_serial_target
from hilbench.ports.listing import list_ports
from hilbench.ports.states import port_states

PORT = os.environ.get("HILBENCH_HARDWARE_PORT", "")
ATTACHED = frozenset(filter(None, map(str.strip, os.environ.get("HILBENCH_HARDWARE_WITH", "").split(","))))
KNOWN = frozenset({"plug", "modem-plug", "echo", "greeting", "person"})
RATE = 115_200
HERE = os.path.dirname(__file__)


def pytest_collection_modifyitems(items):
    """Everything here is about hardware, and is left out where that is not attached, but not for a slip of the pen."""
    if unknown := ", ".join(sorted(ATTACHED - KNOWN)):
        known = ", ".join(sorted(KNOWN))
        raise pytest.UsageError(f"HILBENCH_HARDWARE_WITH: nothing is called {unknown}; there are {known}")
    for item in items:
        if not str(item.path).startswith(HERE):
            continue
        item.add_marker(pytest.mark.hardware)
        if not PORT:
            item.add_marker(pytest.mark.skip(reason="HILBENCH_HARDWARE_PORT names no port; see docs/hardware-tests.md"))
            continue
        for mark in item.iter_markers("attached"):
            if ATTACHED.isdisjoint(mark.args):
                item.add_marker(pytest.mark.skip(reason=f"HILBENCH_HARDWARE_WITH has none of {', '.join(mark.args)}"))


class Attached:
    """The port, and a bench in real time to use it."""

    def __init__(self, scheduler):
        self.scheduler = scheduler
        self.target = parse_serial_target(PORT, RATE)
        self.opened = []

    @property
    def state(self):
        """How the port stands now; None if it is none of this machine's, or not there."""
        return self.state_at(located(self.target).url)

    def state_at(self, path):
        """How a port stands: what comes back may be called otherwise than the port that was named."""
        device = os.path.realpath(path)
        return next((one for one in port_states(this_host(), list_ports()) if one.port.device == device), None)

    @property
    def usb(self):
        """The device it belongs to; a test that needs one is skipped where there is none."""
        state = self.state
        if state is None or state.port.usb is None:
            pytest.skip(f"{PORT} has no USB identity")
        return state.port.usb

    def open(self, kind=SerialPort):
        port = kind(self.scheduler, self.target)
        port.got = bytearray()
        port.on_receive = lambda data, _at_ns: port.got.extend(data)
        self.opened.append(port)
        return port

    def run(self, condition, within_s):
        return self.scheduler.run_until(condition, self.scheduler.now_ns + round(within_s * 1e9))


@pytest.fixture
def attached():
    clock, scheduler = MonotonicHostClock(), Scheduler()
    scheduler.lock(clock)
    made = Attached(scheduler)
    yield made
    for port in made.opened:
        port.close()
    with contextlib.suppress(Exception):
        scheduler.unlock()
    clock.close()


@pytest.fixture
def reconnecting():
    return ReconnectingPort


@pytest.fixture
def tell(capsys):
    """Say something to the person at the desk."""

    def say(text):
        with capsys.disabled():
            sys.stdout.write(f"\n  {text}\n")
            sys.stdout.flush()

    return say
