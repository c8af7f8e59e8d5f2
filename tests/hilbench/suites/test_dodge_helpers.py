"""What the suite of the dodger judges by: spells of motion, times of blindness, clearance, the same edges twice."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.check import Violation
from hilbench.suites import _clearance, _dodge, _replay
from tests.each import each
from worlds.scenes import Box, Scene
from worlds.vehicles.pioneer_2dx import vehicle
from worlds.world import Pose

MS = 1_000_000


def spells(*asked, now_ms=100, settled_ms=1):
    found = _dodge._spells(
        [(round(ms * MS), codes) for ms, codes in asked], now_ms * MS, settled_ms * MS, _dodge._motion_of_codes
    )
    return [(one.start_ns / MS, one.end_ns / MS, one.asked, one.motion) for one in found]


def test_codes_that_last_are_spells():
    assert spells((0, (0, 0)), (10, (3, 3)), (40, (-3, 3)), (70, (-4, -4))) == [
        (0, 10, (0, 0), "stand"),
        (10, 40, (3, 3), "forward"),
        (40, 70, (-3, 3), "turn"),
        (70, 100, (-4, -4), "back"),
    ]


def test_wires_that_change_one_after_the_other_make_no_spell_in_between():
    assert spells((0, (0, 0)), (10, (2, 0)), (10.01, (3, 0)), (10.02, (3, 3))) == [
        (0, 10, (0, 0), "stand"),
        (10.02, 100, (3, 3), "forward"),
    ]
    assert spells((0, (3, 3)), (10, (3, 2)), (10.02, (3, 3))) == [(0, 100, (3, 3), "forward")]


@each(
    ("asked", "motion"),
    [((187, 0), "forward"), ((100, 5), "forward"), ((0, -40), "turn"), ((-50, 0), "back"), ((0, 0), "stand")],
)
def test_commands_are_motions(asked, motion):
    assert _dodge._motion_of_speeds(asked) == motion


def test_commands_that_the_robot_obeys_make_spells():
    commands = _dodge._Commands(0)
    for ms, number, argument in ((10, 11, 200), (20, 21, 0), (200, 11, 0), (209, 21, -40), (300, 4, 1)):
        value = {"command": {"number": number, "argument": argument}}
        commands.take({"kind": "event", "name": "CommandObeyed", "ns": ms * MS, "value": value})
    commands.take({"kind": "tx", "ns": 310 * MS, "data": "00"})
    assert [(one.start_ns / MS, one.end_ns / MS, one.motion) for one in commands.spells(400 * MS)] == [
        (10, 200, "forward"),
        (209, 400, "turn"),
    ]


def test_the_longest_time_that_something_is_seen_and_driven_at():
    motions = [
        _dodge.Spell(0, 50 * MS, (3, 3), "forward"),
        _dodge.Spell(50 * MS, 80 * MS, (-3, 3), "turn"),
        _dodge.Spell(80 * MS, 100 * MS, (3, 3), "forward"),
    ]
    assert _dodge.longest_overlap_s([(45 * MS, 85 * MS)], motions) == pytest.approx(0.005)
    assert _dodge.longest_overlap_s([(50 * MS, 80 * MS)], motions) == 0
    assert _dodge.longest_overlap_s([], motions) == 0
    assert _dodge._spans([(0, False), (5, True), (6, True), (9, False), (12, True)], 20) == [(5, 9), (12, 20)]


def square(name, x, y, yaw_rad=0.0):
    return Box(name=name, center_m=(x, y, 0.25), size_m=(1.0, 1.0, 0.5), yaw_rad=yaw_rad)


def clearance(*boxes, x=0.0, y=0.0, yaw_rad=0.0):
    seen = _clearance.Clearance(vehicle(), Scene(name="test", boxes=boxes))
    seen.look(Pose(position_m=(x, y, 0.0), yaw_rad=yaw_rad))
    return seen.least_m


def test_the_outline_of_the_robot_is_as_long_and_wide_as_published():
    outline = _clearance.outline_m(vehicle())
    xs, ys = zip(*outline, strict=True)
    assert (max(xs), min(xs)) == pytest.approx((0.210, -0.301))
    assert max(ys) == pytest.approx(-min(ys))
    assert 0.18 < max(ys) <= 0.2125


def test_clearance_is_the_distance_to_the_nearest_box():
    assert clearance(square("ahead", 1.21, 0.0), square("far", 1.0, 3.0)) == pytest.approx(0.5)
    assert clearance(square("behind", -1.0, 0.0), x=-0.1) == pytest.approx(0.099)
    assert clearance(square("over", 0.5, 0.0)) == 0
    assert clearance(square("nothing near", 9.0, 9.0)) == math.inf


@given(st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi), st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))
def test_clearance_does_not_depend_on_where_the_axes_are(turn_rad, yaw_rad, x, y):
    """Turning robot and box together about the origin changes nothing."""
    cos, sin = math.cos(turn_rad), math.sin(turn_rad)
    box = square("box", cos * 1.2, sin * 1.2, turn_rad)
    turned = clearance(box, x=cos * x - sin * y, y=sin * x + cos * y, yaw_rad=yaw_rad + turn_rad)
    assert turned == pytest.approx(clearance(square("box", 1.2, 0.0), x=x, y=y, yaw_rad=yaw_rad), abs=1e-9)


def outputs(*edges):
    found = object.__new__(_replay.Outputs)
    found.edges = [_replay.Edge(*edge) for edge in edges]
    return found


ONE, TWO = (72, 1000, "PB7", True), (144, 2000, "PB7", False)


def test_the_same_edges_are_the_same_and_the_first_other_one_is_named():
    outputs(ONE, TWO).require_same(outputs(ONE, TWO))
    with pytest.raises(Violation, match=r"PB7 -> 0 at 0.000002000 s, cycle 144 on wheels, PB7 -> 0 at 0.000002014 s"):
        outputs(ONE, TWO).require_same(outputs(ONE, (145, 2014, "PB7", False)))
    with pytest.raises(Violation, match="cycle 144 is missing alone"):
        outputs(ONE, TWO).require_same(outputs(ONE))
    with pytest.raises(Violation, match="cycle 144 is missing on wheels"):
        outputs(ONE).require_same(outputs(ONE, TWO))
