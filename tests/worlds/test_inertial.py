"""What a place on a vehicle feels, against what mechanics says."""

from __future__ import annotations

import math

import pytest

from tests.each import each
from tests.rigid import RIGID
from worlds import Pose, Scene, Start, Vehicle, Velocity
from worlds.geometry import cross
from worlds.inertial import InertialPoint
from worlds.vehicles.model import Part, SphereShape, sphere_inertia

G = 9.81


class Moved:
    """A world whose vehicle moves as a function of time says."""

    def __init__(self, motion, step_hz=1000):
        self.step_hz, self.step_index, self._motion = step_hz, 0, motion

    def step(self):
        self.step_index += 1

    def pose(self):
        return self._motion(self.step_index / self.step_hz)[0]

    def velocity(self):
        return self._motion(self.step_index / self.step_hz)[1]


def still(_t):
    return Pose(position_m=(0, 0, 0), yaw_rad=0.3), Velocity(linear_m_s=(0, 0, 0), angular_rad_s=(0, 0, 0))


def turning(rate_rad_s, growth_rad_s2=0.0):
    """On the spot about z."""

    def motion(t):
        yaw = rate_rad_s * t + growth_rad_s2 * t * t / 2
        spin = (0.0, 0.0, rate_rad_s + growth_rad_s2 * t)
        return Pose(position_m=(0, 0, 0), yaw_rad=yaw), Velocity(linear_m_s=(0, 0, 0), angular_rad_s=spin)

    return motion


def after(world, point, steps):
    for _ in range(steps):
        world.step()
        felt = point.felt()
    return felt


def test_at_rest_the_floor_pushes_upwards():
    world = Moved(still)
    point = InertialPoint(world, (0.1, 0.2, 0.3))
    assert point.felt().specific_force_m_s2 == pytest.approx((0, 0, G))
    assert after(world, point, 3).specific_force_m_s2 == pytest.approx((0, 0, G))


@each(
    ("pitch_deg", "roll_deg", "force"),
    [
        (-90, 0, (G, 0, 0)),  # nose up: the seat pushes forward
        (90, 0, (-G, 0, 0)),
        (0, 90, (0, G, 0)),  # lying on the right side
        (0, 180, (0, 0, -G)),
        (-30, 0, (G * 0.5, 0, G * math.cos(math.radians(30)))),
    ],
)
def test_tilted_and_at_rest(pitch_deg, roll_deg, force):
    pose = Pose(position_m=(0, 0, 0), yaw_rad=1.0, pitch_rad=math.radians(pitch_deg), roll_rad=math.radians(roll_deg))
    world = Moved(lambda _t: (pose, Velocity(linear_m_s=(0, 0, 0), angular_rad_s=(0, 0, 0))))
    assert after(world, InertialPoint(world, (0, 0, 0)), 2).specific_force_m_s2 == pytest.approx(force, abs=1e-12)


def test_speeding_up_is_felt_ahead_whichever_way_it_looks():
    yaw = 2.0
    ahead = (math.cos(yaw), math.sin(yaw))

    def motion(t):
        speed = (0.5 * t * ahead[0], 0.5 * t * ahead[1], 0.0)
        return Pose(position_m=(0, 0, 0), yaw_rad=yaw), Velocity(linear_m_s=speed, angular_rad_s=(0, 0, 0))

    world = Moved(motion)
    assert after(world, InertialPoint(world, (0, 0, 0)), 5).specific_force_m_s2 == pytest.approx((0.5, 0, G))


@each("arm", [(0.1, 0.0, 0.05), (-0.04, 0.07, 0.0), (0.0, 0.0, 0.2)])
def test_turning_is_felt_towards_the_axis_and_by_the_arm(arm):
    """w x (w x r), and with a growing turn rate dw/dt x r besides."""
    rate, growth = 2.0, 3.0
    world = Moved(turning(rate, growth), step_hz=10_000)
    felt = after(world, InertialPoint(world, arm), 10)
    now = rate + growth * 10 / 10_000
    inwards = cross((0, 0, now), cross((0, 0, now), arm))
    along = cross((0, 0, growth), arm)
    assert felt.turn_rate_rad_s == pytest.approx((0, 0, now))
    expected = (inwards[0] + along[0], inwards[1] + along[1], G)
    assert felt.specific_force_m_s2 == pytest.approx(expected, abs=2e-3)


def test_turn_rates_are_along_the_vehicle_s_axes():
    pose = Pose(position_m=(0, 0, 0), yaw_rad=math.pi / 2)
    world = Moved(lambda _t: (pose, Velocity(linear_m_s=(0, 0, 0), angular_rad_s=(0.0, 0.7, 0.2))))
    assert after(world, InertialPoint(world, (0, 0, 0)), 1).turn_rate_rad_s == pytest.approx((0.7, 0.0, 0.2))


def test_asking_twice_changes_nothing():
    world = Moved(turning(1.0, 5.0))
    point = InertialPoint(world, (0.1, 0, 0))
    assert after(world, point, 4) is point.felt()


def test_in_free_fall_nothing_is_felt(open_it):
    shape = SphereShape(radius_m=0.1, center_m=(0, 0, 0))
    part = Part(
        name="ball",
        mass_kg=1.0,
        center_of_mass_m=(0, 0, 0),
        inertia_kg_m2=sphere_inertia(1.0, 0.1),
        shapes=(shape,),
    )
    world = open_it(Scene(name="fall", start=Start(z_m=50.0)), Vehicle(name="ball", parts=(part,)))
    felt = after(world, InertialPoint(world, (0.05, 0.0, 0.0)), 100)
    assert felt.specific_force_m_s2 == pytest.approx((0, 0, 0), abs=1e-9)


@pytest.mark.parametrize("physics", [*RIGID, "plane"])
def test_a_pioneer_on_a_circle_feels_v_squared_over_r(pioneer, physics):
    body = pioneer(physics=physics)
    p, world = body.parameters, body.world
    point = InertialPoint(world, (0.0, 0.0, 0.1))
    for _ in range(480):
        body.command_wheels(0.2 / p.wheel_radius_m, 0.3 / p.wheel_radius_m)
        world.step()
        felt = point.felt()
    turn = 0.1 / p.track_m
    assert felt.turn_rate_rad_s[2] == pytest.approx(turn, rel=2e-3)
    assert felt.specific_force_m_s2 == pytest.approx((0.0, 0.25 * turn, G), abs=2e-3)
