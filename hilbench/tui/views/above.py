"""The world from above in terminal cells: what stands there, the vehicle, its way, and what its sensors report."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import pairwise

from rich.text import Text

from hilbench.tui.model.places import Point, WorldModel
from hilbench.tui.views.canvas import Canvas
from hilbench.tui.views.words import DIM, HEAD, fit

__all__ = ["world_view"]

_LEAST_SPAN_M = 5.0
_NICE_M = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500)


def world_view(world: WorldModel, width: int, height: int) -> list[Text]:
    """Return the world in so many cells; north is where the y axis points, up."""
    if world.pose is None:
        return [Text("nothing is heard of a world yet" if world.vehicle else "this bench has no world", DIM)]
    canvas = Canvas(width, max(1, height - 1))
    place, per_m = _mapping(world, canvas)
    for outline in world.boxes:
        corners = [place(corner) for corner in outline]
        for begin, end in zip(corners, [*corners[1:], *corners[:1]], strict=True):
            canvas.line(begin, end)
    for begin, end in _edges_of(world):
        canvas.line(place(begin), place(end), DIM, every=2)
    for begin, end, heard in world.echoes.values():
        if heard:
            canvas.line(place(begin), place(end), "blue", every=3)
            canvas.dot(*place(end), "bold red")
    for point in world.track:
        canvas.dot(*place(point), "green")
    _draw_vehicle(canvas, world, place)
    return [*canvas.lines(), fit(_legend(world, per_m), width)]


def _mapping(world: WorldModel, canvas: Canvas) -> tuple[Callable[[Point], Point], float]:
    """Return what takes metres to dots, and how many dots a metre has."""
    assert world.pose is not None
    x, y, _ = world.pose
    points: list[Point] = [
        (x, y),
        *world.lane[0],
        *world.track,
        *(corner for outline in world.boxes for corner in outline),
    ]
    left, right = min(point[0] for point in points), max(point[0] for point in points)
    low, high = min(point[1] for point in points), max(point[1] for point in points)
    middle = ((left + right) / 2, (low + high) / 2)
    span_x, span_y = (max(_LEAST_SPAN_M / 2, right - left) + 1.0, max(_LEAST_SPAN_M / 2, high - low) + 1.0)
    per_m = min(canvas.width / span_x, canvas.height / span_y)

    def place(point: Point) -> Point:
        return (
            canvas.width / 2 + (point[0] - middle[0]) * per_m,
            canvas.height / 2 - (point[1] - middle[1]) * per_m,
        )

    return place, per_m


def _edges_of(world: WorldModel) -> Iterator[tuple[Point, Point]]:
    """Return both edges of the lane, piece by piece."""
    points, half_m = world.lane
    for before, after in pairwise(points):
        along = math.dist(before, after) or 1.0
        left_x, left_y = -(after[1] - before[1]) / along * half_m, (after[0] - before[0]) / along * half_m
        for sign in (1, -1):
            yield (
                (before[0] + sign * left_x, before[1] + sign * left_y),
                (after[0] + sign * left_x, after[1] + sign * left_y),
            )


def _draw_vehicle(canvas: Canvas, world: WorldModel, place: Callable[[Point], Point]) -> None:
    assert world.pose is not None
    x, y, yaw = world.pose
    length_m, breadth_m = world.size_m
    cos, sin = math.cos(yaw), math.sin(yaw)

    def corner(along: float, across: float) -> Point:
        return place((x + cos * along - sin * across, y + sin * along + cos * across))

    nose, left, right = (
        corner(length_m / 2, 0),
        corner(-length_m / 2, breadth_m / 2),
        corner(-length_m / 2, -breadth_m / 2),
    )
    for begin, end in ((nose, left), (left, right), (right, nose)):
        canvas.line(begin, end, "bold yellow")
    arrow = "→↗↑↖←↙↓↘"[round(yaw / (math.pi / 4)) % 8]
    canvas.letter(*place((x, y)), arrow, "bold yellow")


def _legend(world: WorldModel, per_m: float) -> Text:
    assert world.pose is not None
    x, y, yaw = world.pose
    long_m = next((nice for nice in _NICE_M if nice * per_m >= 8), _NICE_M[-1])
    ruler = "├" + "─" * max(0, round(long_m * per_m / 2) - 2) + "┤"
    where = f"x {x:+.2f} m  y {y:+.2f} m  {math.degrees(yaw):+.0f}°"
    return Text.assemble((f"{ruler} {long_m:g} m  ", DIM), (world.vehicle, HEAD), f" {where}  ", (world.scene, DIM))
