"""A car at the simulator's end of a line: what commands mean to it, and what it says of itself."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from hilbench.bench import Bench
from hilbench.benchfile.bench_model import World
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.mcu.bare_vehicle import BareVehicle
from hilbench.systems.vehicle.driven_car import DrivenCar, car_command
from hilbench.systems.vehicle.simulator_peer import BoardPeer
from protocols.carla import AckermannCommand, CommandFrame, ManualCommand, Mode
from targets.robots.car_host import CarHostSettings
from worlds.car_commands import CarCommand, CommandMode
from worlds.car_parameters import DEFAULTS
from worlds.errors import WorldError


@pytest.fixture
def make():
    def make(**settings):
        bench = Bench(Scheduler(), Journal())
        link = MemoryLink(bench.scheduler, Line(baud=921_600), name="usart2")
        vehicle = BareVehicle(bench, World(scene="empty", vehicle="car", physics="plane", step_hz=240), seed=0)
        car = DrivenCar(bench, link.b, vehicle.body, vehicle.runner, CarHostSettings(**settings))
        return SimpleNamespace(bench=bench, car=car, board=BoardPeer(bench, link.a), body=vehicle.body)

    return make


def test_the_boards_factor_makes_the_angle_that_was_asked_for():
    asked_rad = 0.3
    command = car_command(AckermannCommand(steering_rad=1.2 * asked_rad), DEFAULTS.max_steering_rad)
    assert command.mode is CommandMode.ACKERMANN
    assert command.steering_rad == pytest.approx(asked_rad, rel=0.012)


def test_full_angle_of_a_wheel_is_full_angle_of_the_car():
    wish = AckermannCommand(steering_rad=math.radians(69.99), speed_m_s=5.0, acceleration_m_s2=-1.0, jerk_m_s3=2.0)
    command = car_command(wish, DEFAULTS.max_steering_rad)
    assert command.steering_rad == pytest.approx(DEFAULTS.max_steering_rad)
    assert (command.speed_m_s, command.accel_m_s2, command.jerk_m_s3) == (5.0, -1.0, 2.0)


def test_manual_steer_is_positive_to_the_right():
    wish = ManualCommand(steer=0.5, throttle=0.3, brake=0.1)
    assert car_command(wish, 1.0) == CarCommand(mode=CommandMode.PEDALS, throttle=0.3, brake=0.1, steer=-0.5)


def test_nothing_asked_for_is_free_pedals():
    assert car_command(None, 1.0) == CarCommand()
    with pytest.raises(WorldError, match="not finite"):
        car_command(AckermannCommand(speed_m_s=math.nan), 1.0)


def test_frames_move_the_car_and_statuses_say_so(make):
    there = make()
    there.board.command = CommandFrame(steering=0.24, speed=5.0, acceleration=2.0, mode=Mode.AUTOWARE)
    there.board.commands.start(20.0)
    there.bench.run_for(4.0)
    dynamics = there.body.dynamics
    assert dynamics.lon_speed_m_s == pytest.approx(5.0, abs=1e-3)
    assert dynamics.steering_rad == pytest.approx(0.2, rel=0.012)
    statuses = [got.packet for got in there.board.frames()]
    assert len(statuses) == pytest.approx(80, abs=1)
    assert statuses[-1].lon_speed_m_s == pytest.approx(5.0, abs=1e-3)
    assert statuses[-1].steering_rad == pytest.approx(dynamics.steering_rad)
    signs = there.car.simulator.host.behaviour.host.signs
    assert signs.heading_rate * statuses[-1].heading_rate_rad_s == pytest.approx(dynamics.yaw_rate_rad_s, rel=0.01)


def test_a_command_that_is_not_finite_changes_nothing(make):
    there = make(profile="v0")  # the hardened side drops it before
    there.board.command = CommandFrame(speed=3.0, mode=Mode.AUTOWARE)
    there.board.send_command(there.board.command)
    there.bench.run_for(0.1)
    there.board.send_command(CommandFrame(speed=math.nan, mode=Mode.AUTOWARE))
    there.bench.run_for(2.0)
    assert there.body.dynamics.lon_speed_m_s == pytest.approx(3.0, abs=1e-3)


def test_a_simulator_that_is_stopped_says_nothing_but_still_obeys(make):
    there = make()
    there.bench.run_for(0.21)
    there.car.statuses.stop()
    there.board.forget()
    there.board.command = CommandFrame(speed=0.5, mode=Mode.MANUAL)  # half throttle
    there.board.commands.start(20.0)
    there.bench.run_for(1.0)
    assert there.board.frames() == []
    assert there.body.dynamics.lon_speed_m_s > 1.0
