"""A PKT! ground station that tells on a second port what it understood, so that all of it can be checked.

    hilbench check rover-model --suite pkt-host --target 'exec:python reporting_station.py {pty} {report}'

A station of your own needs none of hilbench for it: it writes one JSON object a line to that port, and reads what it is
to send (`hilbench.systems.rover.reporting_station` has the words).
"""

from __future__ import annotations

import contextlib
import signal
import sys

from hilbench.bench import Bench
from hilbench.clock import MonotonicHostClock, Scheduler
from hilbench.journal import Journal
from hilbench.links import SerialPort, parse_serial_target
from hilbench.systems.rover.ground_station import GroundStation
from hilbench.systems.rover.reporting_station import StationReporter

LAST_WORDS_S = 0.2


def main() -> None:
    scheduler = Scheduler()
    bench = Bench(scheduler, Journal())
    to_rover, to_checker = (
        SerialPort(scheduler, parse_serial_target(f"serial:{path}@115200")) for path in sys.argv[1:3]
    )
    ended: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda number, _frame: ended.append(number))
    station = GroundStation(bench, to_rover)
    with (
        contextlib.closing(to_rover),
        contextlib.closing(to_checker),
        contextlib.closing(MonotonicHostClock()) as host,
    ):
        scheduler.lock(host)
        try:
            StationReporter(bench, station, to_checker)
            station.connect()
            while not ended:
                bench.run_for(0.05)
            station.disconnect()
            bench.run_for(LAST_WORDS_S)
        finally:
            scheduler.unlock()


if __name__ == "__main__":
    main()
