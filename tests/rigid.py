"""The physics of rigid bodies that tests run on: each by its own mark, so that what is not installed is skipped.

What a test does to a body from outside has a helper here, as no `worlds.world.World` offers it.
"""

from __future__ import annotations

import importlib.util
import math

import pytest

from worlds.geometry import rotation, subtract, turn

__all__ = [
    "BULLET",
    "DEFAULT_IN_GATE",
    "MUJOCO",
    "RIGID",
    "deepest_m",
    "push",
    "put",
    "skip_without_its_library",
    "turn_joint",
]

_OTHER = "the gate has the other physics here, and both in most tests of worlds/"
BULLET = pytest.param("bullet", marks=pytest.mark.needs_bullet)
MUJOCO = pytest.param("mujoco", marks=pytest.mark.needs_mujoco)
RIGID = (BULLET, MUJOCO)
_DEFAULT = BULLET if importlib.util.find_spec("pybullet") else MUJOCO
DEFAULT_IN_GATE = [
    one if one is _DEFAULT else pytest.param(*one.values, marks=[*one.marks, pytest.mark.exhaustive(_OTHER)])
    for one in RIGID
]
"""Both, of which the gate has the one that is installed by default."""

_NEEDS = {"needs_bullet": ("pybullet",), "needs_mujoco": ("mujoco",), "needs_physics": ("pybullet", "mujoco")}
"""Of each mark the libraries, one of which has to be there."""


def skip_without_its_library(item):
    """Skip a test whose mark asks for a library that is not installed."""
    for mark, libraries in _NEEDS.items():
        if item.get_closest_marker(mark) and not any(importlib.util.find_spec(library) for library in libraries):
            pytest.skip(f"{' or '.join(libraries)} is not installed")


def push(world, linear_m_s, angular_rad_s=(0.0, 0.0, 0.0)):
    """Give the vehicle a velocity: of its centre of mass, and a turn rate along its axes."""
    if world.name == "bullet":
        world._engine.resetBaseVelocity(world._body, linear_m_s, angular_rad_s, physicsClientId=world._client)
    else:
        world._data.qvel[:6] = (*linear_m_s, *angular_rad_s)
    world._forget()


def put(world, center_m, pitch_rad):
    """Put the vehicle's centre of mass somewhere, turned about y."""
    half = math.sin(pitch_rad / 2), math.cos(pitch_rad / 2)
    if world.name == "bullet":
        turned = (0.0, half[0], 0.0, half[1])
        world._engine.resetBasePositionAndOrientation(world._body, center_m, turned, physicsClientId=world._client)
    else:
        arm = turn(rotation(0.0, pitch_rad), world.vehicle.parts[0].center_of_mass_m)
        world._data.qpos[:7] = (*subtract(center_m, arm), half[1], 0.0, half[0], 0.0)
    world._forget()


def turn_joint(world, joint, angle_rad):
    """Turn a joint to an angle, at rest."""
    if world.name == "bullet":
        world._engine.resetJointState(world._body, world._links[joint], angle_rad, 0.0, physicsClientId=world._client)
    else:
        world._data.qpos[world._joints[joint][0]] = angle_rad
    world._forget()


def deepest_m(world):
    """How deep the vehicle is in anything, metres; 0 where it is in nothing."""
    if world.name == "bullet":
        points = world._engine.getContactPoints(bodyA=world._body, physicsClientId=world._client)
        return max((-point[8] for point in points), default=0.0)
    return max((-distance for distance in world._data.contact.dist.tolist()), default=0.0)
