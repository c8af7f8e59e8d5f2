"""The mode table and what each mode does with its loops."""

from __future__ import annotations

import math

import pytest

from targets.robots.pioneer.motion import MODES, Mode, Motion, Order
from targets.robots.pioneer.odometry import Travel
from targets.robots.pioneer.settings import RobotSettings
from targets.robots.pioneer.speed_limits import SessionLimits
from tests.each import each

SETTINGS = RobotSettings()


def travel(left_mm: float, right_mm: float) -> Travel:
    turn_rad = (right_mm - left_mm) / 2 / SETTINGS.half_track_mm
    return Travel(
        left_mm=left_mm,
        right_mm=right_mm,
        translation_mm=(left_mm + right_mm) / 2,
        rotation_deg=math.degrees(turn_rad),
    )


@pytest.fixture
def motion() -> Motion:
    motion = Motion(SETTINGS, SessionLimits(SETTINGS))
    motion.observe(travel(0.0, 0.0))
    motion.enable(True)
    return motion


def give(motion: Motion, order: Order) -> bool:
    orders = {
        Order.VELOCITY: lambda: motion.velocity(100.0),
        Order.POSITION: lambda: motion.move(100.0),
        Order.WHEELS: lambda: motion.wheels(100.0, 50.0),
        Order.STOP: motion.stop,
        Order.E_STOP: motion.emergency_stop,
    }
    return orders[order]()


INTO = {Mode.TRANSLATE_ROTATE: Order.VELOCITY, Mode.DIRECT_WHEELS: Order.WHEELS, Mode.EMERGENCY: Order.E_STOP}


@pytest.mark.parametrize("mode", list(Mode))
@pytest.mark.parametrize("order", list(Order))
def test_every_order_in_every_mode(motion: Motion, mode: Mode, order: Order) -> None:
    give(motion, INTO[mode])
    assert motion.mode is mode
    expected = MODES.get((mode, order))
    assert give(motion, order) is (expected is not None)
    assert motion.mode is (expected or mode)


@each("order", list(Order))
def test_no_order_without_motors(order: Order) -> None:
    motion = Motion(SETTINGS, SessionLimits(SETTINGS))
    assert not give(motion, order)
    assert motion.step(0.01) == (0.0, 0.0)


def test_the_only_order_refused_is_a_position_in_an_emergency() -> None:
    missing = [(mode, order) for mode in Mode for order in Order if (mode, order) not in MODES]
    assert missing == [(Mode.EMERGENCY, Order.POSITION)]


def test_driving_straight_holds_the_heading(motion: Motion) -> None:
    motion.velocity(200.0)
    motion.step(0.1)
    motion.observe(travel(3.0, 0.0))
    left, right = motion.step(0.1)
    assert right > left


def test_a_robot_that_was_told_nothing_does_not_fight_being_pushed(motion: Motion) -> None:
    motion.observe(travel(20.0, 20.0))
    assert motion.step(0.01) == (0.0, 0.0)


def test_tops_hold_for_each_wheel() -> None:
    limits = SessionLimits(SETTINGS)
    motion = Motion(SETTINGS, limits)
    motion.observe(travel(0.0, 0.0))
    motion.enable(True)
    limits.set_translation_speed(1600)
    limits.set_rotation_speed(360)
    motion.velocity(1600.0)
    motion.rotate(360.0)
    fastest = max(abs(speed) for _ in range(600) for speed in motion.step(0.02))
    assert fastest == 1600.0


def test_turning_on_the_spot_holds_the_place(motion: Motion) -> None:
    motion.rotate(20.0)
    motion.step(0.1)
    motion.observe(travel(3.0, 3.0))
    left, right = motion.step(0.1)
    assert left + right < 0
