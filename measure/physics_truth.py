"""``python -m measure.physics_truth``: what each physics computes, against formulas; the table of ``docs/physics.md``.

The scenarios are those of the tests, where a test has one.
"""

from __future__ import annotations

import math
import statistics
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import NamedTuple

from measure.physics_oracles import GRAVITY_M_S2
from protocols.p2os import CommandNumber
from tests.physics.test_motion_formulas import Rig
from tests.rigid import push
from tests.worlds.test_oracles import brick
from tests.worlds.test_rover import go, rolled_turn_rad_s, speed_m_s
from tests.worlds.test_sonar import cone_m, free_places, sampled_m
from worlds import find_scene, open_world
from worlds.car_commands import CarCommand, CommandMode
from worlds.car_dynamics import CarDynamics
from worlds.motion import PlanarPose, PlanarVelocity
from worlds.vehicles.car import CarBody
from worlds.vehicles.pioneer_2dx import DEFAULTS as P
from worlds.vehicles.pioneer_2dx import Pioneer2dxBody
from worlds.vehicles.rover_4wd import DEFAULTS as R
from worlds.vehicles.rover_4wd import Rover4wdBody

PAGE = Path(__file__).parents[1] / "docs" / "physics.md"
BEGIN, END = "<!-- table -->\n", "<!-- end of table -->\n"
BOTH = ("bullet", "mujoco")
HZ = 240
C = CommandNumber


class Row(NamedTuple):
    """A figure: what was done, its unit, what the formula says, what came, and what a clause allows it to be off by."""

    case: str
    unit: str
    expected: float
    found: float
    allowed: str = ""


def rows(physics: str) -> Iterator[Row]:
    """Every figure of the table, of one physics."""
    for scenario in (_pioneer, _stall, _uphill, _rest, _sonar, _sliding, _rover, _car):
        yield from scenario(physics)


def table() -> str:
    """Return the table as Markdown: one line for each figure, both physics side by side."""
    lines = [("Case", "Unit", "Formula", "PyBullet: off by", "MuJoCo: off by", "A clause allows"), ("---",) * 6]
    for one, other in zip(*map(rows, BOTH), strict=True):
        errors = (f"{row.found - row.expected:+.2g}" for row in (one, other))
        lines.append((one.case, one.unit, f"{one.expected:.5g}", *errors, one.allowed))
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


@contextmanager
def _driven(physics: str) -> Iterator[Rig]:
    rig = Rig(physics)
    try:
        yield rig
    finally:
        rig.pioneer.close()


def _pioneer(physics: str) -> Iterator[Row]:
    """By bytes on its line, as tests/physics has it."""
    with _driven(physics) as robot:
        robot.send(C.SETV, 400)
        robot.send(C.MOVE, 1000)
        x, y, heading = robot.run(5.0)[-1]
        yield Row("Pioneer, MOVE 1000: way", "mm", 1000, x, "1")
        yield Row("the same: aside", "mm", 0, y, "1")
        yield Row("the same: turned", "degrees", 0, heading, "0.25")
    with _driven(physics) as robot:
        robot.send(C.DHEAD, 90)
        x, y, heading = robot.run(3.0)[-1]
        yield Row("Pioneer, DHEAD 90: heading", "degrees", 90, heading, "0.25")
        yield Row("the same: moved away", "mm", 0, math.hypot(x, y), "3")
    with _driven(physics) as robot:
        robot.send(C.SETA, 600)
        robot.send(C.VEL, 300)
        robot.send(C.RVEL, -60)
        x0, y0, heading0 = robot.run(1.5)[-1]
        radius = 300 / math.radians(-60)
        middle = x0 - radius * math.sin(math.radians(heading0)), y0 + radius * math.cos(math.radians(heading0))
        poses = robot.run(6.0)
        radii = statistics.fmean(math.dist(pose[:2], middle) for pose in poses)
        yield Row("Pioneer, circle at 300 mm/s and -60 °/s: radius", "mm", -radius, radii)
        turned = math.remainder(poses[-1][2] - heading0, 360)
        yield Row("the same: heading once round", "degrees", 0, turned)
    with _driven(physics) as robot:
        robot.send(C.SETA, 600)
        robot.send(C.SETA, -300)
        robot.send(C.VEL, 600)
        x0 = robot.run(1.5)[-1][0]
        robot.send(C.STOP)
        yield Row("Pioneer, stop from 600 mm/s at 300 mm/s²: way", "mm", 600, robot.run(2.5)[-1][0] - x0)


