"""What every physics of rigid bodies does alike behind the `worlds.world.World` interface.

The commands in force, the lead of a vehicle that has a model of its own, what was read since the last step, and what a
closed world answers. An implementation adds the calls of its library.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from typing import Any, NoReturn

from worlds.errors import UnknownNameError, WorldError
from worlds.geometry import Matrix, Vector
from worlds.motion import Lead, PlanarPose, PlanarVelocity
from worlds.scenes import Scene
from worlds.vehicles import Vehicle
from worlds.world import CONTACTS, GRAVITY, RAYS, TORQUE, Contact, JointState, Pose, Velocity

__all__ = ["Closed", "Quaternion", "RigidWorld", "level", "new"]

Quaternion = tuple[float, float, float, float]
"""x, y, z, w."""

new = tuple.__new__
"""Makes a named tuple at half the cost of a call of its class."""


class RigidWorld(ABC):
    """A scene and a vehicle in a physics of rigid bodies.

    An implementation fills its library in its constructor, sets `_engine`, and then calls `_start`.
    """

    name: str
    capabilities = frozenset({RAYS, CONTACTS, GRAVITY, TORQUE})

    _engine: Any
    """The library; `Closed` once the world is closed, so that no call needs a check."""
    _numbers: dict[str, int]
    """Where each joint stands in the lists of joints, in the library's order; none once the world is closed."""
    # The commands in force, by joint.
    _aims_rad_s: list[float]
    _limits_nm: list[float]
    """The most torque to reach the aim with."""
    _torques_nm: list[float]
    """What turns a joint besides."""
    _limits_changed: bool
    _torques_changed: bool
    """Whether the library has yet to hear of the limits, or of the torques, in force."""
    _placed: bool
    _height_m: float
    # What was read since the last step; None is not read yet.
    _joint_states: dict[str, JointState] | None
    _pose: Pose | None
    _frame: Matrix
    """How the vehicle is turned; as old as the pose."""
    _lever_m: Vector | None = None
    """From the reference point to the place that the library speaks of, vehicle frame; None where that is the same."""
    _arm_m: Vector
    """The lever along the scene's axes; as old as the pose."""
    _good: tuple[int, Pose]
    """The last step in which the vehicle was seen to be somewhere, and where that was."""

    def __init__(self, scene: Scene, vehicle: Vehicle, step_hz: int) -> None:
        self.scene = scene
        self.vehicle = vehicle
        self.step_hz = step_hz
        self.step_index = 0
        self.motion = vehicle.motion(scene.floor_friction) if vehicle.motion else None
        self._lead = Lead(self.motion, self) if self.motion else None
        self._frictions_nm = {part.name: part.axle.friction_nm for part in vehicle.parts if part.axle}

    def step(self) -> None:
        """Advance by one step."""
        lead = self._lead
        if lead:
            lead.before_step(1 / self.step_hz)
        self._advance()
        self.step_index += 1
        self._placed = False
        self._joint_states = self._pose = None
        if lead:
            lead.after_step()

    def command(self, joint: str, speed_rad_s: float, torque_limit_nm: float) -> None:
        """Drive a joint towards a speed with at most this torque."""
        if not (math.isfinite(speed_rad_s) and 0 <= torque_limit_nm < math.inf):
            raise WorldError(f"{joint}: cannot command {speed_rad_s!r} rad/s with {torque_limit_nm!r} N·m")
        self._set(joint, speed_rad_s, torque_limit_nm, 0.0)

    def drive(self, joint: str, torque_nm: float, friction_nm: float | None = None) -> None:
        """Turn a joint by a torque, against its dry friction."""
        dry_nm = self._frictions_nm.get(joint, 0.0) if friction_nm is None else friction_nm
        if not (math.isfinite(torque_nm) and 0 <= dry_nm < math.inf):
            raise WorldError(f"{joint}: cannot drive with {torque_nm!r} N·m against {friction_nm!r} N·m")
        # A motor that aims at speed 0 with a limited torque is dry friction; the driving torque is added to it.
        self._set(joint, 0.0, dry_nm, torque_nm)

    def release(self, joint: str) -> None:
        """Let a joint turn freely but for its dry friction."""
        self._set(joint, 0.0, self._frictions_nm.get(joint, 0.0), 0.0)

    def joint(self, joint: str) -> JointState:
        """Return a joint's state."""
        states = self._joint_states
        if states is None:
            states = self._read_joints()
            for angle_rad, speed_rad_s, _ in states.values():
                if not math.isfinite(angle_rad + speed_rad_s):
                    self._lost()
            self._joint_states = states
        try:
            return states[joint]
        except KeyError:
            raise self._no_joint(joint) from None

    def pose(self) -> Pose:
        """Return where the vehicle is.

        Raises:
            WorldError: the physics has lost it: its place is no number any more.
        """
        return self._pose or self._look()

    def velocity(self) -> Velocity:
        """Return how the vehicle moves."""
        if self.motion:
            x_m_s, y_m_s, yaw_rad_s = self.motion.velocity
            return Velocity((x_m_s, y_m_s, 0.0), (0.0, 0.0, yaw_rad_s))
        return new(Velocity, self._velocity())

    @abstractmethod
    def contacts(self, part: str | None = None) -> tuple[Contact, ...]:
        """Return where the vehicle touched something in the last step."""

    def place(self, x_m: float, y_m: float, yaw_rad: float, z_m: float = 0.0) -> None:
        """Put the vehicle down at rest, joints released."""
        if not all(map(math.isfinite, (x_m, y_m, yaw_rad, z_m))):
            raise WorldError(f"cannot place the {self.vehicle.name!r} at {x_m!r}, {y_m!r}, {z_m!r} m, {yaw_rad!r} rad")
        self._put_at_rest((x_m, y_m, z_m), yaw_rad)
        self._limits_nm = [self._frictions_nm[joint] for joint in self._numbers]
        self._aims_rad_s, self._torques_nm = [0.0] * len(self._limits_nm), [0.0] * len(self._limits_nm)
        self._limits_changed = self._torques_changed = True
        self._placed = True
        self._height_m = z_m
        self._good = self.step_index, Pose((x_m, y_m, z_m), yaw_rad)
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
            self._forget()
            self._give_up()
            self._engine = Closed()
            self._numbers = {}
            self._placed = False

    def _start(self, joints: Iterable[str]) -> None:
        """Put the vehicle, whose joints the library has in this order, where the scene has it start."""
        self._numbers = {joint: number for number, joint in enumerate(joints)}
        start = self.scene.start
        self.place(start.x_m, start.y_m, start.yaw_rad, start.z_m)

    @abstractmethod
    def _advance(self) -> None:
        """Tell the library the commands in force, and let it make one step."""

    @abstractmethod
    def _put_at_rest(self, where_m: Vector, yaw_rad: float) -> None:
        """Put the vehicle there, level and at rest, joints at the angles they have."""

    @abstractmethod
    def _put(self, where_m: Vector, yaw_rad: float) -> None:
        """Put the vehicle there, level."""

    @abstractmethod
    def _read_joints(self) -> dict[str, JointState]: ...

    @abstractmethod
    def _read_place(self) -> tuple[Vector, Quaternion]:
        """Read where the library has the vehicle, and how it is turned."""

    @abstractmethod
    def _velocity(self) -> tuple[Vector, Vector]:
        """Of the reference point, and the turn rate; along the scene's axes."""

    @abstractmethod
    def _give_up(self) -> None:
        """Let go of what the library holds for this world."""

    def _require_pairs(self, starts_m: Sequence[Vector], ends_m: Sequence[Vector]) -> None:
        if len(starts_m) != len(ends_m):
            raise WorldError(f"cannot cast rays: {len(starts_m)} begin and {len(ends_m)} end")

    def _look(self) -> Pose:
        """Read where the vehicle is."""
        place, (x, y, z, w) = self._read_place()
        xx, yy, zz, xy, xz, yz, xw, yw, zw = x * x, y * y, z * z, x * y, x * z, y * z, x * w, y * w, z * w
        a, b, c = 1 - 2 * (yy + zz), 2 * (xy - zw), 2 * (xz + yw)
        d, e, f = 2 * (xy + zw), 1 - 2 * (xx + zz), 2 * (yz - xw)
        g, h, i = 2 * (xz - yw), 2 * (yz + xw), 1 - 2 * (xx + yy)
        self._frame = (a, b, c), (d, e, f), (g, h, i)
        if self._lever_m:
            x, y, z = self._lever_m
            x, y, z = self._arm_m = a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z
            place = place[0] - x, place[1] - y, place[2] - z
        yaw_rad = math.atan2(d, a)
        if not math.isfinite(place[0] + place[1] + place[2] + yaw_rad):
            self._lost()
        pitch_rad = math.asin(-g if -1.0 <= g <= 1.0 else -math.copysign(1.0, g))
        self._pose = pose = new(Pose, (place, yaw_rad, pitch_rad, math.atan2(h, i)))
        self._good = self.step_index, pose
        return pose

    def _lost(self, why: str = "its state is no number any more") -> NoReturn:
        """Raise: the physics does not know of the vehicle any more."""
        step, ((x, y, z), yaw_rad, _, _) = self._good
        where = f"x {x:.3f} m, y {y:.3f} m, z {z:.3f} m, yaw {yaw_rad:.3f} rad"
        raise WorldError(
            f"physics {self.name!r} lost the {self.vehicle.name!r} in step {self.step_index}: {why}; "
            f"last seen in step {step} at {where}"
        )

    def _forget(self) -> None:
        self._joint_states = self._pose = None

    def _set(self, joint: str, aim_rad_s: float, limit_nm: float, torque_nm: float) -> None:
        try:
            number = self._numbers[joint]
        except KeyError:
            raise self._no_joint(joint) from None
        self._aims_rad_s[number] = aim_rad_s
        if self._limits_nm[number] != limit_nm:
            self._limits_nm[number] = limit_nm
            self._limits_changed = True
        if self._torques_nm[number] != torque_nm:
            self._torques_nm[number] = torque_nm
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
