"""The car in its worlds: the physics follows the model, and the model what the physics runs into."""

from __future__ import annotations

import hashlib
import math

import pytest

from tests.each import each
from tests.share import few
from worlds import find_scene, find_vehicle
from worlds.car_commands import CarCommand, CommandMode
from worlds.car_dynamics import CarDynamics
from worlds.car_parameters import DEFAULTS, CarParameters
from worlds.errors import CapabilityError, UnknownNameError, WorldError
from worlds.motion import Lead, PlanarPose, PlanarVelocity
from worlds.scenes import Box, Scene
from worlds.vehicles.car import CarBody, vehicle

STEP_HZ = 240
ON_THE_PLANE = pytest.mark.parametrize("physics", ["plane"])


def ackermann(**fields):
    return CarCommand(mode=CommandMode.ACKERMANN, **fields)


def run(body, seconds):
    for _ in range(round(seconds * body.world.step_hz)):
        body.world.step()


@pytest.fixture
def car(open_it, physics):
    """Open a world with a car and return its body."""

    def opener(scene="empty", physics=physics, step_hz=STEP_HZ, parameters=None):
        return CarBody(open_it(scene, vehicle(parameters) if parameters else "car", physics, step_hz))

    return opener


@ON_THE_PLANE
def test_only_a_car_is_a_car(open_it):
    with pytest.raises(WorldError, match="a pioneer-2dx is no car"):
        CarBody(open_it("empty", "pioneer-2dx"))


def test_the_body_is_as_large_as_its_figures():
    part = find_vehicle("car").parts[0]
    (shape,) = part.shapes
    assert shape.center_m[0] + shape.size_m[0] / 2 == pytest.approx(DEFAULTS.front_bumper_m)
    assert shape.center_m[2] - shape.size_m[2] / 2 == pytest.approx(DEFAULTS.ground_clearance_m)
    assert part.mass_kg == DEFAULTS.mass_kg


@ON_THE_PLANE
def test_each_world_has_a_model_of_its_own(car):
    one, other = car(), car()
    one.command = ackermann(speed_m_s=5.0)
    run(one, 1.0)
    run(other, 1.0)
    assert one.world.pose().position_m[0] > 1.0
    assert other.world.pose().position_m == (0.0, 0.0, 0.0)


@ON_THE_PLANE
def test_on_the_plane_a_car_has_no_wheels_to_command_and_no_obstacles(car):
    body = car()
    with pytest.raises(UnknownNameError):
        body.world.command("wheel", 1.0, 1.0)
    with pytest.raises(CapabilityError):
        body.world.contacts()
    assert body.touches() is False
    assert body.ranges_m() == (math.inf, math.inf, math.inf)
    with pytest.raises(WorldError, match='use scene "empty"'):
        car("test-track")


@pytest.mark.parametrize(
    "step_hz", [100, 240, pytest.param(1000, marks=pytest.mark.exhaustive("the gate has two other lengths of a step"))]
)
def test_without_contacts_the_physics_is_the_model_to_the_last_digits(car, step_hz):
    """A slalom of 10 s at up to 10 m/s: no drift, whatever the step."""
    body, model = car(step_hz=step_hz), CarDynamics()
    for step in range(10 * step_hz):
        command = ackermann(speed_m_s=10.0, steering_rad=0.1 * math.sin(step / step_hz))
        body.command = model.layer.command = command
        body.world.step()
        model.advance(1 / step_hz)
    assert body.world.pose().position_m == pytest.approx((model.pose.x_m, model.pose.y_m, 0.0), abs=1e-9)
    assert body.world.pose().yaw_rad == pytest.approx(model.pose.yaw_rad, abs=1e-9)
    assert body.world.velocity().linear_m_s == (*model.velocity[:2], 0.0)


def test_a_wall_at_10_m_s_stops_the_car_at_its_bumper(car):
    """Contact as the bumper arrives, within a step; back at no more than 2 % of the speed, then at rest at the wall."""
    body = car("test-track")
    body.world.place(60.0, 0.0, 0.0)
    body.dynamics.adopt(PlanarPose(60.0, 0.0, 0.0), PlanarVelocity(10.0, 0.0, 0.0))
    body.command = ackermann(speed_m_s=10.0)
    steps = 0
    while not body.touches():
        body.world.step()
        steps += 1
    ideal_s = (120.0 - DEFAULTS.front_bumper_m - 60.0) / 10.0
    assert ideal_s - 1.5 / STEP_HZ < steps / STEP_HZ < ideal_s + 1.5 / STEP_HZ
    assert -0.2 < body.dynamics.lon_speed_m_s <= 0.0
    run(body, 3.0)
    assert body.touches()
    assert body.world.pose().position_m[0] == pytest.approx(120.0 - DEFAULTS.front_bumper_m, abs=1e-3)
    assert body.dynamics.lon_speed_m_s == pytest.approx(0.0, abs=1e-3)
    assert body.dynamics.lon_accel_m_s2 == pytest.approx(0.0, abs=0.1)
    assert body.world.contacts()[0].other == "wall"


