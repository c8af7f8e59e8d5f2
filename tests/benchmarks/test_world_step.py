"""What the `World` interface costs over the library it hides: the same robot, commands and reads, side by side.

Run by `make bench`; prints the ratio, nothing is asserted on time. The two alternate in short blocks and the best block
of each counts, so that a busy machine disturbs both alike.
"""

from __future__ import annotations

import math
import os
import timeit

import pytest

from worlds import open_world
from worlds.bullet import _Builder
from worlds.vehicles.pioneer_2dx import Pioneer2dxBody

STEPS = 240
BLOCKS = 15


@pytest.fixture
def bullet():
    return pytest.importorskip("pybullet")


def raw_block(bullet, scene, vehicle):
    """The calls a program without the interface would make in each step."""
    client = bullet.connect(bullet.DIRECT)
    body, _, links = _Builder(bullet, client).build(scene, vehicle, 240)
    wheels = [links["wheel_left"], links["wheel_right"]]
    rings = [links["bumper_front"], links["bumper_rear"]]

    def block():
        for step in range(STEPS):
            speed = 2.0 + math.sin(step / 50)
            bullet.setJointMotorControlArray(
                body,
                wheels,
                bullet.VELOCITY_CONTROL,
                targetVelocities=[speed, speed],
                forces=[1.0, 1.0],
                physicsClientId=client,
            )
            bullet.stepSimulation(physicsClientId=client)
            bullet.getJointStates(body, wheels, physicsClientId=client)
            bullet.getBasePositionAndOrientation(body, physicsClientId=client)
            bullet.getBaseVelocity(body, physicsClientId=client)
            for ring in rings:
                bullet.getContactPoints(bodyA=body, linkIndexA=ring, physicsClientId=client)

    return block


def interface_block(world):
    body = Pioneer2dxBody(world, sonar_poses=())

    def block():
        for step in range(STEPS):
            speed = 2.0 + math.sin(step / 50)
            body.command_wheels(speed, speed)
            world.step()
            body.wheel_angles_rad()
            body.motor_loads()
            body.bumpers()
            world.pose()
            world.velocity()

    return block


@pytest.mark.parametrize("scene", ["empty", "room-with-boxes"])
def test_the_interface_costs_little(bullet, scene, record_property):
    world = open_world(scene, "pioneer-2dx")
    ours, theirs = interface_block(world), raw_block(bullet, world.scene, world.vehicle)
    times = [(timeit.timeit(ours, number=1), timeit.timeit(theirs, number=1)) for _ in range(BLOCKS)]
    assert world.step_index == BLOCKS * STEPS
    world.close()
    best, best_raw = (min(column) / STEPS * 1e6 for column in zip(*times, strict=True))
    ratio = best / best_raw
    record_property("world_step_ratio", ratio)
    report = f"step, commands and reads {best:.0f} us, raw PyBullet {best_raw:.0f} us, ratio {ratio:.2f}"
    os.write(1, f"\n{scene}: {report}\n".encode())


def test_opening_a_world_beside_a_bare_client(bullet, record_property):
    """The library keeps its clients, so that a suite that opens a world for each case pays for one only."""
    open_world("room-with-boxes", "pioneer-2dx").close()
    best = min(timeit.repeat(lambda: open_world("room-with-boxes", "pioneer-2dx").close(), number=1, repeat=20))
    first = min(timeit.repeat(lambda: bullet.disconnect(bullet.connect(bullet.DIRECT)), number=1, repeat=5))
    record_property("world_open_ratio", best / first)
    report = f"open_world on a used client {best * 1e3:.1f} ms, a bare new client {first * 1e3:.1f} ms"
    os.write(1, f"\n{report}, ratio {best / first:.1f}\n".encode())
