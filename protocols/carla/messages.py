"""What is said through the frames: commands with their units, for the fields' meaning hangs on the mode byte."""

from __future__ import annotations

import math
from dataclasses import dataclass

from protocols.carla.frames import CommandFrame, Mode

__all__ = ["STEERING_FACTOR", "AckermannCommand", "ControlCommand", "ManualCommand", "command_in"]

STEERING_FACTOR = 1.2
"""By what the board multiplies the tyre's angle and rate for the simulator (microAutoware taksControl.c)."""

_GREATEST = (2 - 2**-23) * 2.0**127


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlCommand:
    """What the driving stack wants of the board: the fields of AckermannControlCommand that are used.

    Attributes:
        steering_rad: lateral.steering_tire_angle, positive to the left.
        steering_rate_rad_s: lateral.steering_tire_rotation_rate.
        speed_m_s: longitudinal.speed.
        acceleration_m_s2: longitudinal.acceleration.
        jerk_m_s3: longitudinal.jerk.
    """

    steering_rad: float = 0.0
    steering_rate_rad_s: float = 0.0
    speed_m_s: float = 0.0
    acceleration_m_s2: float = 0.0
    jerk_m_s3: float = 0.0

    def frame(self, factor: float = STEERING_FACTOR) -> CommandFrame:
        """The frame that hands it on, steering times the factor."""
        return CommandFrame(
            steering=_times(self.steering_rad, factor),
            steering_rate=_times(self.steering_rate_rad_s, factor),
            speed=self.speed_m_s,
            acceleration=self.acceleration_m_s2,
            jerk=self.jerk_m_s3,
            mode=Mode.AUTOWARE,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class AckermannCommand:
    """What the simulator is told in the modes AUTOWARE and EMERGENCY, for /carla/ego_vehicle/ackermann_cmd.

    Acceleration and jerk 0 mean "as fast as possible" there (ackermann_msgs/AckermannDrive).

    Attributes:
        steering_rad: the tyre's angle x 1.2, positive to the left.
        steering_rate_rad_s: its rate x 1.2.
        speed_m_s: wanted.
        acceleration_m_s2: wanted.
        jerk_m_s3: wanted.
    """

    steering_rad: float = 0.0
    steering_rate_rad_s: float = 0.0
    speed_m_s: float = 0.0
    acceleration_m_s2: float = 0.0
    jerk_m_s3: float = 0.0

    def frame(self, mode: int = Mode.AUTOWARE) -> CommandFrame:
        """The frame that says it."""
        return CommandFrame(
            steering=self.steering_rad,
            steering_rate=self.steering_rate_rad_s,
            speed=self.speed_m_s,
            acceleration=self.acceleration_m_s2,
            jerk=self.jerk_m_s3,
            mode=mode,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class ManualCommand:
    """What the simulator is told in the mode MANUAL, for /carla/ego_vehicle/vehicle_control_cmd: gear 1, forwards.

    Attributes:
        steer: -1..1, the joystick's x turned round; as CARLA has it, positive is to the right.
        throttle: 0..1.
        brake: 0..1.
    """

    steer: float = 0.0
    throttle: float = 0.0
    brake: float = 0.0

    def frame(self) -> CommandFrame:
        """The frame that says it."""
        return CommandFrame(steering=self.steer, speed=self.throttle, acceleration=self.brake, mode=Mode.MANUAL)


def _times(value: float, factor: float) -> float:
    """The product in 32 bits, which has infinities where it is too large."""
    product = value * factor
    return math.copysign(math.inf, product) if abs(product) > _GREATEST else product


def command_in(frame: CommandFrame) -> AckermannCommand | ManualCommand | None:
    """What a frame tells the simulator; None for a mode that nobody knows (`publish_to_carla` of the bridge)."""
    if frame.mode == Mode.MANUAL:
        return ManualCommand(steer=frame.steering, throttle=frame.speed, brake=frame.acceleration)
    if frame.mode in (Mode.AUTOWARE, Mode.EMERGENCY):
        return AckermannCommand(
            steering_rad=frame.steering,
            steering_rate_rad_s=frame.steering_rate,
            speed_m_s=frame.speed,
            acceleration_m_s2=frame.acceleration,
            jerk_m_s3=frame.jerk,
        )
    return None
