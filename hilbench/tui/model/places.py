"""Where the vehicle is, where it has been, and what its range sensors report, seen from above."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hilbench.plugins.dashboard import Echo
from worlds.stage import Stage

__all__ = ["WorldModel"]

Event = Mapping[str, Any]
Point = tuple[float, float]

_TRACK_POINTS = 3000
_TRACK_STEP_M = 0.02
_SIZE_M = (0.4, 0.3)
"""Of a vehicle in a recording that does not say it (choice)."""


@dataclass(slots=True)
class WorldModel:
    """The world around the vehicle, in metres and radians.

    Attributes:
        boxes: outlines of what stands there.
        vehicle: its name; empty if there is no world.
        scene: the name of the scene.
        size_m: length and breadth of the vehicle.
        pose: x, y and yaw; None before it was reported.
        track: where it has been, at most some thousand points.
        lane: the middle of the way it is meant to go, and half its breadth; no points where there is none.
        echoes: where the newest reading of each range sensor lies: from, to, and whether anything was heard.
    """

    boxes: Sequence[Sequence[Point]] = ()
    vehicle: str = ""
    scene: str = ""
    size_m: tuple[float, float] = _SIZE_M
    pose: tuple[float, float, float] | None = None
    track: deque[Point] = field(default_factory=lambda: deque(maxlen=_TRACK_POINTS))
    lane: tuple[Sequence[Point], float] = ((), 0.0)
    echoes: dict[int, tuple[Point, Point, bool]] = field(default_factory=dict)
    _of_header: bool = False

    @classmethod
    def of(cls, live: Event) -> WorldModel:
        """Make it from what the header of a journal says."""
        scene = live.get("scene") or {}
        made = cls(
            boxes=[[(x, y) for x, y in outline] for outline in scene.get("boxes", ())],
            vehicle=str(live.get("vehicle", "")),
            scene=str(scene.get("name", "")),
        )
        if lane := live.get("lane"):
            points = [(x, y) for x, y in lane["center"]]
            made.lane = [*points, *points[:1]] if lane["closed"] else points, lane["width_m"] / 2
        made._of_header = bool(scene)
        made.size_m = live.get("vehicle_size_m", _SIZE_M)
        return made

    def take(self, event: Event) -> None:
        """Take what stands there, or a true pose."""
        if event["kind"] == "scene":
            self._take_scene(event)
        else:
            self._take_pose(event)

    def _take_scene(self, event: Event) -> None:
        """Take what stands around the vehicle from now on, where the header says nothing: each case has its own."""
        if self._of_header:
            return
        stage = Stage.from_data(event)
        self.boxes, self.scene, self.vehicle = tuple(stage.scene.outlines_m().values()), stage.scene.name, stage.vehicle
        if corners := [corner for shape in stage.shapes for corner in shape.outline_m()]:
            length_m, breadth_m = (max(along) - min(along) for along in zip(*corners, strict=True))
            self.size_m = length_m, breadth_m
        if lane := stage.scene.lane:
            self.lane = [*lane.center_m, *lane.center_m[: lane.closed]], lane.width_m / 2
        else:
            self.lane = (), 0.0
        self.pose = None
        self.track.clear()
        self.echoes.clear()

    def _take_pose(self, event: Event) -> None:
        x, y, yaw = event["x_m"] / 1e6, event["y_m"] / 1e6, event["yaw_rad"] / 1e6
        self.pose = (x, y, yaw)
        if not self.track or math.dist(self.track[-1], (x, y)) >= _TRACK_STEP_M:
            self.track.append((x, y))

    def take_echoes(self, echoes: Iterable[Echo]) -> None:
        """Take what range sensors report; it is drawn from where the vehicle is now."""
        if self.pose is None:
            return
        x, y, yaw = self.pose
        for echo in echoes:
            if echo.place is None:
                continue
            from_x, from_y, direction = echo.place
            begin = (
                x + from_x * math.cos(yaw) - from_y * math.sin(yaw),
                y + from_x * math.sin(yaw) + from_y * math.cos(yaw),
            )
            range_m = echo.range_m or 0.0
            end = (begin[0] + range_m * math.cos(yaw + direction), begin[1] + range_m * math.sin(yaw + direction))
            self.echoes[echo.number] = (begin, end, echo.range_m is not None)
