"""A kinematic bicycle and some paths for the driver."""

from __future__ import annotations

import math

import pytest

from targets.robots.driving_stack import Path, PathDriver, Pose

STEP_S = 0.01


class Bicycle:
    """Rolls without slip: `yaw' = v tan(angle) / wheelbase`; obeys a command within its limits, 20 reports a second."""

    def __init__(self, x_m=0.0, y_m=0.0, yaw_rad=0.0, speed_m_s=0.0, wheelbase_m=2.85):
        self.x_m, self.y_m, self.yaw_rad, self.speed_m_s = x_m, y_m, yaw_rad, speed_m_s
        self.wheelbase_m = wheelbase_m
        self.angle_rad = 0.0
        self.lateral_m_s2 = 0.0

    @property
    def pose(self):
        return Pose(x_m=self.x_m, y_m=self.y_m, yaw_rad=self.yaw_rad)

    def obey(self, command, step_s=STEP_S):
        most_rad = command.steering_tire_rotation_rate * step_s
        self.angle_rad += min(max(command.steering_tire_angle - self.angle_rad, -most_rad), most_rad)
        most_m_s = (abs(command.acceleration) if command.speed else 8.0) * step_s
        self.speed_m_s += min(max(command.speed - self.speed_m_s, -most_m_s), most_m_s)
        turn_rad_s = self.speed_m_s * math.tan(self.angle_rad) / self.wheelbase_m
        self.lateral_m_s2 = self.speed_m_s * turn_rad_s
        middle_rad = self.yaw_rad + turn_rad_s * step_s / 2
        self.x_m += self.speed_m_s * math.cos(middle_rad) * step_s
        self.y_m += self.speed_m_s * math.sin(middle_rad) * step_s
        self.yaw_rad += turn_rad_s * step_s


class Drive:
    """A driver and a bicycle in a loop: a command each 30 ms from a report that is up to 50 ms old."""

    def __init__(self, path, settings=None, **bicycle):
        self.driver = PathDriver(path, settings)
        self.bicycle = Bicycle(**bicycle)
        self.offsets_m, self.speeds_m_s, self.lateral_m_s2, self.commands = [], [], [], []

    def run(self, duration_s, until=lambda: False):
        for step in range(round(duration_s / STEP_S)):
            if step % 5 == 0:
                pose, speed_m_s = self.bicycle.pose, self.bicycle.speed_m_s
            if step % 3 == 0:
                command = self.driver.command(pose, speed_m_s)
                self.commands.append(command)
            if step % 9 == 0:
                self.offsets_m.append(self.driver.path.place(self.bicycle.x_m, self.bicycle.y_m).offset_m)
            self.bicycle.obey(command)
            self.speeds_m_s.append(self.bicycle.speed_m_s)
            self.lateral_m_s2.append(self.bicycle.lateral_m_s2)
            if until():
                return step * STEP_S
        return duration_s


def arc(x_m, y_m, radius_m, start_rad, turn_rad, count):
    """Points of an arc around a middle, turning left where `turn_rad` is positive."""
    angles = [start_rad + turn_rad * i / count for i in range(count + 1)]
    return [(x_m + radius_m * math.cos(a), y_m + radius_m * math.sin(a)) for a in angles]


@pytest.fixture
def drive():
    return Drive


@pytest.fixture
def straight():
    return Path([(0.0, 0.0), (300.0, 0.0)])


@pytest.fixture
def circle():
    """Radius 30 m around (0, 30), to the left from the origin."""
    return Path(arc(0.0, 30.0, 30.0, -math.pi / 2, 2 * math.pi, 180), closed=True)


@pytest.fixture
def oval():
    """Two straights of 100 m and two half circles of 25 m, to the left."""
    first = [(float(x), 0.0) for x in range(0, 101, 2)]
    right = arc(100.0, 25.0, 25.0, -math.pi / 2, math.pi, 60)
    back = [(float(x), 50.0) for x in range(100, -1, -2)]
    left = arc(0.0, 25.0, 25.0, math.pi / 2, math.pi, 60)
    return Path([*first, *right, *back, *left], closed=True)