@contextmanager
def _pioneer_in(scene: str, physics: str) -> Iterator[Pioneer2dxBody]:
    with closing(open_world(scene, "pioneer-2dx", physics, HZ, seed=3)) as world:
        yield Pioneer2dxBody(world, sonar_poses=[(0.166, 0.027, math.radians(10)), (0.069, 0.136, math.radians(90))])


def _go(body: Pioneer2dxBody, speed_m_s: float | None, seconds: float) -> None:
    for _ in range(round(seconds * HZ)):
        if speed_m_s is None:
            body.release_wheels()
        else:
            body.command_wheels(speed_m_s / P.wheel_radius_m, speed_m_s / P.wheel_radius_m)
        body.world.step()


def _stall(physics: str) -> Iterator[Row]:
    with _pioneer_in("wall", physics) as body:
        body.world.place(1.6, 0.0, 0.0)
        _go(body, 0.3, 3.0)
        yield Row("Pioneer at a wall: place", "mm", 1790, body.world.pose().position_m[0] * 1000, "5")
        yield Row("the same: load of a motor", "1", 1, body.motor_loads()[0])
        yield Row("the same: speed of a wheel", "mm/s", 0, body.world.joint("wheel_left").speed_rad_s * 82.5)


def _uphill(physics: str) -> Iterator[Row]:
    slope = math.radians(8)
    with _pioneer_in("ramp", physics) as body:
        _go(body, 0.3, 9.0)
        _go(body, 0.0, 2.0)
        start = body.world.pose()
        yield Row("Pioneer on 8°: pitch", "degrees", -8, math.degrees(start.pitch_rad))
        load_nm = P.mass_kg * GRAVITY_M_S2 * math.sin(slope) * P.wheel_radius_m / 2
        yield Row("the same, held: torque of a motor", "N·m", load_nm, body.motor_loads()[0] * P.torque_limit_nm)
        _go(body, 0.0, 2.0)
        yield Row("the same: creeps in 2 s", "um", 0, math.dist(start.position_m, body.world.pose().position_m) * 1e6)
        start = body.world.pose()
        _go(body, None, 1.0)
        pull_n = P.mass_kg * GRAVITY_M_S2 * math.sin(slope) - 2 * P.released_friction_nm / P.wheel_radius_m
        rolled_mm = math.dist(body.world.pose().position_m, start.position_m) * 1000
        yield Row("the same, released: rolls in 1 s", "mm", pull_n / (P.mass_kg + P.wheel_mass_kg) * 500, rolled_mm)


def _rest(physics: str) -> Iterator[Row]:
    with _pioneer_in("empty", physics) as body:
        _go(body, 0.3, 1.0)
        _go(body, 0.0, 2.0)
        before = body.world.pose()
        _go(body, 0.0, 60.0)
        after = body.world.pose()
        yield Row("Pioneer held for a minute: drift", "um", 0, math.dist(after.position_m, before.position_m) * 1e6)
        yield Row("the same: turned", "degrees", 0, math.degrees(after.yaw_rad - before.yaw_rad))


