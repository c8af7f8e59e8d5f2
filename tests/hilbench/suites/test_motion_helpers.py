"""What the suite of motion judges by: its formulas, its record of the truth, its expectation of an echo."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hilbench.bench import Bench
from hilbench.check import Inconclusive, Violation
from hilbench.clock import NS_PER_S, ClockDomain, EventClass, Scheduler
from hilbench.journal import Journal
from hilbench.suites import _echoes, _mechanics, _wall
from hilbench.suites._truth import Truth
from protocols.p2os import robot_parameters
from tests.each import each
from worlds.scenes import Box, Scene
from worlds.vehicles.pioneer_2dx import LEFT, RIGHT
from worlds.world import open_world

speeds = st.floats(1, 2000)
rates = st.floats(1, 300)


@settings(deadline=None)
@given(way=st.floats(1, 5000), speed=speeds, acceleration=st.floats(10, 2000))
def test_a_trapezoid_covers_its_way_in_its_time(way, speed, acceleration):
    """Summed up step by step, from rest to rest."""
    time_s = _mechanics.trapezoid_time_s(way, speed, acceleration)
    steps = 2000
    dt = time_s / steps
    middles = ((step + 0.5) * dt for step in range(steps))
    covered = sum(min(speed, acceleration * t, acceleration * (time_s - t)) * dt for t in middles)
    assert covered == pytest.approx(way, rel=1e-3)


@settings(deadline=None)
@given(speed=speeds, turn_deg_s=rates, duration_s=st.floats(0.1, 5), sign=st.sampled_from([-1, 1]))
def test_an_arc_ends_on_its_circle(speed, turn_deg_s, duration_s, sign):
    ahead, left = _mechanics.arc_end(speed, sign * turn_deg_s, duration_s)
    radius = _mechanics.turn_radius(speed, turn_deg_s)
    assert math.dist((ahead, left), (0, sign * radius)) == pytest.approx(radius, rel=1e-9)
    assert left * sign >= 0


def test_a_quarter_of_a_turn_to_the_left():
    radius = _mechanics.turn_radius(100, 45)
    assert radius == pytest.approx(127.32, abs=0.01)
    assert _mechanics.arc_end(100, 45, 2) == pytest.approx((radius, radius))


@settings(deadline=None)
@given(
    radius=st.floats(10, 1000),
    middle=st.tuples(st.floats(-1000, 1000), st.floats(-1000, 1000)),
    part=st.floats(0.2, 1),
)
def test_the_radius_of_part_of_a_circle(radius, middle, part):
    angles = [math.tau * part * step / 50 for step in range(50)]
    points = [(middle[0] + radius * math.cos(a), middle[1] + radius * math.sin(a)) for a in angles]
    assert _mechanics.circle_radius(points) == pytest.approx(radius, rel=1e-6)


def test_stopping_way_and_slope():
    assert _mechanics.stopping_way(500, 300) == pytest.approx(416.667, abs=1e-3)
    assert _mechanics.slope([0.0, 1.0, 2.0], [5.0, 7.0, 9.0]) == pytest.approx(2.0)


class SilentPeer:
    """As much of a peer as the truth needs while it waits."""

    def __init__(self):
        self.sent = []

    def send(self, number):
        self.sent.append(number)

    def require_line(self):
        pass

    def evidence(self):
        return ["nothing"]


class PlaneRig:
    """A robot on the endless floor whose wheels turn at fixed speeds, and the truth about it."""

    def __init__(self, left_rad_s, right_rad_s, yaw_rad=0.0):
        self.bench = Bench(Scheduler(), Journal())
        self.world = open_world("empty", "pioneer-2dx", physics="plane", step_hz=240)
        self.world.place(0.0, 0.0, yaw_rad)
        self.peer = SilentPeer()
        self.grid = ClockDomain(240)
        self.tick = 0
        self.drive(left_rad_s, right_rad_s)
        self.truth = Truth(self.bench, self.world, self.peer)
        self._book()

    def drive(self, left_rad_s, right_rad_s):
        self.world.command(LEFT, left_rad_s, 1.0)
        self.world.command(RIGHT, right_rad_s, 1.0)

    def _book(self):
        self.tick += 1
        self.bench.scheduler.at(self.grid.ns(self.tick), self._step, order=EventClass.PHYSICS, source="world")

    def _step(self):
        self.world.step()
        self._book()


def test_the_truth_is_sampled_right_after_each_step():
    rig = PlaneRig(4.0, 4.0)
    rig.bench.run_for(1.0)
    samples = rig.truth.since(0)
    assert len(samples) == 241
    speed_mm_s = 4.0 * 82.5
    for sample in samples[1:]:
        assert sample.x_mm == pytest.approx(speed_mm_s * sample.after_s(0), abs=1e-3)
        assert sample.speed_mm_s == pytest.approx(speed_mm_s)


def test_the_heading_of_the_truth_does_not_wrap():
    rig = PlaneRig(-4.0, 4.0, yaw_rad=3.0)
    rig.bench.run_for(10.0)
    headings = [sample.heading_deg for sample in rig.truth.since(0)]
    assert headings[0] == pytest.approx(math.degrees(3.0))
    assert headings[-1] - headings[0] == pytest.approx(10 * rig.truth.now.turn_deg_s, rel=1e-6)
    assert headings[-1] > 720


def test_between_two_samples_the_robot_moves_on():
    rig = PlaneRig(3.0, 4.0)
    rig.bench.run_for(0.5)
    before, after = rig.truth.since(0)[-2:]
    moved = rig.truth.at(after.at_ns - 1)
    assert moved.at_ns == after.at_ns - 1
    assert moved.point_mm == pytest.approx(after.point_mm, abs=1e-4)
    assert moved.heading_deg == pytest.approx(after.heading_deg, abs=1e-4)
    assert rig.truth.at(before.at_ns) == before


def test_seen_from_a_robot_that_looks_to_the_left():
    rig = PlaneRig(4.0, 4.0, yaw_rad=math.pi / 2)
    start = rig.truth.now
    rig.bench.run_for(1.0)
    assert rig.truth.now.seen_from(start) == pytest.approx((330.0, 0.0), abs=1e-6)


def test_rest_is_when_it_began_and_not_when_it_was_sure():
    rig = PlaneRig(4.0, 4.0)
    rig.bench.scheduler.at(NS_PER_S, lambda: rig.drive(0.0, 0.0))
    rest = rig.truth.wait_still(5.0)
    assert rest.at_ns / NS_PER_S == pytest.approx(1.0, abs=0.01)
    assert rig.bench.now_ns / NS_PER_S == pytest.approx(1.3, abs=0.01)
    assert len(rig.peer.sent) == 3


def test_who_never_rests_is_told_so():
    rig = PlaneRig(4.0, 4.0)
    with pytest.raises(Violation, match="does not come to rest within 1"):
        rig.truth.wait_still(1.0, feed=False)
    assert rig.peer.sent == []


def test_after_closing_nothing_is_sampled():
    rig = PlaneRig(4.0, 4.0)
    rig.bench.run_for(0.1)
    rig.truth.close()
    count = len(rig.truth.since(0))
    rig.bench.run_for(0.1)
    assert len(rig.truth.since(0)) == count


class Standing:
    """As much of a world as an echo needs."""

    def __init__(self, *boxes):
        self.scene = Scene(name="made up", boxes=boxes)
        self._pose = open_world("empty", "pioneer-2dx", physics="plane").pose()

    def pose(self):
        return self._pose


P2DX = robot_parameters("p2dx")
WALL = Box(name="wall", center_m=(2.05, 0.0, 0.5), size_m=(0.1, 8.0, 1.0))


def test_before_a_wall_the_echo_is_the_way_along_the_nearest_line():
    """Disc 3 stands at x 166 mm and looks 10 degrees to the left: the nearest of the lines is 1.25 degrees off."""
    echo = _echoes.expect_echo(Standing(WALL), P2DX, 3)
    assert echo.cone_mm == pytest.approx(2000 - 166)
    assert echo.lines_mm == pytest.approx((2000 - 166) / math.cos(math.radians(1.25)))
    assert echo.low_mm == pytest.approx(echo.cone_mm - 2 - 0.268)
    assert echo.high_mm == pytest.approx(echo.lines_mm + 2 / math.cos(math.radians(1.25)) + 0.268)


def test_nothing_in_the_cone_is_no_echo():
    echo = _echoes.expect_echo(Standing(WALL), P2DX, 0)
    assert math.isinf(echo.low_mm)
    assert math.isinf(echo.high_mm)
    _echoes.require_range(8576.0, echo, "range")
    with pytest.raises(Violation):
        _echoes.require_range(1000.0, echo, "range")


def test_what_no_line_meets_may_be_heard_or_not_but_not_nearer_than_it_is():
    """A post of 2 cm at 2 m, half-way between two lines."""
    bearing = math.radians(10 + 1.875)
    post = Box(
        name="post",
        center_m=(0.166 + 2 * math.cos(bearing), 0.027 + 2 * math.sin(bearing), 0.5),
        size_m=(0.02,) * 2 + (1.0,),
    )
    echo = _echoes.expect_echo(Standing(post), P2DX, 3)
    assert echo.cone_mm == pytest.approx(1990, abs=5)
    assert math.isinf(echo.high_mm)
    for heard_mm in (8576.0, 1990.0):
        _echoes.require_range(heard_mm, echo, "range")
    with pytest.raises(Violation):
        _echoes.require_range(1900.0, echo, "range")


@each("wrong", [0.99, 1.01])
def test_a_range_that_is_off_by_a_hundredth_is_a_violation(wrong):
    echo = _echoes.expect_echo(Standing(WALL), P2DX, 3)
    with pytest.raises((Violation, Inconclusive)):
        _echoes.require_range(echo.cone_mm * wrong, echo, "range")


@each(
    ("bearing_deg", "touched"),
    [
        (60, (0b00001, 0)),
        (30, (0b00010, 0)),
        (0, (0b00100, 0)),
        (-30, (0b01000, 0)),
        (180, (0, 0b00100)),
        (150, (0, 0b00010)),
        (-150, (0, 0b01000)),
    ],
)
def test_segments_count_from_the_left(bearing_deg, touched):
    assert _wall.segments_touched(bearing_deg) == touched
