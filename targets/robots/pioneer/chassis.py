"""What the controller needs of a body; the bench supplies it from a world, tests from an ideal one."""

from __future__ import annotations

from typing import Protocol


class Chassis(Protocol):
    """Wheels, bumpers and sonar of the robot, seen from its controller."""

    def command_wheels(self, left_rad_s: float, right_rad_s: float) -> None:
        """Servo on: turn the wheels at these speeds, within the motors' torque limit."""

    def release_wheels(self) -> None:
        """Motors off: wheels free but for friction."""

    def wheel_angles_rad(self) -> tuple[float, float]:
        """Angles of the wheels (left, right), unwrapped, + forward."""

    def motor_loads(self) -> tuple[float, float]:
        """Torque of the motors (left, right) as a fraction of its limit, 0..1."""

    def bumpers(self) -> tuple[int, int]:
        """Pressed segments (front, rear), bit 0 = segment 1."""

    def sonar_range_m(self, number: int) -> float | None:
        """Fire the 0-based disc `number` and return the distance of its echo, None without one."""
