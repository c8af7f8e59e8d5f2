"""How a car is driven: what a driver may ask for, and what pedals, brakes and steering make of it.

Two kinds of command, as the ROS bridge of CARLA has them, and one of them in force at a time:

- *ackermann*: a tyre angle and a speed, with limits on the way to them. The meaning is that of
  ackermann_msgs/AckermannDrive: a limit of zero is as fast as the car can, and a limit of acceleration holds for
  braking as well. Two rules are those of CARLA's node for it (carla_ackermann_control_node.py): speed 0 brakes with all
  the car has, whatever the limits, and below 0.1 m/s the hand brake comes on. That node reaches speeds by PID control
  over throttle and brake; here a perfect controller does, within the same limits of the car.
- *pedals*: throttle, brake, steering wheel and hand brake, as in carla_msgs/CarlaEgoVehicleControl.

What is out of range is taken to the nearest end of the range, as CARLA does. A speed below zero is no reverse gear,
which is not modelled: it stops the car, as the node does before it changes gear.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import NamedTuple

from worlds.car_parameters import CarParameters
from worlds.errors import WorldError

__all__ = ["CarCommand", "CommandLayer", "CommandMode", "Effort"]


class CommandMode(enum.IntEnum):
    """Which fields of a command count."""

    PEDALS = 0
    ACKERMANN = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class CarCommand:
    """What a driver asks for.

    Attributes:
        mode: which of the two kinds counts.
        steering_rad: ackermann: tyre angle, + left.
        steering_rate_rad_s: ackermann: limit of its rate; its magnitude counts, 0 is as fast as the car can.
        speed_m_s: ackermann: forward speed.
        accel_m_s2: ackermann: limit of gaining and losing speed; its magnitude counts.
        jerk_m_s3: ackermann: limit of the acceleration's rate; its magnitude counts, 0 is none.
        throttle: pedals: 0 to 1.
        brake: pedals: 0 to 1.
        steer: pedals: share of the greatest tyre angle, -1 to 1, + left.
        hand_brake: pedals: whether it is pulled.

    Raises:
        WorldError: a figure that is not finite.
    """

    mode: CommandMode = CommandMode.PEDALS
    steering_rad: float = 0.0
    steering_rate_rad_s: float = 0.0
    speed_m_s: float = 0.0
    accel_m_s2: float = 0.0
    jerk_m_s3: float = 0.0
    throttle: float = 0.0
    brake: float = 0.0
    steer: float = 0.0
    hand_brake: bool = False

    def __post_init__(self) -> None:
        asked = (self.steering_rad, self.steering_rate_rad_s, self.speed_m_s, self.accel_m_s2, self.jerk_m_s3)
        if not all(map(math.isfinite, (*asked, self.throttle, self.brake, self.steer))):
            raise WorldError(f"a car cannot be commanded by figures that are not finite: {self}")


class Effort(NamedTuple):
    """What acts on the car for a short time.

    Attributes:
        steering_rate_rad_s: of the tyre angle.
        accel_m_s2: what the drive and brakes are to make of the speed; None if the forces below act as they are.
        push_n: of the engine, forward.
        brake_n: of all brakes, against the motion.
    """

    steering_rate_rad_s: float
    accel_m_s2: float | None
    push_n: float
    brake_n: float


class CommandLayer:
    """Turns commands into what acts on a car.

    Args:
        parameters: of the car.

    Attributes:
        command: what is asked for.
        accel_m_s2: how the speed changes now; whoever moves the car says so after each step.
    """

    def __init__(self, parameters: CarParameters) -> None:
        self._p = parameters
        self.command = CarCommand()
        self.accel_m_s2 = 0.0

    def effort(self, speed_m_s: float, steering_rad: float, dt_s: float) -> Effort:
        """Return what acts for the next `dt_s`, on a car with this forward speed and tyre angle."""
        if self.command.mode is CommandMode.ACKERMANN:
            return self._ackermann(speed_m_s, steering_rad, dt_s)
        return self._pedals(speed_m_s, steering_rad, dt_s)

    def push_limit_n(self, speed_m_s: float) -> float:
        """Return the engine's force at full throttle: as much as it has power for."""
        p = self._p
        return min(p.mass_kg * p.max_accel_m_s2, p.power_w / max(abs(speed_m_s), 1.0))

    def _ackermann(self, speed_m_s: float, steering_rad: float, dt_s: float) -> Effort:
        command, p = self.command, self._p
        rate = self._steering_rate(command.steering_rad, abs(command.steering_rate_rad_s), steering_rad, dt_s)
        target = max(0.0, command.speed_m_s)
        if target == 0.0:
            least = -p.max_decel_m_s2
            if abs(speed_m_s) < p.standing_m_s:
                least -= self._hand_brake_n() / p.mass_kg
            return Effort(rate, _clamped(-speed_m_s / dt_s, least, -least), 0.0, 0.0)
        limit = abs(command.accel_m_s2) or math.inf
        wanted = _approach(self.accel_m_s2, target - speed_m_s, limit, abs(command.jerk_m_s3), dt_s)
        return Effort(rate, _clamped(wanted, -p.max_decel_m_s2, p.max_accel_m_s2), 0.0, 0.0)

    def _pedals(self, speed_m_s: float, steering_rad: float, dt_s: float) -> Effort:
        command, p = self.command, self._p
        rate = self._steering_rate(command.steer * p.max_steering_rad, 0.0, steering_rad, dt_s)
        push_n = _clamped(command.throttle, 0.0, 1.0) * self.push_limit_n(speed_m_s)
        brake_n = _clamped(command.brake, 0.0, 1.0) * p.mass_kg * p.max_decel_m_s2
        if command.hand_brake:
            brake_n += self._hand_brake_n()
        return Effort(rate, None, push_n, min(brake_n, p.grip_n))

    def _steering_rate(self, target_rad: float, limit_rad_s: float, steering_rad: float, dt_s: float) -> float:
        p = self._p
        most = min(limit_rad_s or math.inf, p.max_steering_rate_rad_s)
        target_rad = _clamped(target_rad, -p.max_steering_rad, p.max_steering_rad)
        return _clamped((target_rad - steering_rad) / dt_s, -most, most)

    def _hand_brake_n(self) -> float:
        """What locked rear wheels make."""
        return self._p.friction * self._p.rear_load_n


def _approach(accel: float, gap: float, limit: float, jerk: float, dt: float) -> float:
    """Return the acceleration of the next step on the fastest way to close a gap in speed without overshoot.

    With a limit of jerk the acceleration has to shrink in time: steps of it that become smaller by jerk * dt each close
    a gap of accel² / (2 jerk) + accel dt / 2 altogether, of which this is the inverse.
    """
    if jerk == 0.0:
        return _clamped(gap / dt, -limit, limit)
    change = jerk * dt
    shrinking = math.sqrt(change * change / 4 + 2 * jerk * abs(gap)) - change / 2
    wanted = math.copysign(min(shrinking, abs(gap) / dt, limit), gap)
    return _clamped(wanted, accel - change, accel + change)


def _clamped(value: float, least: float, most: float) -> float:
    return max(least, min(most, value))