def test_a_low_obstacle_stops_the_whole_car_at_once(car):
    """It hits the car far below its middle, and does not tip it over."""
    kerb = Box(name="kerb", center_m=(20.0, 0.0, 0.2), size_m=(0.5, 4.0, 0.4))
    body = car(Scene(name="kerb", boxes=(kerb,)))
    body.dynamics.adopt(PlanarPose(0.0, 0.0, 0.0), PlanarVelocity(10.0, 0.0, 0.0))
    while not body.touches():
        body.world.step()
    assert -0.2 < body.dynamics.lon_speed_m_s <= 0.0


@pytest.mark.parametrize("speed", few([25.0, 5.0, 15.0], 1, "lower speeds"))
def test_no_speed_tunnels_through_a_wall(car, speed):
    body = car("test-track")
    body.world.place(100.0, 0.0, 0.0)
    body.dynamics.adopt(PlanarPose(100.0, 0.0, 0.0), PlanarVelocity(speed, 0.0, 0.0))
    body.command = ackermann(speed_m_s=speed)
    run(body, 6.0)
    assert body.world.pose().position_m[0] == pytest.approx(120.0 - DEFAULTS.front_bumper_m, abs=0.01)


def test_a_glancing_blow_turns_the_car_along_the_wall(car):
    """It keeps what the wall does not take, and stays outside of it."""
    wall = Box(name="wall", center_m=(30.0, 5.0, 0.5), size_m=(60.0, 0.5, 1.0))
    body = car(Scene(name="along", boxes=(wall,)))
    body.world.place(0.0, 0.0, 0.2)
    body.command = ackermann(speed_m_s=8.0)
    touched = False
    for _ in range(5 * STEP_HZ):
        body.world.step()
        touched |= body.touches()
        assert body.world.pose().position_m[1] < 4.75 - DEFAULTS.width_m / 2 + 0.05
        assert body.world.pose().position_m[2] == 0.0
    assert touched
    assert abs(body.world.pose().yaw_rad) < 0.05
    assert body.dynamics.lon_speed_m_s > 5.0


def test_a_cone_off_the_middle_turns_the_car_towards_its_side(car):
    cone = Box(name="cone", center_m=(15.0, 0.8, 0.4), size_m=(0.3, 0.3, 0.8))
    body = car(Scene(name="cone", boxes=(cone,)))
    body.command = ackermann(speed_m_s=6.0)
    while not body.touches():
        body.world.step()
    run(body, 0.1)
    assert body.dynamics.yaw_rate_rad_s > 0.1  # held back on the left


def test_a_wall_lets_a_car_go_that_was_put_into_it(car):
    """At walking pace, as nothing but that has pushed it."""
    body = car("test-track")
    body.world.place(120.0 - DEFAULTS.front_bumper_m + 0.2, 0.0, 0.0)
    speeds = []
    for _ in range(5 * STEP_HZ):
        body.world.step()
        speeds.append(body.dynamics.lon_speed_m_s)
    assert -1.1 < min(speeds) < -0.1
    assert not body.touches()


def test_placing_forgets_motion_command_and_contact(car):
    body = car("test-track")
    body.world.place(115.0, 0.0, 0.0)
    body.command = ackermann(speed_m_s=5.0)
    run(body, 2.0)
    assert body.touches()
    body.world.place(1.0, 2.0, 0.5, 0.25)
    assert not body.touches()
    run(body, 1.0)
    assert body.world.pose().position_m == pytest.approx((1.0, 2.0, 0.25), abs=1e-12)
    assert body.world.velocity().linear_m_s == (0.0, 0.0, 0.0)
    assert body.command == CarCommand()


@ON_THE_PLANE
def test_a_slippery_floor_is_slippery_for_a_car_too(car):
    """Half the friction: 0.45 g at most instead of the 0.8 g that its brakes have."""
    body = car("hard-floor")
    body.dynamics.adopt(PlanarPose(0.0, 0.0, 0.0), PlanarVelocity(10.0, 0.0, 0.0))
    body.command = CarCommand(brake=1.0)
    run(body, 1.0)
    assert body.dynamics.lon_accel_m_s2 == pytest.approx(-9.81 * (0.45 + DEFAULTS.rolling_resistance), rel=0.01)


def test_rays_look_ahead_from_the_bumper(car):
    body = car("test-track")
    body.world.place(90.0, 0.0, math.atan2(1.0, 8.0))
    left, middle, right = body.ranges_m()
    slope = math.hypot(8.0, 1.0) / 8.0
    along = (120.0 - 90.0) * slope - DEFAULTS.front_bumper_m
    aside = DEFAULTS.width_m / 2 / 8.0
    assert (left, middle, right) == pytest.approx((along + aside, along, along - aside), abs=1e-6)
    body.world.place(119.0 - DEFAULTS.front_bumper_m - 100.0, 0.0, 0.0)
    assert body.ranges_m() == (math.inf, math.inf, math.inf)


