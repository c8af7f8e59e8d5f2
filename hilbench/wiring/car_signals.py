"""The signals of a car: what whoever drives it asks for, and how it moves.

Everything is of the vehicle's reference point, the middle of the rear axle on the floor, in ISO 8855 axes: x forward,
y to the left, z up, every angle and turn rate positive to the left. A driver asks either for a motion (`ackermann`:
the fields of ackermann_msgs/AckermannDrive, with its meaning of zero) or for pedals (manual: those of
carla_msgs/CarlaEgoVehicleControl, except that ``steer`` is positive to the left here); ``command_mode`` says which
of the two counts.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from hilbench.wiring.world_signals import WorldSignal
from targets.parts import Direction

__all__ = ["CAR_SIGNALS"]


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
    def give(name: str, unit: str, text: str) -> WorldSignal:
        return WorldSignal(name=name, direction=Direction.IN, unit=unit, text=text)

    yield give("lon_speed", "m/s", "along the car, + forward")
    yield give("lat_speed", "m/s", "across the car, + left")
    yield give("yaw_rate", "rad/s", "+ left")
    yield give("steering", "rad", "tyre angle, + left")
    yield give("lon_accel", "m/s2", "rate of change of lon_speed in the last step")
    yield give("x", "m", "position in the scene")
    yield give("y", "m", "position in the scene")
    yield give("yaw", "rad", "+ left, of the scene's x; -pi to pi")
    yield give("contact", "1", "1 while the car touches an obstacle")
    for side, place in (("left", "left corner"), ("middle", "middle"), ("right", "right corner")):
        yield give(f"ray_{side}", "m", f"straight ahead from the {place} of the front bumper to what is hit; or infinite")


CAR_SIGNALS: Mapping[str, WorldSignal] = {signal.name: signal for signal in (*_taken(), *_given())}
"""Every signal of a world with a car in it, by name."""
