"""The same programs, in real time, on `hilbench serve` over a pty and over TCP."""

from __future__ import annotations

import pytest

from .scripts import die_while_driving, drive_a_little, drive_and_die, find_the_robot_at_rest

pytestmark = pytest.mark.real_time("a served robot keeps the host's time, as do the programs at its doors")


def test_dies_while_driving_at_one_door_and_comes_back_at_the_other(make_served):
    rig = make_served()
    die_while_driving(rig.open("aria-serial"), 50)
    client = rig.open("aria-tcp")
    find_the_robot_at_rest(client)
    drive_and_die(client, 50)
    find_the_robot_at_rest(rig.open("aria-serial"))


@pytest.mark.exhaustive("the gate has a program at both doors in real time, and every program in bench time")
@pytest.mark.parametrize(
    ("kind", "bench"),
    [
        ("aria-serial", "pioneer-plane"),
        pytest.param("aria-serial", "pioneer", marks=pytest.mark.needs_physics),
        pytest.param("player-tcp", "pioneer", marks=pytest.mark.needs_physics),
        ("player-tcp", "pioneer-plane"),
    ],
)
def test_a_program_connects_drives_dies_and_is_back_at_once(make_served, kind, bench):
    rig = make_served(bench=bench)
    client = rig.open(kind)
    drive_a_little(client)
    drive_and_die(client)
    client = rig.open(kind)
    find_the_robot_at_rest(client)
    client.disconnect()


@pytest.mark.exhaustive("the gate has a program at both doors in real time, and ROS at another rate in bench time")
def test_ros_finds_the_rate_drives_and_dies(make_served):
    rig = make_served("--baud", "38400", tcp=False)
    die_while_driving(rig.open("ros-serial"))
    rig.close()
    assert rig.said.count("garbled") == 1
