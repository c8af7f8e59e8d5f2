"""Where the vehicle is, where it has been, and what its sonar hears, seen from above."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

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
        echoes: where the newest reading of each sonar disc lies: from, to, and whether anything was heard.
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
    _discs: Sequence[Sequence[float]] = ()
    _unit_m: float = 0.0
    _no_echo: int = 0

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
        made._discs = live.get("sonars", ())
        made._unit_m = live.get("sonar_unit_mm", 0.0) / 1000
        made._no_echo = live.get("sonar_no_echo", 1 << 16)
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

    def take_sonars(self, readings: Sequence[Event]) -> None:
        """Take the readings of a SIP; they are drawn from where the vehicle is now."""
        if self.pose is None:
            return
        x, y, yaw = self.pose
        for reading in readings:
            number = reading["number"]
            if number >= len(self._discs):
                continue
            disc_x, disc_y, disc_th = self._discs[number]
            begin = (
                x + disc_x * math.cos(yaw) - disc_y * math.sin(yaw),
                y + disc_x * math.sin(yaw) + disc_y * math.cos(yaw),
            )
            heard = reading["range_raw"] < self._no_echo
            length_m = reading["range_raw"] * self._unit_m if heard else 0.0
            end = (begin[0] + length_m * math.cos(yaw + disc_th), begin[1] + length_m * math.sin(yaw + disc_th))
            self.echoes[number] = (begin, end, heard)
