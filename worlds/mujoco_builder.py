"""Makes a MuJoCo model of a scene and a vehicle.

Settings that decide whether the motion is right, each tested:

- Friction is given pair by pair, as the product of the two surfaces' coefficients: the library's own rule is the larger
  of the two. Nothing else collides, so no part of the vehicle meets another.
- Contacts are hard, their friction is harder, and both stop a surface within one step. By the library's defaults what
  stands on a slope creeps.
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

from worlds.errors import PhysicsMissingError, WorldError
from worlds.importing import import_whole
from worlds.scenes import Box, Scene
from worlds.vehicles import Vehicle
from worlds.vehicles.model import BoxShape, Part, Shape, SphereShape, Vector, parents

__all__ = ["BOX_GROUP", "FLOOR", "FLOOR_GROUP", "Built", "build", "import_mujoco"]

GRAVITY_M_S2 = 9.81

FLOOR = "floor"

# Groups of geometry, by which rays choose what stops them.
BOX_GROUP, FLOOR_GROUP, VEHICLE_GROUP = 0, 1, 2

MOTOR_HARDNESS = 0.9999
"""Impedance of a motor's constraint, the largest there is: a ten-thousandth of what disturbs it is let through."""

MOTOR_YIELDS = 0.02
"""Of that ten-thousandth a fiftieth is left, as the library scales it with the inverse inertias that it has noted. What
is held on a slope creeps by 0.2 um a second, not by 10. With a thousandth the solver's search along a line is lost in
rounding."""


@dataclass(frozen=True, slots=True)
class Touch:
    """How surfaces meet.

    Attributes:
        hardness: impedance of a contact.
        friction_harder: by how much its friction yields less than itself, so that nothing creeps on a slope.
        pushed_out: share of a penetration that a contact takes back within a step.
    """

    hardness: float
    friction_harder: float
    pushed_out: float


STANDING = Touch(hardness=0.97, friction_harder=1e4, pushed_out=0.2)
"""What stands sinks in by 0.01 mm, so that four wheels share a weight. Harder, and rounding says which bear it."""

LED = Touch(hardness=0.9999, friction_harder=100.0, pushed_out=0.02)
"""For a vehicle that a motion of its own leads, which takes what speed an obstacle leaves it for its own, and that of
being pushed out: a car that hits a wall at 10 m/s is 4 cm deep in it at the first step, and comes back at no more than
0.2 m/s."""

TOUCHING_M = 1e-5
"""Surfaces nearer than this touch: what is put on the floor does not first fall for a step, and rests this high."""

LEAST_FRICTION = 1e-5
"""The library takes none below. A contact always has its two directions of friction, so that all are laid out alike."""

SOLVER_ITERATIONS = 200
SOLVER_TOLERANCE = 1e-15


@dataclass(frozen=True, slots=True)
class Built:
    """A model, and what its numbers mean.

    Attributes:
        model: the library's.
        pairs: of each two geometries that can meet, by number in either order: the vehicle's part, the box or
            ``floor``, the friction, and at what speed of sliding, m/s, it stops them within a step, under the
            vehicle's own weight.
        joints: of each joint, its number in the vector of positions and in that of speeds.
    """

    model: Any
    pairs: dict[tuple[int, int], tuple[str, str, float, float]]
    joints: dict[str, tuple[int, int]]


def import_mujoco() -> Any:
    """Return the library.

    Raises:
        PhysicsMissingError: it is not installed.
    """
    try:
        mujoco = import_whole("mujoco")
    except ImportError as problem:
        raise PhysicsMissingError(
            "MuJoCo is not installed for this Python: run `pip install mujoco-core==4.0.1`, or choose another physics"
        ) from problem
    return mujoco


