"""The second implementation of `worlds.world.World`: a wheeled vehicle on an endless floor.

Exact kinematics of two wheels that never slip: the speed is the mean of the wheels' speeds, the turn rate their
difference over the track, and a step with constant wheel speeds is an exact arc. A wheel takes a commanded speed at
once and stops at once when released; mass, torque limits and the motor's response are not modelled, so joint torques
read 0 and nothing can stall. There are no obstacles, contacts or rays, so only an empty scene is accepted.

It keeps the interface honest, needs nothing but the standard library, and serves machines without PyBullet.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from worlds.errors import CapabilityError, UnknownNameError, WorldError
from worlds.scenes import Scene
from worlds.vehicles import Vehicle
from worlds.world import Contact, JointState, Pose, Vector, Velocity, World


def open_world(scene: Scene, vehicle: Vehicle, step_hz: int) -> World:
    """Open a world on the plane; see `worlds.world.open_world`."""
    return PlaneWorld(scene, vehicle, step_hz)


class PlaneWorld:
    """A vehicle with a differential drive on an endless floor. Use `worlds.world.open_world`.

    Raises:
        WorldError: the scene has boxes, or the vehicle is not a differential drive.
    """

    name = "plane"
    capabilities: frozenset[str] = frozenset()

    _x_m: float
    _y_m: float
    _z_m: float
    _yaw_rad: float
    _speeds_rad_s: dict[str, float]
    _commands_rad_s: dict[str, float]

    def __init__(self, scene: Scene, vehicle: Vehicle, step_hz: int) -> None:
        if not scene.endless:
            raise WorldError(f'physics "plane" has no obstacles, and scene {scene.name!r} does: use scene "empty"')
        if vehicle.drive is None:
            raise WorldError(f'physics "plane" can only drive two wheels side by side, not {vehicle.name!r}')
        self.scene = scene
        self.vehicle = vehicle
        self.step_hz = step_hz
        self.step_index = 0
        self._drive = vehicle.drive
        self._angles_rad = dict.fromkeys((self._drive.left, self._drive.right), 0.0)
        self._closed = False
        self.place(scene.start.x_m, scene.start.y_m, scene.start.yaw_rad, scene.start.z_m)

    def step(self) -> None:
        """Advance by one step along an arc."""
        self._require_open()
        self._speeds_rad_s.update(self._commands_rad_s)
        dt_s = 1 / self.step_hz
        speed_m_s, turn_rad_s = self._motion()
        half_turn = turn_rad_s * dt_s / 2
        # The chord of the arc: its length shrinks with sin(h)/h, its direction is the middle one.
        chord_m = speed_m_s * dt_s * (math.sin(half_turn) / half_turn if half_turn else 1.0)
        self._x_m += chord_m * math.cos(self._yaw_rad + half_turn)
        self._y_m += chord_m * math.sin(self._yaw_rad + half_turn)
        self._yaw_rad = math.remainder(self._yaw_rad + 2 * half_turn, math.tau)
        for joint, speed in self._speeds_rad_s.items():
            self._angles_rad[joint] += speed * dt_s
        self.step_index += 1

    def command(self, joint: str, speed_rad_s: float, torque_limit_nm: float) -> None:
        """Set a wheel's speed from the next step on; a torque limit of 0 is a released wheel, any other is ample."""
        self._require_joint(joint)
        if not (math.isfinite(speed_rad_s) and 0 <= torque_limit_nm < math.inf):
            raise WorldError(f"{joint}: cannot command {speed_rad_s!r} rad/s with {torque_limit_nm!r} N·m")
        self._commands_rad_s[joint] = speed_rad_s if torque_limit_nm else 0.0

    def drive(self, joint: str, torque_nm: float, friction_nm: float | None = None) -> None:
        """Raise: a wheel without inertia has no answer to a torque."""
        del torque_nm, friction_nm
        self._require_joint(joint)
        raise CapabilityError('physics "plane" turns wheels at a speed, not by a torque')

    def release(self, joint: str) -> None:
        """Stop a wheel from the next step on."""
        self._require_joint(joint)
        self._commands_rad_s[joint] = 0.0

    def joint(self, joint: str) -> JointState:
        """Return a wheel's state; its torque is always 0."""
        self._require_joint(joint)
        return JointState(angle_rad=self._angles_rad[joint], speed_rad_s=self._speeds_rad_s[joint], torque_nm=0.0)

    def pose(self) -> Pose:
        """Return where the vehicle is."""
        self._require_open()
        return Pose(position_m=(self._x_m, self._y_m, self._z_m), yaw_rad=self._yaw_rad)

    def velocity(self) -> Velocity:
        """Return how the vehicle moves."""
        self._require_open()
        speed_m_s, turn_rad_s = self._motion()
        heading = (speed_m_s * math.cos(self._yaw_rad), speed_m_s * math.sin(self._yaw_rad), 0.0)
        return Velocity(linear_m_s=heading, angular_rad_s=(0.0, 0.0, turn_rad_s))

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
        self._x_m, self._y_m, self._z_m = x_m, y_m, z_m
        self._yaw_rad = math.remainder(yaw_rad, math.tau)
        self._commands_rad_s = dict.fromkeys(self._angles_rad, 0.0)
        self._speeds_rad_s = dict(self._commands_rad_s)

    def close(self) -> None:
        """Give the world up."""
        self._closed = True

    def _motion(self) -> tuple[float, float]:
        """Forward speed in m/s and turn rate in rad/s."""
        left = self._speeds_rad_s[self._drive.left] * self._drive.wheel_radius_m
        right = self._speeds_rad_s[self._drive.right] * self._drive.wheel_radius_m
        return (left + right) / 2, (right - left) / self._drive.track_m

    def _require_open(self) -> None:
        if self._closed:
            raise WorldError("the world is closed")

    def _require_joint(self, joint: str) -> None:
        self._require_open()
        if joint not in self._angles_rad:
            raise UnknownNameError("joint", joint, self._angles_rad)
