"""From the simulator's car to the status frame, with the signs that the original's bridge gives it.

Source: LMA-FEM-UNICAMP/Carla-Autoware-Bridge, the velocity report from odometry and the steering report from CARLA's
normalised steer.
"""

from __future__ import annotations

from dataclasses import dataclass

from protocols.carla.frames import StatusFrame

__all__ = ["CARLA_STEER_RAD", "ORIGINAL_SIGNS", "ROS_SIGNS", "Signs"]

CARLA_STEER_RAD = 1.0292
"""The tyre's angle at CARLA's full steer, rad: the mean of 69.99 and 47.95 degrees, of the inner and outer wheel."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Signs:
    """What the car's own figures, in ROS axes (x forwards, y left, turns to the left positive), become in the frame.

    Attributes:
        lateral: the factor of the lateral speed.
        heading_rate: the factor of the yaw rate.
        steering: the factor of the tyre's angle, positive to the left.
        steer_rad: the tyre's angle, + left, at full steer of CARLA, which is positive to the right.
    """

    lateral: float = 1.0
    heading_rate: float = 1.0
    steering: float = 1.0
    steer_rad: float = -CARLA_STEER_RAD

    def tyre_rad(self, steer: float) -> float:
        """The tyre's angle, + left, for what CARLA says its steering is, -1 to 1, + right."""
        return self.steer_rad * steer

    def status(
        self, *, lon_speed_m_s: float, lat_speed_m_s: float, yaw_rate_rad_s: float, tyre_rad: float
    ) -> StatusFrame:
        """The status of a car that moves so."""
        return StatusFrame(
            lon_speed_m_s=lon_speed_m_s,
            lat_speed_m_s=self.lateral * lat_speed_m_s,
            heading_rate_rad_s=self.heading_rate * yaw_rate_rad_s,
            steering_rad=self.steering * tyre_rad,
        )


ROS_SIGNS = Signs()
"""As Autoware's messages define them."""
ORIGINAL_SIGNS = Signs(lateral=-1.0, heading_rate=-1.0)
"""As the original's bridge fills them: heading_rate is minus the yaw rate of odometry, lateral minus its y.

The tyre's angle is -1.0292 rad x CARLA's steer, which is positive to the right, so it is positive to the left here.
"""
