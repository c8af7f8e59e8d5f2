"""Sonar ranges from the physics against exact geometry from the scene's own data."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest

from worlds import Box, Scene, UnknownNameError
from worlds.geometry import add, cone_distance_m, ray_distance_m, rotation, turn
from worlds.vehicles.pioneer_2dx import DEFAULTS, Pioneer2dxBody

pytestmark = pytest.mark.needs_bullet

HALF_ANGLE = math.radians(15)
EDGE_M = 2e-3
EXACT_M = 1e-6


def free_places(scene, count, seed):
    """Poses at which no part of a robot is inside a box."""
    rng = random.Random(seed)
    reach = 4.5 if scene.name.startswith("room") else 0.6
    found = []
    while len(found) < count:
        x, y, yaw = rng.uniform(-reach, reach), rng.uniform(-reach, reach), rng.uniform(-math.pi, math.pi)
        if all(math.hypot(box.center_m[0] - x, box.center_m[1] - y) > 0.8 for box in scene.boxes if box.size_m[0] < 1):
            found.append((x, y, yaw))
    return found


def cone_rays():
    yield 1.0, 0.0, 0.0
    for angle in (HALF_ANGLE / 2, HALF_ANGLE):
        for around in range(4):
            side = math.pi / 2 * around
            yield math.cos(angle), math.sin(angle) * math.cos(side), math.sin(angle) * math.sin(side)


def grown(boxes, by_m):
    return [replace(box, size_m=tuple(size + 2 * by_m for size in box.size_m)) for box in boxes]


def disc_frame(body, disc):
    """Where a disc's face is and the rotation that turns x into its axis."""
    pose, (x, y, heading) = body.world.pose(), disc
    face = add(pose.position_m, turn(rotation(pose.yaw_rad), (x, y, DEFAULTS.sonar_height_m)))
    return face, rotation(pose.yaw_rad + heading)


def sampled_m(body, disc, boxes):
    """What the nine rays say when they are computed exactly; 5 m and beyond is infinite, below 0.1 m is 0.1 m."""
    face, facing = disc_frame(body, disc)
    hits = [ray_distance_m(face, turn(facing, ray), boxes) for ray in cone_rays()]
    return max(min((hit for hit in hits if hit is not None and hit < 5.0), default=math.inf), 0.1)


def cone_m(body, disc):
    face, facing = disc_frame(body, disc)
    return cone_distance_m(face, turn(facing, (1.0, 0.0, 0.0)), HALF_ANGLE, body.world.scene.boxes)


@pytest.mark.parametrize("scene", ["wall", "room-with-boxes", "corridor"])
def test_ranges_match_exact_geometry(pioneer, discs, scene):
    """On faces to a micrometre; at an edge the physics may see a box up to two millimetres wider or slimmer."""
    body = pioneer(scene, seed=3)
    boxes = body.world.scene.boxes
    echoes = exact = 0
    for x, y, yaw in free_places(body.world.scene, 40, seed=1):
        body.world.place(x, y, yaw)
        for number, disc in enumerate(discs):
            echo = body.sonar_range_m(number)
            heard = math.inf if echo is None else echo
            assert sampled_m(body, disc, grown(boxes, EDGE_M)) <= heard <= sampled_m(body, disc, grown(boxes, -EDGE_M))
            if echo is not None:
                echoes += 1
                exact += echo == pytest.approx(sampled_m(body, disc, boxes), abs=1e-6)
                assert echo >= cone_m(body, disc) - 5e-3
    assert echoes > 60
    assert exact >= 0.97 * echoes


def test_an_upright_wall_is_at_most_a_fifth_of_a_percent_long(pioneer, discs):
    body = pioneer("wall")
    for step in range(-60, 61):
        body.world.place(0.0, 0.0, math.radians(step / 2))
        cone = cone_m(body, discs[3])
        assert cone - 1e-6 <= body.sonar_range_m(3) <= cone * 1.0022


def test_square_to_a_wall_the_range_is_measured_from_the_disc(open_it):
    body = Pioneer2dxBody(open_it("wall", "pioneer-2dx"), sonar_poses=[(0.166, 0.0, 0.0)])
    for gap in (0.3, 1.0, 1.5):
        body.world.place(2.0 - 0.166 - gap, 0.0, 0.0)
        assert body.sonar_range_m(0) == pytest.approx(gap, abs=EXACT_M)


def test_nearer_than_the_blind_zone_reads_the_blind_zone(pioneer):
    body = pioneer("wall")
    body.world.place(2.0 - 0.215, 0.0, 0.0)
    assert body.sonar_range_m(3) == 0.1


@pytest.mark.parametrize(("distance_m", "heard"), [(4.9, True), (5.1, False)])
def test_no_echo_beyond_full_range(open_it, distance_m, heard):
    wall = Box(name="wall", center_m=(distance_m + 0.05, 0, 1), size_m=(0.1, 8, 2))
    world = open_it(Scene(name="far", boxes=(wall,)), "pioneer-2dx")
    body = Pioneer2dxBody(world, sonar_poses=[(0.0, 0.0, 0.0)])
    echo = body.sonar_range_m(0)
    assert echo == pytest.approx(distance_m, abs=EXACT_M) if heard else echo is None


def test_neither_floor_nor_robot_echoes(pioneer):
    body = pioneer("empty")
    assert [body.sonar_range_m(number) for number in range(8)] == [None] * 8


def test_the_floor_stops_rays_that_ask_for_it(open_it):
    world = open_it("empty", "pioneer-2dx")
    down = [(0.0, 0.0, 1.0)], [(0.0, 0.0, -1.0)]
    assert world.cast(*down) == [1.0]
    assert world.cast(*down, floor=True) == pytest.approx([0.5], abs=1e-3)


def test_discs_that_are_not_there(pioneer):
    body = pioneer("empty")
    for number in (-1, 8):
        with pytest.raises(UnknownNameError, match="sonar disc"):
            body.sonar_range_m(number)


def test_rays_take_arrays(open_it):
    numpy = pytest.importorskip("numpy")
    world = open_it("wall", "pioneer-2dx")
    starts, ends = numpy.array([[0, 0, 0.3], [0, 0, 0.9]], dtype=float), numpy.array([[4, 0, 0.3], [4, 0, 0.9]])
    assert world.cast(starts, ends) == pytest.approx([0.5, 1.0], abs=1e-3)
