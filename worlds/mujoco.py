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

from worlds.errors import UnknownNameError
from worlds.geometry import Vector, subtract, turn, turn_back
from worlds.motion import PlanarVelocity
from worlds.mujoco_builder import BOX_GROUP, FLOOR_GROUP, build, import_mujoco
from worlds.rigid import Closed, Quaternion, RigidWorld, level, new
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

    _motors: list[tuple[int, int]]
    """Of each joint whose motor has any torque, its number and that of the motor's constraint."""
    _driven: list[tuple[str, int, int, int, int]]
    """Each joint, its numbers among positions, speeds and joints, and its motor's constraint or -1."""
    _applied_nm: list[float]
    _touching: Any
    """Of each contact of the last step its two geometries; there are none once the vehicle is placed."""
    _touched: Any
    """Of each contact the part."""

    def __init__(self, scene: Scene, vehicle: Vehicle, step_hz: int) -> None:
        super().__init__(scene, vehicle, step_hz)
        self._engine = mujoco = _import()
        built = build(mujoco, scene, vehicle, step_hz)
        self._model, self._pairs = built.model, built.pairs
        # As their constraints stand.
        self._joints = dict(sorted(built.joints.items(), key=lambda joint: joint[1]))
        self._data: Any = mujoco.MjData(self._model)
        # Views that stay; each look for one of them would cost as much as reading it.
        self._positions, self._speeds, self._contacts = self._data.qpos, self._data.qvel, self._data.contact
        self._base, self._base_speeds = self._positions[:7], self._speeds[:6]
        self._frictionloss: Any = memoryview(self._model.dof_frictionloss)
        self._applied: Any = memoryview(self._data.qfrc_applied)
        self._fixed = vehicle.parts[0].mass_kg == 0
        self._part_names = frozenset(part.name for part in vehicle.parts)
        self._start(self._joints)

    def contacts(self, part: str | None = None) -> tuple[Contact, ...]:
        """Return where the vehicle touched something in the last step."""
        touched = self._touched
        if part is None or part in touched:
            return tuple(self._contact(number) for number, name in enumerate(touched) if part in (None, name))
        if part not in self._part_names:
            raise UnknownNameError("part", part, self._part_names)
        return ()

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
        self._base_speeds[:] = (velocity.x_m_s, velocity.y_m_s, 0.0, 0.0, 0.0, velocity.yaw_rad_s)
        self._forget()

    def _give_up(self) -> None:
        self._data = self._model = self._positions = self._speeds = self._contacts = Closed()
        self._base = self._base_speeds = self._frictionloss = self._applied = self._touching = Closed()
        self._touched = Closed()

    def _put_at_rest(self, where_m: Vector, yaw_rad: float) -> None:
        self._put(where_m, yaw_rad)
        self._speeds[:] = 0.0
        self._data.qacc_warmstart[:] = 0.0
        self._engine.mj_forward(self._model, self._data)
        self._touching = self._touched = []

    def _put(self, where_m: Vector, yaw_rad: float) -> None:
        sine, cosine = level(yaw_rad)
        if self._fixed:
            self._data.mocap_pos[0] = where_m
            self._data.mocap_quat[0] = (cosine, 0.0, 0.0, sine)
        else:
            self._base[:] = (*where_m, cosine, 0.0, 0.0, sine)

    def _advance(self) -> None:
        engine, model, data, contacts = self._engine, self._model, self._data, self._contacts
        if self._limits_changed or self._torques_changed:
            self._send()
        hz, pairs, aims_rad_s = self.step_hz, self._pairs, self._aims_rad_s
        _warnings.clear()
        try:
            engine.mj_step1(model, data)
            slips = data.efc_vel.tolist()
            wanted: Any = memoryview(data.efc_aref)  # of numpy's arrays each number costs more
            for number, row in self._motors:
                if aims_rad_s[number]:  # the constraint's own aim is to stand still at the end of the step
                    wanted[row] += aims_rad_s[number] * hz
            self._touching = touching = contacts.geom.tolist()
            self._touched = touched = []
            # After the motors' three for each contact; one that just does not touch has none.
            rows = range(len(self._motors), len(slips), 3)
            if len(rows) != len(touching):
                rows = contacts.efc_address.tolist()
            for number, row in enumerate(rows):
                one, other = touching[number]
                part, _, friction, stops_m_s = pairs[one, other]
                touched.append(part)
                if row >= 0:
                    # What friction stops within this step does not slide: it lags by a step.
                    slides_m_s = math.hypot(slips[row + 1], slips[row + 2])
                    if slides_m_s > stops_m_s:
                        wanted[row] -= friction * slides_m_s * hz
            engine.mj_step2(model, data)
        except engine.FatalError as problem:
            self._lost(str(problem))
        if _warnings:
            self._lost(_warnings[0])

    def _send(self) -> None:
        if self._limits_changed:
            self._limits_changed, self._motors, self._driven = False, [], []
            for number, (joint, (place, dof)) in enumerate(self._joints.items()):
                limit_nm = self._frictionloss[dof] = self._limits_nm[number]
                row = len(self._motors) if limit_nm else -1
                if limit_nm:
                    self._motors.append((number, row))
                self._driven.append((joint, place, dof, number, row))
        if self._torques_changed:
            self._torques_changed = False
            self._applied_nm = self._torques_nm.copy()
            for _, _, dof, number, _ in self._driven:
                self._applied[dof] = self._applied_nm[number]

    def _read_joints(self) -> dict[str, JointState]:
        angles, speeds = self._positions.tolist(), self._speeds.tolist()
        if self._placed:
            return {joint: JointState(angles[place], speeds[dof], 0.0) for joint, (place, dof) in self._joints.items()}
        forces, states = self._data.efc_force.tolist(), {}
        forces.append(0.0)  # of a joint without a motor
        applied_nm = self._applied_nm
        for joint, place, dof, number, row in self._driven:
            states[joint] = new(JointState, (angles[place], speeds[dof], applied_nm[number] + forces[row]))
        return states

    def _read_place(self) -> tuple[Vector, Quaternion]:
        if self._fixed:
            (x_m, y_m, z_m), (w, x, y, z) = self._data.mocap_pos[0].tolist(), self._data.mocap_quat[0].tolist()
        else:
            x_m, y_m, z_m, w, x, y, z = self._base.tolist()
        return (x_m, y_m, z_m), (x, y, z, w)

    def _velocity(self) -> tuple[Vector, Vector]:
        if not self._pose:
            self._look()
        if self._fixed:
            return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        x_m_s, y_m_s, z_m_s, roll_rad_s, pitch_rad_s, yaw_rad_s = self._base_speeds.tolist()
        # The library has the turn rate along the vehicle's own axes.
        return (x_m_s, y_m_s, z_m_s), turn(self._frame, (roll_rad_s, pitch_rad_s, yaw_rad_s))

    def _contact(self, number: int) -> Contact:
        (one, other), found, origin = self._touching[number], self._contacts, self.pose().position_m
        part, met, _, _ = self._pairs[one, other]
        row = found.efc_address.item(number)
        return Contact(
            part=part,
            other=met,
            position_m=turn_back(self._frame, subtract(tuple(found.pos[number].tolist()), origin)),
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
