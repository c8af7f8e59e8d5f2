"""Drives a PKT! rover with the ground station of hilbench, and prints what the rover says.

    python drive_rover.py                              a virtual rover, in virtual time
    python drive_rover.py serial:/dev/ttyACM0@115200   a rover at a port, or `hilbench serve rover-model --pty ./rover`

It turns the wheels at 100 rpm for two seconds, then takes the voltage away. Lift the wheels of a real rover first.
"""

from __future__ import annotations

import contextlib
import sys

from hilbench.bench import Bench
from hilbench.bench.devices import DeviceActor
from hilbench.clock import MonotonicHostClock, Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink, Port, SerialPort, parse_serial_target
from hilbench.systems.rover.ground_station import GroundStation, Telemetry
from protocols.pkt import GeneralReport, MotionReport
from targets.robots.rover import RoverRobot, RoverSettings


def virtual_rover(bench: Bench) -> Port:
    """A rover inside this program; returns our end of its line."""
    link = MemoryLink(bench.scheduler, Line(baud=115200), name="host")
    DeviceActor(bench, RoverRobot(RoverSettings()), link.b, name="rover")
    return link.a


def show(telemetry: Telemetry) -> None:
    match telemetry.report:
        case MotionReport(rpm=rpm, throttles=throttles):
            wheels = " ".join(f"{one:5.1f}" for one in rpm)
            print(f"{telemetry.ns / 1e9:6.2f} s  wheels {wheels} rpm  throttles {throttles[0]:.3f} {throttles[1]:.3f}")
        case GeneralReport(accepted=accepted, rejected=rejected):
            print(f"{telemetry.ns / 1e9:6.2f} s  {accepted} packets accepted, {rejected} rejected")


def drive(station: GroundStation, bench: Bench) -> None:
    station.connect()
    if not bench.run_until(lambda: station.general is not None, within_s=3.0):
        sys.exit("no rover answers")
    station.set_gains(kp=0.001, kd=0.0, ki=0.004)
    station.drive_wheels(100.0, 100.0)
    bench.run_for(2.0)
    station.disconnect()
    bench.run_for(1.0)


def main() -> None:
    scheduler = Scheduler()
    bench = Bench(scheduler, Journal())
    if len(sys.argv) < 2:
        station = GroundStation(bench, virtual_rover(bench))
        station.on_report = show
        drive(station, bench)
        return
    port = SerialPort(scheduler, parse_serial_target(sys.argv[1]))
    station = GroundStation(bench, port)
    station.on_report = show
    with contextlib.closing(port), contextlib.closing(MonotonicHostClock()) as host:
        scheduler.lock(host)
        try:
            drive(station, bench)
        finally:
            scheduler.unlock()


if __name__ == "__main__":
    main()
