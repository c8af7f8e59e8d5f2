"""The exact side: hand-made vectors, and a dense bundle of rays that may never beat it."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.each import each
from tests.share import examples
from worlds import Box
from worlds.geometry import (
    _nearest_in_cone,
    add,
    cone_distance_m,
    cross,
    dot,
    ray_distance_m,
    rotation,
    subtract,
    turn,
    turn_back,
)

UNIT = Box(name="unit", center_m=(2.5, 0, 0), size_m=(1, 1, 1))
angles = st.floats(-math.pi, math.pi)
places = st.tuples(*[st.floats(-3, 3)] * 3)
boxes = st.builds(
    Box,
    name=st.just("box"),
    center_m=places,
    size_m=st.tuples(*[st.floats(0.05, 3)] * 3),
    yaw_rad=angles,
    pitch_rad=st.floats(-1.5, 1.5),
)
poses = st.tuples(places, angles, st.floats(-1.5, 1.5))


def in_box(box, point, slack=1e-9):
    own = turn_back(rotation(box.yaw_rad, box.pitch_rad), subtract(point, box.center_m))
    return all(abs(value) <= size / 2 + slack for value, size in zip(own, box.size_m, strict=True))


@each(
    ("start", "direction", "expected"),
    [
        ((0, 0, 0), (1, 0, 0), 2.0),
        ((0, 0.49, 0), (1, 0, 0), 2.0),
        ((0, 0.51, 0), (1, 0, 0), None),
        ((0, 0, 0), (-1, 0, 0), None),
        ((2.5, 0, 0), (1, 0, 0), 0.0),
        ((2.5, 0, 4), (0, 0, -1), 3.5),
    ],
)
def test_rays_at_a_unit_box(start, direction, expected):
    assert ray_distance_m(start, direction, [UNIT]) == expected


def test_a_ray_sees_the_nearest_box():
    far = Box(name="far", center_m=(5, 0, 0), size_m=(1, 1, 1))
    assert ray_distance_m((0, 0, 0), (1, 0, 0), [far, UNIT]) == 2.0
    assert ray_distance_m((0, 0, 0), (1, 0, 0), []) is None


def test_a_turned_box_shows_its_corner():
    turned = Box(name="turned", center_m=(2, 0, 0), size_m=(1, 1, 1), yaw_rad=math.pi / 4)
    assert ray_distance_m((0, 0, 0), (1, 0, 0), [turned]) == pytest.approx(2 - math.sqrt(0.5))


def test_negative_pitch_lifts_the_far_end():
    ramp = Box(name="ramp", center_m=(0, 0, 0), size_m=(4, 1, 0.002), pitch_rad=-math.radians(10))
    height = 5 - ray_distance_m((1, 0, 5), (0, 0, -1), [ramp])
    assert height == pytest.approx(math.tan(math.radians(10)), abs=2e-3)


@each(("incidence_deg", "nearest_deg"), [(0, 0), (10, 0), (15, 0), (20, 5), (60, 45)])
def test_a_cone_sees_a_slanted_wall_by_its_nearest_edge(incidence_deg, nearest_deg):
    wall = Box(name="wall", center_m=(2 + 0.05, 0, 0), size_m=(0.1, 40, 40))
    axis = (math.cos(math.radians(incidence_deg)), math.sin(math.radians(incidence_deg)), 0)
    seen = cone_distance_m((0, 0, 0), axis, math.radians(15), [wall])
    assert seen == pytest.approx(2 / math.cos(math.radians(nearest_deg)))


def test_a_cone_sees_a_post_that_its_axis_misses():
    post = Box(name="post", center_m=(2, 0.4, 0), size_m=(0.1, 0.1, 4))
    assert ray_distance_m((0, 0, 0), (1, 0, 0), [post]) is None
    assert cone_distance_m((0, 0, 0), (1, 0, 0), math.radians(15), [post]) == pytest.approx(math.hypot(1.95, 0.35))
    assert cone_distance_m((0, 0, 0), (1, 0, 0), math.radians(5), [post]) is None


@settings(max_examples=examples(200))
@given(box=boxes, pose=poses, half_angle_deg=st.floats(1, 60))
def test_what_the_cone_finds_is_on_the_box_and_in_the_cone(box, pose, half_angle_deg):
    apex, yaw, pitch = pose
    if in_box(box, apex, 1e-3):
        return
    axis = turn(rotation(yaw, pitch), (1, 0, 0))
    for point in _nearest_in_cone(apex, axis, math.radians(half_angle_deg), box):
        assert in_box(box, point, 1e-6)
        offset = subtract(point, apex)
        assert dot(offset, axis) >= math.cos(math.radians(half_angle_deg)) * math.hypot(*offset) - 1e-6


@settings(max_examples=examples(200))
@given(box=boxes, pose=poses, half_angle_deg=st.floats(1, 60))
def test_no_ray_inside_the_cone_is_nearer(box, pose, half_angle_deg):
    apex, yaw, pitch = pose
    if in_box(box, apex, 1e-3):
        return
    frame = rotation(yaw, pitch)
    exact = cone_distance_m(apex, turn(frame, (1, 0, 0)), math.radians(half_angle_deg), [box])
    for ring in range(6):
        angle = math.radians(half_angle_deg) * ring / 5 * (1 - 1e-9)
        for spoke in range(12):
            around = math.tau * spoke / 12
            ray = (math.cos(angle), math.sin(angle) * math.cos(around), math.sin(angle) * math.sin(around))
            hit = ray_distance_m(apex, turn(frame, ray), [box])
            if hit is not None:
                assert exact is not None
                assert exact <= hit + 1e-6


@given(pose=poses, roll=angles, vector=places)
def test_turning_back_undoes_turning(pose, roll, vector):
    frame = rotation(pose[1], pose[2], roll)
    assert turn_back(frame, turn(frame, vector)) == pytest.approx(vector, abs=1e-12)


def test_rotations_follow_the_right_hand():
    quarter = math.pi / 2
    assert turn(rotation(quarter), (1, 0, 0)) == pytest.approx((0, 1, 0))
    assert turn(rotation(0, quarter), (1, 0, 0)) == pytest.approx((0, 0, -1))
    assert turn(rotation(0, 0, quarter), (0, 1, 0)) == pytest.approx((0, 0, 1))
    assert turn(rotation(quarter, quarter, 0), (1, 0, 0)) == pytest.approx((0, 0, -1))
    assert cross((1, 0, 0), (0, 1, 0)) == (0, 0, 1)
    assert add((1, 2, 3), (1, 1, 1), 2.0) == (3, 4, 5)
