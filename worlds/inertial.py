"""What an inertial sensor at one place on the vehicle would feel, exactly: specific force and turn rate.

The specific force is the acceleration of the place less that of gravity, in the vehicle's own frame: 9.81 m/s² upwards
at rest, nothing in free fall. It comes from the difference of the place's velocity between two steps, so it is the mean
over the step that ended last, seen in the frame in which that step ended. The velocity of the place is that of the
reference point and the turn rate times the arm between them; its difference holds the centripetal part and that of a
changing turn rate as well.

Truth has no noise, no bias and no range: those belong to the sensor. An impact, or a vehicle that is put elsewhere
while it moves, is one step of a very large force, as the step is what the velocity changes in.
"""

from __future__ import annotations

from dataclasses import dataclass

from worlds.geometry import Vector, add, cross, rotation, subtract, turn, turn_back
from worlds.world import World

__all__ = ["STANDARD_GRAVITY_M_S2", "Felt", "InertialPoint"]

STANDARD_GRAVITY_M_S2 = 9.81
"""Gravity of the worlds, downwards along the scene's z."""

_GRAVITY_M_S2: Vector = (0.0, 0.0, -STANDARD_GRAVITY_M_S2)


@dataclass(frozen=True, slots=True, kw_only=True)
class Felt:
    """What is felt at a place: specific force in m/s² and turn rate in rad/s, both along the vehicle's axes."""

    specific_force_m_s2: Vector
    turn_rate_rad_s: Vector


class InertialPoint:
    """A place on a vehicle.

    Args:
        world: where the vehicle is.
        position_m: the place, vehicle frame.
    """

    def __init__(self, world: World, position_m: Vector) -> None:
        self._world = world
        self._position_m = position_m
        self._step = world.step_index
        self._velocity_m_s, _, _ = self._motion()
        self._felt = self._at_rest()

    def felt(self) -> Felt:
        """Return what was felt in the last step; before the first one, what is felt at rest.

        To be asked after every step: over several it would return the mean of all of them.
        """
        steps = self._world.step_index - self._step
        if steps:
            velocity, frame, turning = self._motion()
            change = subtract(velocity, self._velocity_m_s)
            acceleration = add((0.0, 0.0, 0.0), change, self._world.step_hz / steps)
            self._felt = Felt(
                specific_force_m_s2=turn_back(frame, subtract(acceleration, _GRAVITY_M_S2)),
                turn_rate_rad_s=turn_back(frame, turning),
            )
            self._step, self._velocity_m_s = self._world.step_index, velocity
        return self._felt

    def _motion(self) -> tuple[Vector, tuple[Vector, Vector, Vector], Vector]:
        """The velocity of the place, the vehicle's frame, and its turn rate; all of the scene."""
        pose, velocity = self._world.pose(), self._world.velocity()
        frame = rotation(pose.yaw_rad, pose.pitch_rad, pose.roll_rad)
        arm = turn(frame, self._position_m)
        return add(velocity.linear_m_s, cross(velocity.angular_rad_s, arm)), frame, velocity.angular_rad_s

    def _at_rest(self) -> Felt:
        _, frame, turning = self._motion()
        return Felt(
            specific_force_m_s2=turn_back(frame, subtract((0.0, 0.0, 0.0), _GRAVITY_M_S2)),
            turn_rate_rad_s=turn_back(frame, turning),
        )
