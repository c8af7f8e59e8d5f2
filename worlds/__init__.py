"""The vehicle and its surroundings: scenes, physics and sensors in SI units behind one narrow interface.

Importing this package loads neither numpy nor a physics library.
"""

from __future__ import annotations

from worlds.errors import (
    CapabilityError,
    PhysicsMissingError,
    PhysicsOutputError,
    SceneFileError,
    UnknownNameError,
    WorldError,
)
from worlds.scenes import Box, Scene, Start, find_scene, scene_names
from worlds.vehicles import Parameter, Vehicle, find_vehicle, vehicle_names
from worlds.world import (
    Contact,
    JointState,
    Pose,
    Velocity,
    World,
    default_physics,
    engine_of,
    open_world,
    physics_names,
)

__all__ = [
    "Box",
    "CapabilityError",
    "Contact",
    "JointState",
    "Parameter",
    "PhysicsMissingError",
    "PhysicsOutputError",
    "Pose",
    "Scene",
    "SceneFileError",
    "Start",
    "UnknownNameError",
    "Vehicle",
    "Velocity",
    "World",
    "WorldError",
    "default_physics",
    "engine_of",
    "find_scene",
    "find_vehicle",
    "open_world",
    "physics_names",
    "scene_names",
    "vehicle_names",
]
