"""What the proxy adds to a round trip, and how soon a port that was unplugged is back: figures of this machine.

Printed, not asserted: a busy host says nothing about the proxy.
"""

from __future__ import annotations

import os
import random
import select
import statistics
import threading
import time
import tty

import serial

from hilbench.bench import Bench
from hilbench.clock import MonotonicHostClock, Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, PtyDoor, ReconnectingPort, SerialTarget
from hilbench.ports.listing import PortInfo, UsbIdentity
from hilbench.serving.relay import Relay

ROUND_TRIPS = 2000
REPLUGS = 20
BOARD = UsbIdentity(vendor_id=0x0483, product_id=0x374B, serial_number="1", location="1-1")
REQUEST = bytes(range(16))


class Echo:
    """A pty whose master sends back what comes, in a thread."""

    def __init__(self):
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)
        self.name = os.ttyname(self.slave)
        self.ending = False
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def run(self):
        while not self.ending:
            if select.select((self.master,), (), (), 0.05)[0]:
                os.write(self.master, os.read(self.master, 4096))

    def close(self):
        self.ending = True
        self.thread.join()
        os.close(self.master)
        os.close(self.slave)


class Running:
    """A bench that runs in a thread until it is closed."""

    def __init__(self):
        self.host, self.scheduler = MonotonicHostClock(), Scheduler()
        self.bench = Bench(self.scheduler, Journal())
        self.over = False

    def start(self):
        self.scheduler.lock(self.host)
        self.thread = threading.Thread(target=self.scheduler.run_until, args=(lambda: self.over, None))
        self.thread.start()

    def stop(self):
        self.over = True
        self.thread.join()
        self.scheduler.unlock()
        self.host.close()


def round_trips_ms(name):
    times = []
    with serial.Serial(name, 115_200, timeout=10) as port:
        for _ in range(ROUND_TRIPS):
            began = time.perf_counter()
            port.write(REQUEST)
            assert port.read(len(REQUEST)) == REQUEST
            times.append((time.perf_counter() - began) * 1000)
    return statistics.quantiles(times, n=100)


def test_what_the_proxy_adds(say):
    echo = Echo()
    direct = round_trips_ms(echo.name)
    running = Running()
    door = PtyDoor(running.scheduler, None, Line(baud=0), any_baud=True)
    port = ReconnectingPort(running.scheduler, SerialTarget(url=echo.name, baud=115_200))
    Relay(running.bench, door, port, record=False)
    running.start()
    through = round_trips_ms(door.slave_name)
    running.stop()
    door.close()
    port.close()
    echo.close()
    say(
        f"round trip of {len(REQUEST)} bytes over ptys, {ROUND_TRIPS} times: direct p50 {direct[49]:.3f}, p99 "
        f"{direct[98]:.3f} ms; through the proxy p50 {through[49]:.3f}, p99 {through[98]:.3f} ms; added p50 "
        f"{through[49] - direct[49]:.3f}, p99 {through[98] - direct[98]:.3f} ms for two passes"
    )


def test_how_soon_a_port_is_back(say):
    boards = [Echo()]
    running = Running()
    port = ReconnectingPort(
        running.scheduler,
        SerialTarget(url=boards[0].name, baud=115_200),
        ports=lambda: [PortInfo(device=board.name, usb=BOARD) for board in boards],
    )
    up, down = threading.Event(), threading.Event()
    port.on_line = lambda is_up, at_ns: (up if is_up else down).set()
    running.start()
    times, phase_s = [], random.Random(0)
    for _ in range(REPLUGS):
        following = Echo()
        gone = boards.pop()
        up.clear()
        gone.close()
        assert down.wait(30)
        down.clear()
        time.sleep(phase_s.uniform(0, 0.25))  # at any moment between two looks, or each would take as long
        began = time.perf_counter()
        boards.append(following)
        assert up.wait(30)
        times.append((time.perf_counter() - began) * 1000)
    running.stop()
    port.close()
    boards.pop().close()
    say(
        f"a port that is plugged in again is open after p50 {statistics.median(times):.1f}, max {max(times):.1f} ms, "
        f"{REPLUGS} times; it is looked for every 250 ms"
    )
