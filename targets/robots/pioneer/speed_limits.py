"""The speed and acceleration limits a client may change during a session.

SETV, SETRV, SETA and SETRA act on later commands, are clipped to the robot's tops, and fall back to the stored values
when the client leaves (Pioneer 2/3 H8 Operations Manual, motion commands).
"""

from __future__ import annotations

from targets.robots.pioneer.profile import Limits
from targets.robots.pioneer.settings import RobotSettings


class SessionLimits:
    """Current limits; a value of zero or less never gets in, so that a profile can always be made."""

    def __init__(self, settings: RobotSettings) -> None:
        self._settings = settings
        self.reset()

    def reset(self) -> None:
        """Back to the stored values."""
        s = self._settings
        self.translation = Limits(
            speed=s.translation_max_mm_s,
            acceleration=s.translation_acceleration_mm_s2,
            deceleration=s.translation_deceleration_mm_s2,
        )
        self.rotation = Limits(
            speed=s.rotation_max_deg_s,
            acceleration=s.rotation_acceleration_deg_s2,
            deceleration=s.rotation_deceleration_deg_s2,
        )

    @property
    def emergency_translation(self) -> Limits:
        """For E_STOP: the fastest deceleration the robot has, mm."""
        s = self._settings
        return Limits(
            speed=s.translation_top_mm_s,
            acceleration=s.emergency_deceleration_mm_s2,
            deceleration=s.emergency_deceleration_mm_s2,
        )

    @property
    def emergency_rotation(self) -> Limits:
        """For E_STOP: the fastest deceleration the robot has, degrees."""
        s = self._settings
        return Limits(
            speed=s.rotation_top_deg_s,
            acceleration=s.emergency_deceleration_deg_s2,
            deceleration=s.emergency_deceleration_deg_s2,
        )

    def set_translation_speed(self, mm_s: int) -> bool:
        """SETV, mm/s; False when the argument is not positive and nothing changed."""
        if mm_s <= 0:
            return False
        now = self.translation
        top = self._settings.translation_top_mm_s
        self.translation = Limits(
            speed=min(float(mm_s), top), acceleration=now.acceleration, deceleration=now.deceleration
        )
        return True

    def set_rotation_speed(self, deg_s: int) -> bool:
        """SETRV, deg/s; False when the argument is not positive and nothing changed."""
        if deg_s <= 0:
            return False
        now = self.rotation
        top = self._settings.rotation_top_deg_s
        self.rotation = Limits(
            speed=min(float(deg_s), top), acceleration=now.acceleration, deceleration=now.deceleration
        )
        return True

    def set_translation_acceleration(self, mm_s2: int) -> bool:
        """SETA: + acceleration, - deceleration, mm/s²; False for zero, which changes nothing."""
        if not mm_s2:
            return False
        self.translation = _with_rate(self.translation, mm_s2, self._settings.translation_acceleration_top_mm_s2)
        return True

    def set_rotation_acceleration(self, deg_s2: int) -> bool:
        """SETRA: + acceleration, - deceleration, deg/s²; False for zero, which changes nothing."""
        if not deg_s2:
            return False
        self.rotation = _with_rate(self.rotation, deg_s2, self._settings.rotation_acceleration_top_deg_s2)
        return True


def _with_rate(limits: Limits, rate: int, top: float) -> Limits:
    clipped = min(float(abs(rate)), top)
    if rate > 0:
        return Limits(speed=limits.speed, acceleration=clipped, deceleration=limits.deceleration)
    return Limits(speed=limits.speed, acceleration=limits.acceleration, deceleration=clipped)
