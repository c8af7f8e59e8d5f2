from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.each import each
from tests.share import examples
from worlds import Box, Scene, SceneFileError, Start, UnknownNameError, find_scene, scene_names
from worlds.scenes.builtin import BUILTIN, ROOM_BOXES

GOOD = """
name = "my-lab"
floor_friction = 0.9
[start]
x_m = 1
y_m = -2.5
yaw_deg = 90
[[boxes]]
name = "crate"
center_m = [2.0, 0.5, 0.2]
size_m = [0.4, 0.4, 0.4]
yaw_deg = 30.0
pitch_deg = -8
friction = 0.3
[[boxes]]
name = "post"
center_m = [4, 0, 1]
size_m = [0.1, 0.1, 2]
"""


@pytest.fixture
def read(tmp_path):
    def reader(text):
        path = tmp_path / "lab.toml"
        path.write_text(text)
        return find_scene(str(path))

    return reader


@each("name", scene_names())
def test_built_in_scenes_are_what_they_are_called(name):
    scene = find_scene(name)
    assert scene.name == name
    names = [box.name for box in scene.boxes]
    assert len(set(names)) == len(names)
    assert scene == find_scene(name)
    assert list(scene.outlines_m()) == names


@each(("name", "free_m"), [("empty", math.inf), ("wall", 2.0), ("corridor", 19.0), ("ramp", 1.5)])
def test_free_distance_ahead(name, free_m):
    scene = find_scene(name)
    assert scene.free_ahead_m() == pytest.approx(free_m, abs=1e-9)
    assert scene.endless == (free_m == math.inf)


def test_free_distance_follows_the_heading_and_the_width():
    post = Box(name="post", center_m=(0, 3, 0.5), size_m=(0.2, 0.2, 1))
    scene = Scene(name="post", start=Start(x_m=0.3, yaw_rad=math.pi / 2), boxes=(post,))
    assert scene.free_ahead_m(0.25) == pytest.approx(2.9)
    assert scene.free_ahead_m(0.15) == math.inf
    away = Scene(name="post", start=Start(yaw_rad=-math.pi / 2), boxes=(post,))
    assert away.free_ahead_m() == math.inf


@settings(max_examples=examples(50))
@given(seed=st.integers(0, 2**32))
def test_the_room_leaves_space_round_the_start_and_between_boxes(seed):
    scene = find_scene("room-with-boxes", seed)
    boxes = [box for box in scene.boxes if box.name.startswith("box")]
    assert len(boxes) == ROOM_BOXES
    for box in boxes:
        corners = box.outline_m()
        assert min(math.hypot(x, y) for x, y in corners) > 1.5
        assert max(max(abs(x), abs(y)) for x, y in corners) < 5.0
    for one, other in itertools.combinations(boxes, 2):
        assert min(math.dist(a, b) for a in one.outline_m() for b in other.outline_m()) > 0.69


def test_the_seed_decides_the_room():
    assert find_scene("room-with-boxes", 1) == find_scene("room-with-boxes", 1)
    assert find_scene("room-with-boxes", 1) != find_scene("room-with-boxes", 2)


def test_an_outline_is_the_shadow_of_the_box():
    flat = Box(name="flat", center_m=(1, 2, 0), size_m=(2, 1, 1), yaw_rad=math.pi / 2)
    assert {(round(x, 9), round(y, 9)) for x, y in flat.outline_m()} == {(0.5, 1), (0.5, 3), (1.5, 1), (1.5, 3)}
    upright = Box(name="upright", center_m=(0, 0, 0), size_m=(2, 1, 4), pitch_rad=math.pi / 2)
    assert max(x for x, _ in upright.outline_m()) == pytest.approx(2.0)


