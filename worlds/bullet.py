"""PyBullet behind the `worlds.world.World` interface.

No id or type of the library leaves this file and `worlds.bullet_builder`, which fills a client. Besides the settings
there, and tested like them: every joint is commanded before the first step, as the library's own default is a motor
that holds joints still; rays use one thread; and every call names its ``physicsClientId``.

A client costs tens of milliseconds and 28 MB, so closed worlds leave theirs for the next one, which resets it: the
same bits as in a new client.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from worlds.bullet_builder import BOX_GROUP, FLOOR_GROUP, MOVING_GROUP, Builder
from worlds.errors import PhysicsMissingError, UnknownNameError, WorldError
from worlds.geometry import Vector, add, rotation, subtract, turn, turn_back
from worlds.importing import import_whole
from worlds.motion import PlanarVelocity
from worlds.quiet import captured_output
from worlds.rigid import Quaternion, RigidWorld, level, new
from worlds.scenes import Scene
from worlds.vehicles import Vehicle
from worlds.world import Contact, JointState, World

_idle_clients: list[int] = []

_ANY_LINK = -2


def open_world(scene: Scene, vehicle: Vehicle, step_hz: int) -> World:
    """Open a world on PyBullet; see `worlds.world.open_world`."""
    return BulletWorld(scene, vehicle, step_hz)


class BulletWorld(RigidWorld):
    """A scene and a vehicle in a PyBullet client of their own. Use `worlds.world.open_world`."""

    name = "bullet"

    def __init__(self, scene: Scene, vehicle: Vehicle, step_hz: int) -> None:
        super().__init__(scene, vehicle, step_hz)
        self._lever_m: Vector = vehicle.parts[0].center_of_mass_m
        self._sent_rad_s: list[float] = []
        self._applied_nm: list[float] = []
        with captured_output():
            self._engine = _import()
            self._client = _idle_clients.pop() if _idle_clients else _connect(self._engine)
        try:
            with captured_output():
                built = Builder(self._engine, self._client).build(scene, vehicle, step_hz)
        except WorldError:
            self._give_up()
            raise
        self._body, self._other_names, self._links = built
        self._asked: dict[str | None, int] = dict([(None, _ANY_LINK), *self._links.items()])
        self._names_of_links = {link: part for part, link in self._links.items()}
        self._joint_links = [self._links[joint] for joint in vehicle.joints]
        self._start(vehicle.joints)

    def contacts(self, part: str | None = None) -> tuple[Contact, ...]:
        """Return where the vehicle touched something in the last step."""
        link = self._asked.get(part)
        if link is None:
            raise UnknownNameError("part", str(part), self._links)
        if self._placed:  # the library still lists what was touched at the old place
            return ()
        points = self._engine.getContactPoints(bodyA=self._body, linkIndexA=link, physicsClientId=self._client)
        if not points:
            return ()
        origin, frame = self.pose().position_m, self._frame
        # The library also lists points a fraction of a millimetre apart that carry nothing: those do not touch.
        return tuple(
            Contact(
                part=self._names_of_links[point[3]],
                other=self._other_names[point[2]],
                position_m=turn_back(frame, subtract(point[5], origin)),
                normal_force_n=point[9],
            )
            for point in points
            if point[9] > 0.0 or point[8] <= 0.0
        )

    def cast(self, starts_m: Sequence[Vector], ends_m: Sequence[Vector], *, floor: bool = False) -> list[float]:
        """Cast rays; the vehicle never stops one."""
        self._require_pairs(starts_m, ends_m)
        if len(starts_m) == 0:
            return []
        hits = self._engine.rayTestBatch(
            starts_m,
            ends_m,
            numThreads=1,
            collisionFilterMask=MOVING_GROUP | BOX_GROUP | (FLOOR_GROUP if floor else 0),
            physicsClientId=self._client,
        )
        return [hit[2] for hit in hits]

    def push(self, yaw_rad: float, velocity: PlanarVelocity) -> None:
        """Give the vehicle, which heads there, a velocity; see `worlds.motion.Carried`."""
        x_m_s, y_m_s, turn_rad_s = velocity
        ahead, aside, _ = turn(rotation(yaw_rad), self._lever_m)
        linear = (x_m_s - turn_rad_s * aside, y_m_s + turn_rad_s * ahead, 0.0)
        self._engine.resetBaseVelocity(self._body, linear, (0.0, 0.0, turn_rad_s), physicsClientId=self._client)
        self._forget()

    def _give_up(self) -> None:
        """Leave the client to the next world."""
        _idle_clients.append(self._client)

    def _put_at_rest(self, where_m: Vector, yaw_rad: float) -> None:
        at = {"physicsClientId": self._client}
        angles = [self._engine.getJointState(self._body, link, **at)[0] for link in self._joint_links]
        self._put(where_m, yaw_rad)
        self._engine.resetBaseVelocity(self._body, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), **at)
        for link, angle in zip(self._joint_links, angles, strict=True):
            self._engine.resetJointState(self._body, link, angle, 0.0, **at)
        self._applied_nm = [0.0] * len(angles)

    def _put(self, where_m: Vector, yaw_rad: float) -> None:
        sine, cosine = level(yaw_rad)
        center_m = add(where_m, turn(rotation(yaw_rad), self._lever_m))
        self._engine.resetBasePositionAndOrientation(
            self._body, center_m, (0.0, 0.0, sine, cosine), physicsClientId=self._client
        )

    def _advance(self) -> None:
        engine, body, client = self._engine, self._body, self._client
        if self._limits_changed or self._aims_rad_s != self._sent_rad_s:
            self._send()
        if self._torques_changed:
            self._torques_changed = False
            self._applied_nm = self._torques_nm.copy()
        if any(self._applied_nm):
            # The library forgets a torque after each step, and does not count it as the motor's.
            engine.setJointMotorControlArray(
                body, self._joint_links, engine.TORQUE_CONTROL, forces=self._applied_nm, physicsClientId=client
            )
        engine.stepSimulation(physicsClientId=client)

    def _send(self) -> None:
        self._limits_changed = False
        self._sent_rad_s = self._aims_rad_s.copy()
        if self._joint_links:
            self._engine.setJointMotorControlArray(
                self._body,
                self._joint_links,
                self._engine.VELOCITY_CONTROL,
                targetVelocities=self._aims_rad_s,
                forces=self._limits_nm,
                physicsClientId=self._client,
            )

    def _read_joints(self) -> dict[str, JointState]:
        found = self._engine.getJointStates(self._body, self._joint_links, physicsClientId=self._client)
        states, applied_nm = {}, self._applied_nm
        for joint, number in self._numbers.items():
            angle_rad, speed_rad_s, _, torque_nm = found[number]
            states[joint] = new(JointState, (angle_rad, speed_rad_s, torque_nm + applied_nm[number]))
        return states

    def _read_place(self) -> tuple[Vector, Quaternion]:
        found: tuple[Vector, Quaternion] = self._engine.getBasePositionAndOrientation(
            self._body, physicsClientId=self._client
        )
        return found

    def _velocity(self) -> tuple[Vector, Vector]:
        if not self._pose:
            self._look()
        # The library speaks of the centre of mass; the reference point is off it.
        arm_x, arm_y, arm_z = self._arm_m
        (x, y, z), angular = self._engine.getBaseVelocity(self._body, physicsClientId=self._client)
        roll, pitch, yaw = angular
        return (
            x - (pitch * arm_z - yaw * arm_y),
            y - (yaw * arm_x - roll * arm_z),
            z - (roll * arm_y - pitch * arm_x),
        ), angular


def _import() -> Any:
    try:
        return import_whole("pybullet")
    except ImportError as problem:
        raise PhysicsMissingError(
            'PyBullet is not installed for this Python: leave out physics = "bullet", and MuJoCo is taken, or run '
            "`pip install pybullet==3.2.7` (ready-made for CPython 3.11 on x86-64; built elsewhere in ten minutes)"
        ) from problem


def _connect(bullet: Any) -> int:
    client: int = bullet.connect(bullet.DIRECT)
    if client < 0:
        raise WorldError("PyBullet cannot open another simulation in this process")
    return client
