"""A path-following driver: the driving stack's stand-in for closed loops.

Pure pursuit: the tyres are set so that the rear axle would roll on a circle through a point of the path ahead, the
farther ahead the faster the vehicle is (R. C. Coulter, Implementation of the Pure Pursuit Path Tracking Algorithm,
CMU-RI-TR-92-01; for a bicycle `tan(angle) = wheelbase * 2 sin(bearing) / distance`). The speed is that of a profile.

What it needs: the pose of the rear axle, which the original's stack gets from localisation, and the speed that the
board reports. It keeps nothing but how far along the path it is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from protocols.autoware import AckermannControlCommand, Time
from targets.robots.driving_stack.path import Path, Place
from targets.robots.driving_stack.profile import SpeedProfile
from targets.robots.driving_stack.settings import DriverSettings

__all__ = ["PathDriver", "Pose"]

SEARCH_M = 20.0
"""How far the vehicle may have come since the last command, along the path (choice: 2 s at full speed)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Pose:
    """Where the middle of the rear axle is, and where it points.

    Attributes:
        x_m: in the world.
        y_m: in the world.
        yaw_rad: positive to the left of the x axis.
    """

    x_m: float
    y_m: float
    yaw_rad: float


class PathDriver:
    """Drives along a path.

    Args:
        path: where to.
        settings: habits and limits.

    Attributes:
        path: where to.
        settings: habits and limits.
        profile: how fast.
        place: where the vehicle was at the last command, seen from the path; None before the first.
        travelled_m: how far along the path it has come since the first command, laps included.
    """

    def __init__(self, path: Path, settings: DriverSettings | None = None) -> None:
        self.path = path
        self.settings = settings or DriverSettings()
        self.profile = SpeedProfile(path, self.settings)
        self.place: Place | None = None
        self.travelled_m = 0.0

    @property
    def arrived(self) -> bool:
        """It is at the end of an open path; a closed one has none."""
        left_m = math.inf if self.place is None else self.path.length_m - self.place.s_m
        return not self.path.closed and left_m <= self.settings.stop_within_m

    def command(self, pose: Pose, speed_m_s: float, stamp: Time | None = None) -> AckermannControlCommand:
        """What is to be done now.

        Args:
            pose: of the rear axle.
            speed_m_s: forwards, as the board reports it.
            stamp: of the command; zero if None.

        Raises:
            ValueError: pose or speed are not finite: whoever has none of them must not be driven.
        """
        if not all(map(math.isfinite, (pose.x_m, pose.y_m, pose.yaw_rad, speed_m_s))):
            raise ValueError(f"nobody can drive from {pose} at {speed_m_s} m/s")
        place = self._progress(pose)
        speed = max(0.0, speed_m_s)
        angle_rad = self._steering_rad(pose, place, speed)
        target_m_s = self._target_m_s(place, speed)
        return AckermannControlCommand(
            stamp=stamp or Time(),
            steering_tire_angle=self.settings.steering_sign * angle_rad,
            steering_tire_rotation_rate=self.settings.steering_rate_rad_s,
            speed=target_m_s,
            acceleration=self._accel_m_s2(target_m_s - speed_m_s),
            jerk=self.settings.jerk_m_s3,
        )

    def _progress(self, pose: Pose) -> Place:
        if self.place is None:
            self.place = self.path.place(pose.x_m, pose.y_m)
            return self.place
        before_m = self.place.s_m
        self.place = self.path.place(pose.x_m, pose.y_m, near_m=before_m, within_m=SEARCH_M)
        gone_m = self.place.s_m - before_m
        if self.path.closed:
            gone_m = math.remainder(gone_m, self.path.length_m)
        self.travelled_m += gone_m
        return self.place

    def _steering_rad(self, pose: Pose, place: Place, speed_m_s: float) -> float:
        habits = self.settings
        ahead_m = min(max(habits.look_ahead_s * speed_m_s, habits.look_ahead_least_m), habits.look_ahead_most_m)
        aim_x, aim_y = self._aim(place.s_m + ahead_m)
        bearing_rad = math.atan2(aim_y - pose.y_m, aim_x - pose.x_m) - pose.yaw_rad
        distance_m = math.dist((aim_x, aim_y), (pose.x_m, pose.y_m))
        if distance_m <= 0.0:
            return 0.0
        angle_rad = math.atan2(2 * habits.wheelbase_m * math.sin(bearing_rad), distance_m)
        return min(max(angle_rad, -habits.steering_limit_rad), habits.steering_limit_rad)

    def _aim(self, s_m: float) -> tuple[float, float]:
        """The point so far along; behind the end of an open path, straight on."""
        x_m, y_m = self.path.point(s_m)
        beyond_m = 0.0 if self.path.closed else s_m - self.path.length_m
        if beyond_m <= 0.0:
            return x_m, y_m
        heading_rad = self.path.heading_rad(s_m)
        return x_m + beyond_m * math.cos(heading_rad), y_m + beyond_m * math.sin(heading_rad)

    def _target_m_s(self, place: Place, speed_m_s: float) -> float:
        if self.arrived:
            return 0.0
        creep_m_s = math.sqrt(2 * self.settings.decel_m_s2 * self.settings.stop_within_m)
        return max(self.profile.speed_m_s(place.s_m + self.settings.preview_s * speed_m_s), creep_m_s)

    def _accel_m_s2(self, wanted_m_s: float) -> float:
        habits = self.settings
        accel_m_s2 = min(max(wanted_m_s / habits.settle_s, -habits.decel_m_s2), habits.accel_m_s2)
        return math.copysign(max(abs(accel_m_s2), habits.least_accel_m_s2), accel_m_s2)
