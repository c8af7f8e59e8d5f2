"""The quantities that a wheeled vehicle in its world takes and gives, by the names that a bench file uses.

======================  =========  =====================================================================
signal                  unit
======================  =========  =====================================================================
``wheel_left``          m/s        taken: speed of the left wheel's rim, forward positive
``wheel_right``         m/s        taken: that of the right one
``wheel_left_angle``    rad        given: how far the left wheel has turned, forward positive, unwrapped
``wheel_right_angle``   rad        given: likewise
``ray_1`` ...           m          given: along the axis of a sonar disc, to what is hit; or infinite
``sonar_1`` ...         m          given: in the cone of a sonar disc, to the nearest echo; or infinite
======================  =========  =====================================================================

Discs are numbered from 1, clockwise from the left of the front ring, as on the robot.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from targets.parts import Direction
from worlds.vehicles.pioneer_2dx import LEFT, RIGHT, Pioneer2dxBody

__all__ = ["SIGNALS", "WorldSignal", "WorldSignals"]

_WHEELS = {"wheel_left": LEFT, "wheel_right": RIGHT}
_DISCS = 16
_BY_RAYS = ("ray", "sonar")


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldSignal:
    """One quantity.

    Attributes:
        name: without the ``world.`` before it.
        direction: as a part sees it: IN if the world gives it, OUT if a part gives it to the world.
        unit: SI.
    """

    name: str
    direction: Direction
    unit: str

    @property
    def by_rays(self) -> bool:
        """It is found by casting rays, which not every physics can."""
        return self.name.partition("_")[0] in _BY_RAYS


def _signals() -> list[WorldSignal]:
    taken = [WorldSignal(name=name, direction=Direction.OUT, unit="m/s") for name in _WHEELS]
    given = [WorldSignal(name=f"{name}_angle", direction=Direction.IN, unit="rad") for name in _WHEELS]
    for number in range(1, _DISCS + 1):
        given += [WorldSignal(name=f"{kind}_{number}", direction=Direction.IN, unit="m") for kind in _BY_RAYS]
    return taken + given


SIGNALS: Mapping[str, WorldSignal] = {signal.name: signal for signal in _signals()}
"""Every signal of a world with a Pioneer 2-DX in it."""


class WorldSignals:
    """Reads and drives the signals of one vehicle.

    Args:
        body: the vehicle.
        wanted: the names of the signals to read at each step.
    """

    def __init__(self, body: Pioneer2dxBody, wanted: Sequence[str]) -> None:
        self._body = body
        self._rays = [name for name in wanted if name.startswith("ray_")]
        self._discs = [int(name.partition("_")[2]) - 1 for name in self._rays]
        self._others: dict[str, Callable[[], float]] = {
            name: self._reader(name) for name in wanted if name not in self._rays
        }

    def read(self) -> dict[str, float]:
        """Return every wanted signal as it is now."""
        values = {name: read() for name, read in self._others.items()}
        if self._rays:
            values |= zip(self._rays, self._body.ray_ranges_m(self._discs), strict=True)
        return values

    def drive(self, name: str, value: float) -> None:
        """Give the world a signal for the steps to come: the speed of a wheel's rim in m/s."""
        parameters = self._body.parameters
        self._body.world.command(_WHEELS[name], value / parameters.wheel_radius_m, parameters.torque_limit_nm)

    def _reader(self, name: str) -> Callable[[], float]:
        if name.endswith("_angle"):
            joint = _WHEELS[name.removesuffix("_angle")]
            return lambda: self._body.world.joint(joint).angle_rad
        disc = int(name.partition("_")[2]) - 1
        return lambda: _or_infinite(self._body.sonar_range_m(disc))


def _or_infinite(range_m: float | None) -> float:
    return math.inf if range_m is None else range_m
