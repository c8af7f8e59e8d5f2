"""What every physics of rigid bodies does alike behind the `worlds.world.World` interface.

The commands in force, the lead of a vehicle that has a model of its own, what was read since the last step, and what a
closed world answers. An implementation adds the calls of its library.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, NoReturn

from worlds.errors import UnknownNameError, WorldError
from worlds.geometry import Matrix, Vector, rotation
from worlds.motion import Lead, PlanarPose, PlanarVelocity
from worlds.scenes import Scene
from worlds.vehicles import Vehicle
from worlds.world import CONTACTS, GRAVITY, RAYS, TORQUE, Contact, JointState, Pose, Velocity

__all__ = ["Closed", "RigidWorld", "level", "matrix_of"]


class RigidWorld(ABC):
    """A scene and a vehicle in a physics of rigid bodies.

    An implementation fills its library in its constructor, sets `_engine`, and then calls `_start`.
    """

    name: str
    capabilities = frozenset({RAYS, CONTACTS, GRAVITY, TORQUE})

    _engine: Any
    """The library; `Closed` once the world is closed, so that no call needs a check."""
    _commands: dict[str, tuple[float, float]]
    """Each joint's speed to aim at, rad/s, and the most torque to do it with, N·m."""
    _torques_nm: dict[str, float]
    _commands_changed: bool
    _torques_changed: bool
    """Whether the library has yet to hear of the commands, or of the torques, in force."""
    _placed: bool
    _height_m: float
    # What was read since the last step; None is not read yet.
    _joint_states: dict[str, JointState] | None
    _pose: Pose | None
    _frame_now: tuple[Vector, Matrix] | None
    _good: tuple[int, Vector, Matrix]
    """The last step in which the vehicle was seen to be somewhere, and where that was."""

    def __init__(self, scene: Scene, vehicle: Vehicle, step_hz: int) -> None:
        self.scene = scene
        self.vehicle = vehicle
        self.step_hz = step_hz
        self.step_index = 0
        self.motion = vehicle.motion(scene.floor_friction) if vehicle.motion else None
        self._lead = Lead(self.motion, self) if self.motion else None
        self._part_names = frozenset(part.name for part in vehicle.parts)
        self._frictions_nm = {part.name: part.axle.friction_nm for part in vehicle.parts if part.axle}
        self._forget()

    def step(self) -> None:
        """Advance by one step."""
        self._send()
        if self._lead:
            self._lead.before_step(1 / self.step_hz)
        self._advance()
        self.step_index += 1
        self._placed = False
        self._forget()
        if self._lead:
            self._lead.after_step()

    def command(self, joint: str, speed_rad_s: float, torque_limit_nm: float) -> None:
        """Drive a joint towards a speed with at most this torque."""
        if not (math.isfinite(speed_rad_s) and 0 <= torque_limit_nm < math.inf):
            raise WorldError(f"{joint}: cannot command {speed_rad_s!r} rad/s with {torque_limit_nm!r} N·m")
        self._set(joint, (speed_rad_s, torque_limit_nm), 0.0)

    def drive(self, joint: str, torque_nm: float, friction_nm: float | None = None) -> None:
        """Turn a joint by a torque, against its dry friction."""
        dry_nm = self._frictions_nm.get(joint, 0.0) if friction_nm is None else friction_nm
        if not (math.isfinite(torque_nm) and 0 <= dry_nm < math.inf):
            raise WorldError(f"{joint}: cannot drive with {torque_nm!r} N·m against {friction_nm!r} N·m")
        # A motor that aims at speed 0 with a limited torque is dry friction; the driving torque is added to it.
        self._set(joint, (0.0, dry_nm), torque_nm)

    def release(self, joint: str) -> None:
        """Let a joint turn freely but for its dry friction."""
        self._set(joint, (0.0, self._frictions_nm.get(joint, 0.0)), 0.0)

    def joint(self, joint: str) -> JointState:
        """Return a joint's state."""
        if self._joint_states is None:
            self._joint_states = self._read_joints()
        try:
            state = self._joint_states[joint]
        except KeyError:
            raise self._no_joint(joint) from None
        if not math.isfinite(state.angle_rad + state.speed_rad_s):
            self._lost()
        return state

    def pose(self) -> Pose:
        """Return where the vehicle is.

        Raises:
            WorldError: the physics has lost it: its place is no number any more.
        """
        if self._pose is None:
            position, frame = self._frame()
            self._pose = Pose(
                position_m=position,
                yaw_rad=math.atan2(frame[1][0], frame[0][0]),
                pitch_rad=math.asin(max(-1.0, min(1.0, -frame[2][0]))),
                roll_rad=math.atan2(frame[2][1], frame[2][2]),
            )
        return self._pose

    def velocity(self) -> Velocity:
        """Return how the vehicle moves."""
        if self.motion:
            x_m_s, y_m_s, yaw_rad_s = self.motion.velocity
            return Velocity(linear_m_s=(x_m_s, y_m_s, 0.0), angular_rad_s=(0.0, 0.0, yaw_rad_s))
        linear, angular = self._velocity()
        return Velocity(linear_m_s=linear, angular_rad_s=angular)

    def contacts(self, part: str | None = None) -> tuple[Contact, ...]:
        """Return where the vehicle touched something in the last step."""
        if part is not None and part not in self._part_names:
            raise UnknownNameError("part", part, self._part_names)
        # After it was placed the library still lists what was touched at the old place.
        return () if self._placed else self._read_contacts(part)

    def place(self, x_m: float, y_m: float, yaw_rad: float, z_m: float = 0.0) -> None:
        """Put the vehicle down at rest, joints released."""
        if not all(map(math.isfinite, (x_m, y_m, yaw_rad, z_m))):
            raise WorldError(f"cannot place the {self.vehicle.name!r} at {x_m!r}, {y_m!r}, {z_m!r} m, {yaw_rad!r} rad")
        self._put_at_rest((x_m, y_m, z_m), yaw_rad)
        self._commands = {joint: (0.0, friction) for joint, friction in self._frictions_nm.items()}
        self._torques_nm = {}
        self._commands_changed = self._torques_changed = True
        self._placed = True
        self._height_m = z_m
        self._good = self.step_index, (x_m, y_m, z_m), rotation(yaw_rad)
        if self.motion:
            self.motion.place(PlanarPose(x_m, y_m, yaw_rad))
        self._forget()

    def carry(self, pose: PlanarPose, velocity: PlanarVelocity) -> None:
        """Put the vehicle there, level and at its height, and give it a velocity; see `worlds.motion.Carried`."""
        self._put((pose.x_m, pose.y_m, self._height_m), pose.yaw_rad)
        self.push(pose.yaw_rad, velocity)

    @abstractmethod
    def push(self, yaw_rad: float, velocity: PlanarVelocity) -> None:
        """Give the vehicle, which heads there, a velocity; see `worlds.motion.Carried`."""

    def planar(self) -> tuple[PlanarPose, PlanarVelocity]:
        """Return where the vehicle is and how it moves, seen from above."""
        (x_m, y_m, _), (linear, angular) = self.pose().position_m, self._velocity()
        return PlanarPose(x_m, y_m, self.pose().yaw_rad), PlanarVelocity(linear[0], linear[1], angular[2])

    @abstractmethod
    def cast(self, starts_m: Sequence[Vector], ends_m: Sequence[Vector], *, floor: bool = False) -> list[float]:
        """Cast rays; the vehicle never stops one."""

    def close(self) -> None:
        """Give the world up."""
        if not isinstance(self._engine, Closed):
            self._give_up()
            self._engine = Closed()
            self._commands = {}
            self._torques_nm = {}
            self._commands_changed = self._torques_changed = False
            self._placed = False
            self._forget()

    def _start(self) -> None:
        """Put the vehicle where the scene has it start."""
        start = self.scene.start
        self.place(start.x_m, start.y_m, start.yaw_rad, start.z_m)

    @abstractmethod
    def _send(self) -> None:
        """Tell the library the commands in force, before a step."""

    @abstractmethod
    def _advance(self) -> None:
        """Let the library make one step."""

    @abstractmethod
    def _put_at_rest(self, where_m: Vector, yaw_rad: float) -> None:
        """Put the vehicle there, level and at rest, joints at the angles they have."""

    @abstractmethod
    def _put(self, where_m: Vector, yaw_rad: float) -> None:
        """Put the vehicle there, level."""

    @abstractmethod
    def _read_joints(self) -> dict[str, JointState]: ...

    @abstractmethod
    def _read_frame(self) -> tuple[Vector, Matrix]:
        """Reference point and rotation matrix."""

    @abstractmethod
    def _velocity(self) -> tuple[Vector, Vector]:
        """Of the reference point, and the turn rate; along the scene's axes."""

    @abstractmethod
    def _read_contacts(self, part: str | None) -> tuple[Contact, ...]: ...

    @abstractmethod
    def _give_up(self) -> None:
        """Let go of what the library holds for this world."""

    def _require_pairs(self, starts_m: Sequence[Vector], ends_m: Sequence[Vector]) -> None:
        if len(starts_m) != len(ends_m):
            raise WorldError(f"cannot cast rays: {len(starts_m)} begin and {len(ends_m)} end")

    def _frame(self) -> tuple[Vector, Matrix]:
        if self._frame_now is None:
            position, frame = self._read_frame()
            if not math.isfinite(sum(position) + frame[0][0]):
                self._lost()
            self._frame_now = position, frame
            self._good = self.step_index, position, frame
        return self._frame_now

    def _lost(self, why: str = "its state is no number any more") -> NoReturn:
        """Raise: the physics does not know of the vehicle any more."""
        step, (x, y, z), frame = self._good
        where = f"x {x:.3f} m, y {y:.3f} m, z {z:.3f} m, yaw {math.atan2(frame[1][0], frame[0][0]):.3f} rad"
        raise WorldError(
            f"physics {self.name!r} lost the {self.vehicle.name!r} in step {self.step_index}: {why}; "
            f"last seen in step {step} at {where}"
        )

    def _forget(self) -> None:
        self._joint_states = None
        self._pose = None
        self._frame_now = None

    def _set(self, joint: str, command: tuple[float, float], torque_nm: float) -> None:
        if joint not in self._commands:
            raise self._no_joint(joint)
        if self._commands[joint] != command:
            self._commands[joint] = command
            self._commands_changed = True
        if torque_nm != self._torques_nm.get(joint, 0.0):
            self._torques_nm[joint] = torque_nm
            self._torques_changed = True

    def _no_joint(self, joint: str) -> WorldError:
        if isinstance(self._engine, Closed):
            return WorldError(Closed.TEXT)
        return UnknownNameError("joint", joint, self.vehicle.joints)


class Closed:
    """Stands where the library was once a world is closed."""

    TEXT = "the world is closed"

    def __getattr__(self, name: str) -> Any:
        raise WorldError(self.TEXT)

    def __getitem__(self, place: Any) -> Any:
        raise WorldError(self.TEXT)

    def __setitem__(self, place: Any, value: Any) -> None:
        raise WorldError(self.TEXT)


def level(yaw_rad: float) -> tuple[float, float]:
    """Return the last and the first number of the quaternion of a turn about z: sine and cosine of half of it."""
    return math.sin(yaw_rad / 2), math.cos(yaw_rad / 2)


def matrix_of(x: float, y: float, z: float, w: float) -> Matrix:
    """Return the rotation matrix of a quaternion."""
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )
