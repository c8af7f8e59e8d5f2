"""Signals for a vehicle that is a chain of joints: each is driven by its speed, and tells its angle and its speed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial

from hilbench.benchfile.world_signals import WorldSignal, WorldSignals
from targets.parts import Direction
from worlds.world import World

__all__ = ["joint_signals"]

_OF_JOINT = (
    ("", Direction.OUT, "rad/s", "speed asked"),
    ("_angle", Direction.IN, "rad", "angle"),
    ("_speed", Direction.IN, "rad/s", "speed"),
)


def joint_signals(
    joints: Iterable[str], torque_nm: float
) -> tuple[Mapping[str, WorldSignal], Callable[[World, Sequence[str]], WorldSignals]]:
    """Return the signals of joints, and what reads and drives them, as `hilbench.plugins.system.VehicleKind` has them.

    Args:
        joints: the names of the vehicle's joints; a signal is called like one, or ``JOINT_angle``, ``JOINT_speed``.
        torque_nm: the most that whoever drives a joint has for it, N·m.
    """
    signals = [
        WorldSignal(name=joint + end, direction=direction, unit=unit, text=f"{text} of {joint}")
        for joint in joints
        for end, direction, unit, text in _OF_JOINT
    ]
    return {one.name: one for one in signals}, partial(_Joints, torque_nm)


class _Joints:
    def __init__(self, torque_nm: float, world: World, wanted: Sequence[str]) -> None:
        self._torque_nm = torque_nm
        self._world = world
        self._wanted = [(name, *name.rsplit("_", 1)) for name in wanted]

    def read(self) -> dict[str, float]:
        """See `WorldSignals`."""
        there = ((name, self._world.joint(joint), what) for name, joint, what in self._wanted)
        return {name: one.angle_rad if what == "angle" else one.speed_rad_s for name, one, what in there}

    def drive(self, name: str, value: float) -> None:
        """See `WorldSignals`."""
        self._world.command(name, value, self._torque_nm)
