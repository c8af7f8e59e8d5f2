"""One controlled axis: a reference that moves along a profile, and a servo that keeps the measured axis on it.

Pioneers use position control even for velocity commands: the reference position simply runs ahead at the commanded
speed (Pioneer 2/3 H8 Operations Manual, "ActivMedia robots in motion"). The reference is exact; the speed asked of
the wheels is the reference's mean speed over the coming step plus a bounded proportional correction of the measured
error. That lands on the target whatever the step length, and corrects what the wheels did not do.

The same class serves translation (mm), rotation (degrees) and a single wheel (mm).
"""

from __future__ import annotations

from dataclasses import dataclass

from targets.robots.pioneer.profile import Limits, Plan, plan_distance, plan_speed

_MOST_CORRECTED_PER_STEP = 0.5
"""Fraction of the error that one step may remove: keeps the servo stable with long steps."""

_A_MOMENT_S = 1e-6
"""How far ahead a reference at rest is looked at to see where it goes: shorter than any ramp."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedGoal:
    """Hold `speed` (units/s, signed).

    With `keeps_place` the way that is lost or gained against the reference is made good; without, only the speed
    counts, so that a robot that slid too far in an emergency does not creep back.
    """

    speed: float
    keeps_place: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class PositionGoal:
    """Come to rest at `position` (units, on the axis's unwrapped scale)."""

    position: float


Goal = SpeedGoal | PositionGoal
REST = SpeedGoal(speed=0.0)
HALT = SpeedGoal(speed=0.0, keeps_place=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Servo:
    """How hard the axis pulls the measured position to the reference.

    Attributes:
        gain_per_s: Speed asked for per unit of error, 1/s.
        window: Error beyond which the reference is set back to the measured position, units.
        correction: Most speed the servo adds to the profile, units/s.
    """

    gain_per_s: float
    window: float
    correction: float


class Axis:
    """Reference, goal and servo of one axis. Starts at rest at position 0."""

    def __init__(self, servo: Servo, limits: Limits) -> None:
        self._servo = servo
        self._limits = limits
        self._goal: Goal = REST
        self._held: Limits | None = None
        self._origin = 0.0
        self._elapsed_s = 0.0
        self._plan = plan_speed(0.0, 0.0, limits)

    @property
    def reference(self) -> tuple[float, float]:
        """Position (units) and speed (units/s) of the reference now."""
        travelled, speed = self._plan.at(self._elapsed_s)
        return self._origin + travelled, speed

    @property
    def setpoint(self) -> float:
        """Where the axis is to come to rest; for a speed goal, where the reference is now. Units."""
        if isinstance(self._goal, PositionGoal):
            return self._goal.position
        return self.reference[0]

    @property
    def direction(self) -> float:
        """+ or - while the reference moves or is about to, 0 while it rests (also on the watchdog's order)."""
        return self.reference[1] or self._plan.at(self._elapsed_s + _A_MOMENT_S)[1]

    def pursue(self, goal: Goal, limits: Limits) -> None:
        """Take a new goal with the limits of this moment, from the present position and speed."""
        self._goal = goal
        self._limits = limits
        self._replan(*self.reference)

    def hold(self, limits: Limits) -> None:
        """Come to rest within `limits` and keep the goal for `release` (watchdog)."""
        self._held = limits
        self._replan(*self.reference)

    def release(self) -> None:
        """Go on with the goal that `hold` interrupted, accelerating normally."""
        self._held = None
        self._replan(*self.reference)

    def rebase(self, measured: float, speed: float) -> None:
        """Put the reference on the `measured` position at `speed`, with the goal unchanged."""
        self._replan(measured, speed)

    def drop(self, reference: tuple[float, float], limits: Limits, goal: SpeedGoal = REST) -> None:
        """Forget the goal and its limits; go on from the `reference` (position, speed) to rest within `limits`."""
        self._goal = goal
        self._limits = limits
        self._held = None
        self._replan(*reference)

    def keep_place(self) -> None:
        """After `HALT`: from here on the axis stays where it is."""
        if self._goal == HALT:
            self._goal = REST

    def step(self, dt_s: float, measured: float) -> float:
        """Advance the reference by `dt_s` seconds and return the mean speed to drive with meanwhile, units/s."""
        position, speed = self.reference
        error = position - measured
        if abs(error) > self._servo.window or self._goal == HALT:
            self.rebase(measured, speed)
            position, error = measured, 0.0
        self._elapsed_s += dt_s
        profile_speed = (self.reference[0] - position) / dt_s
        correction = error * min(self._servo.gain_per_s, _MOST_CORRECTED_PER_STEP / dt_s)
        correction = _clip(correction, self._servo.correction)
        return _clip(profile_speed + correction, max(self._limits.speed, abs(profile_speed)))

    def _replan(self, position: float, speed: float) -> None:
        self._origin, self._elapsed_s = position, 0.0
        self._plan = self._make_plan(position, speed)

    def _make_plan(self, position: float, speed: float) -> Plan:
        if self._held is not None:
            return plan_speed(speed, 0.0, self._held)
        if isinstance(self._goal, PositionGoal):
            return plan_distance(speed, self._goal.position - position, self._limits)
        return plan_speed(speed, self._goal.speed, self._limits)


def _clip(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))
