"""A picture of a vehicle in its scene by MuJoCo's renderer, which wants PyOpenGL and a GL of the system: EGL or OSMesa.

Nothing of a world is needed that lives: a stage and a pose are enough. The model is that of the physics, whose wheels
are crowned.
"""

from __future__ import annotations

import ctypes.util
import importlib.util
import math
import os
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from worlds.errors import CapabilityError, WorldError
from worlds.mujoco_builder import BOX_GROUP, build, import_mujoco
from worlds.png import png
from worlds.stage import Stage
from worlds.vehicles.model import BoxShape, Part, Shape, Vehicle
from worlds.world import Pose

__all__ = ["picture"]

_Colour = tuple[float, float, float, float]

_FLOOR: _Colour = (0.86, 0.86, 0.84, 1.0)
_BOX: _Colour = (0.55, 0.60, 0.66, 1.0)
_BODY: _Colour = (0.80, 0.30, 0.10, 1.0)
_WHEEL: _Colour = (0.12, 0.12, 0.12, 1.0)
_TRACK: _Colour = (0.0, 0.45, 0.70, 1.0)
_LANE: _Colour = (0.45, 0.45, 0.47, 1.0)
_LIGHT = 0.5
"""From everywhere, and as much from the camera."""

_BODY_NAME = "body"
_TRACK_SHARE = 0.05
"""How wide the way is drawn, in lengths of the vehicle (choice)."""
_PAINT_HEIGHT_M = 0.001
_PIECES = 4000
"""Of one line."""
_SEEN_FROM_RAD = math.radians(-35)
_LEAST_DISTANCE_M = 1.5
_LENGTHS_AWAY = 6
"""How far the camera is behind the vehicle, in lengths of the vehicle (choice)."""


def picture(stage: Stage, pose: Pose, track: Sequence[tuple[float, float]], size_px: tuple[int, int]) -> bytes:
    """Return a picture from behind and above the vehicle, as PNG.

    Args:
        stage: what stands there, and the vehicle.
        pose: where the vehicle is.
        track: where it was, metres.
        size_px: width and height.

    Raises:
        PhysicsMissingError: MuJoCo is not installed.
        CapabilityError: there is no GL, or no PyOpenGL; the text says how to get it.
        WorldError: MuJoCo refuses the scene or the vehicle.
    """
    if not importlib.util.find_spec("OpenGL"):
        raise CapabilityError("PyOpenGL is not installed: run `pip install 'hilbench[picture]'`")
    if "MUJOCO_GL" not in os.environ:
        os.environ["MUJOCO_GL"] = "egl" if ctypes.util.find_library("EGL") else "osmesa"
    try:
        return png(_drawn(import_mujoco(), stage, pose, track, size_px), *size_px)
    except WorldError:
        raise
    except Exception as problem:  # what a GL lacks comes in a dozen kinds, some of them from ctypes
        text = " ".join(str(problem).split())
        raise CapabilityError(
            f"there is no GL to draw with ({text}): install EGL or OSMesa (Debian: libegl1, libosmesa6)"
        ) from problem


def _drawn(
    mujoco: Any, stage: Stage, pose: Pose, track: Sequence[tuple[float, float]], size_px: tuple[int, int]
) -> bytes:
    """Return the colours of a picture."""
    body = Part(name=_BODY_NAME, mass_kg=0, center_of_mass_m=(0, 0, 0), inertia_kg_m2=(0, 0, 0), shapes=stage.shapes)
    model = build(mujoco, stage.scene, Vehicle(name=stage.vehicle, parts=(body,)), step_hz=240).model
    model.vis.global_.offwidth, model.vis.global_.offheight = size_px
    data = mujoco.MjData(model)
    data.mocap_pos[0] = pose.position_m
    data.mocap_quat[0] = (math.cos(pose.yaw_rad / 2), 0.0, 0.0, math.sin(pose.yaw_rad / 2))
    _paint(model, stage.shapes)
    for look in (mujoco.mj_kinematics, mujoco.mj_comPos, mujoco.mj_camlight):  # no forces: what touches is no matter
        look(model, data)
    camera = _camera(mujoco, stage.shapes, pose)
    model.stat.extent = camera.distance  # how near and how far is seen is counted in it
    with mujoco.Renderer(model, size_px[1], size_px[0], max_geom=2 * _PIECES + model.ngeom + 1) as renderer:
        for _ in range(2):  # the endless floor is laid around the camera of the time before
            renderer.update_scene(data, camera)
        _draw_lines(renderer.scene, mujoco, stage, track)
        pixels: bytes = renderer.render().tobytes()
        return pixels


def _paint(model: Any, shapes: Sequence[Shape]) -> None:
    model.vis.headlight.ambient[:] = model.vis.headlight.diffuse[:] = _LIGHT
    model.geom_rgba[:] = _FLOOR
    model.geom_rgba[model.geom_group == BOX_GROUP] = _BOX
    for number, shape in enumerate(shapes):
        model.geom(f"{_BODY_NAME}:{number}").rgba = _BODY if isinstance(shape, BoxShape) else _WHEEL


def _camera(mujoco: Any, shapes: Sequence[Shape], pose: Pose) -> Any:
    """Behind the vehicle and above it."""
    camera = mujoco.MjvCamera()
    camera.lookat[:] = pose.position_m
    camera.distance = max(_LEAST_DISTANCE_M, _LENGTHS_AWAY * _length_m(shapes))
    camera.azimuth, camera.elevation = math.degrees(pose.yaw_rad), math.degrees(_SEEN_FROM_RAD)
    return camera


def _length_m(shapes: Sequence[Shape]) -> float:
    corners = [point for shape in shapes for point in shape.outline_m()]
    return 2 * max((math.hypot(x, y) for x, y in corners), default=0.0)


def _draw_lines(drawn: Any, mujoco: Any, stage: Stage, track: Sequence[tuple[float, float]]) -> None:
    """Lay the lane and the way that was driven on the floor; of very many points every so many."""
    lane, height_m = stage.scene.lane, _PAINT_HEIGHT_M
    if lane:
        middle = [*lane.center_m, *lane.center_m[:1]] if lane.closed else lane.center_m
        _lay(drawn, mujoco, middle, (lane.width_m, height_m), _LANE)
    _lay(drawn, mujoco, track, (_TRACK_SHARE * _length_m(stage.shapes), 2 * height_m), _TRACK)


def _lay(
    drawn: Any, mujoco: Any, points: Sequence[tuple[float, float]], size_m: tuple[float, float], colour: _Colour
) -> None:
    """Lay flat boxes from point to point."""
    width_m, height_m = size_m
    for begin, end in pairwise([*points[:: len(points) // _PIECES + 1], points[-1]]):
        length_m, yaw_rad = math.dist(begin, end), math.atan2(end[1] - begin[1], end[0] - begin[0])
        if length_m and drawn.ngeom < drawn.maxgeom:
            cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
            mujoco.mjv_initGeom(
                drawn.geoms[drawn.ngeom],
                mujoco.mjtGeom.mjGEOM_BOX,
                [(length_m + width_m / 2) / 2, width_m / 2, height_m],
                [(begin[0] + end[0]) / 2, (begin[1] + end[1]) / 2, 0.0],
                [cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0],
                colour,
            )
            drawn.ngeom += 1
