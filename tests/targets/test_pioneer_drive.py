"""Driving: the motion clauses of the conformance list, asked in bytes and judged by SIPs and by the true pose."""

from __future__ import annotations

import dataclasses
import itertools
import math
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocols.p2os import Command, CommandNumber, Sip, vel2
from protocols.p2os.arguments import BytePacking
from targets.robots.pioneer import BumpStopped, CommandIgnored, Refusal, RobotSettings, StallCleared, Stalled
from tests.each import each
from tests.share import examples

SYNC0 = "FAFB03000000"
VEL_200, VEL_BACK_200, VEL_0 = "FAFB060B3BC800D33B", "FAFB060B1BC800D31B", "FAFB060B3B00000B3B"
RVEL_30, RVEL_BACK_30 = "FAFB06153B1E00333B", "FAFB06151B1E00331B"
HEAD_90, HEAD_BACK_90 = "FAFB060C3B5A00663B", "FAFB060C1B5A00661B"
MOVE_1000 = "FAFB06083BE803F03E"
STOP, E_STOP = "FAFB031D001D", "FAFB03370037"
SETO, SETO_CUT = "FAFB03070007", "FAFB0407 3B073B".replace(" ", "")
SETA_300 = "FAFB06053B2C01313C"
BUMPSTALL_3 = "FAFB062C3B03002F3B"
CYCLE_S = 0.1
DIST_MM = 0.84


def signed15(raw: int) -> int:
    return (raw + 0x4000) % 0x8000 - 0x4000


def alive(rig, data, duration_s: float) -> list[Sip]:
    """Send, then let time pass with a PULSE every second; return the SIPs."""
    first = len(rig.sips)
    rig.send(data)
    while duration_s > 1e-9:
        part_s = min(1.0, duration_s)
        rig.run(part_s)
        rig.send(SYNC0)
        duration_s -= part_s
    return rig.sips[first:]


def slope_mm_s2(sips: list[Sip], low: float, high: float) -> float:
    """Mean slope of the left wheel's speed between two speeds."""
    inside = [(k, sip.left_raw) for k, sip in enumerate(sips) if low <= abs(sip.left_raw) <= high]
    (k0, v0), (k1, v1) = inside[0], inside[-1]
    return (v1 - v0) / ((k1 - k0) * CYCLE_S)


# --- velocities ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", [VEL_200, RVEL_30, HEAD_90, MOVE_1000, "FAFB06203B0A052A40"])
def test_no_motion_with_motors_off(rig, command: str) -> None:  # S20
    rig.open()
    sips = alive(rig, command, 1.0)
    assert all((sip.x_raw, sip.th_raw, sip.left_raw, sip.right_raw, sip.moving) == (0, 0, 0, 0, False) for sip in sips)
    assert rig.told(CommandIgnored)[-1].reason is Refusal.MOTORS_OFF
    rig.send(Command(CommandNumber.ENABLE, 1))
    assert not any(sip.moving for sip in alive(rig, SYNC0, 1.0))


def test_vel_200(ready) -> None:  # S22
    sips = alive(ready, VEL_200, 2.0)
    assert (sips[-1].left_raw, sips[-1].right_raw, sips[-1].moving) == (200, 200, True)
    assert slope_mm_s2(sips, 20, 190) == pytest.approx(300, rel=0.05)
    assert {sip.th_raw for sip in sips} == {0}
    assert max(sip.left_raw for sip in sips) <= 201
    assert ready.chassis.x_m == pytest.approx(0.2 * 2 - 0.5 * 0.2 * (2 / 3), abs=0.002)


def test_backwards_counts_down_through_zero(ready) -> None:  # S23
    sips = alive(ready, VEL_BACK_200, 2.0)
    assert (sips[-1].left_raw, sips[-1].right_raw) == (-200, -200)
    assert sips[-1].x_raw > 0x7000
    assert signed15(sips[-1].x_raw) * DIST_MM == pytest.approx(ready.chassis.x_m * 1000, abs=20)


def test_rotation_both_ways(ready) -> None:  # S24
    left = alive(ready, RVEL_30, 1.0)
    assert left[-1].th_raw > 0
    assert left[-1].right_raw > 0 > left[-1].left_raw
    right = alive(ready, RVEL_BACK_30, 2.5)
    assert right[-1].th_raw < left[-1].th_raw
    assert right[-1].left_raw > 0 > right[-1].right_raw
    turn_deg_s = math.degrees((right[-1].left_raw - right[-1].right_raw) / 2 * 0.0056)
    assert turn_deg_s == pytest.approx(30, abs=0.3)


def test_translation_and_rotation_leave_each_other_alone(ready) -> None:  # S25
    ready.send("FAFB060B3B64006F3B")
    sips = alive(ready, Command(CommandNumber.RVEL, 20), 2.0)
    assert (sips[-1].left_raw + sips[-1].right_raw) / 2 == pytest.approx(100, abs=1)
    assert sips[-1].right_raw - sips[-1].left_raw == pytest.approx(2 * math.radians(20) / 0.0056, abs=2)
    sips = alive(ready, VEL_0, 2.0)
    assert sips[-1].left_raw == -sips[-1].right_raw != 0


@each(
    ("frame", "left", "right"),
    [
        ("FAFB06203B0A052A40", 100, 200),  # S26
        ("FAFB06201B0504251F", -100, -100),  # S27: ARIA
        ("FAFB06203BFBFB1C36", -100, -100),  # S27: Player
        ("FAFB06203BFB0F1B4A", 300, -100),
        ("FAFB06201BF104111F", -100, 300),
    ],
)
def test_direct_wheels(make_rig, frame: str, left: int, right: int) -> None:
    rig = make_rig(RobotSettings(rotation_max_deg_s=360.0))
    rig.ready()
    sips = alive(rig, frame, 2.0)
    assert (sips[-1].left_raw, sips[-1].right_raw) == (left, right)


@pytest.mark.parametrize("packing", list(BytePacking))
def test_direct_wheels_are_clipped_to_the_speed_limits(ready, packing: BytePacking) -> None:
    sips = alive(ready, vel2(2540, 2540, packing=packing), 4.0)
    assert (sips[-1].left_raw, sips[-1].right_raw) == (600, 600)
    sips = alive(ready, vel2(-2540, 2540, packing=packing), 6.0)
    rim = math.radians(100) / 0.0056
    assert (sips[-1].left_raw, sips[-1].right_raw) == (pytest.approx(-rim, abs=1), pytest.approx(rim, abs=1))


def test_the_last_mode_wins_without_a_jump(ready) -> None:
    alive(ready, VEL_200, 2.0)
    alive(ready, "FAFB06203B0A052A40", 1.5)
    assert (ready.sips[-1].left_raw, ready.sips[-1].right_raw) == (100, 200)
    alive(ready, VEL_200, 3.0)
    assert (ready.sips[-1].left_raw, ready.sips[-1].right_raw) == (200, 200)
    most = CYCLE_S * (300 + math.radians(100) / 0.0056) + 1  # both loops change at once
    for a, b in pairwise(ready.sips):
        assert abs(b.left_raw - a.left_raw) <= most
        assert abs(b.right_raw - a.right_raw) <= most


# --- positions -----------------------------------------------------------------------------------------------------


def test_head_settles_on_both_sides(ready) -> None:  # S28
    assert alive(ready, HEAD_90, 3.0)[-1].th_raw == pytest.approx(1024, abs=2)
    sips = alive(ready, HEAD_BACK_90, 4.0)
    assert sips[-1].th_raw == pytest.approx(-1024, abs=2)
    assert not sips[-1].moving
    assert sips[-1].control_raw == -1024


@given(
    headings=st.lists(st.integers(-180, 359), min_size=1, max_size=4),
    grip=st.sampled_from([1.0, 0.97]),
    wait_s=st.floats(0.05, 4.0),
)
@settings(max_examples=examples(25))
def test_any_heading_is_reached_the_short_way(rig_class, headings: list[int], grip: float, wait_s: float) -> None:
    rig = rig_class(RobotSettings(), steps_hz=100)
    rig.chassis.grip = grip
    rig.ready()
    for heading in headings:
        alive(rig, Command(CommandNumber.HEAD, heading), wait_s)
    sips = alive(rig, SYNC0, 6.0)
    error = math.remainder(sips[-1].th_raw * 360 / 4096 - headings[-1], 360)
    assert abs(error) < 0.2
    assert not sips[-1].moving


@pytest.mark.parametrize("other_side", [190, -170])
def test_head_takes_the_short_way(ready, other_side: int) -> None:
    alive(ready, Command(CommandNumber.HEAD, 170), 5.0)
    sips = alive(ready, Command(CommandNumber.HEAD, other_side), 3.0)
    assert sips[-1].th_raw == pytest.approx(190 * 4096 / 360 - 4096, abs=2)
    assert all(abs(sip.th_raw) > 1800 for sip in sips)


def test_relative_turns(ready) -> None:  # S29
    assert alive(ready, "FAFB060D1B2D003A1B", 3.0)[-1].th_raw == pytest.approx(-512, abs=2)
    assert alive(ready, "FAFB06163B1E00343B", 3.0)[-1].th_raw == pytest.approx(-512 + 341, abs=2)


def test_setpoint_relative_turns_add_up_while_turning(ready) -> None:
    for _ in range(3):
        ready.say("FAFB06163B1E00343B", 0.2)
    assert alive(ready, SYNC0, 4.0)[-1].th_raw == pytest.approx(1024, abs=2)


@pytest.mark.parametrize(("command", "distance_mm"), [(MOVE_1000, 1000), ("FAFB06081BF401FC1C", -500)])
def test_move(ready, command: str, distance_mm: int) -> None:  # S30
    sips = alive(ready, command, 6.0)
    assert signed15(sips[-1].x_raw) == pytest.approx(distance_mm / DIST_MM, abs=1)
    assert not sips[-1].moving


@given(distance=st.integers(-3000, 3000), hz=st.sampled_from([50, 240, 1000]))
@settings(max_examples=examples(12))
def test_any_move_lands_whatever_the_step(rig_class, distance: int, hz: int) -> None:
    rig = rig_class(RobotSettings(), steps_hz=hz)
    rig.ready()
    alive(rig, Command(CommandNumber.MOVE, distance), abs(distance) / 600 + 4.5)
    assert rig.chassis.x_m * 1000 == pytest.approx(distance, abs=0.1)


def test_move_keeps_to_setv(ready) -> None:  # S31
    ready.send(Command(CommandNumber.SETV, 100))
    sips = alive(ready, MOVE_1000, 11.5)
    assert max(sip.left_raw for sip in sips) == 100
    assert signed15(sips[-1].x_raw) == pytest.approx(1000 / DIST_MM, abs=1)


def test_setv_acts_on_later_commands_only(ready) -> None:
    alive(ready, VEL_200, 2.0)
    assert alive(ready, Command(CommandNumber.SETV, 100), 2.0)[-1].left_raw == 200
    assert alive(ready, VEL_200, 2.0)[-1].left_raw == 100


def test_limits_are_clipped_to_the_tops(ready) -> None:
    ready.send(Command(CommandNumber.SETV, 5000))
    ready.send(Command(CommandNumber.SETA, 30000))
    assert ready.robot.controller.limits.translation.speed == 1600
    assert ready.robot.controller.limits.translation.acceleration == 2000
    assert alive(ready, Command(CommandNumber.VEL, 3000), 3.0)[-1].left_raw == 1600


def test_seta_changes_both_slopes(ready) -> None:  # S32
    ready.send(Command(CommandNumber.SETA, 1000))
    ready.send(Command(CommandNumber.SETA, -500))
    assert slope_mm_s2(alive(ready, Command(CommandNumber.VEL, 500), 1.5), 60, 480) == pytest.approx(1000, rel=0.05)
    assert slope_mm_s2(alive(ready, STOP, 1.5), 20, 460) == pytest.approx(-500, rel=0.05)


def test_seto_in_both_forms_and_with_a_setpoint(ready) -> None:  # S33
    for form in (SETO, SETO_CUT):
        alive(ready, Command(CommandNumber.VEL, 100), 1.0)
        alive(ready, HEAD_90, 3.0)
        alive(ready, STOP, 1.0)
        assert ready.sips[-1].x_raw
        ready.send(form)
        sip = ready.next_sip()
        assert (sip.x_raw, sip.y_raw, sip.th_raw, sip.control_raw) == (0, 0, 0, 0)


def test_the_heading_setpoint_moves_with_the_origin(ready) -> None:
    ready.say(HEAD_90, 0.5)
    turned = ready.robot.controller.odometer.travel.rotation_deg
    ready.send(SETO)
    assert ready.next_sip().control_raw == pytest.approx((90 - turned) * 4096 / 360, abs=1)
    alive(ready, SYNC0, 3.0)
    assert math.degrees(ready.chassis.yaw_rad) == pytest.approx(90, abs=0.1)


# --- stopping ------------------------------------------------------------------------------------------------------


def stopping_distance_mm(rig, command: str) -> float:
    alive(rig, Command(CommandNumber.VEL, 500), 3.0)
    start = rig.chassis.x_m
    sips = alive(rig, command, 3.0)
    assert (sips[-1].moving, sips[-1].motors_enabled) == (False, True)
    return (rig.chassis.x_m - start) * 1000


def test_stop_and_e_stop(ready) -> None:  # S34 S35
    assert stopping_distance_mm(ready, STOP) == pytest.approx(500**2 / 600, rel=0.02)
    assert stopping_distance_mm(ready, E_STOP) < 500**2 / 600 / 5


def test_e_stop_keeps_zero_until_a_velocity_command(ready) -> None:
    alive(ready, VEL_200, 1.5)
    alive(ready, E_STOP, 0.5)
    assert not any(sip.moving for sip in alive(ready, HEAD_90, 1.0))
    assert ready.told(CommandIgnored)[-1].reason is Refusal.EMERGENCY
    refused = len(ready.told(CommandIgnored))
    for command in (STOP, E_STOP):
        alive(ready, command, 0.2)
    assert len(ready.told(CommandIgnored)) == refused
    assert alive(ready, VEL_200, 1.5)[-1].left_raw == 200
    assert alive(ready, HEAD_90, 1.0)[-1].th_raw > 0


def test_e_stop_out_of_direct_wheels(ready) -> None:
    alive(ready, "FAFB06203B0A052A40", 1.5)
    assert not alive(ready, E_STOP, 0.4)[-1].moving
    assert (alive(ready, "FAFB06203B0A052A40", 1.5)[-1].left_raw) == 100


def test_stop_out_of_direct_wheels_is_gentle(ready) -> None:
    alive(ready, vel2(300, 300), 2.0)
    assert slope_mm_s2(alive(ready, STOP, 1.5), 20, 290) == pytest.approx(-300, rel=0.05)


def test_motors_off_releases_and_forgets(ready) -> None:
    alive(ready, VEL_200, 1.5)
    ready.say(Command(CommandNumber.ENABLE, 0), 0.2)
    assert not ready.chassis.servo
    ready.send(Command(CommandNumber.ENABLE, 1))
    assert not any(sip.moving for sip in alive(ready, SYNC0, 1.0)[1:])


def test_enable_again_and_again_does_not_disturb(ready) -> None:
    alive(ready, VEL_200, 1.5)
    for _ in range(10):
        ready.say(Command(CommandNumber.ENABLE, 1), 0.1)
    assert ready.sips[-1].left_raw == 200


# --- long ways -----------------------------------------------------------------------------------------------------


def test_forty_metres_wrap_without_a_jump(make_rig) -> None:  # S52
    rig = make_rig(RobotSettings(translation_max_mm_s=950.0), steps_hz=50)
    rig.ready()
    sips = alive(rig, Command(CommandNumber.VEL, 950), 44.0)
    raw = [sip.x_raw for sip in sips]
    steps = [(b - a) % 0x8000 for a, b in itertools.pairwise(raw)]
    assert rig.chassis.x_m > 40
    assert sum(b < a for a, b in itertools.pairwise(raw)) == 1
    assert max(steps) * DIST_MM < 100
    assert max(raw) <= 0x7FFF
    assert sum(steps) * DIST_MM == pytest.approx(rig.chassis.x_m * 1000, abs=100)


def test_five_turns_stay_within_half_a_turn(make_rig) -> None:  # S53
    rig = make_rig(RobotSettings(), steps_hz=50)
    rig.ready()
    sips = alive(rig, Command(CommandNumber.RVEL, 90), 22.0)
    raw = [sip.th_raw for sip in sips]
    assert rig.chassis.yaw_rad > 5 * math.tau
    assert all(-2048 <= th <= 2047 for th in raw)
    assert sum(b < a for a, b in itertools.pairwise(raw)) == 5


def test_an_arc_is_where_the_robot_says(make_rig) -> None:
    rig = make_rig(RobotSettings())
    rig.ready()
    alive(rig, Command(CommandNumber.VEL, 300), 0.01)
    alive(rig, Command(CommandNumber.RVEL, 25), 6.0)
    alive(rig, STOP, 2.0)
    pose = rig.robot.controller.odometer.pose
    assert pose.x_mm == pytest.approx(rig.chassis.x_m * 1000, abs=1)
    assert pose.y_mm == pytest.approx(rig.chassis.y_m * 1000, abs=1)
    assert math.radians(pose.heading_deg) == pytest.approx(rig.chassis.yaw_rad, abs=1e-4)


@each("error", [0.03, -0.03])
def test_a_wrong_wheel_makes_the_robot_believe_what_is_not_so(make_rig, error: float) -> None:
    rig = make_rig(dataclasses.replace(RobotSettings(), left_wheel_error=error))
    rig.ready()
    sips = alive(rig, MOVE_1000, 6.0)
    assert sips[-1].th_raw == pytest.approx(0, abs=2)
    assert rig.chassis.yaw_rad == pytest.approx(error * 1000 / 2 * 0.0056, rel=0.1)


# --- stall and bump ------------------------------------------------------------------------------------------------


def test_a_wall_stalls_both_wheels_again_and_again(ready) -> None:
    ready.chassis.wall_m = 0.5
    sips = alive(ready, VEL_200, 5.0)
    stalled = [sip for sip in sips if sip.left_stall and sip.right_stall]
    assert stalled
    assert all((sip.left_raw, sip.moving) == (0, False) for sip in stalled)
    assert len(ready.told(Stalled)) >= 3
    assert len(ready.told(StallCleared)) >= 2
    assert ready.chassis.x_m == pytest.approx(0.29, abs=0.002)
    ready.chassis.wall_m = math.inf
    assert alive(ready, SYNC0, 2.0)[-1].left_raw == 200


def test_power_is_cut_for_the_stall_time(ready) -> None:
    ready.chassis.wall_m = 0.5
    alive(ready, VEL_200, 1.0)
    while not ready.told(Stalled):
        ready.run(0.01)
    assert not ready.chassis.servo
    ready.run(0.18)
    assert not ready.chassis.servo
    ready.run(0.04)
    assert ready.chassis.servo


def test_after_a_stall_the_robot_starts_gently(ready) -> None:
    ready.chassis.wall_m = 0.5
    alive(ready, VEL_200, 1.0)
    while not ready.told(Stalled):
        ready.run(0.01)
    ready.chassis.wall_m = math.inf
    sips = alive(ready, SYNC0, 1.5)
    assert slope_mm_s2(sips, 10, 195) == pytest.approx(300, rel=0.1)
    assert sips[-1].left_raw == 200


def test_switching_the_motors_off_ends_a_stall(ready) -> None:
    ready.chassis.wall_m = 0.5
    alive(ready, VEL_200, 1.0)
    while not ready.told(Stalled):
        ready.run(0.01)
    ready.send(Command(CommandNumber.ENABLE, 0))
    assert not ready.next_sip().left_stall


def test_one_stuck_wheel_sets_its_own_bit(ready) -> None:
    ready.chassis.stuck = {0}
    sips = alive(ready, VEL_200, 1.5)
    assert any(sip.left_stall for sip in sips)
    assert not any(sip.right_stall for sip in sips)
    ready.chassis.stuck = {1}
    assert any(sip.right_stall for sip in alive(ready, VEL_200, 2.5))


@pytest.mark.parametrize("ends", ["wall", "front", "rear"])
def test_bump_stops_until_the_next_motion_command(ready, ends: str) -> None:  # S56
    ready.send(BUMPSTALL_3)
    alive(ready, VEL_200, 1.0)
    if ends == "wall":
        ready.chassis.wall_m = ready.chassis.x_m + 0.21 + 0.05
        ready.run(0.5)
    else:
        ready.chassis.pressed = (1, 0) if ends == "front" else (0, 1)
        ready.run(0.15)
    sips = alive(ready, SYNC0, 1.5)
    assert sips[-1].left_stall
    assert sips[-1].right_stall
    assert not sips[-1].moving
    assert bool(sips[-1].rear_bumpers) == (ends == "rear")
    assert bool(sips[-1].front_bumpers) == (ends != "rear")
    assert len(ready.told(BumpStopped)) == 1
    away, speed = (VEL_200, 200) if ends == "rear" else (VEL_BACK_200, -200)
    sips = alive(ready, away, 1.5)
    assert sips[-1].left_raw == speed
    assert not sips[-1].left_stall


TOWARD = [VEL_200, MOVE_1000, Command(CommandNumber.MOVE, 1), vel2(200, 200), vel2(300, 0)]


@pytest.mark.parametrize("order", TOWARD)
def test_nothing_moves_toward_a_pressed_end(ready, order: str | Command) -> None:
    """As a client asks that sends its speed ten times a second: the robot stays, and so do the stall bits."""
    ready.send(BUMPSTALL_3)
    ready.chassis.pressed = (0b100, 0)
    alive(ready, VEL_200, 0.2)
    x_m, first = ready.chassis.x_m, len(ready.sips)
    for _ in range(30):
        ready.say(order, 0.1)
    sips = ready.sips[first:]
    assert all(sip.left_stall and sip.right_stall and not sip.moving for sip in sips)
    assert ready.chassis.x_m == x_m
    sips = alive(ready, VEL_BACK_200, 1.5)
    assert (sips[-1].left_raw, sips[-1].left_stall) == (-200, False)


@pytest.mark.parametrize("turn", [RVEL_30, HEAD_90, vel2(-100, 100)])
def test_turning_is_not_toward_a_pressed_end(ready, turn: str | Command) -> None:
    ready.send(BUMPSTALL_3)
    ready.chassis.pressed = (0b100, 0)
    alive(ready, VEL_200, 0.2)
    sips = alive(ready, turn, 1.0)
    assert sips[-1].moving
    assert not sips[-1].left_stall


def test_an_end_that_is_not_chosen_does_not_hold_the_robot(ready) -> None:
    ready.send(Command(CommandNumber.BUMPSTALL, 2))
    ready.chassis.pressed = (0b100, 0)
    assert alive(ready, VEL_200, 1.5)[-1].left_raw == 200


def test_bump_stall_acts_on_a_contact_that_is_there_already(ready) -> None:
    alive(ready, VEL_200, 1.0)
    ready.chassis.pressed = (0b100, 0)
    assert alive(ready, SYNC0, 0.5)[-1].moving
    sips = alive(ready, BUMPSTALL_3, 0.5)
    assert not sips[-1].moving
    assert sips[-1].left_stall


def test_a_finished_move_is_not_motion_toward_the_bumper(ready) -> None:
    ready.chassis.pressed = (0b100, 0)
    alive(ready, Command(CommandNumber.MOVE, 100), 2.0)
    sips = alive(ready, BUMPSTALL_3, 0.5)
    assert not sips[-1].left_stall


def test_bumpers_do_not_stop_by_default(ready) -> None:
    alive(ready, VEL_200, 1.0)
    ready.chassis.pressed = (1, 1)
    sips = alive(ready, SYNC0, 1.0)
    assert sips[-1].left_raw == 200
    assert (sips[-1].stall_front, sips[-1].stall_rear) == (0b10, 0b10)
