"""Trapezoidal velocity profiles, exact at any instant.

Theory of operation: a plan is a few phases of constant acceleration. It is computed once, when a motion command
arrives, from the position and speed of that moment, and then only *read*: position and speed at any later time follow
in closed form, so the result does not depend on how often the profile is stepped. A new command makes a new plan that
starts where the old one was (Pioneer 2 Operations Manual, client motion commands: the trapezoidal velocity function
is recomputed each time a new motion command is received).

Units are the caller's: mm or degrees; speeds are per second, accelerations per second squared.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """What a profile may use; all positive.

    Attributes:
        speed: Highest speed, units/s.
        acceleration: Rate at which the speed's magnitude may grow, units/s².
        deceleration: Rate at which it may shrink, units/s².
    """

    speed: float
    acceleration: float
    deceleration: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Phase:
    """A stretch of constant acceleration: `duration_s` seconds from `speed` with `acceleration`."""

    duration_s: float
    speed: float
    acceleration: float

    def travelled(self, elapsed_s: float) -> float:
        """Distance covered in the first `elapsed_s` seconds of the phase."""
        return (self.speed + 0.5 * self.acceleration * elapsed_s) * elapsed_s

    def speed_after(self, elapsed_s: float) -> float:
        """Speed `elapsed_s` seconds into the phase."""
        return self.speed + self.acceleration * elapsed_s


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """Phases in order, then `final_speed` for ever.

    Attributes:
        distance: Distance covered when the last phase ends; where the plan has a target, exactly that.
    """

    phases: tuple[Phase, ...]
    distance: float
    final_speed: float

    @property
    def duration_s(self) -> float:
        """Seconds until the final speed is reached."""
        return math.fsum(phase.duration_s for phase in self.phases)

    def at(self, elapsed_s: float) -> tuple[float, float]:
        """Return (distance since the plan's start, speed) after `elapsed_s` seconds, `elapsed_s` >= 0."""
        travelled = 0.0
        remaining_s = elapsed_s
        for phase in self.phases:
            if remaining_s < phase.duration_s:
                return travelled + phase.travelled(remaining_s), phase.speed_after(remaining_s)
            travelled += phase.travelled(phase.duration_s)
            remaining_s -= phase.duration_s
        return self.distance + self.final_speed * remaining_s, self.final_speed


def plan_speed(speed: float, target: float, limits: Limits) -> Plan:
    """Plan the change from `speed` to `target`: brake as far as needed, then accelerate.

    A change of direction brakes to zero with the deceleration and goes on with the acceleration. `target` is clipped to
    the speed limit.
    """
    target = max(-limits.speed, min(limits.speed, target))
    slowest = 0.0 if speed * target < 0 else min(speed, target, key=abs)
    ramps = [(speed, slowest, limits.deceleration), (slowest, target, limits.acceleration)]
    phases = tuple(_ramp(start, end, rate) for start, end, rate in ramps if start != end)
    return Plan(phases=phases, distance=_length(phases), final_speed=target)


def plan_distance(speed: float, distance: float, limits: Limits) -> Plan:
    """Plan to come to rest exactly `distance` ahead (signed) when moving at `speed` now.

    Where the brakes cannot stop in time, the plan overshoots, stops and comes back.
    """
    sign = math.copysign(1.0, distance if distance else -speed)
    phases = _reverse_first(sign * speed, sign * distance, limits)
    mirrored = tuple(
        Phase(duration_s=p.duration_s, speed=sign * p.speed, acceleration=sign * p.acceleration) for p in phases
    )
    return Plan(phases=mirrored, distance=distance, final_speed=0.0)


def _ramp(start: float, end: float, rate: float) -> Phase:
    return Phase(duration_s=abs(end - start) / rate, speed=start, acceleration=math.copysign(rate, end - start))


def _length(phases: Sequence[Phase]) -> float:
    return math.fsum(phase.travelled(phase.duration_s) for phase in phases)


def _reverse_first(speed: float, distance: float, limits: Limits) -> list[Phase]:
    """Phases for a distance >= 0; brakes first when going backwards or too fast to stop in time."""
    braking = speed * speed / (2 * limits.deceleration)
    if speed >= 0 and braking <= distance:
        return _trapezoid(speed, distance, limits)
    stop = _ramp(speed, 0.0, limits.deceleration)
    if speed < 0:
        return [stop, *_trapezoid(0.0, distance + braking, limits)]
    back = _trapezoid(0.0, braking - distance, limits)
    return [stop, *(Phase(duration_s=p.duration_s, speed=-p.speed, acceleration=-p.acceleration) for p in back)]


def _trapezoid(speed: float, distance: float, limits: Limits) -> list[Phase]:
    """Phases that cover `distance` from `speed` >= 0, with speed²/2d <= distance, ending at rest."""
    acceleration, deceleration = limits.acceleration, limits.deceleration
    peak_squared = (2 * acceleration * deceleration * distance + deceleration * speed * speed) / (
        acceleration + deceleration
    )
    peak = max(speed, math.sqrt(peak_squared))
    if peak <= limits.speed:
        ramps = [(speed, peak, acceleration), (peak, 0.0, deceleration)]
        return [_ramp(*ramp) for ramp in ramps if ramp[0] != ramp[1]]
    to_cruise = _ramp(speed, limits.speed, acceleration if speed < limits.speed else deceleration)
    stop = _ramp(limits.speed, 0.0, deceleration)
    cruise_s = max(0.0, distance - _length((to_cruise, stop))) / limits.speed
    return [to_cruise, Phase(duration_s=cruise_s, speed=limits.speed, acceleration=0.0), stop]
