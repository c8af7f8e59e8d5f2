"""The Pioneer as rigid bodies: does it go where its wheels say, stop at walls, and feel what it touches."""

from __future__ import annotations

import math

import pytest

from tests.share import few
from worlds import Box, Contact, Scene
from worlds.vehicles.pioneer_2dx import BODY, DEFAULTS, FRONT_BUMPER, LEFT, REAR_BUMPER, RIGHT


def push(body, left, right, seconds):
    for _ in range(round(seconds * body.world.step_hz)):
        body.command_wheels(left, right)
        body.world.step()


@pytest.mark.parametrize(
    "step_hz", [240, pytest.param(1000, marks=pytest.mark.exhaustive("the gate has it at rest at 1000 steps a second"))]
)
def test_straight_to_a_tenth_of_a_percent(pioneer, drive, step_hz):
    body = pioneer(step_hz=step_hz)
    pose = drive(body, left=1, right=1, distance_m=1.5)
    assert pose.position_m[0] == pytest.approx(1.5, rel=1e-3)
    assert pose.position_m[1] == pytest.approx(0.0, abs=1.5e-3)
    assert math.degrees(pose.yaw_rad) == pytest.approx(0.0, abs=0.1)
    assert sum(body.wheel_angles_rad()) / 2 * DEFAULTS.wheel_radius_m == pytest.approx(1.5, rel=1e-3)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_quarter_turn_to_a_tenth_of_a_degree_on_the_spot(pioneer, drive, sign):
    body = pioneer()
    quarter_m = math.pi / 2 * DEFAULTS.track_m / 2
    pose = drive(body, left=-sign, right=sign, distance_m=quarter_m, top_m_s=0.14, acceleration_m_s2=0.31)
    assert math.degrees(pose.yaw_rad) == pytest.approx(sign * 90, abs=0.1)
    assert math.hypot(*pose.position_m[:2]) < 2e-3  # the turning point stays between the wheels


def test_an_arc(pioneer, drive):
    body = pioneer()
    pose = drive(body, left=2 / 3, right=1, distance_m=1.5)
    turn = (1.5 - 1.0) / DEFAULTS.track_m
    radius = 1.25 / turn
    assert math.degrees(pose.yaw_rad) == pytest.approx(math.degrees(turn), abs=0.2)
    assert pose.position_m[:2] == pytest.approx((radius * math.sin(turn), radius * (1 - math.cos(turn))), abs=3e-3)


def test_the_turn_rate_is_the_one_aria_reckons_with(pioneer):
    body = pioneer()
    push(body, -100 / 82.5, 100 / 82.5, 1.0)
    assert body.world.velocity().angular_rad_s[2] == pytest.approx(100 * 0.0056, rel=2e-3)


def test_on_the_spot_the_reference_point_stands_still(pioneer):
    body = pioneer()
    push(body, -2.0, 2.0, 1.0)
    assert math.hypot(*body.world.velocity().linear_m_s) < 2e-3


@pytest.mark.parametrize(
    ("step_hz", "held", "driven"),
    few(
        [(240, True, True), (240, True, False), (240, False, False), (240, False, True), (1000, False, True)],
        2,
        "other ways to stand",
    ),
)
def test_at_rest_it_stays_where_it_is(pioneer, step_hz, held, driven):
    """Within 0.01 degrees and 0.05 mm in ten minutes, body and wheels alike; here in five seconds."""
    body = pioneer(step_hz=step_hz)
    if driven:
        push(body, 3.0, -1.0, 1.0)
    rest(body, 2.0, held)
    before, wheels_before = body.world.pose(), body.wheel_angles_rad()
    rest(body, 5.0, held)
    after, wheels_after = body.world.pose(), body.wheel_angles_rad()
    assert math.degrees(abs(after.yaw_rad - before.yaw_rad)) < 0.01 / 120
    assert math.dist(after.position_m, before.position_m) < 0.05e-3 / 120
    assert math.dist(wheels_after, wheels_before) * DEFAULTS.wheel_radius_m < 0.05e-3 / 120


