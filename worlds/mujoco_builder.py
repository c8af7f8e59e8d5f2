"""Makes a MuJoCo model of a scene and a vehicle.

Settings that decide whether the motion is right, each tested:

- Friction is given pair by pair, as the product of the two surfaces' coefficients: the library's own rule is the larger
  of the two. Nothing else collides, so no part of the vehicle meets another.
- Contacts are as hard as the library makes them, and their friction stops a sliding surface within one step, as dry
  friction does. By the library's defaults a contact yields like rubber, and what stands on a slope creeps.
- A motor is dry friction about a speed that need not be 0: a constraint with a limited torque, solved together with the
  contacts. It has no gain, so there is none that could blow up. The library's own servo takes a torque that grows with
  the error of the speed, and on a light wheel at 240 Hz it swings up until the numbers end.
- What turns with a joint through a gear counts about the joint alone (``armature``), and not where the vehicle turns.
- The Newton solver works each step out to its end.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from worlds.errors import WorldError
from worlds.scenes import Box, Scene
from worlds.vehicles import Vehicle
from worlds.vehicles.model import BoxShape, Part, Shape, SphereShape, Vector, parents

__all__ = ["BOX_GROUP", "FLOOR", "FLOOR_GROUP", "Built", "build"]

GRAVITY_M_S2 = 9.81

FLOOR = "floor"

# Groups of geometry, by which rays choose what stops them.
BOX_GROUP, FLOOR_GROUP, VEHICLE_GROUP = 0, 1, 2

HARDNESS = 0.9999
"""Impedance of every constraint, the largest the library takes: a ten-thousandth of what disturbs it is let through."""

CONTACT_S = 0.02
"""Time constant in which a contact, critically damped, takes a penetration back. It is what a contact gives when it
rests, too: 9.81 m/s² · (1 - hardness) · 0.02² s² is 0.4 nm."""

SOFT_CONTACT_S = 0.1
"""The same for a vehicle that a motion of its own leads, which takes the speed of being pushed out for its own: a car
that hits a wall at 10 m/s is 4 cm deep in it at the first step, and comes back at no more than 0.15 m/s."""

SOLVER_ITERATIONS = 200
SOLVER_TOLERANCE = 1e-15


@dataclass(frozen=True, slots=True)
class Built:
    """A model, and what its numbers mean.

    Attributes:
        model: the library's.
        parts: the vehicle's part of each geometry, by number; None for the scene's.
        others: the box of each geometry, or ``floor``; None for the vehicle's.
        joints: of each joint, its number in the vector of positions and in that of speeds.
    """

    model: Any
    parts: tuple[str | None, ...]
    others: tuple[str | None, ...]
    joints: dict[str, tuple[int, int]]


def build(mujoco: Any, scene: Scene, vehicle: Vehicle, step_hz: int) -> Built:
    """Make the model.

    Raises:
        WorldError: the library refuses the vehicle, or a part hangs on none that stands before it.
    """
    spec = mujoco.MjSpec()
    _options(mujoco, spec, step_hz)
    surfaces = {FLOOR: scene.floor_friction} | {box.name: box.friction for box in scene.boxes}
    _floor(mujoco, spec)
    for box in scene.boxes:
        _box(mujoco, spec, box)
    frictions = _vehicle(mujoco, spec, vehicle, step_hz)
    contact_s = SOFT_CONTACT_S if vehicle.motion else CONTACT_S
    for geom, (_, friction) in frictions.items():
        for other, surface in surfaces.items():
            _pair(spec, geom, _scene_name(other), friction * surface, step_hz, contact_s)
    try:
        model = spec.compile()
    except ValueError as problem:
        text = " ".join(str(problem).split())
        raise WorldError(f"the physics refused the vehicle {vehicle.name!r}: {text}") from problem
    names = [model.geom(number).name for number in range(model.ngeom)]
    scenery = {_scene_name(name): name for name in surfaces}
    joints = {joint: model.joint(joint) for joint in vehicle.joints}
    return Built(
        model,
        tuple(frictions[name][0] if name in frictions else None for name in names),
        tuple(scenery.get(name) for name in names),
        {name: (int(joint.qposadr[0]), int(joint.dofadr[0])) for name, joint in joints.items()},
    )


def _scene_name(name: str) -> str:
    """A box may be called like a part of the vehicle; here it must not."""
    return f"scene:{name}"


def _options(mujoco: Any, spec: Any, step_hz: int) -> None:
    option = spec.option
    option.timestep = 1 / step_hz
    option.gravity = (0.0, 0.0, -GRAVITY_M_S2)
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    option.iterations = SOLVER_ITERATIONS
    option.tolerance = SOLVER_TOLERANCE
    # Islands have copies of the constraints, which would not see a motor's speed; after bad numbers the library would
    # begin again from the start.
    option.disableflags = int(mujoco.mjtDisableBit.mjDSBL_ISLAND | mujoco.mjtDisableBit.mjDSBL_AUTORESET)


def _floor(mujoco: Any, spec: Any) -> None:
    spec.worldbody.add_geom(
        name=_scene_name(FLOOR), type=mujoco.mjtGeom.mjGEOM_PLANE, size=(0.0, 0.0, 1.0), group=FLOOR_GROUP, **_ALONE
    )


_ALONE = {"contype": 0, "conaffinity": 0}
"""Meets nothing but what a pair names."""


def _box(mujoco: Any, spec: Any, box: Box) -> None:
    length, width, height = box.size_m
    sin_yaw, cos_yaw = math.sin(box.yaw_rad / 2), math.cos(box.yaw_rad / 2)
    sin_pitch, cos_pitch = math.sin(box.pitch_rad / 2), math.cos(box.pitch_rad / 2)
    spec.worldbody.add_geom(
        name=_scene_name(box.name),
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=(length / 2, width / 2, height / 2),
        pos=box.center_m,
        quat=(cos_yaw * cos_pitch, -sin_yaw * sin_pitch, cos_yaw * sin_pitch, sin_yaw * cos_pitch),
        group=BOX_GROUP,
        **_ALONE,
    )


def _vehicle(mujoco: Any, spec: Any, vehicle: Vehicle, step_hz: int) -> dict[str, tuple[str, float]]:
    """Add the vehicle; return the part and the friction of each of its geometries."""
    frictions: dict[str, tuple[str, float]] = {}
    bodies: dict[str, tuple[Any, Vector]] = {}
    for part, parent in parents(vehicle):
        origin = part.axle.origin_m if part.axle else (0.0, 0.0, 0.0)
        if parent is None:
            body = spec.worldbody.add_body(name=part.name, mocap=part.mass_kg == 0)
            if part.mass_kg:
                body.add_freejoint()
        else:
            above, above_origin = bodies[parent]
            body = above.add_body(name=part.name, pos=_minus(origin, above_origin))
        bodies[part.name] = body, origin
        if part.mass_kg:
            body.mass = part.mass_kg
            body.ipos = _minus(part.center_of_mass_m, origin)
            body.inertia = part.inertia_kg_m2
            body.explicitinertial = True
        if part.axle is not None:
            _joint(mujoco, body, part, step_hz)
        for number, shape in enumerate(part.shapes):
            name = f"{part.name}:{number}"
            _shape(mujoco, body, name, shape, origin)
            frictions[name] = part.name, part.friction
    return frictions


def _joint(mujoco: Any, body: Any, part: Part, step_hz: int) -> None:
    assert part.axle is not None
    body.add_joint(
        name=part.name,
        type=mujoco.mjtJoint.mjJNT_HINGE,
        axis=part.axle.axis,
        armature=part.axle.reflected_inertia_kg_m2,
        solref_friction=_at_once(step_hz),
        solimp_friction=_HARD,
    )


_HARD = (HARDNESS, HARDNESS, 0.001, 0.5, 2.0)


def _at_once(step_hz: int) -> tuple[float, float]:
    """The library's stiffness and damping, negative, of a constraint that takes a speed back within one step."""
    return -1.0, -step_hz * HARDNESS


