"""The rover as rigid bodies: does it go, turn, slip and lean as rigid wheels with dry friction do."""

from __future__ import annotations

import hashlib
import math

import pytest

from tests.share import few
from worlds import WorldError, find_vehicle, open_world
from worlds.vehicles.model import parameter_table
from worlds.vehicles.rover_4wd import BODY, DEFAULTS, IMU, WHEELS, Rover4wdBody, Rover4wdParameters, vehicle

STALL_NM, IDLE_RAD_S, NOMINAL_V = 0.08, 20.9, 6.0
"""The motor law that the figures are held against: torque = stall V / 6 V - stall w / idle."""

G = 9.81


@pytest.fixture
def rover(open_it):
    def opener(scene="carpet", step_hz=240, **figures):
        parameters = Rover4wdParameters(**figures)
        return Rover4wdBody(open_it(scene, vehicle(parameters), step_hz=step_hz), parameters=parameters)

    return opener


def go(body, left_v, right_v, seconds, friction_nm=0.0):
    """Put volts on the motors of both sides; return the mean turn rate of the last half, rad/s."""
    steps, turned = round(seconds * body.world.step_hz), 0.0
    for step in range(steps):
        for wheel in WHEELS:
            volts = left_v if wheel.startswith("wheel_l") else right_v
            torque = STALL_NM * volts / NOMINAL_V - STALL_NM / IDLE_RAD_S * body.wheel(wheel).speed_rad_s
            body.drive(wheel, torque, friction_nm)
        body.world.step()
        body.felt()
        if step >= steps // 2:
            turned += body.world.velocity().angular_rad_s[2]
    return turned / (steps - steps // 2)


def speed_m_s(body):
    return math.hypot(*body.world.velocity().linear_m_s[:2])


def rolled_turn_rad_s(body):
    """The turn rate of two wheels that never slip, by the speed of the wheels."""
    left, right = (sum(body.wheel(f"wheel_{side}{end}").speed_rad_s for end in "fb") / 2 for side in "lr")
    return (right - left) * body.parameters.wheel_radius_m / body.parameters.track_m


# --- figures


def test_every_figure_has_a_unit_and_a_source():
    for row in parameter_table(DEFAULTS):
        assert row.unit
        assert row.source.startswith(("assumed", "TT motor"))


def test_it_weighs_what_it_says_and_stands_on_four_wheels():
    parts = vehicle().parts
    assert sum(part.mass_kg for part in parts) == pytest.approx(1.0)
    assert vehicle().joints == WHEELS
    centers = {part.name: part.center_of_mass_m for part in parts if part.name != BODY}
    assert centers["wheel_lf"] == (0.0575, 0.07, 0.0325)
    assert centers["wheel_rb"] == (-0.0575, -0.07, 0.0325)
    assert find_vehicle("rover-4wd").mounts[IMU] == (0.03, 0.0, 0.07)


def test_a_rotor_weighs_most_behind_its_gear():
    assert DEFAULTS.reflected_inertia_kg_m2 == pytest.approx(48**2 * 1.4e-7)
    assert DEFAULTS.reflected_inertia_kg_m2 > 10 * 0.034 * 0.0325**2 / 2


def test_the_plane_cannot_hold_it():
    with pytest.raises(WorldError, match="two wheels"):
        open_world("empty", "rover-4wd", "plane")


# --- motion


@pytest.mark.parametrize("scene", ["carpet", "hard-floor"])
def test_straight_ahead_at_the_motors_idle_speed(rover, scene):
    """(5.6 V / 6 V) * 20.9 rad/s * 32.5 mm = 0.634 m/s, with nothing to hold it back."""
    body = rover(scene)
    go(body, 5.6, 5.6, 3.0)
    assert speed_m_s(body) == pytest.approx(5.6 / 6 * 20.9 * 0.0325, rel=5e-3)
    assert body.world.pose().position_m[1] == pytest.approx(0.0, abs=5e-3)
    assert body.felt().specific_force_m_s2 == pytest.approx((0, 0, G), abs=0.5)


def test_it_speeds_up_as_its_mass_and_its_rotors_let_it(rover):
    """Rotors and wheels count with J / r²: 1 kg becomes 2.3, and the time constant 2.3 kg r² idle / (4 stall)."""
    body = rover()
    p = body.parameters
    inertia = p.mass_kg * p.wheel_radius_m**2 + 4 * (
        p.reflected_inertia_kg_m2 + p.wheel_mass_kg * p.wheel_radius_m**2 / 2
    )
    constant_s = inertia * IDLE_RAD_S / (4 * STALL_NM)
    go(body, 3.0, 3.0, constant_s)
    expected = 3.0 / 6 * IDLE_RAD_S * p.wheel_radius_m * (1 - math.exp(-1))
    assert speed_m_s(body) == pytest.approx(expected, rel=0.02)


MORE_TURNS = [("carpet", -4.4, 4.4), ("carpet", -5.6, 5.6), ("hard-floor", 4.4, -4.4)]


@pytest.mark.parametrize(
    ("scene", "left_v", "right_v"),
    few([("hard-floor", -4.4, 4.4), *MORE_TURNS], 1, "the other floor, the other side, another speed"),
)
def test_on_the_spot_it_turns_half_as_fast_as_its_wheels_roll(rover, physics, scene, left_v, right_v):
    """Four points that slide with dry friction give track² / (track² + wheelbase²) = 0.60, and MuJoCo does.

    PyBullet weighs sliding along and across a wheel by how easily each is stopped, and gives 0.51.
    """
    body = rover(scene)
    turn = go(body, left_v, right_v, 4.0)
    p, share = body.parameters, turn / rolled_turn_rad_s(body)
    if physics == "mujoco":
        assert share == pytest.approx(p.track_m**2 / (p.track_m**2 + p.wheelbase_m**2), rel=2e-3)
    else:
        assert 0.42 < share < 0.55
    assert math.copysign(1, turn) == math.copysign(1, right_v)
    assert math.hypot(*body.world.pose().position_m[:2]) < 2e-3


def test_both_step_rates_turn_alike(rover):
    slow, fast = (go(rover("hard-floor", step_hz=hz), -4.4, 4.4, 3.0) for hz in (240, 1000))
    assert fast == pytest.approx(slow, rel=0.01)


def test_what_grips_too_well_does_not_turn(rover):
    """Scrubbing takes mu m g L / 2 / 4 * 2 r / track of torque at each wheel, more than 0.059 N·m at mu = 1.2."""
    body = rover(wheel_friction=1.2)
    assert go(body, -4.4, 4.4, 2.0) == pytest.approx(0.0, abs=1e-3)
    assert abs(body.wheel("wheel_rf").speed_rad_s) < 1e-2


def test_a_slow_side_bends_the_way(rover):
    body = rover("hard-floor")
    turn = go(body, 2.2, 5.6, 4.0)
    assert 0.02 < turn < 0.5
    assert body.world.velocity().linear_m_s != pytest.approx((0, 0, 0), abs=0.1)


def test_at_rest_it_stays_where_it_is(rover):
    body = rover()
    go(body, 0.0, 0.0, 2.0, friction_nm=0.012)
    before = body.world.pose()
    go(body, 0.0, 0.0, 15.0, friction_nm=0.012)
    after = body.world.pose()
    assert math.dist(after.position_m, before.position_m) < 1e-6
    assert abs(after.yaw_rad - before.yaw_rad) < 1e-6
    assert body.felt().specific_force_m_s2 == pytest.approx((0, 0, G), abs=1e-6)


def test_up_the_ramp_it_leans_back_and_feels_it(rover):
    body = rover("ramp")
    go(body, 5.0, 5.0, 5.0)
    slope = math.radians(8)
    assert body.world.pose().pitch_rad == pytest.approx(-slope, abs=1e-3)
    assert body.felt().specific_force_m_s2 == pytest.approx((G * math.sin(slope), 0.0, G * math.cos(slope)), abs=0.02)
    assert not body.touches(BODY)


def test_the_power_that_goes_in_is_what_comes_out(rover):
    """Work of the torques = energy of motion + what dry friction of the joints took; nothing slips here."""
    body = rover()
    p, work_j, angles = body.parameters, 0.0, dict.fromkeys(WHEELS, 0.0)
    for _ in range(240):
        for wheel in WHEELS:
            body.drive(wheel, 0.02, 0.005)
        body.world.step()
        for wheel in WHEELS:
            state = body.wheel(wheel)
            work_j += state.torque_nm * (state.angle_rad - angles[wheel])
            angles[wheel] = state.angle_rad
    wheels = 4 * (p.reflected_inertia_kg_m2 + p.wheel_mass_kg * p.wheel_radius_m**2 / 2)
    energy_j = p.mass_kg * speed_m_s(body) ** 2 / 2 + wheels * body.wheel("wheel_lf").speed_rad_s ** 2 / 2
    assert work_j == pytest.approx(energy_j, rel=0.02)


# --- scenes


def test_on_the_stand_the_wheels_turn_and_the_rover_does_not(rover):
    body = rover("stand")
    go(body, 6.0, -6.0, 2.0)
    assert [body.touches(wheel) for wheel in WHEELS] == [False] * 4
    assert body.touches(BODY)
    assert body.wheel("wheel_lf").speed_rad_s == pytest.approx(IDLE_RAD_S, rel=1e-3)
    assert body.wheel("wheel_rb").speed_rad_s == pytest.approx(-IDLE_RAD_S, rel=1e-3)
    assert body.world.pose().position_m == pytest.approx((0, 0, 0.03), abs=1e-3)
    assert body.world.pose().yaw_rad == pytest.approx(0.0, abs=1e-3)


def test_in_the_room_a_wall_stops_it(rover):
    body = rover("rover-room")
    assert not body.touches(BODY)
    body.world.place(1.0, 0.0, 0.0)
    go(body, 1.8, 1.8, 5.0, friction_nm=0.012)
    assert body.touches(BODY)
    assert body.world.pose().position_m[0] == pytest.approx(1.4 - 0.125, abs=1e-3)
    assert speed_m_s(body) < 1e-3
    assert [abs(body.wheel(wheel).speed_rad_s) for wheel in WHEELS] == pytest.approx([0.0] * 4, abs=1e-2)


def test_the_same_run_twice_is_the_same_bit_for_bit(rover, state_bits):
    def run():
        body, digest = rover("rover-room"), hashlib.sha256()
        for _ in range(8):
            go(body, 5.6, 3.1, 0.25, friction_nm=0.01)
            digest.update(state_bits(body.world))
        return digest.hexdigest()

    assert run() == run()
