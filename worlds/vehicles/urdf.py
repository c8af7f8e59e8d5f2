"""A vehicle as URDF text, the only form PyBullet loads joints from.

URDF says inertia, joints and shapes; friction and damping are set after loading, because URDF has no standard words
for them.
"""

from __future__ import annotations

import math

from worlds.vehicles.model import BoxShape, Part, Shape, SphereShape, Vector, Vehicle, parents

_NOWHERE = (0.0, 0.0, 0.0)
"""The origin of the vehicle's own frame."""


def to_urdf(vehicle: Vehicle) -> str:
    """Return the vehicle as URDF. Numbers are written so that they read back bit for bit.

    Raises:
        WorldError: a part hangs on none that stands before it.
    """
    lines, origins = [f'<robot name="{vehicle.name}">'], {}
    for part, parent in parents(vehicle):
        origins[part.name] = origin = part.axle.origin_m if part.axle else _NOWHERE
        lines += _link(part, origin)
        if parent is not None:
            lines += _joint(parent, part, _minus(origin, origins[parent]))
    return "\n".join([*lines, "</robot>"])


def _link(part: Part, origin: Vector) -> list[str]:
    ixx, iyy, izz = part.inertia_kg_m2
    return [
        f'<link name="{part.name}">',
        "<inertial>",
        f'<origin xyz="{_numbers(_minus(part.center_of_mass_m, origin))}"/>',
        f'<mass value="{part.mass_kg!r}"/>',
        f'<inertia ixx="{ixx!r}" ixy="0" ixz="0" iyy="{iyy!r}" iyz="0" izz="{izz!r}"/>',
        "</inertial>",
        *(_collision(shape, origin) for shape in part.shapes),
        "</link>",
    ]


def _joint(parent: str, part: Part, origin: Vector) -> list[str]:
    kind = "continuous" if part.axle else "fixed"
    return [
        f'<joint name="{part.name}" type="{kind}">',
        f'<parent link="{parent}"/><child link="{part.name}"/>',
        f'<origin xyz="{_numbers(origin)}"/>',
        f'<axis xyz="{_numbers(part.axle.axis)}"/>' if part.axle else "",
        "</joint>",
    ]


def _collision(shape: Shape, origin: Vector) -> str:
    if isinstance(shape, BoxShape):
        turn, geometry = (0.0, 0.0, shape.yaw_rad), f'<box size="{_numbers(shape.size_m)}"/>'
    elif isinstance(shape, SphereShape):
        turn, geometry = (0.0, 0.0, 0.0), f'<sphere radius="{shape.radius_m!r}"/>'
    else:  # a URDF cylinder stands along z
        turn, geometry = (math.pi / 2, 0.0, 0.0), f'<cylinder radius="{shape.radius_m!r}" length="{shape.width_m!r}"/>'
    place = f'<origin xyz="{_numbers(_minus(shape.center_m, origin))}" rpy="{_numbers(turn)}"/>'
    return f"<collision>{place}<geometry>{geometry}</geometry></collision>"


def _minus(one: Vector, other: Vector) -> Vector:
    return one[0] - other[0], one[1] - other[1], one[2] - other[2]


def _numbers(vector: Vector) -> str:
    return " ".join(repr(value) for value in vector)
