"""Ask the installed physics whether it still moves things right, in about a tenth of a second.

A build or a setting that damps, hops or slips gives plausible motion and wrong verdicts, so a bench should ask before
it believes. Warnings of the library while loading raise `worlds.errors.PhysicsOutputError` from here as from anywhere.
"""

from __future__ import annotations

import math
from contextlib import closing
from dataclasses import dataclass

from worlds.scenes import Scene, Start
from worlds.vehicles.model import Part, SphereShape, Vehicle, sphere_inertia
from worlds.vehicles.pioneer_2dx import DEFAULTS, Pioneer2dxBody
from worlds.vehicles.rover_4wd import DEFAULTS as ROVER
from worlds.vehicles.rover_4wd import WHEELS
from worlds.world import default_physics, open_world

GRAVITY_M_S2 = 9.81
FALL_TOLERANCE_M = 1e-6
ROLL_TOLERANCE = 1e-3
DRIVE_TOLERANCE = 1e-3

_STEP_HZ = 240
_FALL_HEIGHT_M = 100.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One check's outcome: what was asked, whether it held, and the figures, ready to print."""

    name: str
    passed: bool
    detail: str


def self_check(physics: str | None = None) -> tuple[Finding, ...]:
    """Run every check on a physics of rigid bodies, `worlds.world.default_physics` if None.

    Raises:
        PhysicsMissingError: the physics library is not installed.
        PhysicsOutputError: it warned while loading.
    """
    physics = default_physics() if physics is None else physics
    return free_fall(physics), rolling(physics), driving(physics)


def free_fall(physics: str) -> Finding:
    """A ball falls for 2 s as semi-implicit Euler integration says, to 1e-6 m: no damping anywhere."""
    steps = 2 * _STEP_HZ
    expected_m = _FALL_HEIGHT_M - GRAVITY_M_S2 * steps * (steps + 1) / 2 / _STEP_HZ**2
    scene = Scene(name="fall", start=Start(z_m=_FALL_HEIGHT_M))
    with closing(open_world(scene, _ball(), physics, step_hz=_STEP_HZ)) as world:
        for _ in range(steps):
            world.step()
        fallen_m = world.pose().position_m[2]
    detail = f"height after 2 s: {fallen_m:.6f} m, expected {expected_m:.6f} m"
    return Finding(name="free fall", passed=abs(fallen_m - expected_m) <= FALL_TOLERANCE_M, detail=detail)


def rolling(physics: str) -> Finding:
    """A Pioneer that speeds up gently and rolls for 2 s covers what its wheels turned, to 0.1 %: round wheels."""
    with closing(open_world("empty", "pioneer-2dx", physics, step_hz=_STEP_HZ)) as world:
        body = Pioneer2dxBody(world, sonar_poses=())
        for step in range(2 * _STEP_HZ):
            speed_rad_s = min(0.3 * step / _STEP_HZ, 0.3) / DEFAULTS.wheel_radius_m
            body.command_wheels(speed_rad_s, speed_rad_s)
            world.step()
        rolled_m = sum(body.wheel_angles_rad()) / 2 * DEFAULTS.wheel_radius_m
        travelled_m = math.hypot(*world.pose().position_m[:2])
    detail = f"travelled {travelled_m:.5f} m, wheels turned {rolled_m:.5f} m"
    return Finding(name="rolling", passed=abs(travelled_m / rolled_m - 1) <= ROLL_TOLERANCE, detail=detail)


def driving(physics: str) -> Finding:
    """A rover's wheel in the air is driven for 0.5 s against dry friction, and turns as its inertia says, to 0.1 %."""
    torque_nm, friction_nm, seconds = 0.010, 0.004, 0.5
    with closing(open_world("stand", "rover-4wd", physics, step_hz=_STEP_HZ)) as world:
        for _ in range(round(seconds * _STEP_HZ)):
            for wheel in WHEELS:
                world.drive(wheel, torque_nm, friction_nm)
            world.step()
        speed_rad_s = world.joint(WHEELS[0]).speed_rad_s
    wheel_kg_m2 = ROVER.reflected_inertia_kg_m2 + ROVER.wheel_mass_kg * ROVER.wheel_radius_m**2 / 2
    expected_rad_s = (torque_nm - friction_nm) / wheel_kg_m2 * seconds
    detail = f"wheel at {speed_rad_s:.5f} rad/s, expected {expected_rad_s:.5f} rad/s"
    return Finding(name="driving", passed=abs(speed_rad_s / expected_rad_s - 1) <= DRIVE_TOLERANCE, detail=detail)


def _ball() -> Vehicle:
    radius_m, mass_kg = 0.1, 1.0
    shape = SphereShape(radius_m=radius_m, center_m=(0.0, 0.0, 0.0))
    ball = Part(
        name="ball",
        mass_kg=mass_kg,
        center_of_mass_m=(0.0, 0.0, 0.0),
        inertia_kg_m2=sphere_inertia(mass_kg, radius_m),
        shapes=(shape,),
    )
    return Vehicle(name="ball", parts=(ball,))
