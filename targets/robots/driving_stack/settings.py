"""What the path-following driver can be set to. No source has this driver: every figure is a choice."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

__all__ = ["DriverSettings"]


@dataclass(frozen=True, slots=True, kw_only=True)
class DriverSettings:
    """A driver's habits and what it knows of the vehicle.

    Attributes:
        wheelbase_m: between the axles.
        steering_limit_rad: largest tyre angle asked for.
        steering_rate_rad_s: how fast the tyres are to turn.
        steering_sign: 1: positive steers to the left, as in ROS; -1: to the right.
        look_ahead_s: the point aimed at is so far ahead in time,
        look_ahead_least_m: but at least so far away,
        look_ahead_most_m: and at most so far.
        speed_m_s: on the straight.
        lateral_m_s2: in curves, the speed is what keeps the lateral acceleration below this.
        accel_m_s2: to gain speed.
        decel_m_s2: to lose it, a magnitude.
        jerk_m_s3: how fast the acceleration is to change.
        preview_s: the speed asked for is that of the profile so far ahead in time: as long as it takes to be reached.
        settle_s: time in which a difference in speed is to be made up.
        least_accel_m_s2: the acceleration asked for is never smaller, for 0 would mean as fast as possible
            (ackermann_msgs/AckermannDrive).
        stop_within_m: nearer to the end of an open path than this, it stands.
    """

    wheelbase_m: float = 2.85
    steering_limit_rad: float = 0.6
    steering_rate_rad_s: float = 0.6
    steering_sign: int = 1
    look_ahead_s: float = 0.6
    look_ahead_least_m: float = 4.0
    look_ahead_most_m: float = 15.0
    speed_m_s: float = 10.0
    lateral_m_s2: float = 2.0
    accel_m_s2: float = 1.5
    decel_m_s2: float = 1.5
    jerk_m_s3: float = 5.0
    preview_s: float = 0.3
    settle_s: float = 0.5
    least_accel_m_s2: float = 0.3
    stop_within_m: float = 0.3

    def __post_init__(self) -> None:
        """Checks the figures; ValueError names the wrong one."""
        if self.steering_sign not in (-1, 1):
            raise ValueError(f"steering_sign is {self.steering_sign}, neither 1 nor -1")
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name != "steering_sign" and not 0 < value < math.inf:
                raise ValueError(f"{field.name} is {value}, not above 0")
