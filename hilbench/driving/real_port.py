"""The port at which a client of ours meets what somebody else runs."""

from __future__ import annotations

from hilbench.bench import Bench
from hilbench.benchfile.bench_file import BenchFile
from hilbench.links import ReconnectingPort, parse_serial_target

__all__ = ["open_at"]


def open_at(bench: Bench, bench_file: BenchFile, target: str, usual_baud: int) -> ReconnectingPort:
    """Open a port, again and again if it goes; the caller closes it.

    Args:
        bench: whose time passes.
        bench_file: says how ports are opened.
        target: as ``serial:/dev/ttyACM0``.
        usual_baud: its rate where nobody says one, in bit/s.
    """
    serial = parse_serial_target(target, usual_baud, bench_file.port.settings)
    return ReconnectingPort(bench.scheduler, serial, record=bench.record)
