"""The second implementation of `worlds.world.World`: a vehicle on an endless floor.

A vehicle that has a model of its own (`worlds.motion`) is moved by it, as everywhere. Any other has to stand on two
driven wheels side by side, and these never slip: the speed is the mean of the wheels' speeds, the turn rate their
difference over the track, and a step with constant wheel speeds is an exact arc. A wheel takes a commanded speed at
once and stops at once when released; mass, torque limits and the motor's response are not modelled, so joint torques
read 0 and nothing can stall. There are no obstacles, contacts or rays, so only an empty scene is accepted.

It keeps the interface honest, needs nothing but the standard library, and serves machines without PyBullet.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from worlds.errors import CapabilityError, UnknownNameError, WorldError
from worlds.motion import PlanarPose, PlanarVelocity
from worlds.scenes import Scene
from worlds.vehicles import Vehicle
from worlds.vehicles.model import DifferentialDrive
from worlds.world import Contact, JointState, Pose, Vector, Velocity, World


def open_world(scene: Scene, vehicle: Vehicle, step_hz: int) -> World:
    """Open a world on the plane; see `worlds.world.open_world`."""
    return PlaneWorld(scene, vehicle, step_hz)


class _Wheels:
    """Two wheels side by side, or none; what moves a vehicle on them."""

    pose: PlanarPose

    def __init__(self, drive: DifferentialDrive | None) -> None:
        self._drive = drive
        names = (drive.left, drive.right) if drive else ()
        self.angles_rad = dict.fromkeys(names, 0.0)
        self.speeds_rad_s = dict(self.angles_rad)
        self.commands_rad_s = dict(self.angles_rad)

    @property
    def velocity(self) -> PlanarVelocity:
        speed_m_s, turn_rad_s = self._motion()
        yaw_rad = self.pose.yaw_rad
        return PlanarVelocity(speed_m_s * math.cos(yaw_rad), speed_m_s * math.sin(yaw_rad), turn_rad_s)

    def advance(self, dt_s: float) -> None:
        """Move on along an arc."""
        self.speeds_rad_s.update(self.commands_rad_s)
        speed_m_s, turn_rad_s = self._motion()
        half_turn = turn_rad_s * dt_s / 2
        # The chord of the arc: its length shrinks with sin(h)/h, its direction is the middle one.
        chord_m = speed_m_s * dt_s * (math.sin(half_turn) / half_turn if half_turn else 1.0)
        x_m, y_m, yaw_rad = self.pose
        self.pose = PlanarPose(
            x_m + chord_m * math.cos(yaw_rad + half_turn),
            y_m + chord_m * math.sin(yaw_rad + half_turn),
            math.remainder(yaw_rad + 2 * half_turn, math.tau),
        )
        for joint, speed in self.speeds_rad_s.items():
            self.angles_rad[joint] += speed * dt_s

    def place(self, pose: PlanarPose) -> None:
        """Stand there, wheels released."""
        self.pose = pose
        self.commands_rad_s = dict.fromkeys(self.angles_rad, 0.0)
        self.speeds_rad_s = dict(self.commands_rad_s)

    def _motion(self) -> tuple[float, float]:
        """Forward speed in m/s and turn rate in rad/s."""
        assert self._drive is not None
        left = self.speeds_rad_s[self._drive.left] * self._drive.wheel_radius_m
        right = self.speeds_rad_s[self._drive.right] * self._drive.wheel_radius_m
        return (left + right) / 2, (right - left) / self._drive.track_m


class PlaneWorld:
    """A vehicle on an endless floor. Use `worlds.world.open_world`.

    Raises:
        WorldError: the scene has boxes, or the vehicle has neither a differential drive nor a model that moves it.
    """

    name = "plane"
    capabilities: frozenset[str] = frozenset()

    _z_m: float

    def __init__(self, scene: Scene, vehicle: Vehicle, step_hz: int) -> None:
        if not scene.endless:
            raise WorldError(f'physics "plane" has no obstacles, and scene {scene.name!r} does: use scene "empty"')
        if vehicle.drive is None and vehicle.motion is None:
            raise WorldError(f'physics "plane" can only drive two wheels side by side, not {vehicle.name!r}')
        self.scene = scene
        self.vehicle = vehicle
        self.step_hz = step_hz
        self.step_index = 0
        self.motion = vehicle.motion(scene.floor_friction) if vehicle.motion else None
        self._wheels = _Wheels(vehicle.drive)
        self._mover = self.motion or self._wheels
        self._closed = False
        self.place(scene.start.x_m, scene.start.y_m, scene.start.yaw_rad, scene.start.z_m)

    def step(self) -> None:
        """Advance by one step."""
        self._require_open()
        self._mover.advance(1 / self.step_hz)
        self.step_index += 1

    def command(self, joint: str, speed_rad_s: float, torque_limit_nm: float) -> None:
        """Set a wheel's speed from the next step on; a torque limit of 0 is a released wheel, any other is ample."""
        self._require_joint(joint)
        if not (math.isfinite(speed_rad_s) and 0 <= torque_limit_nm < math.inf):
            raise WorldError(f"{joint}: cannot command {speed_rad_s!r} rad/s with {torque_limit_nm!r} N·m")
        self._wheels.commands_rad_s[joint] = speed_rad_s if torque_limit_nm else 0.0

    def drive(self, joint: str, torque_nm: float, friction_nm: float | None = None) -> None:
        """Raise: a wheel without inertia has no answer to a torque."""
        del torque_nm, friction_nm
        self._require_joint(joint)
        raise CapabilityError('physics "plane" turns wheels at a speed, not by a torque')

    def release(self, joint: str) -> None:
        """Stop a wheel from the next step on."""
        self._require_joint(joint)
        self._wheels.commands_rad_s[joint] = 0.0

    def joint(self, joint: str) -> JointState:
        """Return a wheel's state; its torque is always 0."""
        self._require_joint(joint)
        wheels = self._wheels
        return JointState(angle_rad=wheels.angles_rad[joint], speed_rad_s=wheels.speeds_rad_s[joint], torque_nm=0.0)

    def pose(self) -> Pose:
        """Return where the vehicle is."""
        self._require_open()
        x_m, y_m, yaw_rad = self._mover.pose
        return Pose(position_m=(x_m, y_m, self._z_m), yaw_rad=yaw_rad)

    def velocity(self) -> Velocity:
        """Return how the vehicle moves."""
        self._require_open()
        x_m_s, y_m_s, yaw_rad_s = self._mover.velocity
        return Velocity(linear_m_s=(x_m_s, y_m_s, 0.0), angular_rad_s=(0.0, 0.0, yaw_rad_s))

    def cast(self, starts_m: Sequence[Vector], ends_m: Sequence[Vector], *, floor: bool = False) -> Sequence[float]:
        """Raise: there is nothing to hit."""
        del starts_m, ends_m, floor
        self._require_open()
        raise CapabilityError('physics "plane" has no rays')

    def contacts(self, part: str | None = None) -> Sequence[Contact]:
        """Raise: there is nothing to touch."""
        del part
        self._require_open()
        raise CapabilityError('physics "plane" has no contacts')

    def place(self, x_m: float, y_m: float, yaw_rad: float, z_m: float = 0.0) -> None:
        """Put the vehicle down at rest, wheels released."""
        self._require_open()
        self._z_m = z_m
        self._mover.place(PlanarPose(x_m, y_m, math.remainder(yaw_rad, math.tau)))

    def close(self) -> None:
        """Give the world up."""
        self._closed = True

    def _require_open(self) -> None:
        if self._closed:
            raise WorldError("the world is closed")

    def _require_joint(self, joint: str) -> None:
        self._require_open()
        if joint not in self._wheels.angles_rad:
            raise UnknownNameError("joint", joint, self._wheels.angles_rad)
