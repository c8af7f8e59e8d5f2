"""Paths: lengths, places, curvature; against circles and lines."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.robots.driving_stack import Path, PathError
from tests.each import each

CORNER = Path([(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)])


def test_lengths_and_points():
    assert CORNER.length_m == 20.0
    assert CORNER.point(4.0) == (4.0, 0.0)
    assert CORNER.point(13.0) == (10.0, 3.0)
    assert CORNER.point(-5.0) == (0.0, 0.0)
    assert CORNER.point(25.0) == (10.0, 10.0)
    assert CORNER.heading_rad(5.0) == 0.0
    assert CORNER.heading_rad(15.0) == pytest.approx(math.pi / 2)


def test_a_closed_path_goes_around():
    square = Path([(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0), (0.0, 0.0)], closed=True)
    assert square.length_m == 40.0
    assert square.point(45.0) == (5.0, 0.0)
    assert square.point(-5.0) == (0.0, 5.0)
    assert square.heading_rad(35.0) == pytest.approx(-math.pi / 2)


def test_left_of_the_path_is_positive():
    assert CORNER.place(5.0, 2.0).offset_m == 2.0
    assert CORNER.place(5.0, -2.0).offset_m == -2.0
    assert CORNER.place(8.0, 6.0).offset_m == pytest.approx(2.0)
    assert CORNER.place(8.0, 6.0).s_m == pytest.approx(16.0)
    assert CORNER.place(-3.0, 4.0).s_m == 0.0
    assert CORNER.place(-3.0, 4.0).offset_m == pytest.approx(5.0)


def test_where_a_path_crosses_itself_the_place_before_tells_which_way_is_meant():
    eight = Path([(0.0, 0.0), (20.0, 0.0), (20.0, 20.0), (10.0, 20.0), (10.0, -20.0)])
    assert eight.place(10.2, 0.1).s_m == pytest.approx(10.2)
    assert eight.place(10.2, 0.1, near_m=70.0, within_m=5.0).s_m == pytest.approx(69.9)
    assert eight.place(10.2, 0.1, near_m=1e9, within_m=5.0).s_m == pytest.approx(69.9)


def test_near_reaches_over_the_end_of_a_closed_path(circle):
    near_end_m = circle.length_m - 1.0
    assert circle.place(1.0, 0.0, near_m=near_end_m, within_m=5.0).s_m == pytest.approx(1.0, abs=0.05)


def test_curvature_is_that_of_the_circle_with_its_sign(circle, straight):
    for s_m in range(0, 180, 7):
        assert circle.curvature_per_m(s_m) == pytest.approx(1 / 30, rel=0.04)  # points 1 m apart
    mirrored = Path([(circle.point(s)[0], -circle.point(s)[1]) for s in range(188)], closed=True)
    assert mirrored.curvature_per_m(50.0) == pytest.approx(-1 / 30, rel=0.04)
    assert straight.curvature_per_m(50.0) == 0.0
    assert straight.curvature_per_m(0.0) == 0.0


@given(st.floats(-60, 60), st.floats(-30, 90), st.floats(0, 188))
def test_a_search_around_a_place_finds_nothing_farther_than_what_is_there(x_m, y_m, near_m):
    points = [(30 * math.sin(i / 10), 30 - 30 * math.cos(i / 10)) for i in range(63)]
    path = Path(points, closed=True)
    found = path.place(x_m, y_m, near_m=near_m, within_m=25.0)
    around = [path.point(near_m + d / 4) for d in range(-100, 101)]
    assert abs(found.offset_m) <= min(math.dist(point, (x_m, y_m)) for point in around) + 1e-9


@given(st.floats(-40, 40), st.floats(-40, 40))
def test_no_point_of_the_path_is_nearer_than_its_place(x_m, y_m):
    place = CORNER.place(x_m, y_m)
    nearest_m = min(math.dist(CORNER.point(s / 4), (x_m, y_m)) for s in range(81))
    assert abs(place.offset_m) <= nearest_m + 1e-9
    assert math.dist(CORNER.point(place.s_m), (x_m, y_m)) == pytest.approx(abs(place.offset_m))


def test_repeated_points_do_no_harm():
    path = Path([(0.0, 0.0), (0.0, 0.0), (5.0, 0.0), (5.0, 0.0), (10.0, 0.0)])
    assert path.length_m == 10.0
    assert path.place(5.0, 1.0).s_m == 5.0


@each(
    ("points", "closed"),
    [([], False), ([(0.0, 0.0)], False), ([(1.0, 1.0)] * 5, False), ([(0.0, 0.0), (1.0, 0.0), (0.0, 0.0)], True)],
)
def test_too_few_points_are_refused(points, closed):
    with pytest.raises(PathError, match="points or more"):
        Path(points, closed=closed)


def test_points_that_are_none_are_refused():
    with pytest.raises(PathError, match="not finite"):
        Path([(0.0, 0.0), (math.nan, 1.0)])
