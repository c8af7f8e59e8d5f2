"""What the `World` interface costs over the library it hides: the same robot, commands and reads, side by side.

Run by `make bench`; prints the ratio, nothing is asserted on time. The two alternate in short blocks, and the processor
time of each block is held against that of the next one of the other: the median of these ratios counts, so that a busy
machine disturbs both alike. In the end both have read the same figures, which is asserted.
"""

from __future__ import annotations

import math
import os
import statistics
import time
import timeit

import pytest

from worlds import open_world
from worlds.bullet_builder import Builder
from worlds.car_commands import CarCommand, CommandMode
from worlds.car_dynamics import CarDynamics
from worlds.mujoco_builder import build
from worlds.vehicles.car import CarBody
from worlds.vehicles.pioneer_2dx import Pioneer2dxBody

STEPS = 240
BLOCKS = 15
DRIVES = 4


@pytest.fixture
def bullet():
    return pytest.importorskip("pybullet")


def taken_s(block):
    """Return the processor time of a block."""
    return timeit.timeit(block, timer=time.process_time, number=1)


def raw_block(bullet, scene, vehicle):
    """The calls a program without the interface would make in each step, and the figures it wants from them."""
    client = bullet.connect(bullet.DIRECT)
    body, _, links = Builder(bullet, client).build(scene, vehicle, 240)
    wheels = [links["wheel_left"], links["wheel_right"]]
    rings = [links["bumper_front"], links["bumper_rear"]]
    center_of_mass = vehicle.parts[0].center_of_mass_m

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
            left, right = bullet.getJointStates(body, wheels, physicsClientId=client)
            angles, loads = (left[0], right[0]), (min(abs(left[3]), 1.0), min(abs(right[3]), 1.0))
            (x, y, z), quaternion = bullet.getBasePositionAndOrientation(body, physicsClientId=client)
            # The library speaks of the centre of mass.
            ahead, aside, up = bullet.rotateVector(quaternion, center_of_mass)
            place, turn = (x - ahead, y - aside, z - up), bullet.getEulerFromQuaternion(quaternion)
            (x, y, z), (wx, wy, wz) = bullet.getBaseVelocity(body, physicsClientId=client)
            linear = x - (wy * up - wz * aside), y - (wz * ahead - wx * up), z - (wx * aside - wy * ahead)
            touched = [bullet.getContactPoints(bodyA=body, linkIndexA=ring, physicsClientId=client) for ring in rings]
        return [*angles, *loads, *place, *turn, *linear, wx, wy, wz, any(touched)]

    return block


def raw_mujoco_block(mujoco, scene, vehicle):
    """The same with MuJoCo, whose constraints are told in each step what motors aim at and not to rise."""
    built = build(mujoco, scene, vehicle, 240)
    model, data = built.model, mujoco.MjData(built.model)
    mujoco.mj_forward(model, data)
    wheels = [built.joints[name] for name in ("wheel_left", "wheel_right")]
    (left, _), (right, _) = wheels
    rings = {number for number in range(model.ngeom) if model.geom(number).name.startswith("bumper_")}

    def block():
        for step in range(STEPS):
            speed = 2.0 + math.sin(step / 50)
            for _, dof in wheels:
                model.dof_frictionloss[dof] = 1.0
            mujoco.mj_step1(model, data)
            wanted, slips, contact = data.efc_aref, data.efc_vel.tolist(), data.contact
            for row in range(len(wheels)):
                wanted[row] += speed * 240
            for row, friction in zip(contact.efc_address.tolist(), contact.friction[:, 0].tolist(), strict=True):
                slides = math.hypot(slips[row + 1], slips[row + 2])
                if slides > friction * 9.81 / 240:
                    wanted[row] -= friction * slides * 240
            mujoco.mj_step2(model, data)
            forces, positions, speeds = data.efc_force.tolist(), data.qpos.tolist(), data.qvel.tolist()
            angles, loads = (positions[left], positions[right]), (min(abs(forces[0]), 1.0), min(abs(forces[1]), 1.0))
            *place, w, x, y, z = positions[:7]
            roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
            yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
            turn = roll, math.asin(2 * (w * y - x * z)), yaw
            *linear, wx, wy, wz = speeds[:6]
            # The library has the turn rate along the vehicle's axes.
            tx, ty, tz = 2 * (y * wz - z * wy), 2 * (z * wx - x * wz), 2 * (x * wy - y * wx)
            angular = wx + w * tx + y * tz - z * ty, wy + w * ty + z * tx - x * tz, wz + w * tz + x * ty - y * tx
            places = zip(contact.geom.tolist(), contact.pos.tolist(), contact.efc_address.tolist(), strict=True)
            touched = [(point, forces[row]) for pair, point, row in places if not rings.isdisjoint(pair)]
        return [*angles, *loads, *place, *turn, *linear, *angular, bool(touched)]

    return block


