"""Foreign programs and the virtual robot, in bench time."""

from __future__ import annotations

import gc
import tracemalloc

import pytest

from tests.each import each
from worlds import default_physics

from . import packets as p
from .aria import Aria
from .conftest import KINDS
from .lines import BenchLine
from .player import FrozenError
from .scripts import die_while_driving, drive_a_little, find_the_robot_at_rest

every_kind = pytest.mark.parametrize("kind", KINDS)
other_lines = pytest.mark.exhaustive("the gate has each program on one of its lines, and driving on all of them")
kinds = pytest.mark.parametrize(
    "kind",
    [
        "aria-serial",
        pytest.param("aria-tcp", marks=other_lines),
        pytest.param("player-serial", marks=other_lines),
        "player-tcp",
        "ros-serial",
    ],
)
serial_kinds = pytest.mark.parametrize("kind", [kind for kind, (_, serial) in KINDS.items() if serial])


def silent_for(rig, duration_s):
    heard = []
    rig.link.b.on_receive = lambda data, _at_ns: heard.append(data)
    rig.pass_time(duration_s)
    return not heard


@every_kind
def test_a_program_connects_drives_leaves_and_comes_back(make_rig, kind):
    rig = make_rig()
    for _ in range(2):
        client = rig.open(kind)
        drive_a_little(client)
        client.disconnect()
        rig.open(kind)
        assert silent_for(rig, 1.0)
        rig.client_gone()
        rig.pass_time(0.1)


@kinds
def test_what_it_believes_to_have_driven_is_what_it_drove(make_rig, kind):
    rig = make_rig()
    client = rig.open(kind)
    drive_a_little(client, 300, until_mm=1000)
    x_m, y_m, _ = rig.pioneer.world.pose().position_m
    # The worst is Player's odometry, which rounds each step of some 30 mm to whole millimetres.
    assert abs(client.x_mm - 1000 * x_m) < 40
    assert abs(y_m) < 0.001
    assert getattr(client, "thrown_away", 0) == 0


@kinds
def test_it_turns_on_the_spot(make_rig, kind):
    rig = make_rig()
    client = rig.open(kind)
    assert client.connect()
    client.enable_motors()
    client.drive(0, 30)
    client.run(3.0)  # Player asks for steps of 20 mm/s a wheel
    assert client.sip.right_mm_s > 30 > -30 > client.sip.left_mm_s
    assert client.sip.th_raw > 300


@pytest.mark.needs_physics
@kinds
def test_it_sees_the_wall_two_metres_ahead(make_rig, kind):
    client = make_rig(scene="wall", physics=default_physics()).open(kind)
    assert client.connect()
    client.enable_sonar()
    client.run(1.0)
    assert client.sip.sonar
    assert sorted(client.ranges_mm) == list(range(8))
    assert 1700 < client.ranges_mm[3] < 1950  # the disc sits some 0.2 m in front of the middle
    assert 1700 < client.ranges_mm[4] < 1950
    assert client.ranges_mm[0] > 4000


@kinds
def test_a_program_that_died_is_back_at_once_where_the_line_hangs_up(make_rig, kind):
    rig = make_rig(hangs_up=True)
    die_while_driving(rig.open(kind))
    client = rig.open(kind)
    find_the_robot_at_rest(client)
    client.disconnect()


@pytest.mark.parametrize("kind", ["player-serial", "player-tcp", "ros-serial"])
def test_a_program_that_died_is_back_after_three_seconds_where_nobody_notices(make_rig, kind):
    """On RS-232 without modem lines the session outlives the program; the watchdog has stopped the robot by then."""
    rig = make_rig(hangs_up=False)
    die_while_driving(rig.open(kind))
    rig.pass_time(3.5)
    client = rig.open(kind)
    find_the_robot_at_rest(client)
    client.enable_motors()
    client.drive(200)
    client.run(1.5)
    assert client.sip.moving


@pytest.mark.parametrize(("phase_ms", "had"), [(50, False), (85, True)])
def test_aria_coming_back_after_three_seconds_has_the_robot_if_it_says_so_before_it_moves(make_rig, phase_ms, had):
    """ARIA's SYNC0 is a PULSE, and motion resumes as soon as communication does (Pioneer 2 Operations Manual): only a
    SIP that follows at once still says that the robot stands, and makes ARIA send its CLOSE.
    """
    rig = make_rig(hangs_up=False)
    die_while_driving(rig.open("aria-serial"))
    rig.pass_time(3.5)
    rig.hear_the_next_byte()
    rig.pass_time(phase_ms / 1000)
    client = rig.open("aria-serial")
    assert client.connect() is had


@pytest.mark.parametrize(("kind", "had"), [("aria-serial", False), ("player-serial", True), ("ros-serial", True)])
def test_who_can_take_a_robot_that_still_moves(make_rig, kind, had):
    """ARIA sends no CLOSE while the robot moves, and its SYNC0 is a PULSE that keeps it moving; the others do."""
    rig = make_rig(hangs_up=False)
    die_while_driving(rig.open(kind))
    client = rig.open(kind)
    assert client.connect() is had
    client.run(0.5)
    assert client.sip.moving is not had


@kinds
def test_one_program_takes_the_session_of_another(make_rig, kind):
    rig = make_rig(hangs_up=False)
    first = Aria(BenchLine(rig, serial=False))
    assert first.connect()
    first.enable_motors()
    first.run(1.0)
    find_the_robot_at_rest(rig.open(kind))