def test_a_scene_file_says_what_it_says(read):
    scene = read(GOOD)
    assert scene == Scene(
        name="my-lab",
        start=Start(x_m=1.0, y_m=-2.5, yaw_rad=math.pi / 2),
        boxes=(
            Box(
                name="crate",
                center_m=(2.0, 0.5, 0.2),
                size_m=(0.4, 0.4, 0.4),
                yaw_rad=math.radians(30),
                pitch_rad=math.radians(-8),
                friction=0.3,
            ),
            Box(name="post", center_m=(4.0, 0.0, 1.0), size_m=(0.1, 0.1, 2.0)),
        ),
        floor_friction=0.9,
    )


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('name = "my-lab"', "", "name: missing"),
        ('name = "my-lab"', "name = 5", "name: must be a text"),
        ("floor_friction", "floor_fricton", "floor_fricton: unknown key: did you mean 'floor_friction'"),
        ("floor_friction = 0.9", "floor_friction = -1", "floor_friction: must be at least 0"),
        ("x_m = 1", "x_m = nan", "start.x_m: must be a finite number"),
        ("x_m = 1", "x_m = true", "start.x_m: must be a finite number"),
        ("yaw_deg = 90", "heading = 90", "start.heading: unknown key"),
        ("[start]", "[[start]]", "start: must be a table"),
        ("[[boxes]]", "[boxes]", "not TOML|must be a list of tables"),
        ("center_m = [4, 0, 1]", "", r"boxes\[1\].center_m: missing"),
        ("center_m = [4, 0, 1]", "center_m = [4, 0]", r"boxes\[1\].center_m: must be a list of three"),
        ("size_m = [0.1, 0.1, 2]", "size_m = [0.1, 0, 2]", r"boxes\[1\].size_m: every number must be greater"),
        ('name = "post"', 'name = "crate"', r"boxes\[1\].name: 'crate' is taken"),
        ('name = "post"', 'name = "floor"', r"boxes\[1\].name: 'floor' is taken"),
        ("friction = 0.3", "colour = 3", r"boxes\[0\].colour: unknown key"),
        ("[start]", "[start", "not TOML"),
    ],
)
def test_complaints_name_the_file_and_the_key(read, old, new, message):
    with pytest.raises(SceneFileError, match=rf"lab\.toml: .*({message})"):
        read(GOOD.replace(old, new))


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(SceneFileError, match="No such file"):
        find_scene(str(tmp_path / "none.toml"))


def test_boxes_that_are_none(tmp_path):
    path = tmp_path / "lab.toml"
    path.write_text(f"boxes = 5\n{GOOD.partition('[[boxes]]')[0]}")
    with pytest.raises(SceneFileError, match=r"must be a list of tables, \[\[boxes\]\]"):
        find_scene(str(path))


def test_a_file_that_is_not_text(tmp_path):
    path = tmp_path / "lab.toml"
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(SceneFileError, match="not UTF-8"):
        find_scene(str(path))


def test_an_unknown_scene_names_the_nearest():
    with pytest.raises(UnknownNameError, match="did you mean 'ramp'"):
        find_scene("ramps")
    with pytest.raises(UnknownNameError, match="known: carpet, cell, corridor"):
        find_scene("zzz")


def test_a_scene_file_can_be_driven_in(tmp_path, open_it):
    path = tmp_path / "lab.toml"
    path.write_text(GOOD)
    world = open_it(str(path), "pioneer-2dx")
    assert world.pose().yaw_rad == pytest.approx(math.pi / 2)
    assert world.cast([(4.0, -1.0, 1.0)], [(4.0, 1.0, 1.0)]) == pytest.approx([0.475], abs=1e-3)


@each(
    ("scene", "inside_m"),
    [("room-with-boxes", (-5.0, 5.0, -5.0, 5.0)), ("rover-room", (-1.6, 1.4, -1.2, 1.2))],
)
def test_the_walls_of_a_room_are_closed_and_stand_outside_it(scene, inside_m):
    walls = {box.name: box for box in BUILTIN[scene](1).boxes if box.name.startswith("wall_")}
    least_x, most_x, least_y, most_y = inside_m

    def edges(name, axis):
        box = walls[f"wall_{name}"]
        half = box.size_m[axis] / 2
        return pytest.approx((box.center_m[axis] - half, box.center_m[axis] + half))

    t = 0.1
    assert (most_x, most_x + t) == edges("front", 0)
    assert (least_x - t, least_x) == edges("back", 0)
    assert (most_y, most_y + t) == edges("left", 1)
    assert (least_y - t, least_y) == edges("right", 1)
    for name in ("front", "back"):  # the corners are theirs
        assert (least_y - t, most_y + t) == edges(name, 1)