def interface_block(world):
    body = Pioneer2dxBody(world, sonar_poses=())

    def block():
        for step in range(STEPS):
            speed = 2.0 + math.sin(step / 50)
            body.command_wheels(speed, speed)
            world.step()
            angles = body.wheel_angles_rad()
            loads = body.motor_loads()
            masks = body.bumpers()
            pose = world.pose()
            velocity = world.velocity()
        turn = pose.roll_rad, pose.pitch_rad, pose.yaw_rad
        return [*angles, *loads, *pose.position_m, *turn, *velocity.linear_m_s, *velocity.angular_rad_s, any(masks)]

    return block


@pytest.mark.parametrize(
    ("physics", "library", "raw"), [("bullet", "pybullet", raw_block), ("mujoco", "mujoco", raw_mujoco_block)]
)
@pytest.mark.parametrize("scene", ["empty", "room-with-boxes"])
def test_the_interface_costs_little(physics, library, raw, scene, record_property):
    engine = pytest.importorskip(library)
    times = []
    for _ in range(DRIVES):
        world = open_world(scene, "pioneer-2dx", physics)
        ours, theirs = interface_block(world), raw(engine, world.scene, world.vehicle)
        times += [(taken_s(ours), taken_s(theirs)) for _ in range(BLOCKS)]
        assert world.step_index == BLOCKS * STEPS
        assert ours() == pytest.approx(theirs(), abs=1e-6), "the two do not read the same"
        world.close()
    ratio = statistics.median(one / raw_one for one, raw_one in times)
    typical, typical_raw = (statistics.median(column) / STEPS * 1e6 for column in zip(*times, strict=True))
    record_property("world_step_ratio", ratio)
    report = f"step, commands and reads {typical:.0f} us, raw {library} {typical_raw:.0f} us, ratio {ratio:.2f}"
    os.write(1, f"\n{scene}: {report}\n".encode())


def raw_car_block(bullet, scene, vehicle):
    """A program that sets the car's velocity in each step, and asks what it touches and where it is."""
    client = bullet.connect(bullet.DIRECT)
    body, _, _ = Builder(bullet, client).build(scene, vehicle, 240)

    def block():
        for _ in range(STEPS):
            bullet.resetBaseVelocity(body, (0.1, 0.0, 0.04), (0.0, 0.0, 0.1), physicsClientId=client)
            bullet.stepSimulation(physicsClientId=client)
            bullet.getBasePositionAndOrientation(body, physicsClientId=client)
            bullet.getContactPoints(bodyA=body, physicsClientId=client)

    return block


def car_block(world):
    body = CarBody(world)

    def block():
        for step in range(STEPS):
            angle = 0.1 * math.sin(step / 50)
            body.command = CarCommand(mode=CommandMode.ACKERMANN, speed_m_s=3.0, steering_rad=angle)
            world.step()
            body.touches()
            world.pose()
            world.velocity()

    return block


def test_a_car_costs_its_model_over_a_pushed_box(bullet, record_property):
    """In the open, so that none of the three ever runs into anything; and what the model takes of it."""
    world, model = open_world("empty", "car", "bullet"), CarDynamics()
    model.layer.command = CarCommand(mode=CommandMode.ACKERMANN, speed_m_s=3.0, steering_rad=0.1)
    ours, theirs = car_block(world), raw_car_block(bullet, world.scene, world.vehicle)

    def alone():
        for _ in range(STEPS):
            model.advance(1 / 240)

    times = [[timeit.timeit(block, number=1) for block in (ours, theirs, alone)] for _ in range(BLOCKS)]
    world.close()
    best, best_raw, best_model = (min(column) / STEPS * 1e6 for column in zip(*times, strict=True))
    record_property("car_step_ratio", best / best_raw)
    report = (
        f"step, command and reads {best:.0f} us ({best_model:.0f} us of it the model), raw PyBullet {best_raw:.0f} us"
    )
    os.write(1, f"\ncar: {report}, ratio {best / best_raw:.2f}\n".encode())


def test_opening_a_world_beside_a_bare_client(bullet, record_property):
    """The library keeps its clients, so that a suite that opens a world for each case pays for one only."""
    open_world("room-with-boxes", "pioneer-2dx", "bullet").close()
    best = min(
        timeit.repeat(lambda: open_world("room-with-boxes", "pioneer-2dx", "bullet").close(), number=1, repeat=20)
    )
    first = min(timeit.repeat(lambda: bullet.disconnect(bullet.connect(bullet.DIRECT)), number=1, repeat=5))
    record_property("world_open_ratio", best / first)
    report = f"open_world on a used client {best * 1e3:.1f} ms, a bare new client {first * 1e3:.1f} ms"
    os.write(1, f"\n{report}, ratio {best / first:.1f}\n".encode())
