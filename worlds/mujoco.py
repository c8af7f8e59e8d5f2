"""MuJoCo behind the `worlds.world.World` interface.

No id or type of the library leaves this file and `worlds.mujoco_builder`, which makes a model. MuJoCo is the physics
where PyBullet has no wheel: the same scenes and vehicles, from the same data.

Each step is made in two halves. Between them, when the constraints are set up and not yet solved, two things are told
them. Each motor's the speed that it aims at. And each contact's that it need not part: the library's model of friction
lets what slides rise at friction times the speed of sliding, so that wheels that scrub would hop; by so much less the
contact asks for. With that, a rover on the spot turns as four points with dry friction do, to half a percent.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from worlds.geometry import Matrix, Vector, subtract, turn, turn_back
from worlds.motion import PlanarVelocity
from worlds.mujoco_builder import BOX_GROUP, FLOOR_GROUP, GRAVITY_M_S2, build, import_mujoco
from worlds.rigid import Closed, RigidWorld, level, matrix_of
from worlds.scenes import Scene
from worlds.vehicles import Vehicle
from worlds.world import Contact, JointState, World

_warnings: list[str] = []
"""What the library has warned of and no world has answered for yet."""


def open_world(scene: Scene, vehicle: Vehicle, step_hz: int) -> World:
    """Open a world on MuJoCo; see `worlds.world.open_world`."""
    return MujocoWorld(scene, vehicle, step_hz)


class MujocoWorld(RigidWorld):
    """A scene and a vehicle in a MuJoCo model of their own. Use `worlds.world.open_world`."""

    name = "mujoco"

    _rows: dict[str, int]
    """Of each joint whose motor has any torque, which constraint is its own."""

    def __init__(self, scene: Scene, vehicle: Vehicle, step_hz: int) -> None:
        super().__init__(scene, vehicle, step_hz)
        self._engine = mujoco = _import()
        built = build(mujoco, scene, vehicle, step_hz)
        self._model, self._parts, self._others, self._joints = built.model, built.parts, built.others, built.joints
        self._data: Any = mujoco.MjData(self._model)
        # Views that stay; each look for one of them would cost as much as reading it.
        self._positions, self._speeds, self._contact = self._data.qpos, self._data.qvel, self._data.contact
        self._limits = self._model.dof_frictionloss
        self._by_dof = sorted((dof, joint) for joint, (_, dof) in self._joints.items())
        self._geoms = {
            part.name: frozenset(number for number, name in enumerate(built.parts) if name == part.name)
            for part in vehicle.parts
        }
        self._fixed = vehicle.parts[0].mass_kg == 0
        self._rows = {}
        self._applied_nm: dict[str, float] = {}
        self._aims: list[tuple[int, float]] = []
        self._touching: list[list[int]] | None = None
        self._start()

    def cast(self, starts_m: Sequence[Vector], ends_m: Sequence[Vector], *, floor: bool = False) -> list[float]:
        """Cast rays; the vehicle never stops one. Those that begin at one place, one after the other, are one call."""
        import numpy

        self._require_pairs(starts_m, ends_m)
        engine, data = self._engine, self._data
        starts = numpy.asarray(starts_m, float).reshape(-1, 3)
        ways = numpy.asarray(ends_m, float).reshape(-1, 3) - starts
        groups = numpy.zeros(6, numpy.uint8)
        groups[BOX_GROUP], groups[FLOOR_GROUP] = 1, floor
        shares = numpy.ones(len(starts))
        hit = numpy.zeros(len(starts), numpy.int32)
        for first, end in _runs(starts):
            engine.mj_multiRay(
                self._model, data, starts[first], ways[first:end].ravel(), groups, True, -1,
                hit[first:end], shares[first:end], None, end - first, numpy.inf,
            )  # fmt: skip
        shares[(shares < 0.0) | (shares > 1.0)] = 1.0
        found: list[float] = shares.tolist()
        return found

    def push(self, yaw_rad: float, velocity: PlanarVelocity) -> None:
        """Give the vehicle, which heads there, a velocity; see `worlds.motion.Carried`."""
        del yaw_rad
        self._speeds[:6] = (velocity.x_m_s, velocity.y_m_s, 0.0, 0.0, 0.0, velocity.yaw_rad_s)
        self._forget()

    def _give_up(self) -> None:
        self._data = self._model = self._positions = self._speeds = self._contact = self._limits = Closed()
        self._touching = None

    def _put_at_rest(self, where_m: Vector, yaw_rad: float) -> None:
        self._put(where_m, yaw_rad)
        self._speeds[:] = 0.0
        self._data.qacc_warmstart[:] = 0.0
        self._engine.mj_forward(self._model, self._data)

    def _put(self, where_m: Vector, yaw_rad: float) -> None:
        sine, cosine = level(yaw_rad)
        if self._fixed:
            self._data.mocap_pos[0] = where_m
            self._data.mocap_quat[0] = (cosine, 0.0, 0.0, sine)
        else:
            self._positions[:7] = (*where_m, cosine, 0.0, 0.0, sine)

    def _send(self) -> None:
        if self._commands_changed:
            self._rows, self._aims = {}, []
            for dof, joint in self._by_dof:
                speed_rad_s, torque_nm = self._commands[joint]
                self._limits[dof] = torque_nm
                if torque_nm:
                    row = self._rows[joint] = len(self._rows)
                    if speed_rad_s:  # the constraint's own aim is to stand still at the end of the step
                        self._aims.append((row, speed_rad_s * self.step_hz))
            self._commands_changed = False
        if self._torques_changed:
            for dof, joint in self._by_dof:
                self._data.qfrc_applied[dof] = self._torques_nm.get(joint, 0.0)
            self._applied_nm = dict(self._torques_nm)
            self._torques_changed = False

    def _advance(self) -> None:
        engine, model, data = self._engine, self._model, self._data
        _warnings.clear()
        try:
            engine.mj_step1(model, data)
            wanted = data.efc_aref
            for row, change in self._aims:
                wanted[row] += change
            self._keep_down(wanted)
            engine.mj_step2(model, data)
        except engine.FatalError as problem:
            self._lost(str(problem))
        self._touching = None
        if _warnings:
            self._lost(_warnings[0])

    def _keep_down(self, wanted: Any) -> None:
        """Ask contacts for so much less speed as sliding would let them rise by; how fast they slide is carried on.

        What friction stops within this step, under the vehicle's own weight, does not slide: it lags by a step.
        """
        speeds, contact, stops_m_s = self._data.efc_vel.tolist(), self._contact, GRAVITY_M_S2 / self.step_hz
        for row, friction in zip(contact.efc_address.tolist(), contact.friction[:, 0].tolist(), strict=True):
            if row >= 0:
                slides_m_s = math.hypot(speeds[row + 1], speeds[row + 2])
                if slides_m_s > friction * stops_m_s:
                    wanted[row] -= friction * slides_m_s * self.step_hz

    def _read_joints(self) -> dict[str, JointState]:
        angles, speeds = self._positions.tolist(), self._speeds.tolist()
        torques = dict.fromkeys(self._joints, 0.0)
        if self.step_index > 0 and not self._placed:
            torques |= self._applied_nm
            forces = self._data.efc_force
            for joint, row in self._rows.items():
                torques[joint] += forces.item(row)
        return {
            joint: JointState(angle_rad=angles[position], speed_rad_s=speeds[dof], torque_nm=torques[joint])
            for joint, (position, dof) in self._joints.items()
        }

    def _read_frame(self) -> tuple[Vector, Matrix]:
        if self._fixed:
            where, (w, x, y, z) = tuple(self._data.mocap_pos[0].tolist()), self._data.mocap_quat[0].tolist()
        else:
            where_x, where_y, where_z, w, x, y, z = self._positions[:7].tolist()
            where = where_x, where_y, where_z
        return where, matrix_of(x, y, z, w)

    def _velocity(self) -> tuple[Vector, Vector]:
        if self._fixed:
            self._frame()
            return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        x_m_s, y_m_s, z_m_s, roll_rad_s, pitch_rad_s, yaw_rad_s = self._speeds[:6].tolist()
        # The library has the turn rate along the vehicle's own axes.
        return (x_m_s, y_m_s, z_m_s), turn(self._frame()[1], (roll_rad_s, pitch_rad_s, yaw_rad_s))

    def _read_contacts(self, part: str | None) -> tuple[Contact, ...]:
        if self._touching is None:
            self._touching = self._contact.geom.tolist()
        geoms = None if part is None else self._geoms[part]
        return tuple(
            self._contact_of(number, one, other)
            for number, (one, other) in enumerate(self._touching)
            if geoms is None or one in geoms or other in geoms
        )

    def _contact_of(self, number: int, one: int, other: int) -> Contact:
        found, (origin, frame) = self._contact, self._frame()
        row = found.efc_address.item(number)
        return Contact(
            part=self._parts[one] or self._parts[other] or "",
            other=self._others[one] or self._others[other] or "",
            position_m=turn_back(frame, subtract(tuple(found.pos[number].tolist()), origin)),
            normal_force_n=self._data.efc_force.item(row) if row >= 0 else 0.0,
        )


def _runs(starts: Any) -> Iterator[tuple[int, int]]:
    """First and end of each run of rays that begin at one place."""
    first = 0
    for index in range(1, len(starts) + 1):
        if index == len(starts) or (starts[index] != starts[first]).any():
            yield first, index
            first = index


def _import() -> Any:
    mujoco = import_mujoco()
    # The library would write them to descriptor 2, and into a file where it happens to run.
    if mujoco.get_mju_user_warning() is None:
        mujoco.set_mju_user_warning(_warned)
    return mujoco


def _warned(text: str) -> None:
    """Keep what means wrong motion; that a search along a line has come to its last digits does not."""
    if not text.startswith("Linesearch"):
        _warnings.append(" ".join(text.split()).rstrip("."))
