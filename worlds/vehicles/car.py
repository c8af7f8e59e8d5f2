"""A car: its body for the physics, and what a driver asks of it and sees on it.

It is moved by a model of its own (`worlds.car_dynamics`), because wheels that roll on rigid contacts have no slip
angle: they follow the kinematic bicycle up to the limit of friction and then slide. The body is a box that floats at
its ground clearance; it is there for obstacles, which it hits with the car's mass, and for rays. The reference point is
the middle of the rear axle, on the floor, where ackermann_msgs/AckermannDrive and Autoware's base_link have it.
"""

from __future__ import annotations

import math
from functools import partial

from worlds.car_commands import CarCommand
from worlds.car_dynamics import CarDynamics
from worlds.car_parameters import DEFAULTS, CarParameters
from worlds.errors import WorldError
from worlds.geometry import add, rotation, turn
from worlds.vehicles.model import BoxShape, Part, Vector, Vehicle, parameter_table
from worlds.world import CONTACTS, RAYS, World

__all__ = ["BODY", "DEFAULTS", "CarBody", "CarParameters", "vehicle"]

BODY = "body"

_BEHIND_BUMPER_M = 0.5
"""Rays start within the car, which never stops one: a bumper that leans on a wall may be a hair's breadth inside it."""

_LEVEL_KG_M2 = 1e9
"""The body neither rolls nor pitches: what meets it off its middle turns it about the vertical axis alone."""


def vehicle(parameters: CarParameters = DEFAULTS) -> Vehicle:
    """Return the car as a part for the physics, and what moves it."""
    p = parameters
    bottom, middle_x = p.ground_clearance_m, p.length_m / 2 - p.rear_overhang_m
    middle_z = (p.height_m + bottom) / 2
    shape = BoxShape(size_m=(p.length_m, p.width_m, p.height_m - bottom), center_m=(middle_x, 0.0, middle_z))
    body = Part(
        name=BODY,
        mass_kg=p.mass_kg,
        center_of_mass_m=(p.com_ahead_m, 0.0, middle_z),
        inertia_kg_m2=(_LEVEL_KG_M2, _LEVEL_KG_M2, p.yaw_inertia_kg_m2),
        shapes=(shape,),
        friction=p.body_friction,
    )
    return Vehicle(
        name="car", parts=(body,), motion=partial(CarDynamics, parameters), parameters=parameter_table(parameters)
    )


class CarBody:
    """What a driver asks of a car and sees on it, on any world that holds it.

    Args:
        world: where the car stands.

    Raises:
        WorldError: no car stands in this world.

    Attributes:
        dynamics: what moves it, with its speeds, its turn rate and its tyre angle.
    """

    def __init__(self, world: World) -> None:
        if not isinstance(world.motion, CarDynamics):
            raise WorldError(f"a {world.vehicle.name} is no car")
        self.world = world
        self.dynamics = world.motion
        self.parameters = world.motion.parameters
        p = self.parameters
        x_m, sides_m = p.front_bumper_m - _BEHIND_BUMPER_M, (p.width_m / 2, 0.0, -p.width_m / 2)
        self._starts_m: tuple[Vector, ...] = tuple((x_m, y_m, p.ray_height_m) for y_m in sides_m)
        self._reach_m = p.ray_range_m + _BEHIND_BUMPER_M

    @property
    def command(self) -> CarCommand:
        """What is asked of the car."""
        return self.dynamics.layer.command

    @command.setter
    def command(self, command: CarCommand) -> None:
        """Ask it from the next step on, until something else is asked."""
        self.dynamics.layer.command = command

    def touches(self) -> bool:
        """Whether it touched an obstacle in the last step."""
        return CONTACTS in self.world.capabilities and bool(self.world.contacts())

    def ranges_m(self) -> tuple[float, float, float]:
        """Return how far it is straight ahead from the front bumper.

        Returns:
            From its left corner, its middle and its right corner: metres to the nearest obstacle; infinite where there
            is none within the range, or in a world without rays.
        """
        if RAYS not in self.world.capabilities:
            return math.inf, math.inf, math.inf
        pose = self.world.pose()
        frame = rotation(pose.yaw_rad)
        starts = [add(pose.position_m, turn(frame, start)) for start in self._starts_m]
        reach = turn(frame, (self._reach_m, 0.0, 0.0))
        left, middle, right = self.world.cast(starts, [add(start, reach) for start in starts])
        return self._range_m(left), self._range_m(middle), self._range_m(right)

    def _range_m(self, share: float) -> float:
        return max(0.0, share * self._reach_m - _BEHIND_BUMPER_M) if share < 1.0 else math.inf