def test_other_figures_make_another_car(car):
    body = car(parameters=CarParameters(max_accel_m_s2=1.0))
    body.command = ackermann(speed_m_s=9.0)
    run(body, 1.0)
    assert body.dynamics.lon_speed_m_s < 1.0
    assert any(row.source.startswith("set by the user") for row in body.world.vehicle.parameters)


def test_the_same_drive_gives_the_same_bits(car, state_bits):
    digests = set()
    for _ in range(2):
        body, digest = car("test-track"), hashlib.sha256()
        body.world.place(95.0, 0.3, 0.1)
        for step in range(1200):
            body.command = ackermann(speed_m_s=7.0, steering_rad=0.2 * math.sin(step / 50))
            body.world.step()
            digest.update(state_bits(body.world))
        digests.add(digest.hexdigest())
        assert body.touches()
    assert len(digests) == 1


def test_a_car_leaves_the_physics_as_it_was(car, pioneer, run_hash):
    """Its contacts are softer; the next world in the same client has those of its own again."""
    body = pioneer("wall")
    before = run_hash(body)
    body.world.close()
    car("test-track").world.close()
    assert run_hash(pioneer("wall")) == before


class FakeMotion:
    """Moves by a metre a step."""

    def __init__(self):
        self.pose, self.velocity = PlanarPose(0.0, 0.0, 0.0), PlanarVelocity(1.0, 0.0, 0.0)
        self.adopted = []

    def advance(self, dt_s):
        self.pose = PlanarPose(self.pose.x_m + dt_s, 0.0, 0.0)

    def adopt(self, pose, velocity):
        self.adopted.append((pose, velocity))
        self.pose, self.velocity = pose, velocity


class FakeBody:
    """Remembers how it is carried."""

    def __init__(self, contacts):
        self.carried = []
        self._contacts = contacts

    def carry(self, pose, velocity):
        self.carried.append((pose, velocity))

    def push(self, yaw_rad, velocity):
        self.carried.append((yaw_rad, velocity))

    def planar(self):
        return PlanarPose(0.5, 0.1, 0.2), PlanarVelocity(0.0, 0.1, 0.3)

    def contacts(self):
        return self._contacts


@each("contacts", [(), ("wall",)])
def test_who_follows_whom(contacts):
    motion, body = FakeMotion(), FakeBody(contacts)
    lead = Lead(motion, body)
    lead.before_step(1.0)
    assert body.carried == [(0.0, PlanarVelocity(1.0, 0.0, 0.0))]
    lead.after_step()
    where = body.planar() if contacts else (PlanarPose(1.0, 0.0, 0.0), PlanarVelocity(1.0, 0.0, 0.0))
    assert body.carried[1] == where
    assert bool(motion.adopted) is bool(contacts)


def test_the_track_s_lane_is_a_line_that_a_car_can_follow():
    """From the start on, closed, evenly dense, no sharper than the slalom's 20 m, and 2 m from every cone."""
    scene = find_scene("test-track")
    lane = scene.lane
    points = lane.center_m
    assert lane.closed
    assert points[0] == (0.0, 0.0)
    assert points[1][0] > 0
    gaps = [math.dist(one, other) for one, other in zip(points, (*points[1:], points[0]), strict=True)]
    assert 0.45 < min(gaps) <= max(gaps) < 0.6
    assert 397 < sum(gaps) < 402
    headings = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in zip(points, (*points[1:], points[0]), strict=True)]
    turns = [math.remainder(b - a, math.tau) for a, b in zip(headings, (*headings[1:], headings[0]), strict=True)]
    assert max(abs(turn) / gap for turn, gap in zip(turns, gaps, strict=True)) < 1 / 18.5
    assert sum(turns) == pytest.approx(math.tau)
    cones = [box for box in scene.boxes if box.name.startswith("cone")]
    for cone in cones:
        nearest = min(math.dist(cone.center_m[:2], point) for point in points)
        assert nearest == pytest.approx(2.0, abs=0.1)
    sides = [
        min(points, key=lambda point, cone=cone: math.dist(point, cone.center_m[:2]))[1] > cone.center_m[1]
        for cone in cones
    ]
    assert sides == [False, True, False, True]


def test_the_wall_stands_outside_the_lane():
    scene = find_scene("test-track")
    wall = next(box for box in scene.boxes if box.name == "wall")
    assert min(math.dist(corner, point) for corner in wall.outline_m() for point in scene.lane.center_m) > 3.0
    assert scene.free_ahead_m() == 120.0
