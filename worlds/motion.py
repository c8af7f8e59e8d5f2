"""Vehicles whose motion is reckoned by a model of their own rather than left to wheels and contacts.

The model moves the vehicle in the plane; the physics says only whether it has run into something. Each step the model
is advanced, the body gets its velocity and the physics moves the body. If it touched nothing the body is put exactly
where the model is, so that no error of the physics adds up. If it did, the body is where the obstacle let it go, and
the model goes on from there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

__all__ = ["Carried", "Lead", "PlanarMotion", "PlanarPose", "PlanarVelocity"]


class PlanarPose(NamedTuple):
    """Where a vehicle's reference point is in the scene, metres, and the vehicle's heading, radians in -pi..pi."""

    x_m: float
    y_m: float
    yaw_rad: float


class PlanarVelocity(NamedTuple):
    """Velocity of a vehicle's reference point along the scene's axes, m/s, and its turn rate, rad/s."""

    x_m_s: float
    y_m_s: float
    yaw_rad_s: float


class PlanarMotion(Protocol):
    """A model of a vehicle that moves in the plane."""

    @property
    def pose(self) -> PlanarPose:
        """Where the vehicle is."""

    @property
    def velocity(self) -> PlanarVelocity:
        """How it moves."""

    def advance(self, dt_s: float) -> None:
        """Move on by a step of this length under the commands in force."""

    def place(self, pose: PlanarPose) -> None:
        """Stand still there, without commands."""

    def adopt(self, pose: PlanarPose, velocity: PlanarVelocity) -> None:
        """Go on from where an obstacle let the vehicle go, with the commands in force."""


class Carried(Protocol):
    """A body in a physics that can be put and pushed."""

    def carry(self, pose: PlanarPose, velocity: PlanarVelocity) -> None:
        """Put the body there, level, and give it this velocity for the next step."""

    def push(self, yaw_rad: float, velocity: PlanarVelocity) -> None:
        """Give the body, which heads there, this velocity for the next step."""

    def planar(self) -> tuple[PlanarPose, PlanarVelocity]:
        """Return where the body is and how it moves."""

    def contacts(self) -> Sequence[object]:
        """Return where it touched something in the last step."""


class Lead:
    """Lets a motion lead a body of the physics, as the module says.

    Args:
        motion: who leads.
        body: who is led.
    """

    def __init__(self, motion: PlanarMotion, body: Carried) -> None:
        self._motion = motion
        self._body = body

    def before_step(self, dt_s: float) -> None:
        """Advance the motion, and push the body along."""
        self._motion.advance(dt_s)
        self._body.push(self._motion.pose.yaw_rad, self._motion.velocity)

    def after_step(self) -> None:
        """Let the body follow the motion, or the motion the body."""
        if self._body.contacts():
            self._motion.adopt(*self._body.planar())
        self._body.carry(self._motion.pose, self._motion.velocity)
