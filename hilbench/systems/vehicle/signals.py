"""The signals of a car: what whoever drives it asks for, and how it moves.

Everything is of the vehicle's reference point, the middle of the rear axle on the floor, in ISO 8855 axes: x forward,
y to the left, z up, every angle and turn rate positive to the left. A driver asks either for a motion (`ackermann`:
the fields of ackermann_msgs/AckermannDrive, with its meaning of zero) or for pedals (manual: those of
carla_msgs/CarlaEgoVehicleControl, except that ``steer`` is positive to the left here); ``command_mode`` says which
of the two counts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from hilbench.benchfile.world_signals import WorldSignal
from targets.parts import Direction
from worlds.car_commands import CommandMode
from worlds.vehicles.car import CarBody

__all__ = ["CAR_SIGNALS", "CarSignals"]

_FIELDS = {
    "steering_command": "steering_rad",
    "steering_rate_limit": "steering_rate_rad_s",
    "speed_command": "speed_m_s",
    "accel_limit": "accel_m_s2",
    "jerk_limit": "jerk_m_s3",
    "throttle": "throttle",
    "brake": "brake",
    "steer": "steer",
}
"""Fields of `worlds.car_commands.CarCommand` by signals."""

_RAYS = ("ray_left", "ray_middle", "ray_right")


def _taken() -> Iterator[WorldSignal]:
    def take(name: str, unit: str, text: str) -> WorldSignal:
        return WorldSignal(name=name, direction=Direction.OUT, unit=unit, text=text)

    yield take("command_mode", "1", "which commands count: 0 the pedals, as after switching on, or 1 ackermann")
    yield take("steering_command", "rad", "ackermann: tyre angle, + left")
    yield take("steering_rate_limit", "rad/s", "ackermann: of the tyre angle; 0 is as fast as the car can")
    yield take("speed_command", "m/s", "ackermann: forward speed; 0 brakes with all the car has")
    yield take("accel_limit", "m/s2", "ackermann: while gaining or losing speed; 0 is as hard as the car can")
    yield take("jerk_limit", "m/s3", "ackermann: of the acceleration; 0 is without limit")
    yield take("throttle", "1", "pedals: 0 to 1")
    yield take("brake", "1", "pedals: 0 to 1")
    yield take("steer", "1", "pedals: share of the greatest tyre angle, -1 to 1, + left")
    yield take("hand_brake", "1", "pedals: 1 is pulled")


def _given() -> Iterator[WorldSignal]:
    def give(name: str, unit: str, text: str, *, by_rays: bool = False) -> WorldSignal:
        return WorldSignal(name=name, direction=Direction.IN, unit=unit, text=text, by_rays=by_rays)

    yield give("lon_speed", "m/s", "along the car, + forward")
    yield give("lat_speed", "m/s", "across the car, + left")
    yield give("yaw_rate", "rad/s", "+ left")
    yield give("steering", "rad", "tyre angle, + left")
    yield give("lon_accel", "m/s2", "rate of change of lon_speed in the last step")
    yield give("x", "m", "position in the scene")
    yield give("y", "m", "position in the scene")
    yield give("yaw", "rad", "+ left, of the scene's x; -pi to pi")
    yield give("contact", "1", "1 while the car touches an obstacle")
    for name, place in zip(_RAYS, ("left corner", "middle", "right corner"), strict=True):
        text = f"from the {place} of the front bumper straight ahead to what is hit; or inf"
        yield give(name, "m", text, by_rays=True)


CAR_SIGNALS: Mapping[str, WorldSignal] = {signal.name: signal for signal in (*_taken(), *_given())}
"""Every signal of a world with a car in it, by name."""


class CarSignals:
    """Reads and drives the signals of one car.

    Args:
        body: the vehicle.
        wanted: the names of the signals to read at each step.
    """

    def __init__(self, body: CarBody, wanted: Sequence[str]) -> None:
        self._body = body
        self._rays = [name for name in wanted if name in _RAYS]
        known = _readers(body)
        self._readers = {name: known[name] for name in wanted if name not in _RAYS}

    def read(self) -> dict[str, float]:
        """Return every wanted signal as it is now."""
        values = {name: read() for name, read in self._readers.items()}
        if self._rays:
            ranges = dict(zip(_RAYS, self._body.ranges_m(), strict=True))
            values |= {name: ranges[name] for name in self._rays}
        return values

    def drive(self, name: str, value: float) -> None:
        """Ask the car for something from the next step on; what else it was asked for stays in force.

        Raises:
            WorldError: a value that is not finite.
        """
        changed: dict[str, Any]
        if name == "command_mode":
            changed = {"mode": CommandMode(value >= 0.5)}
        elif name == "hand_brake":
            changed = {"hand_brake": value >= 0.5}
        else:
            changed = {_FIELDS[name]: value}
        self._body.command = replace(self._body.command, **changed)


def _readers(body: CarBody) -> dict[str, Callable[[], float]]:
    car = body.dynamics
    return {
        "lon_speed": lambda: car.lon_speed_m_s,
        "lat_speed": lambda: car.lat_speed_m_s,
        "yaw_rate": lambda: car.yaw_rate_rad_s,
        "steering": lambda: car.steering_rad,
        "lon_accel": lambda: car.lon_accel_m_s2,
        "x": lambda: car.pose.x_m,
        "y": lambda: car.pose.y_m,
        "yaw": lambda: car.pose.yaw_rad,
        "contact": lambda: float(body.touches()),
    }
