"""The one interface to the surroundings, and how to open it.

SI units throughout; x forward, y left, z up, yaw counter-clockwise seen from above. Nothing here loads numpy,
PyBullet or MuJoCo: the implementation is imported when a world is opened.

Three implementations: ``bullet`` and ``mujoco`` (rigid bodies, contacts, rays; what they have in common is in
`worlds.rigid`) and ``plane`` (a vehicle on an endless floor, without contacts or rays).
"""

from __future__ import annotations

import contextlib
import importlib
import importlib.metadata
import importlib.util
from collections.abc import Sequence
from types import MappingProxyType
from typing import Literal, NamedTuple, Protocol

from worlds.errors import UnknownNameError, WorldError
from worlds.motion import PlanarMotion
from worlds.scenes import Scene, find_scene
from worlds.vehicles import Vehicle, find_vehicle

Vector = tuple[float, float, float]

RAYS = "rays"
CONTACTS = "contacts"
GRAVITY = "gravity"
TORQUE = "torque"

_PHYSICS = MappingProxyType({"bullet": "worlds.bullet", "mujoco": "worlds.mujoco", "plane": "worlds.plane"})

_LIBRARIES = MappingProxyType({"bullet": "pybullet", "mujoco": "mujoco"})
_ENGINES = MappingProxyType({"bullet": ("PyBullet", ("pybullet",)), "mujoco": ("MuJoCo", ("mujoco-core",))})


class JointState(NamedTuple):
    """A joint: angle in radians, never wrapped; speed in rad/s; torque on it in the last step, N·m.

    The torque is what its motor applied; of a driven joint, the driving torque less what dry friction took of it.
    """

    angle_rad: float
    speed_rad_s: float
    torque_nm: float


class Pose(NamedTuple):
    """Where the vehicle's reference point is and how it is turned.

    ``position_m`` is in the scene's frame. The turn is yaw about z, then pitch about the new y (positive lowers the
    nose), then roll about the new x; yaw and roll lie in -pi..pi, pitch in -pi/2..pi/2, radians.
    """

    position_m: Vector
    yaw_rad: float
    pitch_rad: float = 0.0
    roll_rad: float = 0.0


class Velocity(NamedTuple):
    """Velocity of the vehicle's reference point in m/s and turn rate in rad/s, both in the scene's frame."""

    linear_m_s: Vector
    angular_rad_s: Vector


class Contact(NamedTuple):
    """One point where the vehicle touches something.

    Attributes:
        part: the vehicle's part.
        other: the box touched, or ``floor``.
        position_m: where, in the vehicle's frame.
        normal_force_n: how hard in the last step. At an impact this peaks by a factor of twenty and depends on the
            step rate: judge by presence.
    """

    part: str
    other: str
    position_m: Vector
    normal_force_n: float


class World(Protocol):
    """A scene with one vehicle in it, advanced in equal steps.

    The same scene, vehicle, step rate and calls in the same order give the same states bit for bit on one platform.
    A world belongs to one thread. The methods of a capability it lacks raise `worlds.errors.CapabilityError`; every
    method raises `WorldError` after `close`.
    """

    @property
    def name(self) -> str:
        """Which implementation: ``bullet``, ``mujoco`` or ``plane``."""

    @property
    def capabilities(self) -> frozenset[str]:
        """Which of ``rays``, ``contacts``, ``gravity`` and ``torque`` it has."""

    @property
    def scene(self) -> Scene:
        """What surrounds the vehicle."""

    @property
    def vehicle(self) -> Vehicle:
        """What the vehicle is made of."""

    @property
    def motion(self) -> PlanarMotion | None:
        """What moves a vehicle that has a model of its own (`worlds.vehicles.Vehicle.motion`); None for any other."""

    @property
    def step_hz(self) -> int:
        """Steps per second of simulated time."""

    @property
    def step_index(self) -> int:
        """Steps since the world was opened."""

    def step(self) -> None:
        """Advance by 1 / ``step_hz`` seconds under the commands in force."""

    def command(self, joint: str, speed_rad_s: float, torque_limit_nm: float) -> None:
        """Drive a joint towards a speed from the next step on, with no more than this torque (N·m, >= 0).

        Raises:
            UnknownNameError: no such joint.
            WorldError: a speed or torque that is not finite, or a negative torque.
        """

    def drive(self, joint: str, torque_nm: float, friction_nm: float | None = None) -> None:
        """Turn a joint by a torque from the next step on, whatever speed that gives.

        Args:
            joint: which.
            torque_nm: about the joint's axis, N·m; it stays the same until the joint is told something else.
            friction_nm: dry friction that opposes the motion and holds a joint at rest, N·m, >= 0; None for the
                joint's own.

        Raises:
            UnknownNameError: no such joint.
            WorldError: a torque or friction that is not finite, or a negative friction.
            CapabilityError: this world lacks ``torque``.
        """

    def release(self, joint: str) -> None:
        """Let a joint turn freely but for its own dry friction, from the next step on; as it is after opening."""

    def joint(self, joint: str) -> JointState:
        """Return a joint's state. Raises `UnknownNameError` where there is none of that name."""

    def pose(self) -> Pose:
        """Return where the vehicle is."""

    def velocity(self) -> Velocity:
        """Return how the vehicle moves."""

    def cast(self, starts_m: Sequence[Vector], ends_m: Sequence[Vector], *, floor: bool = False) -> Sequence[float]:
        """Cast rays in the scene's frame.

        Args:
            starts_m: where each ray begins, metres; any sequence of triples, an (n, 3) array too.
            ends_m: where each ends.
            floor: whether the floor stops a ray. Boxes always do, the vehicle itself never does.

        Returns:
            For each ray the fraction of its length at which it hits, 1.0 where it hits nothing. What stops a ray that
            begins inside of something is up to the physics.
        """

    def contacts(self, part: str | None = None) -> Sequence[Contact]:
        """Return where the vehicle touched something in the last step, or only one part of it.

        Empty before the first step and after `place`.
        """

    def place(self, x_m: float, y_m: float, yaw_rad: float, z_m: float = 0.0) -> None:
        """Put the vehicle down somewhere at rest, level, all joints released at the angles they have.

        ``z_m`` is the height of the reference point over the floor. Nothing stops you from putting it into a wall.
        """

    def close(self) -> None:
        """Give the world up. Closing twice is fine."""


