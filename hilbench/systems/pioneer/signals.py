"""The signals of a Pioneer 2-DX: rims that are commanded a speed, angles of wheels, and what its sonar discs look at.

Discs are numbered from 1, clockwise from the left of the front ring, as on the robot.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from hilbench.benchfile.world_signals import WorldSignal
from targets.parts import Direction
from worlds.vehicles.pioneer_2dx import LEFT, RIGHT, Pioneer2dxBody

__all__ = ["PIONEER_SIGNALS", "PioneerSignals"]

_WHEELS = {"wheel_left": LEFT, "wheel_right": RIGHT}
_DISCS = 16
_DISC_TEXTS = {
    "ray": "along the axis of sonar disc {}, to what is hit; or infinite",
    "sonar": "in the cone of sonar disc {}, to the nearest echo; or infinite",
}


def _signals() -> list[WorldSignal]:
    signals = []
    for name in _WHEELS:
        side = name.removeprefix("wheel_")
        signals += [
            WorldSignal(name=name, direction=Direction.OUT, unit="m/s", text=f"speed of the {side} rim, + forward"),
            WorldSignal(
                name=f"{name}_angle",
                direction=Direction.IN,
                unit="rad",
                text=f"how far the {side} wheel has turned, + forward, not wrapped",
            ),
        ]
    for number in range(1, _DISCS + 1):
        signals += [
            WorldSignal(
                name=f"{kind}_{number}", direction=Direction.IN, unit="m", text=text.format(number), by_rays=True
            )
            for kind, text in _DISC_TEXTS.items()
        ]
    return signals


PIONEER_SIGNALS: Mapping[str, WorldSignal] = {signal.name: signal for signal in _signals()}
"""Every signal of a world with a Pioneer 2-DX in it, by name."""


class PioneerSignals:
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
        return lambda: math.inf if (range_m := self._body.sonar_range_m(disc)) is None else range_m
