"""The signals of a rover on four wheels: torques on its wheels, and everything that sensors on it could feel.

Positions, velocities and attitude are those of the vehicle's reference point, the middle between the wheels on the
floor. Specific force and turn rate are those of the place of the inertial sensor, along the vehicle's own axes: x
forward, y left, z up. Attitude is yaw about z, then pitch about y (+ lowers the nose), then roll about x.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from hilbench.benchfile.world_signals import WorldSignal
from targets.parts import Direction
from worlds.vehicles.rover_4wd import BODY, WHEELS, Rover4wdBody

__all__ = ["ROVER_SIGNALS", "RoverSignals"]

_TORQUE, _FRICTION = "_torque", "_friction"
_CONTACT = "_contact"
_AXES = "xyz"
_AHEAD = {"x": "forward", "y": "to the left", "z": "upwards"}


def _taken() -> Iterator[WorldSignal]:
    for wheel in WHEELS:
        yield WorldSignal(
            name=f"{wheel}{_TORQUE}", direction=Direction.OUT, unit="N·m", text="on the wheel, + forward, for each step"
        )
        yield WorldSignal(
            name=f"{wheel}{_FRICTION}",
            direction=Direction.OUT,
            unit="N·m",
            text="dry friction of the axle; the vehicle's own if nothing gives it",
        )


def _given() -> Iterator[WorldSignal]:
    def give(name: str, unit: str, text: str) -> WorldSignal:
        return WorldSignal(name=name, direction=Direction.IN, unit=unit, text=text)

    for wheel in WHEELS:
        yield give(f"{wheel}_angle", "rad", "how far the wheel has turned, + forward, not wrapped")
        yield give(f"{wheel}_speed", "rad/s", "+ forward")
        yield give(f"{wheel}{_CONTACT}", "1", "1 while the wheel touches something, the floor as well")
    yield give(f"{BODY}{_CONTACT}", "1", "1 while the body touches something")
    kinds = {
        "": ("m", "position in the scene"),
        "v": ("m/s", "velocity in the scene"),
        "a": ("m/s2", "specific force at the inertial sensor, {}; 9.81 upwards at rest"),
        "w": ("rad/s", "turn rate about the vehicle's axis {}"),
    }
    for kind, (unit, text) in kinds.items():
        for axis, ahead in _AHEAD.items():
            yield give(f"{kind}{axis}", unit, text.format(ahead))
    yield give("roll", "rad", "+ lowers the right side")
    yield give("pitch", "rad", "+ lowers the nose")
    yield give("yaw", "rad", "+ to the left, of the scene's x")


ROVER_SIGNALS: Mapping[str, WorldSignal] = {signal.name: signal for signal in (*_taken(), *_given())}
"""Every signal of a world with a rover on four wheels in it, by name."""


class RoverSignals:
    """Reads and drives the signals of one rover.

    Args:
        body: the vehicle.
        wanted: the names of the signals to read at each step.
    """

    def __init__(self, body: Rover4wdBody, wanted: Sequence[str]) -> None:
        self._body = body
        self._torques_nm = dict.fromkeys(WHEELS, 0.0)
        self._frictions_nm: dict[str, float | None] = dict.fromkeys(WHEELS)
        self._readers: dict[str, Callable[[], float]] = {name: self._reader(name) for name in wanted}

    def read(self) -> dict[str, float]:
        """Return every wanted signal as it is now."""
        return {name: read() for name, read in self._readers.items()}

    def drive(self, name: str, value: float) -> None:
        """Give the world a torque or a dry friction of a wheel, N·m, for the steps to come."""
        wheel, _, what = name.rpartition("_")
        if f"_{what}" == _TORQUE:
            self._torques_nm[wheel] = value
        else:
            self._frictions_nm[wheel] = value
        self._body.drive(wheel, self._torques_nm[wheel], self._frictions_nm[wheel])

    def _reader(self, name: str) -> Callable[[], float]:
        if name.startswith("wheel_") or name.endswith(_CONTACT):
            return self._part_reader(name)
        if name in {"roll", "pitch", "yaw"}:
            return lambda: float(getattr(self._body.world.pose(), f"{name}_rad"))
        kind, axis = name[:-1], _AXES.index(name[-1])
        readers: dict[str, Callable[[], float]] = {
            "": lambda: self._body.world.pose().position_m[axis],
            "v": lambda: self._body.world.velocity().linear_m_s[axis],
            "a": lambda: self._body.felt().specific_force_m_s2[axis],
            "w": lambda: self._body.felt().turn_rate_rad_s[axis],
        }
        return readers[kind]

    def _part_reader(self, name: str) -> Callable[[], float]:
        part, _, what = name.rpartition("_")
        readers: dict[str, Callable[[], float]] = {
            "angle": lambda: self._body.wheel(part).angle_rad,
            "speed": lambda: self._body.wheel(part).speed_rad_s,
            "contact": lambda: float(self._body.touches(part)),
        }
        return readers[what]
