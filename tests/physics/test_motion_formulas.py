"""How far the virtual Pioneer in its world is off what mechanics says: straight, turn, circle, stopping distance.

Driven with bytes on its line, looked at in its world, compared with formulas written down here. The bounds are a few
times what is measured, so that a worse physics or servo shows.
"""

from __future__ import annotations

import math
import statistics

import pytest

from hilbench.bench import Bench
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.systems.pioneer.robot import PioneerPlan, VirtualPioneer
from protocols.p2os import Command, CommandNumber, encode_command
from targets.robots.pioneer import RobotSettings
from tests.rigid import RIGID

C = CommandNumber
STEP_HZ = 240

OTHER_VALUES = pytest.mark.exhaustive("the gate has the formula at other values, with each physics")
PHYSICS = pytest.mark.parametrize("physics", [*RIGID, "plane"])


class Rig:
    """A robot with an open session and its motors on, at the far end of a line without pace."""

    def __init__(self, physics, step_hz=STEP_HZ):
        self.bench = Bench(Scheduler(), Journal())
        link = MemoryLink(self.bench.scheduler, Line(baud=0), name="host")
        plan = PioneerPlan(physics=physics, step_hz=step_hz, settings=RobotSettings(host_baud=115_200))
        self.pioneer = VirtualPioneer(self.bench, link.b, plan, seed=0)
        self.world = self.pioneer.world
        self.port = link.a
        for number, argument in ((0, None), (1, None), (2, None), (C.OPEN, None), (C.ENABLE, 1)):
            self.send(number, argument)
            self.bench.run_for(0.2)

    def send(self, number, argument=None):
        self.port.write(encode_command(Command(number=number, argument=argument)))

    def run(self, duration_s):
        """Let time pass with the watchdog fed; return the pose (mm, degrees) at each physics step."""
        poses = []
        for step in range(round(duration_s * self.world.step_hz)):
            if step % self.world.step_hz == 0:
                self.send(C.PULSE)
            self.bench.run_for(1 / self.world.step_hz)
            poses.append(self.pose())
        return poses

    def pose(self):
        pose = self.world.pose()
        return pose.position_m[0] * 1000, pose.position_m[1] * 1000, math.degrees(pose.yaw_rad)


@pytest.fixture
def rig():
    rigs = []

    def make(physics, **options):
        rigs.append(Rig(physics, **options))
        return rigs[-1]

    yield make
    for one in rigs:
        one.pioneer.close()


@PHYSICS
@pytest.mark.parametrize(
    ("speed", "acceleration"), [pytest.param(200, 300, marks=OTHER_VALUES), (400, 300), (600, 600)]
)
def test_one_metre_straight(rig, physics, speed, acceleration):
    """Rest to rest along a trapezoid: time v/a + s/v, way 1 m, no drift to the side, no turn."""
    robot = rig(physics)
    robot.send(C.SETV, speed)
    robot.send(C.SETA, acceleration)
    robot.send(C.SETA, -acceleration)
    x0, y0, heading0 = robot.pose()
    robot.send(C.MOVE, 1000)
    trapezoid_s = speed / acceleration + 1000 / speed
    poses = robot.run(trapezoid_s + 0.5)
    x, y, heading = poses[-1]
    assert x - x0 == pytest.approx(1000, abs=0.1)
    assert y - y0 == pytest.approx(0, abs=0.2)
    assert heading - heading0 == pytest.approx(0, abs=0.02)
    halfway = poses[round(trapezoid_s / 2 * robot.world.step_hz)][0] - x0
    assert halfway == pytest.approx(500, abs=0.2)
    before_the_end = poses[round((trapezoid_s - 0.1) * robot.world.step_hz)][0] - x0
    assert 1000 - before_the_end == pytest.approx(acceleration * 0.1**2 / 2, abs=0.2)


@PHYSICS
@pytest.mark.parametrize("angle", [90, pytest.param(-90, marks=OTHER_VALUES), pytest.param(45, marks=OTHER_VALUES)])
def test_turn_on_the_spot(rig, physics, angle):
    robot = rig(physics)
    x0, y0, heading0 = robot.pose()
    robot.send(C.DHEAD, angle)
    x, y, heading = robot.run(3.0)[-1]
    assert heading - heading0 == pytest.approx(angle, abs=0.02)
    assert math.hypot(x - x0, y - y0) < 0.3


@PHYSICS
@pytest.mark.parametrize(
    ("speed", "turn_deg_s"),
    [(-150, 60), *(pytest.param(300, turn, marks=OTHER_VALUES) for turn in (45, -30, -60))],
)
def test_circle(rig, physics, speed, turn_deg_s):
    """Once round: every point is at v/w from the middle, which is to the left for a turn to the left; back in 360/w."""
    robot = rig(physics)
    robot.send(C.SETA, 600)
    robot.send(C.VEL, speed)
    robot.send(C.RVEL, turn_deg_s)
    x0, y0, heading0 = robot.run(1.5)[-1]
    radius = speed / math.radians(turn_deg_s)
    middle = (x0 - radius * math.sin(math.radians(heading0)), y0 + radius * math.cos(math.radians(heading0)))
    poses = robot.run(360 / abs(turn_deg_s))
    radii = [math.dist((x, y), middle) for x, y, _ in poses]
    # In a bend wheels creep outwards by a fraction of a millimetre, so that the middle is not quite abreast of the
    # robot; the mean over a whole turn is free of that.
    assert statistics.fmean(radii) == pytest.approx(abs(radius), abs=0.15)
    assert max(radii) - min(radii) < 2.5
    x, y, heading = poses[-1]
    assert math.dist((x, y), (x0, y0)) < 0.5
    assert math.remainder(heading - heading0, 360) == pytest.approx(0, abs=0.05)


@PHYSICS
@pytest.mark.parametrize(
    ("speed", "deceleration"), [(200, 300), pytest.param(500, 300, marks=OTHER_VALUES), (600, 600)]
)
def test_stopping_distance(rig, physics, speed, deceleration):
    """v²/2a, and up to one step at full speed, for the command waits for the next one."""
    robot = rig(physics)
    robot.send(C.SETA, 600)
    robot.send(C.SETA, -deceleration)
    robot.send(C.VEL, speed)
    x0 = robot.run(speed / 600 + 0.5)[-1][0]
    robot.send(C.STOP)
    x = robot.run(speed / deceleration + 0.5)[-1][0]
    formula = speed**2 / (2 * deceleration)
    assert formula - 0.3 <= x - x0 <= formula + speed / robot.world.step_hz + 0.3


@pytest.mark.exhaustive("the same drives at finer steps; the gate has each formula at the usual one")
@pytest.mark.parametrize("physics", RIGID)
def test_a_finer_step_moves_nothing_by_more_than_a_step(physics):
    """The same 300 mm at 240 and at 1000 steps per second."""
    ends = []
    for step_hz in (240, 1000):
        robot = Rig(physics, step_hz=step_hz)
        try:
            robot.send(C.MOVE, 300)
            ends.append(robot.run(2.5)[-1][0])
        finally:
            robot.pioneer.close()
    assert ends[0] == pytest.approx(ends[1], abs=0.2)
