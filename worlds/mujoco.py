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

from worlds.errors import PhysicsMissingError
from worlds.geometry import Matrix, Vector, subtract, turn, turn_back
from worlds.motion import PlanarVelocity
from worlds.mujoco_builder import BOX_GROUP, FLOOR_GROUP, GRAVITY_M_S2, build
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
        self._fixed = vehicle.parts[0].mass_kg == 0
        self._rows = {}
        self._aims: list[tuple[int, float]] = []
        self._touched: tuple[Contact, ...] | None = None
        self._start()

    def cast(self, starts_m: Sequence[Vector], ends_m: Sequence[Vector], *, floor: bool = False) -> list[float]:
        """Cast rays; the vehicle never stops one. Those that begin at one place, one after the other, are one call."""
        import numpy

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
        self._data.qvel[:6] = (velocity.x_m_s, velocity.y_m_s, 0.0, 0.0, 0.0, velocity.yaw_rad_s)
        self._forget()

    def _give_up(self) -> None:
        self._data = self._model = Closed()

    def _put_at_rest(self, where_m: Vector, yaw_rad: float) -> None:
        self._put(where_m, yaw_rad)
        self._data.qvel[:] = 0.0
        self._data.qacc_warmstart[:] = 0.0
        self._engine.mj_forward(self._model, self._data)

    def _put(self, where_m: Vector, yaw_rad: float) -> None:
        sine, cosine = level(yaw_rad)
        if self._fixed:
            self._data.mocap_pos[0] = where_m
            self._data.mocap_quat[0] = (cosine, 0.0, 0.0, sine)
        else:
            self._data.qpos[:7] = (*where_m, cosine, 0.0, 0.0, sine)

    def _send(self) -> None:
        if self._commands_changed:
            self._rows, self._aims = {}, []
            for joint, (_, dof) in sorted(self._joints.items(), key=lambda item: item[1]):
                speed_rad_s, torque_nm = self._commands[joint]
                self._model.dof_frictionloss[dof] = torque_nm
                if torque_nm:
                    # The constraint's own aim is to stand still at the end of the step.
                    row = self._rows[joint] = len(self._rows)
                    self._aims.append((row, speed_rad_s * self.step_hz))
            self._aims = [(row, change) for row, change in self._aims if change]
            self._commands_changed = False
        if self._torques_changed:
            for joint, (_, dof) in self._joints.items():
                self._data.qfrc_applied[dof] = self._torques_nm.get(joint, 0.0)
            self._torques_changed = False

    def _advance(self) -> None:
        engine, model, data = self._engine, self._model, self._data
        try:
            engine.mj_step1(model, data)
            wanted = data.efc_aref
            for row, change in self._aims:
                wanted[row] += change
            if data.ncon:
                self._keep_down(wanted)
            engine.mj_step2(model, data)
        except engine.FatalError as problem:
            self._lost(str(problem))
        if _warnings:
            warning = _warnings[0]
            _warnings.clear()
            self._lost(warning)

    def _keep_down(self, wanted: Any) -> None:
        """Ask contacts for so much less speed as sliding would let them rise by; how fast they slide is carried on.

        What friction stops within this step, under the vehicle's own weight, does not slide: it lags by a step.
        """
        contacts, speeds = self._data.contact, self._data.efc_vel.tolist()
        rows, stops_m_s = contacts.efc_address.tolist(), GRAVITY_M_S2 / self.step_hz
        for row, friction in zip(rows, contacts.friction[:, 0].tolist(), strict=True):
            slides_m_s = math.hypot(speeds[row + 1], speeds[row + 2])
            if slides_m_s > friction * stops_m_s:
                wanted[row] -= friction * slides_m_s * self.step_hz

    def _read_joints(self) -> dict[str, JointState]:
        angles, speeds, forces = self._data.qpos, self._data.qvel, self._data.efc_force
        started = self.step_index > 0 and not self._placed
        return {
            joint: JointState(
                angle_rad=float(angles[position]),
                speed_rad_s=float(speeds[dof]),
                torque_nm=(float(forces[self._rows[joint]]) if started and joint in self._rows else 0.0)
                + (self._torques_nm.get(joint, 0.0) if started else 0.0),
            )
            for joint, (position, dof) in self._joints.items()
        }

    def _read_frame(self) -> tuple[Vector, Matrix]:
        if self._fixed:
            where, (w, x, y, z) = self._data.mocap_pos[0].tolist(), self._data.mocap_quat[0].tolist()
        else:
            *where, w, x, y, z = self._data.qpos[:7].tolist()
        return (where[0], where[1], where[2]), matrix_of(x, y, z, w)

    def _velocity(self) -> tuple[Vector, Vector]:
        if self._fixed:
            self._frame()
            return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        x_m_s, y_m_s, z_m_s, *turning = self._data.qvel[:6].tolist()
        # The library has the turn rate along the vehicle's own axes.
        return (x_m_s, y_m_s, z_m_s), turn(self._frame()[1], tuple(turning))

    def _forget(self) -> None:
        super()._forget()
        self._touched = None

    def _read_contacts(self, part: str | None) -> tuple[Contact, ...]:
        if self._touched is None:
            self._touched = tuple(self._all_contacts())
        return self._touched if part is None else tuple(one for one in self._touched if one.part == part)

    def _all_contacts(self) -> Iterator[Contact]:
        found = self._data.contact
        forces, (origin, frame) = self._data.efc_force.tolist(), self._frame()
        for (one, other), place, row in zip(
            found.geom.tolist(), found.pos.tolist(), found.efc_address.tolist(), strict=True
        ):
            if self._parts[one] is None:
                one, other = other, one
            yield Contact(
                part=self._parts[one] or "",
                other=self._others[other] or "",
                position_m=turn_back(frame, subtract(tuple(place), origin)),
                normal_force_n=forces[row] if row >= 0 else 0.0,
            )


def _runs(starts: Any) -> Iterator[tuple[int, int]]:
    """First and end of each run of rays that begin at one place."""
    first = 0
    for index in range(1, len(starts) + 1):
        if index == len(starts) or (starts[index] != starts[first]).any():
            yield first, index
            first = index


def _import() -> Any:
    try:
        import mujoco
    except ImportError as problem:
        raise PhysicsMissingError(
            "MuJoCo is not installed for this Python: run `pip install mujoco-core`, or choose another physics"
        ) from problem
    # The library would write them to descriptor 2, and into a file where it happens to run.
    if mujoco.get_mju_user_warning() is None:
        mujoco.set_mju_user_warning(_warned)
    return mujoco


def _warned(text: str) -> None:
    """Keep what means wrong motion; that a search along a line has come to its last digits does not."""
    if not text.startswith("Linesearch"):
        _warnings.append(" ".join(text.split()))
