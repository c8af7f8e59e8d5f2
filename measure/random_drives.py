"""``python -m measure.random_drives --seeds 1000``: random drives in random rooms, on each physics of rigid bodies.

Each seed is a room with twelve boxes, a place in it and a vehicle, a Pioneer or a rover in turn. For a while its wheels
get random speeds and torques, full ones both ways among them, and it is pushed; then it brakes, is released and stands.
"""

from __future__ import annotations

import argparse
import math
import random
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import NamedTuple

from tests.rigid import deepest_m, push
from worlds import find_scene, open_world
from worlds.errors import WorldError
from worlds.scenes.builtin import ROOM_SIDE_M

HZ = 240
DRIVE_S = 4.0
CHANGE_S = 0.8
BRAKING_S = 5.0
"""At most: full torque may have driven it for all the time before."""

STAND_S = 1.0
FULL_NM = {"pioneer-2dx": 1.0, "rover-4wd": 0.08}
FASTEST_RAD_S = 12.0
PUSHED_M_S = 1.0
PUSHED_RAD_S = 3.0

DEEPEST_M = {"bullet": 0.03, "mujoco": 0.03}
"""What the library may say of how deep a vehicle is in a wall, a box or the floor."""

DRIFT_M = {"bullet": 1e-4, "mujoco": 1e-5}
"""How far it may move within a second of standing. In PyBullet a rover that leans on a wall with a wheel creeps on."""


class Drive(NamedTuple):
    """What came of a seed: the greatest depth, how far it moved at the end, in how many steps it ran into something."""

    physics: str
    seed: int
    deepest_m: float
    drift_m: float
    bumps: int
    problem: str


def drive(physics: str, seed: int, drive_s: float = DRIVE_S) -> Drive:
    """Drive one seed, and say what was wrong, if anything was."""
    rng = random.Random(seed)
    vehicle = ("pioneer-2dx", "rover-4wd")[seed % 2]
    scene = find_scene("room-with-boxes", seed)
    world = open_world(scene, vehicle, physics, HZ)
    deepest, bumps, problem = 0.0, 0, ""
    try:
        world.place(*_free_place(scene, rng))
        for step in range(round(drive_s * HZ)):
            if step % round(CHANGE_S * HZ) == 0:
                _change(world, rng)
            world.step()
            deepest = max(deepest, deepest_m(world))
            bumps += any(contact.other != "floor" for contact in world.contacts())
            problem = problem or _out_of_place(world)
        drift = _stand(world)
    except WorldError as lost:
        return Drive(physics, seed, deepest, math.inf, bumps, str(lost))
    finally:
        world.close()
    if deepest > DEEPEST_M[physics]:
        problem = problem or f"{deepest * 1000:.1f} mm deep"
    if drift > DRIFT_M[physics]:
        problem = problem or f"moved by {drift * 1000:.4f} mm where it stands"
    return Drive(physics, seed, deepest, drift, bumps, problem)


def _free_place(scene, rng):
    """A place near the wall in front or the one behind, and clear of boxes."""
    while True:
        x, y = rng.choice((-1, 1)) * rng.uniform(3.5, 4.5), rng.uniform(-4.5, 4.5)
        if all(math.dist((x, y), box.center_m[:2]) > 0.8 for box in scene.boxes if not box.name.startswith("wall")):
            return x, y, rng.uniform(-math.pi, math.pi)


def _change(world, rng):
    full_nm, together = FULL_NM[world.vehicle.name], rng.random() < 0.6
    for number, joint in enumerate(world.vehicle.joints):
        if number == 0 or not together:
            kind, share, way = rng.randrange(4), rng.uniform(0, 4), rng.uniform(-1, 1)
        if kind == 0:
            world.release(joint)
        elif kind == 1:
            world.command(joint, way * FASTEST_RAD_S, full_nm * share)
        else:
            world.drive(joint, math.copysign(full_nm, way))
    if rng.random() < 0.1:
        way = rng.uniform(-math.pi, math.pi)
        linear = (PUSHED_M_S * math.cos(way), PUSHED_M_S * math.sin(way), 0.0)
        push(world, linear, (0.0, 0.0, rng.uniform(-1, 1) * PUSHED_RAD_S))


def _out_of_place(world):
    """Say where a vehicle is that has gone through a wall, a box or the floor."""
    x, y, z = world.pose().position_m
    inside = max(abs(x), abs(y)) < ROOM_SIDE_M / 2 and -0.05 < z < 1.0
    boxed = any(_within(box, x, y) for box in world.scene.boxes if z < box.size_m[2])
    return "" if inside and not boxed else f"at x {x:.3f} m, y {y:.3f} m, z {z:.3f} m"


def _within(box, x, y):
    cos, sin = math.cos(box.yaw_rad), math.sin(box.yaw_rad)
    dx, dy = x - box.center_m[0], y - box.center_m[1]
    return abs(dx * cos + dy * sin) < box.size_m[0] / 2 and abs(dy * cos - dx * sin) < box.size_m[1] / 2


def _stand(world):
    """Brake until the wheels stand too, wait for a second without power, and return how far it moves in one more."""
    for joint in world.vehicle.joints:
        world.command(joint, 0.0, FULL_NM[world.vehicle.name])
    for _ in range(round(BRAKING_S / 0.1)):
        _steps(world, 0.1)
        wheels = max(abs(world.joint(joint).speed_rad_s) for joint in world.vehicle.joints)
        if math.hypot(*world.velocity().linear_m_s) < 1e-3 and wheels < 1e-2:
            break
    for joint in world.vehicle.joints:
        world.release(joint)
    _steps(world, STAND_S)
    before = world.pose().position_m
    _steps(world, STAND_S)
    return math.dist(before, world.pose().position_m)


def _steps(world, seconds):
    for _ in range(round(seconds * HZ)):
        world.step()


def _both(seed):
    return [drive(physics, seed) for physics in DEEPEST_M]


def main(words: Sequence[str]) -> int:
    """Drive all seeds by two processes, and print what came of them."""
    parser = argparse.ArgumentParser(prog="python -m measure.random_drives", description=__doc__)
    parser.add_argument("--seeds", type=int, default=1000, help="how many (default %(default)s)")
    seeds = parser.parse_args(words).seeds
    drives: list[Drive] = []
    with ProcessPoolExecutor(2) as pool:
        for number, pair in enumerate(pool.map(_both, range(seeds), chunksize=5), 1):
            drives += pair
            for one in pair:
                if one.problem:
                    sys.stdout.write(f"{one.physics}, seed {one.seed}: {one.problem}\n")
            if number % 50 == 0:
                sys.stdout.write(f"{number} of {seeds}\n")
                sys.stdout.flush()
    for physics in DEEPEST_M:
        mine = [one for one in drives if one.physics == physics]
        deepest, drift = max(one.deepest_m for one in mine), max(one.drift_m for one in mine)
        bumped, wrong = sum(one.bumps > 0 for one in mine), sum(bool(one.problem) for one in mine)
        sys.stdout.write(
            f"{physics}: {len(mine)} drives, {bumped} of them into something, {wrong} wrong; "
            f"deepest {deepest * 1000:.1f} mm, drift at rest {drift * 1e6:.3f} um/s\n"
        )
    return 1 if any(one.problem for one in drives) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
