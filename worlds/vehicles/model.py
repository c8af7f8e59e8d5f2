"""What a vehicle is to the physics: rigid parts, joints and the figures they are made of, each with its source.

The first part is the body; every other part hangs on it, or on another part before it, by a fixed joint or by one axle.
Lengths are in the vehicle's own frame with every axle at angle 0. Its origin is the vehicle's reference point at floor
level (for a differential drive the middle between its wheels), x forward, y left, z up.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import Field, dataclass, field, fields
from typing import Any

from worlds.errors import WorldError
from worlds.motion import PlanarMotion

Point = tuple[float, float]
Vector = tuple[float, float, float]

_ROUND = 16
"""Corners of what is round, in a picture."""

ASSUMED = "assumed"
"""The source of a figure that nobody measured or published; reports print these."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter:
    """One figure of a vehicle: its name, its value in ``unit`` and where it comes from (or ``assumed: why``)."""

    name: str
    value: float
    unit: str
    source: str


def parameter(value: float, unit: str, source: str) -> Any:
    """Declare a dataclass field that knows its unit and its source."""
    return field(default=value, metadata={"unit": unit, "source": source})


def parameter_table(parameters: Any) -> tuple[Parameter, ...]:
    """Return the figures of a parameter dataclass as rows, in the order they are declared."""
    return tuple(_row(parameters, item) for item in fields(parameters))


def _row(parameters: Any, item: Field[Any]) -> Parameter:
    default = item.default
    value = getattr(parameters, item.name)
    source = item.metadata["source"] if value == default else f"set by the user, instead of {default:g}"
    return Parameter(name=item.name, value=value, unit=item.metadata["unit"], source=source)


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxShape:
    """A box: full edge lengths and middle in metres, turned about z by ``yaw_rad``."""

    size_m: Vector
    center_m: Vector
    yaw_rad: float = 0.0

    def outline_m(self) -> list[Point]:
        """Return its corners from above, counter-clockwise, vehicle frame, metres."""
        return _rectangle(self.center_m, self.size_m[0] / 2, self.size_m[1] / 2, self.yaw_rad)


@dataclass(frozen=True, slots=True, kw_only=True)
class SphereShape:
    """A sphere: radius and middle in metres."""

    radius_m: float
    center_m: Vector

    def outline_m(self) -> list[Point]:
        """Return it from above, as a polygon, counter-clockwise, vehicle frame, metres."""
        turns = (math.tau * corner / _ROUND for corner in range(_ROUND))
        x, y, _ = self.center_m
        return [(x + self.radius_m * math.cos(turn), y + self.radius_m * math.sin(turn)) for turn in turns]


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelShape:
    """A true cylinder (no facets) whose axis is the y axis: radius, width and middle in metres."""

    radius_m: float
    width_m: float
    center_m: Vector

    def outline_m(self) -> list[Point]:
        """Return its corners from above, counter-clockwise, vehicle frame, metres."""
        return _rectangle(self.center_m, self.radius_m, self.width_m / 2)


def _rectangle(center_m: Vector, half_x_m: float, half_y_m: float, yaw_rad: float = 0.0) -> list[Point]:
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    corners = ((half_x_m, half_y_m), (-half_x_m, half_y_m), (-half_x_m, -half_y_m), (half_x_m, -half_y_m))
    return [(center_m[0] + cos * x - sin * y, center_m[1] + sin * x + cos * y) for x, y in corners]


Shape = BoxShape | SphereShape | WheelShape


@dataclass(frozen=True, slots=True, kw_only=True)
class Axle:
    """A joint that turns without end.

    Attributes:
        origin_m: a point on the axis, vehicle frame.
        axis: unit vector; a wheel's is (0, 1, 0), so that positive angles roll forward.
        friction_nm: dry friction of the released joint, N·m.
        reflected_inertia_kg_m2: of what turns with the joint through a gear, times the gear's ratio squared. The
            axle then has to lie along one of the vehicle's axes. PyBullet gives it to the part, so that it also counts
            where the whole vehicle turns about that axis; MuJoCo to the joint alone.
    """

    origin_m: Vector
    axis: Vector = (0.0, 1.0, 0.0)
    friction_nm: float = 0.0
    reflected_inertia_kg_m2: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """A rigid part.

    Attributes:
        name: unique; contacts report it, and a part with an axle gives its name to the joint.
        mass_kg: 0 only for a body that stays where it is put.
        center_of_mass_m: vehicle frame.
        inertia_kg_m2: principal moments about the centre of mass, axes along the vehicle's.
        shapes: what it collides with.
        friction: Coulomb coefficient against a surface of 1.0.
        axle: None for a part that is fixed to what it hangs on (and for the body itself).
        on: the part that it hangs on, which stands before it; the body if empty.
    """

    name: str
    mass_kg: float
    center_of_mass_m: Vector
    inertia_kg_m2: Vector
    shapes: tuple[Shape, ...] = ()
    friction: float = 0.5
    axle: Axle | None = None
    on: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class DifferentialDrive:
    """Two wheels side by side: the names of their parts, their radius and their effective track in metres."""

    left: str
    right: str
    wheel_radius_m: float
    track_m: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Vehicle:
    """A vehicle.

    Attributes:
        name: of its kind.
        parts: body first.
        drive: how it is driven, if by two wheels side by side.
        motion: makes the model that moves it on a floor of this friction (`worlds.scenes.Scene.floor_friction`), where
            that is not left to its wheels (`worlds.motion`).
        mounts: places on the body where sensors sit, by name: metres, vehicle frame.
        parameters: the figures it was made from.
    """

    name: str
    parts: tuple[Part, ...]
    drive: DifferentialDrive | None = None
    motion: Callable[[float], PlanarMotion] | None = None
    mounts: Mapping[str, Vector] = field(default_factory=dict)
    parameters: tuple[Parameter, ...] = ()

    @property
    def joints(self) -> tuple[str, ...]:
        """The names of the joints that turn."""
        return tuple(part.name for part in self.parts if part.axle is not None)


def parents(vehicle: Vehicle) -> Iterator[tuple[Part, str | None]]:
    """Give each part with the name of the part that it hangs on, None for the body; each after what it hangs on.

    Raises:
        WorldError: a part hangs on none that stands before it.
    """
    body = vehicle.parts[0]
    before = {body.name}
    yield body, None
    for part in vehicle.parts[1:]:
        parent = part.on or body.name
        if parent not in before:
            raise WorldError(f"vehicle {vehicle.name!r}: {part.name!r} hangs on {parent!r}, which is no part before it")
        if part.axle and not part.mass_kg:
            raise WorldError(f"vehicle {vehicle.name!r}: {part.name!r} turns and has no mass: give it some")
        before.add(part.name)
        yield part, parent


def box_inertia(mass_kg: float, size_m: Vector) -> Vector:
    """Return the principal moments of a homogeneous box about its middle, kg·m²."""
    x, y, z = (length * length for length in size_m)
    return mass_kg * (y + z) / 12, mass_kg * (x + z) / 12, mass_kg * (x + y) / 12


def wheel_inertia(mass_kg: float, radius_m: float, width_m: float) -> Vector:
    """Return the principal moments of a homogeneous cylinder along y about its middle, kg·m²."""
    across = mass_kg * (3 * radius_m**2 + width_m**2) / 12
    return across, mass_kg * radius_m**2 / 2, across


def sphere_inertia(mass_kg: float, radius_m: float) -> Vector:
    """Return the principal moments of a homogeneous sphere about its middle, kg·m²."""
    moment = 0.4 * mass_kg * radius_m**2
    return moment, moment, moment
