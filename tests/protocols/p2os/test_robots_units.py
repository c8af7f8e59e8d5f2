"""Robot tables and what the raw numbers mean."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols.p2os import (
    ROBOT_VARIANTS,
    ROBOTS,
    CompassRule,
    Dialect,
    LocalProtocolError,
    PoseTracker,
    Sip,
    SonarReading,
    bumpers,
    compass_deg,
    distance_raw,
    find_robot,
    heading_raw,
    is_no_echo,
    read_sip,
    robot_parameters,
    sonar_range_mm,
    sonar_range_raw,
    timer_bytes,
    wheel_speed_mm_s,
    wheel_speed_raw,
)
from protocols.p2os.units import Pose
from tests.each import each

P2DX = ROBOTS["p2dx"]
GOLDEN = Sip(
    moving=True,
    x_raw=1190,
    y_raw=32758,
    th_raw=1024,
    left_raw=200,
    right_raw=300,
    battery_dv=128,
    stall_rear=1,
    stall_front=2,
    control_raw=1024,
    flags=3,
    compass_raw=45,
    sonars=(SonarReading(number=0, range_raw=1000), SonarReading(number=5, range_raw=3731)),
    timer=5,
    analog=0x80,
    digin=0xFF,
    digout=0x0F,
)


def test_every_robot_of_the_family_is_there():
    assert set(ROBOTS) == {
        *("p2dx", "p2de", "p2df", "p2ce", "p2d8", "p2d8+", "p3dx", "p3dx-sh"),
        *("p2at", "p2at8", "p2at8+", "p3at", "p3at-sh", "p2it", "p2pb", "p2pp"),
        *("amigo", "amigo-sh", "pion1x", "pion1m", "psos1x", "psos1m", "pionat", "powerbot"),
    }


@each(
    ("name", "distance", "sonar", "turn", "speed", "turn_rate"),
    [
        ("p2dx", 0.84, 0.268, 0.0056, 2200, 500),
        ("p2df", 0.485, 0.268, 0.006, 2200, 500),
        ("p2ce", 0.826, 0.268, 0.0057, 2200, 500),
        ("p3dx", 0.485, 1, 0.0056, 2200, 500),
        ("p2at", 1.32, 0.268, 0.0034, 1200, 300),
        ("p2it", 1.136, 0.268, 0.0032, 1200, 300),
        ("p2pp", 0.485, 0.268, 0.006, 2200, 500),
        ("amigo", 0.5083, 1, 0.011, 1000, 300),
        ("pionat", 0.07, 0.1734, 0.00333, 500, 100),
        ("powerbot", 0.5813, 1, 0.00373, 2000, 360),
    ],
)
def test_factors(name, distance, sonar, turn, speed, turn_rate):
    robot = ROBOTS[name]
    assert (robot.distance_unit_mm, robot.range_unit_mm, robot.turn_rad_per_mm) == (distance, sonar, turn)
    assert (robot.max_speed_mm_s, robot.max_turn_deg_s) == (speed, turn_rate)


def test_every_robot_is_consistent():
    for name, robot in [*ROBOTS.items(), *ROBOT_VARIANTS.items()]:
        assert robot.front_mm + robot.rear_mm == pytest.approx(robot.length_mm), name
        assert robot.units_per_turn == (1024 if robot.vel2_unit_mm_s == 4 else 4096), name
        assert robot.source, name
        for pose in filter(None, robot.sonars):
            assert abs(pose.x_mm) <= robot.length_mm, name
            assert abs(pose.y_mm) <= robot.width_mm / 2, name
            outwards_deg = math.degrees(math.atan2(pose.y_mm, pose.x_mm))
            assert abs(math.remainder(pose.th_deg - outwards_deg, 360)) < 55, name


def test_sonars_of_a_2dx():
    poses = [(pose.x_mm, pose.y_mm, pose.th_deg) for pose in P2DX.sonars if pose]
    assert poses == [
        *((69, 136, 90), (114, 119, 50), (148, 78, 30), (166, 27, 10)),
        *((166, -27, -10), (148, -78, -30), (114, -119, -50), (69, -136, -90)),
        *((-157, -136, -90), (-203, -119, -130), (-237, -78, -150), (-255, -27, -170)),
        *((-255, 27, 170), (-237, 78, 150), (-203, 119, 130), (-157, 136, 90)),
    ]


@each(
    ("name", "count"), [("p2dx", 16), ("p2at", 16), ("p2pb", 24), ("amigo", 8), ("pion1x", 7), ("p2dx/front-array", 8)]
)
def test_number_of_sonars(name, count):
    robot = find_robot(name)
    assert robot is not None
    assert len(robot.sonars) == count


def test_powerbot_has_gaps_in_its_numbers():
    assert [number for number, pose in enumerate(ROBOTS["powerbot"].sonars) if pose is None] == [7, 15, 23, 31]
    assert len(ROBOTS["powerbot"].sonars) == 32


def test_older_table_is_a_variant():
    older = find_robot("P2DX/older")
    assert older is not None
    assert older.sonars[3] is not None
    assert (older.sonars[3].x_mm, older.sonars[3].y_mm) == (210, 25)
    assert older.sonars[3].th_rad == pytest.approx(math.radians(10))
    assert robot_parameters("amigo-sh/older").speed_unit_mm_s == 1.3746
    assert robot_parameters("amigo-sh/player").speed_unit_mm_s == 1.0


def test_names_in_any_case_and_unknown_ones():
    assert find_robot("P2DX") is P2DX
    assert find_robot("") is None
    with pytest.raises(LocalProtocolError, match=r"p9zz.*p2dx"):
        robot_parameters("p9zz")


def test_golden_sip_in_units():
    reading = read_sip(GOLDEN, P2DX)
    assert (reading.left_mm_s, reading.right_mm_s, reading.battery_v) == (200, 300, 12.8)
    assert (reading.left_stall, reading.right_stall) == (True, False)
    assert reading.sonars_mm == pytest.approx({0: 268, 5: 999.9}, abs=0.1)
    assert reading.no_echo == frozenset()
    assert (reading.compass_deg, reading.analog_port, reading.gripper_state) == (90, 5, 0)
    assert reading.analog_v == pytest.approx(2.51, abs=0.01)
    assert (reading.digin, reading.digout, reading.heading_error_rad) == (0xFF, 0x0F, 0)
    assert reading.motors_enabled
    assert reading.sonar_enabled
    assert bumpers(GOLDEN, ROBOT_VARIANTS["p2dx/bumpers"]) == (1, 0)
    pose = PoseTracker(P2DX).update(GOLDEN)
    assert (pose.x_mm, pose.y_mm) == pytest.approx((999.6, -8.4))
    assert pose.heading_deg == pytest.approx(90)


def test_captured_packet_of_a_real_robot():
    sip = Sip.decode(
        bytes.fromhex("32 00 00 00 00 00 00 00 00 00 00 90 FE FE 00 00 00 00 00 02 04 00 7D 07 00 7D 05 00 59 30 F0")
    )
    reading = read_sip(sip, P2DX)
    assert reading.battery_v == 14.4
    assert (reading.front_bumpers, reading.rear_bumpers) == (0, 0)
    assert reading.sonars_mm == {4: 8576, 7: 8576}
    assert reading.no_echo == {4, 7}
    assert bumpers(sip, ROBOT_VARIANTS["p2dx/bumpers"]) == (0b11111, 0b11111)


walks = st.lists(st.tuples(st.integers(-119, 119), st.integers(-119, 119), st.integers(-600, 600)), max_size=80)


@given(walks, st.sampled_from((0x7FFF, 0xFFFF)), st.integers(-40000, 40000))
def test_pose_runs_on_where_counters_wrap(walk, mask, start):
    tracker = PoseTracker(P2DX)
    x, y, th = start, start, 0
    first = tracker.update(Sip(x_raw=x & mask, y_raw=y & mask))
    for dx, dy, dth in walk:
        x, y, th = x + dx, y + dy, th + dth
        tracker.update(Sip(x_raw=x & mask, y_raw=y & mask, th_raw=(th + 2048) % 4096 - 2048))
    pose = tracker.pose
    assert (pose.x_mm - first.x_mm, pose.y_mm - first.y_mm) == pytest.approx(
        ((x - start) * 0.84, (y - start) * 0.84), abs=1e-6
    )
    assert pose.heading_rad == pytest.approx(th * 2 * math.pi / 4096)


@each("top", [32767, 65535])
def test_one_step_over_the_wrap(top):
    tracker = PoseTracker(P2DX)
    before = tracker.update(Sip(x_raw=top, th_raw=2047))
    after = tracker.update(Sip(x_raw=0, th_raw=-2048))
    assert after.x_mm - before.x_mm == pytest.approx(0.84)
    assert after.heading_rad - before.heading_rad == pytest.approx(2 * math.pi / 4096)


def test_tracker_starts_anew_after_a_reset():
    tracker = PoseTracker(P2DX)
    tracker.update(Sip(x_raw=5000))
    tracker.reset()
    assert tracker.pose == Pose()
    assert tracker.update(Sip()) == Pose()


def test_a_turn_is_short_by_arias_angle():
    tracker = PoseTracker(P2DX, Dialect(aria_angle=True))
    for th in (1000, 2000, -1096, -96, 0):
        pose = tracker.update(Sip(th_raw=th))
    assert pose.heading_deg == pytest.approx(359.07, abs=0.01)


@each(("aria", "unit_rad"), [(True, 0.00153), (False, 2 * math.pi / 4096)])
def test_the_heading_error_has_the_unit_of_the_heading(aria, unit_rad):
    sip = Sip(th_raw=-1000, control_raw=-900)
    reading = read_sip(sip, P2DX, Dialect(aria_angle=aria))
    assert reading.heading_error_rad == pytest.approx(100 * unit_rad)


@given(st.floats(-1e5, 1e5), st.sampled_from(sorted(ROBOTS)))
def test_position_in_raw_units(mm, name):
    robot = ROBOTS[name]
    raw = distance_raw(mm, robot)
    assert 0 <= raw < 32768
    difference = (raw - mm / robot.distance_unit_mm) % 32768
    assert min(difference, 32768 - difference) <= 0.5 + 1e-6


@given(st.floats(-50, 50), st.sampled_from(sorted(ROBOTS)))
def test_heading_in_raw_units(rad, name):
    robot = ROBOTS[name]
    raw = heading_raw(rad, robot)
    turn = robot.units_per_turn
    assert -turn // 2 <= raw < turn // 2
    assert abs(math.remainder(raw * 2 * math.pi / turn - rad, 2 * math.pi)) <= math.pi / turn + 1e-9


@given(st.integers(-1000, 1000))
def test_wheel_speeds_there_and_back(raw):
    for robot in ROBOTS.values():
        assert wheel_speed_raw(wheel_speed_mm_s(raw, robot), robot) == raw


def test_values_beyond_their_field_are_held_at_its_end():
    assert (wheel_speed_raw(1e9, P2DX), wheel_speed_raw(-1e9, P2DX)) == (32767, -32768)
    assert (sonar_range_raw(1e9, P2DX), sonar_range_raw(-5, P2DX)) == (65535, 0)


def test_sonar_ranges():
    assert sonar_range_raw(1000, P2DX) == 3731
    assert sonar_range_mm(3731, P2DX) == pytest.approx(1000, abs=0.2)
    assert sonar_range_raw(None, P2DX) == 32000
    assert is_no_echo(sonar_range_raw(None, P2DX))
    assert not is_no_echo(sonar_range_raw(5000, P2DX))


def test_dialects():
    assert compass_deg(45) == 90
    assert compass_deg(45, CompassRule.PLAYER) == 88
    assert [compass_deg(raw, CompassRule.PLAYER) for raw in (0, 181, 255)] == [None, None, None]
    sip = Sip(timer=0x2A05)
    assert timer_bytes(sip) == (5, 0x2A)
    assert timer_bytes(sip, Dialect(gripper_first=True)) == (0x2A, 5)
