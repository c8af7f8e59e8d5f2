from __future__ import annotations

import hashlib
import math
import os
import struct
import subprocess
import sys

import pytest

from tests.rigid import DEFAULT_IN_GATE, RIGID
from worlds.vehicles.pioneer_2dx import Pioneer2dxBody
from worlds.world import open_world

FRONT_DISCS_MM_DEG = [
    (69, 136, 90),
    (114, 119, 50),
    (148, 78, 30),
    (166, 27, 10),
    (166, -27, -10),
    (148, -78, -30),
    (114, -119, -50),
    (69, -136, -90),
]


LONG = {"test_car", "test_determinism", "test_pioneer", "test_plane", "test_rover", "test_sonar"}
"""Files whose tests drive for long: the gate has them with one physics."""


def pytest_generate_tests(metafunc):
    """Run a test with each physics of rigid bodies, unless it says itself with which."""
    said = [mark.args[0] for mark in metafunc.definition.iter_markers("parametrize")]
    if "physics" in metafunc.fixturenames and not any("physics" in names for names in said):
        is_long = metafunc.module.__name__.rpartition(".")[2] in LONG
        metafunc.parametrize("physics", DEFAULT_IN_GATE if is_long else RIGID, indirect=True)


@pytest.fixture
def physics(request):
    """The physics of rigid bodies of the test."""
    return request.param


@pytest.fixture
def open_it(physics):
    """Open worlds as `open_world` does, of the test's physics; all are closed afterwards."""
    opened = []

    def opener(scene, vehicle, physics=physics, step_hz=240, seed=0):
        opened.append(open_world(scene, vehicle, physics, step_hz, seed))
        return opened[-1]

    yield opener
    for world in opened:
        world.close()


@pytest.fixture
def discs():
    """The eight front discs of a P2-DX (AriaCoda params/p2dx.p), as metres and radians."""
    return [(x / 1000, y / 1000, math.radians(th)) for x, y, th in FRONT_DISCS_MM_DEG]


@pytest.fixture
def pioneer(open_it, discs, physics):
    """Open a world with a Pioneer and return its body."""

    def opener(scene="empty", physics=physics, step_hz=240, seed=0):
        return Pioneer2dxBody(open_it(scene, "pioneer-2dx", physics, step_hz, seed), sonar_poses=discs)

    return opener


@pytest.fixture
def drive():
    """Drive a trapezoid: `distance` of one wheel path at `left`, `right` shares of a top speed, then stand for 1 s."""

    def driver(body, *, left, right, distance_m, top_m_s=0.3, acceleration_m_s2=0.3):
        radius, hz = body.parameters.wheel_radius_m, body.world.step_hz
        ramp_s = top_m_s / acceleration_m_s2
        end_s = distance_m / top_m_s + ramp_s
        for step in range(round((end_s + 1) * hz)):
            now_s = (step + 0.5) / hz
            speed = max(0.0, min(now_s * acceleration_m_s2, top_m_s, (end_s - now_s) * acceleration_m_s2)) / radius
            body.command_wheels(left * speed, right * speed)
            body.world.step()
        return body.world.pose()

    return driver


@pytest.fixture
def state_bits():
    """Everything a world tells about its vehicle, as the bits of its floats."""

    def bits(world):
        pose, velocity = world.pose(), world.velocity()
        joints = [world.joint(name) for name in world.vehicle.joints]
        numbers = [
            *pose.position_m,
            pose.yaw_rad,
            pose.pitch_rad,
            pose.roll_rad,
            *velocity.linear_m_s,
            *velocity.angular_rad_s,
            *(value for joint in joints for value in (joint.angle_rad, joint.speed_rad_s, joint.torque_nm)),
        ]
        return struct.pack(f"<{len(numbers)}d", *numbers)

    return bits


@pytest.fixture
def run_hash(state_bits):
    """Hash of a run with stops, turns and a collision; `meanwhile(body)` is called in every step."""

    def run(body, steps=600, meanwhile=None):
        digest = hashlib.sha256()
        for step in range(steps):
            if step % 150 < 120:
                body.command_wheels(4.0 + step / 200, 5.0 - step / 300)
            else:
                body.release_wheels()
            body.world.step()
            if meanwhile is not None:
                meanwhile(body)
            digest.update(state_bits(body.world))
        return digest.hexdigest()

    return run


@pytest.fixture
def python():
    """Run a program in a fresh interpreter of its own."""

    def runner(source, *words, **variables):
        # PYTHONUNBUFFERED would switch off C's buffers too, and hide what a pipe does to them.
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"} | variables
        command = [sys.executable, "-c", source, *words]
        return subprocess.run(command, capture_output=True, text=True, timeout=60, env=environment)

    return runner
