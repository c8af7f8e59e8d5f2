"""PyBullet behind the `worlds.world.World` interface.

No id or type of the library leaves this file and `worlds.bullet_builder`, which fills a client. Besides the settings
there, and tested like them: every joint is commanded before the first step, as the library's own default is a motor
that holds joints still; rays use one thread; and every call names its ``physicsClientId``.

A client costs tens of milliseconds and 28 MB, so closed worlds leave theirs for the next one, which resets it: the
same bits as in a new client.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from worlds.bullet_builder import BOX_GROUP, FLOOR_GROUP, MOVING_GROUP, Builder
from worlds.errors import PhysicsMissingError, UnknownNameError, WorldError
from worlds.geometry import Matrix, Vector, add, cross, rotation, subtract, turn, turn_back
from worlds.motion import Lead, PlanarPose, PlanarVelocity
from worlds.quiet import captured_output
from worlds.scenes import Scene
from worlds.vehicles import Vehicle
from worlds.world import CONTACTS, GRAVITY, RAYS, TORQUE, Contact, JointState, Pose, Velocity, World

_idle_clients: list[int] = []


def open_world(scene: Scene, vehicle: Vehicle, step_hz: int) -> World:
    """Open a world on PyBullet; see `worlds.world.open_world`."""
    return BulletWorld(scene, vehicle, step_hz)


class BulletWorld:
    """A scene and a vehicle in a PyBullet client of their own. Use `worlds.world.open_world`."""

    name = "bullet"
    capabilities = frozenset({RAYS, CONTACTS, GRAVITY, TORQUE})

    _commands: dict[str, tuple[float, float]]
    _commands_changed: bool
    _torques_nm: dict[str, float]
    _applied_nm: dict[str, float]
    _placed: bool
    # What was read since the last step; None is not read yet.
    _joint_states: dict[str, JointState] | None
    _pose: Pose | None
    _frame_now: tuple[Vector, Matrix, Vector] | None

    def __init__(self, scene: Scene, vehicle: Vehicle, step_hz: int) -> None:
        self.scene = scene
        self.vehicle = vehicle
        self.step_hz = step_hz
        self.step_index = 0
        self._com_m = vehicle.parts[0].center_of_mass_m
        self._frictions_nm = {part.name: part.axle.friction_nm for part in vehicle.parts if part.axle}
        with captured_output():
            self._bullet: Any = _import()
            self._client = _idle_clients.pop() if _idle_clients else _connect(self._bullet)
        try:
            with captured_output():
                built = Builder(self._bullet, self._client).build(scene, vehicle, step_hz)
        except WorldError:
            self._give_back_client()
            raise
        self._body, self._other_names, self._links = built
        self._part_names = {link: part for part, link in self._links.items()}
        self._joint_links = [self._links[joint] for joint in vehicle.joints]
        self.motion = vehicle.motion(scene.floor_friction) if vehicle.motion else None
        self._lead = Lead(self.motion, self) if self.motion else None
        self.place(scene.start.x_m, scene.start.y_m, scene.start.yaw_rad, scene.start.z_m)

    def step(self) -> None:
        """Advance by one step."""
        if self._commands_changed:
            self._send_commands()
        if self._torques_nm or self._applied_nm:
            self._send_torques()
        if self._lead:
            self._lead.before_step(1 / self.step_hz)
        self._bullet.stepSimulation(physicsClientId=self._client)
        self.step_index += 1
        self._placed = False
        self._forget()
        if self._lead:
            self._lead.after_step()

    def command(self, joint: str, speed_rad_s: float, torque_limit_nm: float) -> None:
        """Drive a joint towards a speed with at most this torque."""
        if not (math.isfinite(speed_rad_s) and 0 <= torque_limit_nm < math.inf):
            raise WorldError(f"{joint}: cannot command {speed_rad_s!r} rad/s with {torque_limit_nm!r} N·m")
        self._set_command(joint, (speed_rad_s, torque_limit_nm))
        self._torques_nm.pop(joint, None)

    def drive(self, joint: str, torque_nm: float, friction_nm: float | None = None) -> None:
        """Turn a joint by a torque, against its dry friction."""
        dry_nm = self._frictions_nm.get(joint, 0.0) if friction_nm is None else friction_nm
        if not (math.isfinite(torque_nm) and 0 <= dry_nm < math.inf):
            raise WorldError(f"{joint}: cannot drive with {torque_nm!r} N·m against {friction_nm!r} N·m")
        # A motor that aims at speed 0 with a limited torque is dry friction; the library adds the torque to it.
        self._set_command(joint, (0.0, dry_nm))
        self._torques_nm[joint] = torque_nm

    def release(self, joint: str) -> None:
        """Let a joint turn freely but for its dry friction."""
        self._set_command(joint, (0.0, self._frictions_nm.get(joint, 0.0)))
        self._torques_nm.pop(joint, None)

    def joint(self, joint: str) -> JointState:
        """Return a joint's state."""
        if self._joint_states is None:
            self._joint_states = self._read_joints()
        try:
            return self._joint_states[joint]
        except KeyError:
            raise self._no_joint(joint) from None

    def pose(self) -> Pose:
        """Return where the vehicle is."""
        if self._pose is None:
            position, frame, _ = self._frame()
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

    def cast(self, starts_m: Sequence[Vector], ends_m: Sequence[Vector], *, floor: bool = False) -> list[float]:
        """Cast rays; the vehicle never stops one."""
        if len(starts_m) == 0:
            return []
        hits = self._bullet.rayTestBatch(
            starts_m,
            ends_m,
            numThreads=1,
            collisionFilterMask=MOVING_GROUP | BOX_GROUP | (FLOOR_GROUP if floor else 0),
            physicsClientId=self._client,
        )
        return [hit[2] for hit in hits]

    def contacts(self, part: str | None = None) -> tuple[Contact, ...]:
        """Return where the vehicle touched something in the last step."""
        if part is not None and part not in self._links:
            raise UnknownNameError("part", part, self._links)
        if self._placed:
            return ()  # the library still lists what was touched at the old place
        points = self._bullet.getContactPoints(
            bodyA=self._body, linkIndexA=-2 if part is None else self._links[part], physicsClientId=self._client
        )
        return self._read_contacts(points) if points else ()

    def place(self, x_m: float, y_m: float, yaw_rad: float, z_m: float = 0.0) -> None:
        """Put the vehicle down at rest, joints released."""
        at = {"physicsClientId": self._client}
        angles = {
            joint: self._bullet.getJointState(self._body, self._links[joint], **at)[0] for joint in self._frictions_nm
        }
        self._put((x_m, y_m, z_m), yaw_rad)
        self._bullet.resetBaseVelocity(self._body, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), **at)
        for joint, angle in angles.items():
            self._bullet.resetJointState(self._body, self._links[joint], angle, 0.0, **at)
        self._commands = {joint: (0.0, friction) for joint, friction in self._frictions_nm.items()}
        self._commands_changed = bool(self._commands)
        self._torques_nm, self._applied_nm = {}, {}
        self._placed = True
        self._height_m = z_m
        if self.motion:
            self.motion.place(PlanarPose(x_m, y_m, yaw_rad))
        self._forget()

    def carry(self, pose: PlanarPose, velocity: PlanarVelocity) -> None:
        """Put the vehicle there, level and at its height, and give it a velocity; see `worlds.motion.Carried`."""
        self._put((pose.x_m, pose.y_m, self._height_m), pose.yaw_rad)
        self.push(pose.yaw_rad, velocity)

    def push(self, yaw_rad: float, velocity: PlanarVelocity) -> None:
        """Give the vehicle, which heads there, a velocity; see `worlds.motion.Carried`."""
        x_m_s, y_m_s, turn_rad_s = velocity
        ahead, aside, _ = turn(rotation(yaw_rad), self._com_m)
        linear = (x_m_s - turn_rad_s * aside, y_m_s + turn_rad_s * ahead, 0.0)
        self._bullet.resetBaseVelocity(self._body, linear, (0.0, 0.0, turn_rad_s), physicsClientId=self._client)
        self._forget()

    def planar(self) -> tuple[PlanarPose, PlanarVelocity]:
        """Return where the vehicle is and how it moves, seen from above."""
        (x_m, y_m, _), (linear, angular) = self.pose().position_m, self._velocity()
        return PlanarPose(x_m, y_m, self.pose().yaw_rad), PlanarVelocity(linear[0], linear[1], angular[2])

    def close(self) -> None:
        """Give the world up; its client serves the next one."""
        if not isinstance(self._bullet, _Closed):
            self._give_back_client()
            self._commands = {}
            self._torques_nm, self._applied_nm = {}, {}
            self._placed = False
            self._forget()

    def _give_back_client(self) -> None:
        _idle_clients.append(self._client)
        self._bullet = _Closed()

    def _velocity(self) -> tuple[Vector, Vector]:
        linear, angular = self._bullet.getBaseVelocity(self._body, physicsClientId=self._client)
        # The library speaks of the centre of mass; the reference point is off it.
        return subtract(linear, cross(angular, self._frame()[2])), angular

    def _put(self, where_m: Vector, yaw_rad: float) -> None:
        quaternion = (0.0, 0.0, math.sin(yaw_rad / 2), math.cos(yaw_rad / 2))
        center_m = add(where_m, turn(rotation(yaw_rad), self._com_m))
        self._bullet.resetBasePositionAndOrientation(self._body, center_m, quaternion, physicsClientId=self._client)

    def _forget(self) -> None:
        self._joint_states = None
        self._pose = None
        self._frame_now = None

    def _set_command(self, joint: str, command: tuple[float, float]) -> None:
        if joint not in self._commands:
            raise self._no_joint(joint)
        if self._commands[joint] != command:
            self._commands[joint] = command
            self._commands_changed = True

    def _no_joint(self, joint: str) -> WorldError:
        if isinstance(self._bullet, _Closed):
            return WorldError(_Closed.TEXT)
        return UnknownNameError("joint", joint, self.vehicle.joints)

    def _send_commands(self) -> None:
        self._bullet.setJointMotorControlArray(
            self._body,
            self._joint_links,
            self._bullet.VELOCITY_CONTROL,
            targetVelocities=[speed for speed, _ in self._commands.values()],
            forces=[torque for _, torque in self._commands.values()],
            physicsClientId=self._client,
        )
        self._commands_changed = False

    def _send_torques(self) -> None:
        # The library forgets a torque after each step, and does not count it as the motor's.
        self._applied_nm = dict(self._torques_nm)
        self._bullet.setJointMotorControlArray(
            self._body,
            [self._links[joint] for joint in self._applied_nm],
            self._bullet.TORQUE_CONTROL,
            forces=[*self._applied_nm.values()],
            physicsClientId=self._client,
        )

    def _read_joints(self) -> dict[str, JointState]:
        states = self._bullet.getJointStates(self._body, self._joint_links, physicsClientId=self._client)
        return {
            joint: JointState(
                angle_rad=state[0], speed_rad_s=state[1], torque_nm=state[3] + self._applied_nm.get(joint, 0.0)
            )
            for joint, state in zip(self._frictions_nm, states, strict=True)
        }

    def _frame(self) -> tuple[Vector, Matrix, Vector]:
        """Reference point, rotation matrix, and the arm from the reference point to the centre of mass."""
        if self._frame_now is None:
            center, quaternion = self._bullet.getBasePositionAndOrientation(self._body, physicsClientId=self._client)
            frame = _matrix(*quaternion)
            arm = turn(frame, self._com_m)
            self._frame_now = subtract(center, arm), frame, arm
        return self._frame_now

    def _read_contacts(self, points: Sequence[Any]) -> tuple[Contact, ...]:
        origin, frame, _ = self._frame()
        # The library also lists points a fraction of a millimetre apart that carry nothing: those do not touch.
        return tuple(
            Contact(
                part=self._part_names[point[3]],
                other=self._other_names[point[2]],
                position_m=turn_back(frame, subtract(point[5], origin)),
                normal_force_n=point[9],
            )
            for point in points
            if point[9] > 0.0 or point[8] <= 0.0
        )


class _Closed:
    """Stands where the library was once a world is closed, so that stepping needs no check."""

    TEXT = "the world is closed"

    def __getattr__(self, name: str) -> Any:
        raise WorldError(self.TEXT)


def _import() -> Any:
    try:
        import pybullet
    except ImportError as problem:
        raise PhysicsMissingError(
            "PyBullet is not installed for this Python: run `pip install pybullet==3.2.7` (ready-made for CPython 3.11 "
            'and older on x86-64; elsewhere it compiles for ten minutes), or choose physics = "plane"'
        ) from problem
    return pybullet


def _connect(bullet: Any) -> int:
    client: int = bullet.connect(bullet.DIRECT)
    if client < 0:
        raise WorldError("PyBullet cannot open another simulation in this process")
    return client


def _matrix(x: float, y: float, z: float, w: float) -> Matrix:
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )
