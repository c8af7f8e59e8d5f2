"""The joystick's law at its edges, and the signs of the status."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols.carla import (
    CARLA_STEER_RAD,
    ORIGINAL_SIGNS,
    ROS_SIGNS,
    VECTORS,
    X_AXIS,
    Y_AXIS,
    Axis,
    LocalProtocolError,
    ManualCommand,
    encode_command,
    manual_command,
)
from tests.each import each

READING = st.integers(0, 65535)


@each("axis", [X_AXIS, Y_AXIS])
def test_an_axis_at_its_points(axis):
    assert axis.position(axis.zero) == 0
    for off in (-axis.dead_band, axis.dead_band):
        assert axis.position(axis.zero + off) == 0
    assert 0 < axis.position(axis.zero + axis.dead_band + 1) < 1e-4
    assert -1e-4 < axis.position(axis.zero - axis.dead_band - 1) < 0
    assert axis.position(axis.greatest) == 1
    assert axis.position(axis.least) == -1


@given(READING, READING)
def test_an_axis_never_turns_back(a, b):
    low, high = sorted((a, b))
    assert X_AXIS.position(low) <= X_AXIS.position(high)


@each(
    ("x", "y", "command"),
    [
        (33970, 33580, ManualCommand()),
        (34470, 34080, ManualCommand()),
        (33470, 33080, ManualCommand()),
        (65535, 65535, ManualCommand(steer=-1.0, throttle=1.0)),
        (1057, 1062, ManualCommand(steer=1.0, brake=1.0)),
    ],
)
def test_what_the_stick_commands(x, y, command):
    for clamp in (False, True):
        assert manual_command(x, y, clamp=clamp) == command


def test_at_rest_the_steering_is_minus_zero():
    frame = encode_command(manual_command(33970, 33580, clamp=True).frame())
    assert frame[2:6] == b"\0\0\0\x80"
    assert frame[6:] == VECTORS["F3"].data[6:27] + b"\x04$\0"


def test_beyond_the_calibration_is_beyond_one_without_a_clamp():
    free = manual_command(0, 0, clamp=False)
    assert (free.steer, free.brake) == (pytest.approx(1.03261, abs=1e-5), pytest.approx(1.03317, abs=1e-5))
    assert manual_command(0, 0, clamp=True) == ManualCommand(steer=1.0, brake=1.0)


@given(READING, READING)
def test_a_clamped_stick_stays_within_its_ranges(x, y):
    command = manual_command(x, y, clamp=True)
    assert -1 <= command.steer <= 1
    assert 0 <= command.throttle <= 1
    assert 0 <= command.brake <= 1
    assert not (command.throttle and command.brake)


@each("reading", [0, 65535, 33970, 34471, 33469])
@each("profile", ["hardened", "v0", "v1"])
def test_the_board_sends_what_the_stick_says(by_hand, profile, reading):
    board = by_hand(profile)
    board.joystick(reading, reading)
    board.run(0.4)
    wanted = manual_command(reading, reading, clamp=profile == "hardened").frame()
    assert board.last.frame in (wanted, type(wanted)())
    assert encode_command(wanted) in {event.data for event in board.since(0, type(board.last))}


@each("figures", [(100, 50, 200), (0, 400, 65535), (0, 65400, 65535)])
def test_a_calibration_that_cannot_be(figures):
    least, zero, greatest = figures
    with pytest.raises(LocalProtocolError, match="is no calibration"):
        Axis(least=least, zero=zero, greatest=greatest)


def test_the_signs_of_the_original():
    status = ORIGINAL_SIGNS.status(
        lon_speed_m_s=8.0, lat_speed_m_s=0.05, yaw_rate_rad_s=0.1, tyre_rad=-CARLA_STEER_RAD * 0.5
    )
    assert (status.lat_speed_m_s, status.heading_rate_rad_s) == (-0.05, -0.1)
    assert status.steering_rad == pytest.approx(-0.5146)
    assert math.degrees(CARLA_STEER_RAD) == pytest.approx((69.99 + 47.95) / 2, abs=0.01)
    plain = ROS_SIGNS.status(lon_speed_m_s=8.0, lat_speed_m_s=0.05, yaw_rate_rad_s=0.1, tyre_rad=0.2)
    assert (plain.lat_speed_m_s, plain.heading_rate_rad_s, plain.steering_rad) == (0.05, 0.1, 0.2)
