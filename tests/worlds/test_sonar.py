"""Sonar ranges from the physics against exact geometry from the scene's own data."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest

from tests.share import ALL, few
from worlds import Box, Scene, UnknownNameError
from worlds.geometry import add, cone_distance_m, ray_distance_m, rotation, turn
from worlds.vehicles.pioneer_2dx import DEFAULTS, Pioneer2dxBody

HALF_ANGLE = math.radians(15)
EDGE_M = 2e-3
EXACT_M = 1e-6
PLACES = 40 if ALL else 20
SEEDS = (1, 9, 22, 28) if ALL else (9, 22)


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
    """Unit vectors by degrees to the left and upwards: at most 3.75 degrees apart in the plane of the discs."""
    level = [(3.75 * step, 0.0) for step in range(-4, 5)]
    for left, up in [*level, (0.0, 7.5), (0.0, -7.5), (0.0, 15.0), (0.0, -15.0)]:
        yield turn(rotation(math.radians(left), -math.radians(up)), (1.0, 0.0, 0.0))


def grown(boxes, by_m):
    return [replace(box, size_m=tuple(size + 2 * by_m for size in box.size_m)) for box in boxes]


def disc_frame(body, disc):
    """Where a disc's face is and the rotation that turns x into its axis."""
    pose, (x, y, heading) = body.world.pose(), disc
    face = add(pose.position_m, turn(rotation(pose.yaw_rad), (x, y, DEFAULTS.sonar_height_m)))
    return face, rotation(pose.yaw_rad + heading)


def sampled_m(body, disc, boxes):
    """What the thirteen rays say when they are computed exactly; 5 m and beyond is infinite, below 0.1 m is 0.1 m."""
    face, facing = disc_frame(body, disc)
    hits = [ray_distance_m(face, turn(facing, ray), boxes) for ray in cone_rays()]
    return max(min((hit for hit in hits if hit is not None and hit < 5.0), default=math.inf), 0.1)


def cone_m(body, disc, by_m=0.0):
    """The exact distance within the cone, of boxes grown by so much."""
    face, facing = disc_frame(body, disc)
    return cone_distance_m(face, turn(facing, (1.0, 0.0, 0.0)), HALF_ANGLE, grown(body.world.scene.boxes, by_m))


@pytest.mark.parametrize("scene", few(["room-with-boxes", "wall", "corridor"], 1, "other scenes"))
def test_ranges_match_exact_geometry(pioneer, discs, scene):
    """On faces to a micrometre; at an edge (one echo in thirty) the physics may see a box two millimetres wider or
    slimmer."""
    body = pioneer(scene, seed=3)
    boxes = body.world.scene.boxes
    echoes = exact = 0
    for x, y, yaw in free_places(body.world.scene, PLACES, seed=1):
        body.world.place(x, y, yaw)
        for number, disc in enumerate(discs):
            echo = body.sonar_range_m(number)
            heard = math.inf if echo is None else echo
            assert sampled_m(body, disc, grown(boxes, EDGE_M)) <= heard <= sampled_m(body, disc, grown(boxes, -EDGE_M))
            if echo is not None:
                echoes += 1
                exact += echo == pytest.approx(sampled_m(body, disc, boxes), abs=1e-6)
                assert echo >= min(cone_m(body, disc, EDGE_M), 5.0) - EXACT_M
    assert echoes > 1.5 * PLACES
    assert exact >= 0.95 * echoes


def test_an_upright_wall_is_at_most_a_twentieth_of_a_percent_long(pioneer, discs):
    body = pioneer("wall")
    for step in range(-60, 61):
        body.world.place(0.0, 0.0, math.radians(step / 2))
        cone = cone_m(body, discs[3])
        assert cone - 1e-6 <= body.sonar_range_m(3) <= cone * 1.00054


@pytest.mark.parametrize("distance_m", few([4.5, 1.0, 2.5], 1, "other distances"))
def test_what_is_wider_than_the_gap_between_two_rays_is_heard(open_it, distance_m):
    """A slab square to the line of sight, 0.066 of its distance wide, wherever in the cone it stands."""
    missed = []
    for bearing_deg in range(-15, 16):
        bearing, width = math.radians(bearing_deg), 0.066 * distance_m
        middle = ((distance_m + 0.05) * math.cos(bearing), (distance_m + 0.05) * math.sin(bearing), 0.25)
        slab = Box(name="slab", center_m=middle, size_m=(0.1, width, 0.5), yaw_rad=bearing)
        world = open_it(Scene(name="slab", boxes=(slab,)), "pioneer-2dx")
        echo = Pioneer2dxBody(world, sonar_poses=[(0.0, 0.0, 0.0)]).sonar_range_m(0)
        world.close()
        if echo != pytest.approx(distance_m, rel=1e-3):
            missed.append((bearing_deg, echo))
    assert missed == []


def test_in_seeded_rooms_no_reading_is_far_too_long(pioneer, discs):
    """Boxes are 0.3 to 0.6 m wide; with rays 7.5 degrees apart one of them went unseen, and 1.3 m were too many."""
    worst = 0.0
    for seed in SEEDS:
        body = pioneer("room-with-boxes", seed=seed)
        for x, y, yaw in free_places(body.world.scene, 25, seed=seed):
            body.world.place(x, y, yaw)
            for number, disc in enumerate(discs):
                cone = cone_m(body, disc)
                if cone is not None and cone < 4.5:
                    worst = max(worst, (body.sonar_range_m(number) or 5.0) - max(cone, 0.1))
    assert 0.0 < worst < 0.2


def test_a_scan_costs_one_call_per_disc(pioneer, monkeypatch):
    body = pioneer("wall")
    calls = []
    monkeypatch.setattr(body.world, "cast", lambda starts, ends: calls.append(len(starts)) or [1.0] * len(starts))
    for number in range(8):
        body.sonar_range_m(number)
    assert calls == [13] * 8


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
