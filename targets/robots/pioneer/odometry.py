"""Encoders and dead reckoning, with the controller's own idea of wheels and track.

The wheels' true angles are quantised to encoder ticks; everything the robot reports is computed from ticks, as in the
real one. The pose is integrated along exact arcs between two samples. Errors of the belief (wheel size, track, slip)
are settings and are zero by default.
"""

from __future__ import annotations

import math
import random
from collections import deque
from dataclasses import dataclass

from targets.robots.pioneer.settings import RobotSettings


@dataclass(frozen=True, slots=True, kw_only=True)
class Travel:
    """Way since power-on as the controller measures it: mm, and degrees unwrapped, counter-clockwise."""

    left_mm: float
    right_mm: float
    translation_mm: float
    rotation_deg: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Pose:
    """Dead-reckoned pose: mm, and degrees unwrapped, counter-clockwise."""

    x_mm: float
    y_mm: float
    heading_deg: float


class Odometer:
    """Turns wheel angles into ticks, wheel distances, wheel speeds and a pose.

    Args:
        settings: The controller's beliefs and errors.
        angles_rad: Wheel angles (left, right) that count as zero.
        seed: Of the slip noise.
    """

    def __init__(self, settings: RobotSettings, angles_rad: tuple[float, float], seed: int) -> None:
        self._settings = settings
        self._zero_rad = angles_rad
        self._noise = random.Random(seed)
        self._slip_mm = [0.0, 0.0]
        self._window_ns = settings.speed_window_ms * 1_000_000
        self._samples: deque[tuple[int, float, float]] = deque()
        self._reference_deg = 0.0
        self.ticks = (0, 0)
        self.travel = Travel(left_mm=0.0, right_mm=0.0, translation_mm=0.0, rotation_deg=0.0)
        self.pose = Pose(x_mm=0.0, y_mm=0.0, heading_deg=0.0)

    @property
    def zero_heading_deg(self) -> float:
        """Unwrapped rotation that is reported as heading 0 (moved by `set_origin`), degrees."""
        return self._reference_deg

    def wheel_rad_s(self, left_mm_s: float, right_mm_s: float) -> tuple[float, float]:
        """Turn wheel speeds in mm/s into rad/s, with the sizes the controller believes in."""
        radius_mm = self._settings.wheel_diameter_mm / 2
        left_mm = radius_mm * (1 + self._settings.left_wheel_error)
        right_mm = radius_mm * (1 + self._settings.right_wheel_error)
        return left_mm_s / left_mm, right_mm_s / right_mm

    def set_origin(self) -> None:
        """Make the present pose 0, 0, 0 (SETO). Encoder counts are untouched."""
        self._reference_deg = self.travel.rotation_deg
        self.pose = Pose(x_mm=0.0, y_mm=0.0, heading_deg=0.0)

    def update(self, angles_rad: tuple[float, float], now_ns: int) -> None:
        """Take the wheels' angles of this moment."""
        before = self.travel
        self.ticks = self._count(0, angles_rad[0]), self._count(1, angles_rad[1])
        self.travel = self._measure(before)
        self._integrate(before, self.travel)
        self._remember(now_ns)

    def wheel_speeds_mm_s(self) -> tuple[float, float]:
        """Mean wheel speeds (left, right) over the speed window that ended at the last update, mm/s."""
        if len(self._samples) < 2:
            return 0.0, 0.0
        start, end = self._samples[0], self._samples[-1]
        duration_s = (end[0] - start[0]) * 1e-9
        return (end[1] - start[1]) / duration_s, (end[2] - start[2]) / duration_s

    def _count(self, side: int, angle_rad: float) -> int:
        turns = (angle_rad - self._zero_rad[side]) / math.tau
        return round(turns * self._settings.encoder_ticks_per_turn)

    def _measure(self, before: Travel) -> Travel:
        s = self._settings
        mm_per_tick = s.mm_per_turn / s.encoder_ticks_per_turn
        left = self.ticks[0] * mm_per_tick * (1 + s.left_wheel_error)
        right = self.ticks[1] * mm_per_tick * (1 + s.right_wheel_error)
        if s.slip_noise_mm_per_sqrt_m:
            self._slip(0, left + self._slip_mm[0] - before.left_mm)
            self._slip(1, right + self._slip_mm[1] - before.right_mm)
        left, right = left + self._slip_mm[0], right + self._slip_mm[1]
        turned_rad = (right - left) / 2 / s.believed_half_track_mm
        return Travel(
            left_mm=left,
            right_mm=right,
            translation_mm=(left + right) / 2,
            rotation_deg=math.degrees(turned_rad),
        )

    def _slip(self, side: int, moved_mm: float) -> None:
        """Random walk whose deviation grows with the square root of the distance, however finely it is stepped."""
        deviation_mm = self._settings.slip_noise_mm_per_sqrt_m * math.sqrt(abs(moved_mm) / 1000)
        self._slip_mm[side] += self._noise.gauss(0.0, deviation_mm)

    def _integrate(self, before: Travel, after: Travel) -> None:
        """Exact for a constant ratio of the wheel speeds: the chord of the arc, along the mean heading."""
        turned_rad = math.radians(after.rotation_deg - before.rotation_deg)
        arc_mm = after.translation_mm - before.translation_mm
        half_rad = turned_rad / 2
        chord_mm = arc_mm * math.sin(half_rad) / half_rad if half_rad else arc_mm
        direction_rad = math.radians(self.pose.heading_deg) + half_rad
        self.pose = Pose(
            x_mm=self.pose.x_mm + chord_mm * math.cos(direction_rad),
            y_mm=self.pose.y_mm + chord_mm * math.sin(direction_rad),
            heading_deg=after.rotation_deg - self._reference_deg,
        )

    def _remember(self, now_ns: int) -> None:
        if self._samples and self._samples[-1][0] == now_ns:
            self._samples.pop()
        self._samples.append((now_ns, self.travel.left_mm, self.travel.right_mm))
        while len(self._samples) > 2 and self._samples[1][0] <= now_ns - self._window_ns:
            self._samples.popleft()