def physics_names() -> tuple[str, ...]:
    """Return the names of the implementations, installed or not."""
    return tuple(_PHYSICS)


def default_physics() -> Literal["bullet", "mujoco"]:
    """Return ``bullet`` where PyBullet is installed, else ``mujoco``; which of them runs, everything says that runs."""
    return "bullet" if physics_is_there("bullet") else "mujoco"


def physics_is_there(physics: str) -> bool:
    """Return whether the library for this physics is installed; ``plane`` needs none."""
    module = _LIBRARIES.get(physics)
    return module is None or _is_installed(module)


def _is_installed(module: str) -> bool:
    spec = importlib.util.find_spec(module)
    return spec is not None and spec.origin is not None  # a folder that happens to be called so has no origin


def engine_of(physics: str) -> str:
    """Return the library that computes this physics, with its version, for example ``PyBullet 3.2.7``.

    Without loading it. One that is not there is ``PyBullet, not installed``; ``plane``, which needs none, has ``""``.
    """
    title, distributions = _ENGINES.get(physics, ("", ()))
    if not physics_is_there(physics):
        return f"{title}, not installed"
    for distribution in distributions:
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            return f"{title} {importlib.metadata.version(distribution)}"
    return title


def open_world(
    scene: Scene | str, vehicle: Vehicle | str, physics: str | None = None, step_hz: int = 240, seed: int = 0
) -> World:
    """Open a world with the vehicle at rest at the scene's start and step index 0.

    Args:
        scene: a scene, the name of a built-in one, or a path to a scene file ending in ``.toml``.
        vehicle: a vehicle or the name of a built-in one.
        physics: ``bullet``, ``mujoco``, or ``plane`` where contacts and rays are not needed; `default_physics` if None.
        step_hz: steps per second; 240 is enough for robots, an odd figure is as good.
        seed: which placement, for scenes that place boxes at random.

    Raises:
        UnknownNameError: no such scene, vehicle or physics; the nearest name is in the text.
        SceneFileError: the scene file cannot be read or is not a scene.
        PhysicsMissingError: the physics library is not installed; the text says how to get it.
        PhysicsOutputError: the library warned while loading.
        WorldError: the step rate is not a positive whole number, or this physics cannot hold this scene or vehicle.
    """
    if type(step_hz) is not int or step_hz < 1:
        raise WorldError(f"step_hz must be a whole number of at least 1, not {step_hz!r}")
    physics = default_physics() if physics is None else physics
    if physics not in _PHYSICS:
        raise UnknownNameError("physics", physics, _PHYSICS)
    found_scene = find_scene(scene, seed) if isinstance(scene, str) else scene
    found_vehicle = find_vehicle(vehicle) if isinstance(vehicle, str) else vehicle
    opener = importlib.import_module(_PHYSICS[physics])
    world: World = opener.open_world(found_scene, found_vehicle, step_hz)
    return world
