"""The joystick's law: its figures at the stops, at the edges of the dead band, and between."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.robots.vehicle_interface.joystick import HIGHEST_COUNT, X_AXIS, Y_AXIS, Axis, Stick

COUNTS = st.integers(0, HIGHEST_COUNT)


@pytest.mark.parametrize(
    ("counts", "steer", "throttle", "brake"),
    [
        ((33_970, 33_580), 0.0, 0.0, 0.0),
        ((34_470, 34_080), 0.0, 0.0, 0.0),
        ((33_470, 33_080), 0.0, 0.0, 0.0),
        ((65_535, 65_535), -1.0, 1.0, 0.0),
        ((1057, 1062), 1.0, 0.0, 1.0),
    ],
)
def test_figures(counts, steer, throttle, brake):
    assert Stick.of(*counts) == Stick(steer=steer, throttle=throttle, brake=brake)


def test_a_stick_let_go_steers_minus_zero():
    assert math.copysign(1.0, Stick.of(33_970, 33_580).steer) == -1.0


def test_one_count_beyond_the_dead_band():
    assert Stick.of(34_471, 34_081) == Stick(steer=-1 / 31_065, throttle=1 / 31_455, brake=0.0)


def test_beyond_the_stop_the_original_asks_for_more():
    loose = [replace(axis, clamped=False) for axis in (X_AXIS, Y_AXIS)]
    stick = Stick.of(0, 0, x_axis=loose[0], y_axis=loose[1])
    assert (round(stick.steer, 3), round(stick.brake, 3)) == (1.033, 1.033)
    assert Stick.of(0, 0) == Stick(steer=1.0, throttle=0.0, brake=1.0)


@given(COUNTS, COUNTS)
def test_it_never_asks_for_more_than_all(x_count, y_count):
    stick = Stick.of(x_count, y_count)
    assert -1 <= stick.steer <= 1
    assert 0 <= stick.throttle <= 1
    assert 0 <= stick.brake <= 1
    assert not (stick.throttle and stick.brake)


@given(COUNTS, COUNTS)
def test_more_count_is_more_share(one, other):
    axis = Axis(least=1057, zero=33_970, most=65_535, clamped=False)
    low, high = sorted((one, other))
    assert axis.share(low) <= axis.share(high)
