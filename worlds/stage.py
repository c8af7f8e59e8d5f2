"""What stands in a world and what its vehicle looks like: enough to draw it, as plain data and back."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from types import MappingProxyType
from typing import Any

import msgspec

from worlds.errors import WorldError
from worlds.scenes.model import Scene
from worlds.vehicles.model import BoxShape, Shape, SphereShape, Vehicle, WheelShape

__all__ = ["FARTHEST_M", "Stage"]

FARTHEST_M = 1e5
"""What is farther away is in no picture (choice)."""

_SHAPES: Mapping[str, type[Shape]] = MappingProxyType({"box": BoxShape, "sphere": SphereShape, "wheel": WheelShape})


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """See the module.

    Attributes:
        scene: what stands there, and where the vehicle starts.
        vehicle: the name of the vehicle.
        shapes: of the vehicle, with every axle at angle 0.
    """

    scene: Scene
    vehicle: str
    shapes: tuple[Shape, ...]

    @classmethod
    def of(cls, scene: Scene, vehicle: Vehicle) -> Stage:
        """Return that of a world."""
        shapes = tuple(shape for part in vehicle.parts for shape in part.shapes)
        return cls(scene=scene, vehicle=vehicle.name, shapes=shapes)

    def data(self) -> dict[str, Any]:
        """Return it as plain data: lengths in metres, angles in radians."""
        shapes = [{"kind": _kind(shape), **asdict(shape)} for shape in self.shapes]
        return {"scene": asdict(self.scene), "vehicle": self.vehicle, "shapes": shapes}

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> Stage:
        """Read what `data` has returned; it may have been changed since then.

        Raises:
            WorldError: it is none, or not of this world.
        """
        try:
            scene = msgspec.convert(data["scene"], Scene)
            vehicle = msgspec.convert(data["vehicle"], str)
            shapes = tuple(_shape(one) for one in msgspec.convert(data["shapes"], list[dict[str, Any]]))
        except KeyError as missing:
            raise WorldError(f"what stands there is damaged: {missing} is missing or unknown") from missing
        except msgspec.ValidationError as problem:
            raise WorldError(f"what stands there is damaged: {problem}") from problem
        if scene.lane and not scene.lane.center_m:
            raise WorldError("what stands there is damaged: a lane without points")
        if not all(abs(number) < FARTHEST_M for number in _numbers([asdict(scene), *map(asdict, shapes)])):
            raise WorldError(f"what stands there is damaged: a number beyond {FARTHEST_M:g}")
        return cls(scene=scene, vehicle=vehicle, shapes=shapes)

    def outlines_m(self, x_m: float, y_m: float, yaw_rad: float) -> list[list[tuple[float, float]]]:
        """Return the vehicle from above where it stands, shape by shape, metres."""
        cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
        return [
            [(x_m + cos * x - sin * y, y_m + sin * x + cos * y) for x, y in shape.outline_m()] for shape in self.shapes
        ]


def _kind(shape: Shape) -> str:
    """Return what a shape is; a vehicle may have brought a class of its own for it."""
    return next(kind for kind, made in _SHAPES.items() if isinstance(shape, made))


def _shape(data: dict[str, Any]) -> Shape:
    made: Shape = msgspec.convert(data, _SHAPES[msgspec.convert(data["kind"], str)])
    return made


def _numbers(value: object) -> Iterator[float]:
    if isinstance(value, int | float):
        yield value
    elif isinstance(value, dict):
        for item in value.values():
            yield from _numbers(item)
    elif isinstance(value, list | tuple):
        for item in value:
            yield from _numbers(item)
