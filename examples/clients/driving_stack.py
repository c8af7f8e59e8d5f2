"""Plays the driving stack at a vehicle-interface board: publishes commands, subscribes to what the board reports.

    python driving_stack.py                              a virtual board and a car, in virtual time
    python driving_stack.py serial:/dev/ttyACM0@921600   a board at a port, or one that is served:
                                                         hilbench serve vehicle-model --pty usart3=./stack

It asks for AUTOWARE, drives with 3 m/s in a gentle turn to the left for four seconds, and stops. Nothing moves without
a simulator at the board's other line; with the original's, turn rates to the left are reported as negative.
"""

from __future__ import annotations

import contextlib
import sys

from hilbench.bench import Bench
from hilbench.bench.devices import LinesActor
from hilbench.benchfile.bench_model import World
from hilbench.clock import MonotonicHostClock, Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink, Port, SerialPort, parse_serial_target
from hilbench.mcu.bare_vehicle import BareVehicle
from hilbench.systems.vehicle.driven_car import DrivenCar
from hilbench.systems.vehicle.driving_stack import DrivingStack
from protocols.autoware import ControlMode, ControlModeReport, VelocityReport
from targets.robots.vehicle_interface import SIMULATOR_LINE, STACK_LINE, VehicleInterface, VehicleSettings
from worlds.vehicles.car import CarBody

DRIVE_S = 4.0


def virtual_board(bench: Bench) -> Port:
    """A board between us and a car on an endless floor; returns our end of its line."""
    line = Line(baud=921_600)
    links = {name: MemoryLink(bench.scheduler, line, name=name) for name in (SIMULATOR_LINE, STACK_LINE)}
    LinesActor(bench, VehicleInterface(VehicleSettings()), {name: link.b for name, link in links.items()}, name="board")
    vehicle = BareVehicle(bench, World(scene="empty", vehicle="car", physics="plane", step_hz=240), seed=0)
    assert isinstance(vehicle.body, CarBody)
    DrivenCar(bench, links[SIMULATOR_LINE].a, vehicle.body, vehicle.runner)
    return links[STACK_LINE].a


def show(stack: DrivingStack, bench: Bench) -> None:
    """Print each change of the mode, and the velocity about once a second."""
    shown: list[object] = [None, -1]

    def mode(report: ControlModeReport) -> None:
        if report.mode != shown[0]:
            shown[0] = report.mode
            print(f"{bench.now_s:6.2f} s  mode {ControlMode(report.mode).name}")

    def velocity(report: VelocityReport) -> None:
        if int(bench.now_s) != shown[1]:
            shown[1] = int(bench.now_s)
            print(f"{bench.now_s:6.2f} s  {report.longitudinal_velocity:5.2f} m/s  {report.heading_rate:6.3f} rad/s")

    stack.subscribe(ControlModeReport, mode)
    stack.subscribe(VelocityReport, velocity)


def drive(stack: DrivingStack, bench: Bench) -> None:
    answers: list[bool | None] = []
    stack.open()
    stack.drive_with(lambda: stack.command(speed=3.0, steering_tire_angle=0.1, acceleration=1.5, jerk=5.0))
    if not bench.run_until(lambda: stack.mode is not None, within_s=3.0):
        sys.exit("no board answers")
    stack.request_mode(ControlMode.AUTONOMOUS, answers.append)
    bench.run_until(lambda: bool(answers), within_s=2.0)
    if answers != [True]:
        sys.exit("the board does not let the driving stack drive")
    bench.run_for(DRIVE_S)
    stack.drive_with(lambda: stack.command(speed=0.0))
    bench.run_for(1.0)
    stack.close()


def main() -> None:
    scheduler = Scheduler()
    bench = Bench(scheduler, Journal())
    if len(sys.argv) < 2:
        stack = DrivingStack(bench, virtual_board(bench))
        show(stack, bench)
        drive(stack, bench)
        return
    port = SerialPort(scheduler, parse_serial_target(sys.argv[1]))
    stack = DrivingStack(bench, port)
    show(stack, bench)
    with contextlib.closing(port), contextlib.closing(MonotonicHostClock()) as host:
        scheduler.lock(host)
        try:
            drive(stack, bench)
        finally:
            scheduler.unlock()


if __name__ == "__main__":
    main()
