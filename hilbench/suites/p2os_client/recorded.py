"""Packets that were read by others before."""

from __future__ import annotations

import dataclasses
import math

from hilbench.check import Violation, case, near
from hilbench.suites._client import ClientBench, connect, own_client, understood
from hilbench.systems.pioneer.scripted_packets import MOVING
from protocols.p2os import encode_packet

REAL = bytes.fromhex("FAFB21320000000000000000000090FEFE00000000000204007D0700" + "7D05005930F011B4")
"""A SIP captured from a real Pioneer 2-DX without bumpers (qemu-gazebo-sim/p2os-arduino, test_sip.cpp)."""

GOLDEN = bytes.fromhex("FAFB2133A604F67F0004C8002C01800102000403002D0200E80305930E050080FF0F0C1D")
"""A SIP with every field in use; what it says was read alike by ARIA and by hand from the Pioneer 2 manual."""


@case("C28", bench_time_s=0.7)
def test_the_packet_of_a_real_robot_is_read(bench: ClientBench) -> None:
    connect(bench)
    reading = understood(bench, REAL)
    near(reading.battery_v, 14.4, 0.05, unit="V", what="battery")
    assert (reading.front_bumpers, reading.rear_bumpers) == (0, 0), "a bumper alarm on a robot without bumpers"
    alarms = (reading.left_stall, reading.right_stall, reading.moving)
    assert not any(alarms), f"(left stall, right stall, moving) is {alarms} on a robot at rest"
    assert sorted(reading.sonars_mm) == [4, 7], f"readings of the sonars {sorted(reading.sonars_mm)} instead of 4 and 7"
    for number in (4, 7):
        near(reading.sonars_mm[number], 8576, 1, unit="mm", what=f"range of sonar {number}")


@case("C29", bench_time_s=0.7)
def test_a_moving_sip_is_read(bench: ClientBench) -> None:
    connect(bench)
    reading = understood(bench, GOLDEN)
    own = own_client(bench)
    tracker, sip = own.pose, own.sips[-1]
    assert tracker is not None, "the client has no pose"
    pose = tracker.pose
    near(pose.x_mm, 999.6, 0.5, unit="mm", what="x")
    near(pose.y_mm, -8.4, 0.5, unit="mm", what="y")
    near(pose.heading_deg, 90, 0.5, unit="deg", what="heading")
    near(reading.left_mm_s, 200, 0.5, unit="mm/s", what="speed of the left wheel")
    near(reading.right_mm_s, 300, 0.5, unit="mm/s", what="speed of the right wheel")
    near(reading.battery_v, 12.8, 0.05, unit="V", what="battery")
    near(reading.heading_error_rad, 0, 0.001, unit="rad", what="heading asked for less heading")
    near(reading.analog_v, 2.51, 0.005, unit="V", what="analog input")
    near(reading.sonars_mm.get(0, math.inf), 268, 0.5, unit="mm", what="range of sonar 0")
    near(reading.sonars_mm.get(5, math.inf), 1000, 0.5, unit="mm", what="range of sonar 5")
    seen = {
        "moving": (reading.moving, True),
        "left stall": (reading.left_stall, True),
        "right stall": (reading.right_stall, False),
        "front bumper bits": (sip.front_bumpers, 0b00001),
        "rear bumper bits": (sip.rear_bumpers, 0),
        "motors": (reading.motors_enabled, True),
        "sonar": (reading.sonar_enabled, True),
        "compass": (reading.compass_deg, 90),
        "sonars": (sorted(reading.sonars_mm), [0, 5]),
        "analog port": (reading.analog_port, 5),
        "gripper": (reading.gripper_state, 0),
        "digital inputs": (reading.digin, 0xFF),
        "digital outputs": (reading.digout, 0x0F),
    }
    wrong = [f"{name}: {got} instead of {meant}" for name, (got, meant) in seen.items() if got != meant]
    if wrong:
        raise Violation(f"{len(wrong)} fields were misread", wrong)


@case("C30", bench_time_s=1.5)
def test_the_stalled_wheel_is_told(bench: ClientBench) -> None:
    connect(bench)
    for rear, front in ((1, 0), (0, 1), (0, 0)):
        sip = dataclasses.replace(MOVING, stall_rear=rear, stall_front=front)
        reading = understood(bench, encode_packet(sip))
        got, meant = (reading.left_stall, reading.right_stall), (bool(rear), bool(front))
        assert got == meant, f"byte 15 is {rear:02X}, byte 16 {front:02X}: (left, right) stall {got} instead of {meant}"
