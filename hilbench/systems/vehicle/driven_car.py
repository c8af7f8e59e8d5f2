"""A car in its world at the simulator's end of a vehicle-interface board's line.

The car host says how the car moves, twenty times a second, and takes the board's commands; here they reach the car's
command layer, as CARLA's ackermann node and its vehicle control would have it:

- a tyre angle is divided by the largest of CARLA's wheels, 69.99 degrees, and what is left is a share of the car's own
  largest angle, the mean of both wheels: with the board's factor of 1.2 the tyres stand within 1.1 % of what the
  driving stack asked for. That is what the factor is for;
- ``steer`` of a manual command is positive to the right there, and so turns the car to the right.

A command that is not finite changes nothing (choice: CARLA has no answer for it).
"""

from __future__ import annotations

import math

from hilbench.bench import Bench
from hilbench.bench.feed import Feed
from hilbench.bench.world_runner import WorldRunner
from hilbench.links import Port
from hilbench.systems.vehicle.car_simulator import CarSimulator
from hilbench.systems.vehicle.simulator_peer import STATUS_HZ
from protocols.carla import AckermannCommand
from targets.robots.car_host import CarHostSettings, CarState, CarWish
from worlds.car_commands import CarCommand, CommandMode
from worlds.errors import WorldError
from worlds.vehicles.car import CarBody

__all__ = ["CARLA_LARGEST_RAD", "DrivenCar", "car_command"]

CARLA_LARGEST_RAD = math.radians(69.99)
"""The largest angle of a front wheel of CARLA's VW T2, by which the ackermann node divides (carla_ackermann_control,
max_steering_angle of the vehicle's info; the figure is that of LMA-FEM-UNICAMP/Carla-Autoware-Bridge)."""


def car_command(wish: CarWish, largest_rad: float) -> CarCommand:
    """What a wish is to the command layer of a car with this largest tyre angle.

    Raises:
        WorldError: a figure of it is not finite.
    """
    if wish is None:
        return CarCommand()
    if isinstance(wish, AckermannCommand):
        share = largest_rad / CARLA_LARGEST_RAD
        return CarCommand(
            mode=CommandMode.ACKERMANN,
            steering_rad=wish.steering_rad * share,
            steering_rate_rad_s=wish.steering_rate_rad_s * share,
            speed_m_s=wish.speed_m_s,
            accel_m_s2=wish.acceleration_m_s2,
            jerk_m_s3=wish.jerk_m_s3,
        )
    return CarCommand(mode=CommandMode.PEDALS, throttle=wish.throttle, brake=wish.brake, steer=-wish.steer)


class DrivenCar:
    """See the module.

    Args:
        bench: whose time it lives in.
        port: the simulator's end of the line.
        body: the car.
        runner: who moves its world.
        settings: of the car host; the hardened one if None.

    Attributes:
        simulator: the car host on the bench, with everything that the car was commanded.
        statuses: says how the car moves, as long as it runs; a simulator that is lost has it stopped.
        status_hz: how often.
        body: the car.
    """

    def __init__(
        self, bench: Bench, port: Port, body: CarBody, runner: WorldRunner, settings: CarHostSettings | None = None
    ) -> None:
        self.body = body
        self.simulator = CarSimulator(bench, port, settings or CarHostSettings())
        self.simulator.connect()
        self.simulator.report_by_hand()
        self.statuses = Feed(bench, lambda: self.simulator.report("velocity", "steering"), name="car")
        self.status_hz = STATUS_HZ
        self.statuses.start(self.status_hz)
        self._commanded: CarWish = None
        runner.before.append(self._obey)
        runner.after.append(self._sense)

    def place(self, x_m: float, y_m: float, yaw_rad: float) -> None:
        """Put the car down there, at rest; what it was commanded is commanded anew."""
        self.body.world.place(x_m, y_m, yaw_rad)
        self._commanded = None

    def _obey(self, _now_ns: int, _next_ns: int) -> None:
        wish = self.simulator.host.wish
        if wish == self._commanded:
            return
        self._commanded = wish
        try:
            self.body.command = car_command(wish, self.body.parameters.max_steering_rad)
        except WorldError:
            self._commanded = None

    def _sense(self, _now_ns: int, _next_ns: int) -> None:
        dynamics = self.body.dynamics
        self.simulator.sense(
            CarState(
                lon_speed_m_s=dynamics.lon_speed_m_s,
                lat_speed_m_s=dynamics.lat_speed_m_s,
                yaw_rate_rad_s=dynamics.yaw_rate_rad_s,
                steering_rad=dynamics.steering_rad,
            )
        )