@serial_kinds
def test_a_robot_at_another_rate(make_rig, kind):
    """Player and ROS go through the rates; ARIA stays at its own, and the robot is none the worse for what it heard."""
    rig = make_rig(baud=38400)
    client = rig.open(kind)
    assert client.connect() is (kind != "aria-serial")
    client.die()
    rig.pass_time(0.5)
    rig.link.b.baud = 38400
    again = Aria(BenchLine(rig, serial=False))
    rig.link.restore()
    rig.pass_time(0.1)
    find_the_robot_at_rest(again)
    assert rig.link.a.counters.framing_errors > 0


@kinds
def test_ten_seconds_without_a_gap(make_rig, kind):
    rig = make_rig()
    client = rig.open(kind)
    assert client.connect()
    before, since_s = client.sips, client.line.now_s
    client.run(10)
    assert abs(client.sips - before - 10 * (client.line.now_s - since_s)) <= 8
    assert client.longest_silence_s < 0.45


def test_ros_repeats_its_speed_just_in_time(make_rig):
    """Every two seconds and a SIP VEL, a SIP later RVEL: a watchdog of 2.0 s that any packet feeds just about holds."""
    rig = make_rig()
    client = rig.open("ros-serial")
    assert client.connect()
    client.enable_motors()
    client.run(1.0)  # read what came during the start
    client.drive(200)
    client.run(1.5)
    slowest = 200
    for _ in range(10):
        client.run(0.5)
        slowest = min(slowest, client.sip.left_mm_s)
    assert 1.8 < client.longest_without_command_s < 2.01
    assert slowest >= 190


def test_aria_walks_and_turns_by_the_robots_own_controller(make_rig):
    client = make_rig().open("aria-serial")
    assert client.connect()
    client.enable_motors()
    client.move(500)
    client.run(5.0)
    assert abs(client.x_mm - 500) < 10
    client.turn_to(90)
    client.run(5.0)
    assert abs(client.heading_deg - 90) < 2
    assert not client.sip.moving


def test_aria_gets_its_limits_from_the_robot(make_rig):
    client = make_rig().open("aria-serial")
    began_s = client.line.now_s
    assert client.connect()
    assert client.line.now_s - began_s < 1.0  # 1.4 s and more for a robot that does not answer CONFIG
    assert (client.config.subclass, client.config.translation_max, client.config.rotation_max) == ("p2dx", 600, 100)
    assert client.config.translation_accelerations == (300, 300)


def test_aria_notices_that_the_robot_is_gone_after_eight_seconds(make_rig):
    rig = make_rig()
    client = rig.open("aria-tcp")
    assert client.connect()
    client.run(1.0)
    rig.link.hang_up()
    client.run(7.5)
    assert not client.lost
    client.run(1.0)
    assert client.lost


def test_a_driver_of_players_line_hangs_when_the_robot_falls_silent(make_rig):
    rig = make_rig()
    client = rig.open("player-tcp")
    assert client.connect()
    rig.link.hang_up()
    with pytest.raises(FrozenError):
        client.run(10.0)


def test_ten_sessions_in_turn(make_rig):
    rig = make_rig()
    for round_ in range(10):
        kind = list(KINDS)[round_ % len(KINDS)]
        client = rig.open(kind)
        assert client.connect(), kind
        client.run(0.3)
        (client.disconnect, client.die)[round_ % 2]()
        rig.pass_time(0.05)


@each(
    ("number", "argument", "raw"),
    [
        (p.SYNC0, None, "FAFB03000000"),
        (p.OPEN, 1, "FAFB06013B0100023B"),
        (p.SETA, -300, "FAFB06051B2C01311C"),
        (p.SETO, b"\x3b", "FAFB04073B073B"),
        (p.VEL2, b"\x3b\xfb\x0f", "FAFB06203BFB0F1B4A"),
        (p.VEL2, b"\x3b\xfb\xfb", "FAFB06203BFBFB1C36"),
        (p.TTY2, b"\x2b\x02AT", "FAFB072A2B0241542C38"),
    ],
)
def test_the_stand_ins_own_packets(number, argument, raw):
    """Known vectors: packed by AriaCoda's ArRobotPacket and Player's P2OSPacket."""
    assert p.frame(number, argument).hex().upper() == raw


def test_the_stand_ins_own_ears():
    """A packet behind a stray FA is lost to ARIA; ROS takes a wrong checksum and refuses some right ones."""
    sip = bytes.fromhex("FAFB1B3200000000000000000000800000000000000000050000FF00387F")
    encoder = bytes.fromhex("FAFB0B90E803000018FCFFFF9000")
    aria, player, ros = p.AriaReceiver(), p.PlayerReceiver(), p.RosReceiver()
    assert aria.take(bytearray(sip)) == player.take(bytearray(sip)) == ros.take(bytearray(sip)) == sip[3:-2]
    assert aria.take(bytearray(b"\xfa" + sip)) is None
    assert player.take(bytearray(b"\xfa" + sip)) == sip[3:-2]
    wrong = sip[:-1] + b"\x01"
    assert aria.take(bytearray(wrong)) is player.take(bytearray(wrong)) is None
    assert ros.take(bytearray(wrong)) == sip[3:-2]
    assert player.take(bytearray(encoder)) == encoder[3:-2]
    assert ros.take(bytearray(encoder)) is None


@pytest.mark.exhaustive("minutes of bench time; the gate has ten sessions in turn")
def test_a_long_session_takes_no_more_memory_than_a_short_one(make_rig):
    """Without a journal file nothing grows: what is kept is the latest events, and these are full after the start."""
    rig = make_rig(keep_events=30)
    client = rig.open("aria-serial")
    assert client.connect()
    client.enable_motors()
    client.drive(100, 20)
    sizes = []
    tracemalloc.start()
    try:
        for _ in range(3):
            client.run(4)
            gc.collect()
            sizes.append(tracemalloc.get_traced_memory()[0])
    finally:
        tracemalloc.stop()
    assert sizes[2] - sizes[1] < 4_000, sizes