def _sonar(physics: str) -> Iterator[Row]:
    faces, cones = [], []
    with _pioneer_in("room-with-boxes", physics) as body:
        discs, boxes = [(0.166, 0.027, math.radians(10)), (0.069, 0.136, math.radians(90))], body.world.scene.boxes
        for place in free_places(body.world.scene, 40, seed=1):
            body.world.place(*place)
            for number, disc in enumerate(discs):
                heard = body.sonar_range_m(number)
                if heard is not None:
                    faces.append(heard - sampled_m(body, disc, boxes))
                    cones.append(heard - max(cone_m(body, disc), 0.1))
    yield Row(f"Sonar, {len(faces)} echoes: median against its rays", "mm", 0, statistics.median(map(abs, faces)) * 1e3)
    yield Row("the same: worst, at an edge", "mm", 0, max(faces, key=abs) * 1e3)
    yield Row("the same: worst against the cone", "mm", 0, max(cones, key=abs) * 1e3)


def _sliding(physics: str) -> Iterator[Row]:
    with closing(open_world("empty", brick(0.5), physics, HZ)) as world:
        for _ in range(24):
            world.step()
        start = world.pose().position_m[0]
        push(world, (5.0, 0.0, 0.0))
        for _ in range(4 * HZ):
            world.step()
        way_m = 25 / GRAVITY_M_S2
        yield Row("Box that slides from 5 m/s, friction 0.5: way", "m", way_m, world.pose().position_m[0] - start)


def _rover(physics: str) -> Iterator[Row]:
    with closing(open_world("hard-floor", "rover-4wd", physics, HZ)) as world:
        body = Rover4wdBody(world)
        go(body, 5.6, 5.6, 3.0)
        yield Row("Rover straight on at 5.6 V: speed", "m/s", 5.6 / 6 * 20.9 * R.wheel_radius_m, speed_m_s(body), "3 %")
    with closing(open_world("hard-floor", "rover-4wd", physics, HZ)) as world:
        body = Rover4wdBody(world)
        share = go(body, -4.4, 4.4, 4.0) / rolled_turn_rad_s(body)
        ideal = R.track_m**2 / (R.track_m**2 + R.wheelbase_m**2)
        yield Row("Rover on the spot: turn, of two wheels'", "1", ideal, share, "0.42 to 0.62 (R11)")
    with closing(open_world("hard-floor", "rover-4wd", physics, HZ)) as world:
        body = Rover4wdBody(world)
        turn = go(body, 2.2, 5.6, 4.0)
        yield Row("Rover at 2.2 V and 5.6 V: turn (no formula)", "rad/s", 0, turn)


def _car(physics: str) -> Iterator[Row]:
    def command(**fields: float) -> CarCommand:
        return CarCommand(mode=CommandMode.ACKERMANN, **fields)

    for speed, degrees in ((10.0, 2.0), (0.9, 20.0)):
        model, angle = CarDynamics(), math.radians(degrees)
        with closing(open_world("empty", "car", physics, HZ)) as world:
            body = CarBody(world)
            for one in (body.dynamics, model):
                one.adopt(PlanarPose(0.0, 0.0, 0.0), PlanarVelocity(speed, 0.0, 0.0))
                one.layer.command = command(speed_m_s=speed, steering_rad=angle)
            for _ in range(15 * HZ):
                world.step()
                model.advance(1 / HZ)
            off_m = math.dist(world.pose().position_m[:2], model.pose[:2])
        yield Row(f"Car, 15 s of circle at {speed:g} m/s and {degrees:g}°: off its model", "m", 0, off_m)
    with closing(open_world(find_scene("test-track"), "car", physics, HZ)) as world:
        body = CarBody(world)
        world.place(60.0, 0.0, 0.0)
        body.dynamics.adopt(PlanarPose(60.0, 0.0, 0.0), PlanarVelocity(10.0, 0.0, 0.0))
        body.command = command(speed_m_s=10.0)
        while not body.touches():
            world.step()
        yield Row("Car into a wall at 10 m/s: speed after it", "m/s", 0, body.dynamics.lon_speed_m_s)
        for _ in range(3 * HZ):
            world.step()
        yield Row("the same: place 3 s later", "m", 116.2, world.pose().position_m[0])


def main() -> int:
    """Write the table into the page."""
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    after = rest.partition(END)[2]
    PAGE.write_text(before + BEGIN + table() + END + after, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