def rest(body, seconds, held):
    for _ in range(round(seconds * body.world.step_hz)):
        if held:
            body.command_wheels(0.0, 0.0)
        else:
            body.release_wheels()
        body.world.step()


@pytest.mark.parametrize("gap_m", [0.001, 0.005, 0.015])
def test_near_is_not_touching(pioneer, gap_m):
    body = pioneer("wall")
    body.world.place(2.0 - 0.210 - gap_m, 0.0, 0.0)
    push(body, 0.0, 0.0, 0.1)
    assert body.bumpers() == (0, 0)


@pytest.fixture
def at_the_wall(pioneer):
    """Drive a robot against the wall, from a hand's breadth before it."""

    def opener(wheel_rad_s=4.0):
        body = pioneer("wall")
        body.world.place(2.0 - 0.210 - 0.1, 0.0, 0.0)
        push(body, wheel_rad_s, wheel_rad_s, 2.0)
        return body

    return opener


def test_at_a_wall_the_wheels_stop_dead_under_full_load(at_the_wall):
    body = at_the_wall(0.3 / 0.0825)
    assert body.motor_loads() == pytest.approx((1.0, 1.0), abs=1e-6)
    assert abs(body.world.joint(LEFT).speed_rad_s * DEFAULTS.wheel_radius_m) < 1e-3
    assert abs(body.world.joint(RIGHT).speed_rad_s * DEFAULTS.wheel_radius_m) < 1e-3
    assert body.bumpers() == (0b00100, 0)
    assert body.world.pose().position_m[0] == pytest.approx(2.0 - 0.210, abs=1e-3)


def test_with_more_torque_the_wheels_spin_on_the_floor_instead(at_the_wall):
    world = at_the_wall().world
    for _ in range(2 * 240):
        world.command(LEFT, 4.0, 4.0)
        world.command(RIGHT, 4.0, 4.0)
        world.step()
    assert world.joint(LEFT).speed_rad_s == pytest.approx(4.0, rel=0.01)


def test_a_pressed_bumper_stays_pressed_in_every_step(at_the_wall):
    body = at_the_wall()
    masks = set()
    for _ in range(240):
        push(body, 4.0, 4.0, 1 / 240)
        masks.add(body.bumpers())
    assert masks == {(0b00100, 0)}


def test_backing_off_frees_the_bumper(at_the_wall):
    body = at_the_wall()
    push(body, -2.0, -2.0, 1.0)
    assert body.bumpers() == (0, 0)


def test_after_place_nothing_is_touched_until_the_next_step(at_the_wall):
    body = at_the_wall()
    body.world.place(0.0, 0.0, 0.0)
    assert body.world.contacts() == ()
    assert body.bumpers() == (0, 0)
    body.world.step()
    assert {contact.other for contact in body.world.contacts()} == {"floor"}


@pytest.mark.parametrize(
    ("y", "x_behind", "mask"), [(0.2125, 0.1, 0b00001), (-0.2125, 0.1, 0b10000), (0.0, -0.2125, 0b00100)]
)
def test_the_ends_of_a_ring_belong_to_the_outer_segments(pioneer, monkeypatch, y, x_behind, mask):
    body = pioneer()
    touch = Contact(part=FRONT_BUMPER, other="post", position_m=(-0.0025 - x_behind, y, 0.1), normal_force_n=1.0)
    monkeypatch.setattr(body.world, "contacts", lambda part: (touch,) if part == FRONT_BUMPER else ())
    assert body.bumpers() == (mask, 0)


def post_at(bearing_rad, center_x_m):
    """A slim post so near that a robot creeping towards it along the bearing touches one segment."""
    reach = 0.2125 + 0.04 + 0.005
    x, y = center_x_m + reach * math.cos(bearing_rad), reach * math.sin(bearing_rad)
    return Box(name="post", center_m=(x, y, 0.25), size_m=(0.08, 0.08, 0.5), yaw_rad=bearing_rad)