def _shape(mujoco: Any, body: Any, name: str, shape: Shape, origin: Vector) -> None:
    if isinstance(shape, BoxShape):
        length, width, height = shape.size_m
        kind, size = mujoco.mjtGeom.mjGEOM_BOX, (length / 2, width / 2, height / 2)
        quaternion = (math.cos(shape.yaw_rad / 2), 0.0, 0.0, math.sin(shape.yaw_rad / 2))
    elif isinstance(shape, SphereShape):
        kind, size, quaternion = mujoco.mjtGeom.mjGEOM_SPHERE, (shape.radius_m, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
    else:  # crowned, so that it stands on the middle of its tread; the two edges of a cylinder would scrub in turns
        kind, size = mujoco.mjtGeom.mjGEOM_ELLIPSOID, (shape.radius_m, shape.width_m / 2, shape.radius_m)
        quaternion = (1.0, 0.0, 0.0, 0.0)
    body.add_geom(
        name=name,
        type=kind,
        size=size,
        pos=_minus(shape.center_m, origin),
        quat=quaternion,
        group=VEHICLE_GROUP,
        **_ALONE,
    )


def _pair(spec: Any, geom: str, other: str, friction: float, step_hz: int, contact_s: float) -> None:
    spec.add_pair(
        geomname1=geom,
        geomname2=other,
        condim=3 if friction else 1,
        friction=(friction, friction, 0.0, 0.0, 0.0),
        solref=(max(contact_s, 2 / step_hz), 1.0),
        solreffriction=_at_once(step_hz),
        solimp=_HARD,
    )


def _minus(one: Vector, other: Vector) -> Vector:
    return one[0] - other[0], one[1] - other[1], one[2] - other[2]