def build(mujoco: Any, scene: Scene, vehicle: Vehicle, step_hz: int) -> Built:
    """Make the model.

    Raises:
        WorldError: the library refuses scene or vehicle, or a part hangs on none that stands before it.
    """
    spec = mujoco.MjSpec()
    touch = LED if vehicle.motion else STANDING
    _options(mujoco, spec, step_hz)
    spec.option.impratio = touch.friction_harder
    if vehicle.motion:  # it is carried at its height; a weight would only rub it down what it runs into
        spec.option.gravity = (0.0, 0.0, 0.0)
    surfaces = {FLOOR: scene.floor_friction} | {box.name: box.friction for box in scene.boxes}
    try:
        _floor(mujoco, spec)
        for box in scene.boxes:
            _box(mujoco, spec, box)
        frictions = _vehicle(mujoco, spec, vehicle, step_hz)
        meetings = [
            (geom, _scene_name(other), part, other, max(friction * surface, LEAST_FRICTION))
            for geom, (part, friction) in frictions.items()
            for other, surface in surfaces.items()
        ]
        for geom, scenery, _, _, friction in meetings:
            _pair(spec, geom, scenery, friction, step_hz, touch)
        model = spec.compile()
    except ValueError as problem:
        text = " ".join(str(problem).split())
        raise WorldError(f"the physics refused {vehicle.name!r} in scene {scene.name!r}: {text}") from problem
    model.dof_invweight0 *= MOTOR_YIELDS
    numbers = {model.geom(number).name: number for number in range(model.ngeom)}
    pairs = {}
    for geom, scenery, part, other, friction in meetings:
        one, another = numbers[geom], numbers[scenery]
        pairs[one, another] = pairs[another, one] = part, other, friction, friction * (GRAVITY_M_S2 / step_hz)
    joints = {joint: model.joint(joint) for joint in vehicle.joints}
    return Built(model, pairs, {name: (int(joint.qposadr[0]), int(joint.dofadr[0])) for name, joint in joints.items()})


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
        solref_friction=_within_a_step(step_hz, MOTOR_HARDNESS),
        solimp_friction=_impedance(MOTOR_HARDNESS),
    )


def _impedance(hardness: float) -> tuple[float, ...]:
    """As the library wants it: the same however deep; what follows says how it would grow."""
    return hardness, hardness, 0.001, 0.5, 2.0


def _within_a_step(step_hz: int, hardness: float, pushed_out: float = 0.0) -> tuple[float, float]:
    """The library's stiffness and damping, negative, of a constraint that takes a speed back within one step.

    And a share of a distance. The library would take a stiffness of 0 for a time constant.
    """
    return -max(pushed_out * (step_hz * hardness) ** 2, 1.0), -step_hz * hardness


def _shape(mujoco: Any, body: Any, name: str, shape: Shape, origin: Vector) -> None:
    if isinstance(shape, BoxShape):
        length, width, height = shape.size_m
        kind, size = mujoco.mjtGeom.mjGEOM_BOX, (length / 2, width / 2, height / 2)
        quaternion = (math.cos(shape.yaw_rad / 2), 0.0, 0.0, math.sin(shape.yaw_rad / 2))
    elif isinstance(shape, SphereShape):
        kind, size, quaternion = mujoco.mjtGeom.mjGEOM_SPHERE, (shape.radius_m, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
    else:  # crowned, so that it stands on its middle; on the edges of a cylinder a Pioneer turns 0.6 % too slowly
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


def _pair(spec: Any, geom: str, other: str, friction: float, step_hz: int, touch: Touch) -> None:
    spec.add_pair(
        geomname1=geom,
        geomname2=other,
        condim=3,
        friction=(friction, friction, 0.0, 0.0, 0.0),
        margin=TOUCHING_M,
        solref=_within_a_step(step_hz, touch.hardness, touch.pushed_out),
        solreffriction=_within_a_step(step_hz, touch.hardness),
        solimp=_impedance(touch.hardness),
    )


def _minus(one: Vector, other: Vector) -> Vector:
    return one[0] - other[0], one[1] - other[1], one[2] - other[2]