@pytest.mark.parametrize("segment", range(1, 6))
@pytest.mark.parametrize("end", ["front", "rear"])
def test_each_segment_has_its_bit_left_to_right(pioneer, end, segment):
    from_left = math.radians(60 - 30 * (segment - 1))
    if end == "front":
        bearing, center, way = from_left, 0.210 - 0.2125, 1
    else:
        bearing, center, way = math.pi - from_left, 0.2125 - 0.301, -1
    body = pioneer(Scene(name="post", boxes=(post_at(bearing, center),)))
    for _ in range(240):
        push(body, way * 0.5, way * 0.5, 1 / 240)
        if body.bumpers() != (0, 0):
            break
    front, rear = body.bumpers()
    assert (front if end == "front" else rear) == 1 << (segment - 1)
    assert (rear if end == "front" else front) == 0


def test_contacts_name_part_and_obstacle_and_place(at_the_wall):
    body = at_the_wall()
    assert {contact.part for contact in body.world.contacts()} == {"caster", LEFT, RIGHT, FRONT_BUMPER}
    for contact in body.world.contacts(FRONT_BUMPER):
        assert contact.other == "wall"
        assert contact.position_m[0] == pytest.approx(0.210, abs=2e-3)
    assert {contact.other for contact in body.world.contacts(LEFT)} == {"floor"}
    assert body.world.contacts(REAR_BUMPER) == ()


def test_up_the_ramp_the_body_never_touches(pioneer):
    body = pioneer("ramp")
    highest = 0.0
    for _ in range(round(5.2 / 0.3 * 240)):
        push(body, 0.3 / 0.0825, 0.3 / 0.0825, 1 / 240)
        touching = {contact.part for contact in body.world.contacts()}
        assert touching <= {LEFT, RIGHT, "caster"}, touching
        highest = max(highest, -body.world.pose().pitch_rad)
    assert math.degrees(highest) == pytest.approx(8.0, abs=1.0)
    assert body.world.pose().position_m[2] == pytest.approx(3.0 * math.sin(math.radians(8)), abs=5e-3)


def test_holding_on_the_ramp_takes_torque(pioneer):
    body = pioneer("ramp")
    push(body, 0.3 / 0.0825, 0.3 / 0.0825, 9.0)
    push(body, 0.0, 0.0, 2.0)
    here = body.world.pose().position_m
    push(body, 0.0, 0.0, 2.0)
    assert math.dist(body.world.pose().position_m, here) < 2e-6
    expected = 9.0 * 9.81 * math.sin(math.radians(8)) * DEFAULTS.wheel_radius_m / 2
    assert body.motor_loads() == pytest.approx((expected, expected), rel=0.05)


def test_released_on_the_ramp_it_rolls_down(pioneer):
    """With (m g sin a - 2 M / r) / (m + 2 J / r²): the weight against the gearboxes' friction M."""
    body = pioneer("ramp")
    push(body, 0.3 / 0.0825, 0.3 / 0.0825, 9.0)
    push(body, 0.0, 0.0, 2.0)
    start, seconds = body.world.pose().position_m, 1.0
    rest(body, seconds, held=False)
    p = DEFAULTS
    pull_n = p.mass_kg * 9.81 * math.sin(math.radians(8)) - 2 * p.released_friction_nm / p.wheel_radius_m
    expected_m = pull_n / (p.mass_kg + p.wheel_mass_kg) * seconds**2 / 2
    assert math.dist(body.world.pose().position_m, start) == pytest.approx(expected_m, rel=0.02)
    assert body.world.pose().position_m[0] < start[0]


def test_hull_stays_inside_the_bumpers(pioneer):
    parts = {part.name: part for part in pioneer().world.vehicle.parts}
    for ring, center in ((FRONT_BUMPER, 0.210 - 0.2125), (REAR_BUMPER, 0.2125 - 0.301)):
        for shape in parts[BODY].shapes:
            (length, width, _), (x, _, _) = shape.size_m, shape.center_m
            corner = x + math.copysign(length / 2, 1 if ring == FRONT_BUMPER else -1)
            assert math.hypot(corner - center, width / 2) < 0.2125 - 0.0149
