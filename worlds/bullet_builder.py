"""Fills a PyBullet client with a scene and a vehicle.

Settings that decide whether the motion is right, each tested:

- All damping 0. The default of 0.04 limits a fall to 15 m/s.
- Wheels are implicit cylinders. The default is a faceted hull, on which a vehicle hops.
- The floor's friction is 1.0, because the library multiplies the two surfaces' coefficients.
- ``deterministicOverlappingPairs`` on and a fixed loading order (floor, boxes, vehicle): the same run bit for bit.
- The solver works each step out to the end. By the library's defaults it stops while the wheels' motors and the floor's
  friction still disagree, and what is left over makes a robot at rest turn by 17 degrees in an hour.
"""

from __future__ import annotations

import math
import os
from typing import Any

from worlds.errors import WorldError
from worlds.scenes import Box, Scene
from worlds.vehicles import Vehicle
from worlds.vehicles.model import Axle
from worlds.vehicles.urdf import to_urdf

__all__ = ["BOX_GROUP", "FLOOR_GROUP", "MOVING_GROUP", "Builder"]

GRAVITY_M_S2 = 9.81

SOLVER_ITERATIONS = 200
SOLVER_RESIDUAL = 1e-14
"""The solver goes over the constraints in turn, at most so often, and stops once the largest speed it still corrects,
squared (m/s or rad/s), is below the residual. A motor that holds a light wheel under a heavy body comes only 5 % nearer
each time: with the library's 50 and 1e-7 a standing Pioneer creeps by 0.57 mm and 0.28 degrees a minute, with these by
0.0003 mm and 0.0001 degrees. A step takes 65 us instead of 25."""

SOFT_CONTACT_ERP = 0.02
"""Share of a penetration that a contact takes back within a step, for a vehicle that a motion of its own leads. It does
so by speed, which the motion then takes for its own: with the library's 0.08 a car that hits a wall at 10 m/s, and is
4 cm deep in it at the first step, comes back at up to 0.8 m/s."""

# Collision groups. The library itself uses the low six bits: 1 for what moves (and for rays), 2 for what does not.
MOVING_GROUP = 1
BOX_GROUP = 2
FLOOR_GROUP = 1 << 6
VEHICLE_GROUP = 1 << 7


class Builder:
    """Fills a client with a scene and a vehicle, always in the same order."""

    def __init__(self, bullet: Any, client: int) -> None:
        self._bullet = bullet
        self._at = {"physicsClientId": client}

    def build(self, scene: Scene, vehicle: Vehicle, step_hz: int) -> tuple[int, dict[int, str], dict[str, int]]:
        """Return the vehicle's id, the names of the other bodies by id, and the links by part name."""
        self._bullet.resetSimulation(**self._at)
        self._bullet.setGravity(0.0, 0.0, -GRAVITY_M_S2, **self._at)
        self._bullet.setPhysicsEngineParameter(
            fixedTimeStep=1 / step_hz,
            numSolverIterations=SOLVER_ITERATIONS,
            solverResidualThreshold=SOLVER_RESIDUAL,
            deterministicOverlappingPairs=1,
            enableFileCaching=0,
            **self._at,
        )
        if vehicle.motion:
            self._bullet.setPhysicsEngineParameter(contactERP=SOFT_CONTACT_ERP, **self._at)
        names = {self._floor(scene.floor_friction): "floor"}
        names.update((self._box(box), box.name) for box in scene.boxes)
        try:
            body, links = self._vehicle(vehicle)
        except self._bullet.error as problem:
            raise WorldError(f"the physics refused the vehicle {vehicle.name!r}: {problem}") from problem
        return body, names, links

    def _floor(self, friction: float) -> int:
        shape = self._bullet.createCollisionShape(self._bullet.GEOM_PLANE, planeNormal=(0.0, 0.0, 1.0), **self._at)
        floor: int = self._bullet.createMultiBody(0, shape, **self._at)
        self._surface(floor, -1, friction)
        # A group of its own, so that a sonar can look past the floor.
        self._bullet.setCollisionFilterGroupMask(floor, -1, FLOOR_GROUP, VEHICLE_GROUP | MOVING_GROUP, **self._at)
        return floor

    def _box(self, box: Box) -> int:
        length, width, height = box.size_m
        shape = self._bullet.createCollisionShape(
            self._bullet.GEOM_BOX, halfExtents=(length / 2, width / 2, height / 2), **self._at
        )
        sin_yaw, cos_yaw = math.sin(box.yaw_rad / 2), math.cos(box.yaw_rad / 2)
        sin_pitch, cos_pitch = math.sin(box.pitch_rad / 2), math.cos(box.pitch_rad / 2)
        turned = (-sin_yaw * sin_pitch, cos_yaw * sin_pitch, sin_yaw * cos_pitch, cos_yaw * cos_pitch)
        body: int = self._bullet.createMultiBody(
            0, shape, basePosition=box.center_m, baseOrientation=turned, **self._at
        )
        self._surface(body, -1, box.friction)
        return body

    def _vehicle(self, vehicle: Vehicle) -> tuple[int, dict[str, int]]:
        body = self._load(to_urdf(vehicle), fixed=vehicle.parts[0].mass_kg == 0)
        links = {vehicle.parts[0].name: -1}
        for index in range(self._bullet.getNumJoints(body, **self._at)):
            links[self._bullet.getJointInfo(body, index, **self._at)[12].decode()] = index
        for part in vehicle.parts:
            self._surface(body, links[part.name], part.friction)
            self._bullet.setCollisionFilterGroupMask(body, links[part.name], VEHICLE_GROUP, -1, **self._at)
            if part.axle is not None and part.axle.reflected_inertia_kg_m2:
                self._add_inertia(body, links[part.name], part.axle)
        return body, links

    def _add_inertia(self, body: int, link: int, axle: Axle) -> None:
        """Add inertia about an axle. Within the URDF it would make an impossible body, whose inertia becomes zero."""
        inertia = self._bullet.getDynamicsInfo(body, link, **self._at)[2]
        self._bullet.changeDynamics(
            body,
            link,
            localInertiaDiagonal=[
                own + abs(share) * axle.reflected_inertia_kg_m2 for own, share in zip(inertia, axle.axis, strict=True)
            ],
            **self._at,
        )

    def _load(self, urdf: str, *, fixed: bool) -> int:
        file = os.memfd_create("vehicle.urdf")
        try:
            os.write(file, urdf.encode())
            body: int = self._bullet.loadURDF(
                f"/proc/self/fd/{file}",
                useFixedBase=fixed,
                flags=self._bullet.URDF_USE_INERTIA_FROM_FILE | self._bullet.URDF_USE_IMPLICIT_CYLINDER,
                **self._at,
            )
        finally:
            os.close(file)
        return body

    def _surface(self, body: int, link: int, friction: float) -> None:
        self._bullet.changeDynamics(
            body,
            link,
            lateralFriction=friction,
            rollingFriction=0.0,
            spinningFriction=0.0,
            restitution=0.0,
            linearDamping=0.0,
            angularDamping=0.0,
            jointDamping=0.0,
            **self._at,
        )
