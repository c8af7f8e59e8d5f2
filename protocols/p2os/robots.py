"""What a client must know of each robot: conversion factors, limits, sizes, sonar poses.

The subclass of the identification selects the row. Values from AriaCoda params/*.p; Player robot_params.cc agrees
unless a row says otherwise. The speed limits are those of the clients, not what the robot can do: a real Pioneer 2-DX
is usually quoted at 1.6 m/s. The angle unit is the exact 2 pi / 4096; ARIA's files round it to 0.00153 (see `Dialect`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING

from protocols.p2os import sonar_poses
from protocols.p2os.errors import LocalProtocolError
from protocols.p2os.sonar_poses import SonarPose

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["ROBOTS", "ROBOT_VARIANTS", "RobotParameters", "SonarPose", "find_robot", "robot_parameters"]

_EXACT_ANGLE_RAD = 2 * math.pi / 4096


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotParameters:
    """One robot.

    Attributes:
        subclass: the model key of the identification, lower case.
        distance_unit_mm: mm in one unit of a SIP's x and y (DistConvFactor).
        range_unit_mm: mm in one unit of a sonar range (RangeConvFactor).
        turn_rad_per_mm: rad/s for 1 mm/s of half the wheel difference (DiffConvFactor), about 1 / half-track.
        max_speed_mm_s: greatest speed a client may ask for.
        max_turn_deg_s: greatest rotation rate a client may ask for.
        radius_mm: radius of the turning robot.
        width_mm: over the wheels.
        length_mm: over all.
        front_mm: from the centre of rotation to the front.
        rear_mm: from the centre of rotation to the rear.
        sonars: the sonar discs by number, from 0; a number without a disc has None.
        front_bumpers: segments of the front bumper ring, 0 without one.
        rear_bumpers: segments of the rear bumper ring, 0 without one.
        angle_unit_rad: rad in one unit of heading.
        speed_unit_mm_s: mm/s in one unit of a SIP's wheel speeds (VelConvFactor).
        vel2_unit_mm_s: mm/s in one unit of a VEL2 byte.
        has_move: the firmware has MOVE.
        switch_to_baud: rate in bit/s that ARIA changes to when the robot offers it; 0 for never.
        table_sensors: it has infrared sensors that look for tables.
        source: where the row comes from.
    """

    subclass: str
    distance_unit_mm: float
    range_unit_mm: float
    turn_rad_per_mm: float
    max_speed_mm_s: int
    max_turn_deg_s: int
    radius_mm: int
    width_mm: int
    length_mm: int
    front_mm: float
    rear_mm: float
    sonars: tuple[SonarPose | None, ...]
    front_bumpers: int = 0
    rear_bumpers: int = 0
    angle_unit_rad: float = _EXACT_ANGLE_RAD
    speed_unit_mm_s: float = 1.0
    vel2_unit_mm_s: float = 20.0
    has_move: bool = True
    switch_to_baud: int = 38_400
    table_sensors: bool = False
    source: str = "AriaCoda params"

    @property
    def units_per_turn(self) -> int:
        """Heading units of a whole turn: 4096, on a Pioneer 1 1024."""
        return round(2 * math.pi / self.angle_unit_rad)


_P2DX = RobotParameters(
    subclass="p2dx",
    distance_unit_mm=0.84,
    range_unit_mm=0.268,
    turn_rad_per_mm=0.0056,
    max_speed_mm_s=2200,
    max_turn_deg_s=500,
    radius_mm=250,
    width_mm=425,
    length_mm=511,
    front_mm=210,
    rear_mm=301,
    sonars=sonar_poses.DX,
    source="AriaCoda params/p2dx.p",
)
_P2AT = RobotParameters(
    subclass="p2at",
    distance_unit_mm=1.32,
    range_unit_mm=0.268,
    turn_rad_per_mm=0.0034,
    max_speed_mm_s=1200,
    max_turn_deg_s=300,
    radius_mm=500,
    width_mm=505,
    length_mm=626,
    front_mm=313,
    rear_mm=313,
    sonars=sonar_poses.AT,
    source="AriaCoda params/p2at.p",
)
_P2PB = replace(
    _P2DX,
    subclass="p2pb",
    distance_unit_mm=0.424,
    radius_mm=300,
    length_mm=513,
    front_mm=256.5,
    rear_mm=256.5,
    sonars=sonar_poses.PEOPLEBOT,
    front_bumpers=5,
    rear_bumpers=5,
    source="AriaCoda params/p2pb.p",
)
_AMIGO = RobotParameters(
    subclass="amigo",
    distance_unit_mm=0.5083,
    range_unit_mm=1.0,
    turn_rad_per_mm=0.011,
    max_speed_mm_s=1000,
    max_turn_deg_s=300,
    radius_mm=180,
    width_mm=279,
    length_mm=330,
    front_mm=160,
    rear_mm=170,
    sonars=sonar_poses.AMIGO,
    speed_unit_mm_s=0.6154,
    source="AriaCoda params/amigo.p",
)
_PION1X = RobotParameters(
    subclass="pion1x",
    distance_unit_mm=0.05066,
    range_unit_mm=0.1734,
    turn_rad_per_mm=0.00333,
    max_speed_mm_s=400,
    max_turn_deg_s=100,
    radius_mm=220,
    width_mm=400,
    length_mm=500,
    front_mm=250,
    rear_mm=250,
    sonars=sonar_poses.PIONEER_1,
    angle_unit_rad=2 * math.pi / 1024,
    speed_unit_mm_s=2.5332,
    vel2_unit_mm_s=4.0,
    has_move=False,
    switch_to_baud=0,
    source="AriaCoda params/pion1x.p",
)
_POWERBOT = RobotParameters(
    subclass="powerbot",
    distance_unit_mm=0.5813,
    range_unit_mm=1.0,
    turn_rad_per_mm=0.00373,
    max_speed_mm_s=2000,
    max_turn_deg_s=360,
    radius_mm=550,
    width_mm=680,
    length_mm=911,
    front_mm=369,
    rear_mm=542,
    sonars=sonar_poses.POWERBOT,
    front_bumpers=7,
    rear_bumpers=5,
    source="AriaCoda params/powerbot.p",
)


def _like(base: RobotParameters, subclass: str, distance_unit_mm: float, range_unit_mm: float) -> RobotParameters:
    """A robot that differs from another in its name and these two units."""
    return replace(
        base,
        subclass=subclass,
        distance_unit_mm=distance_unit_mm,
        range_unit_mm=range_unit_mm,
        source=f"AriaCoda params/{subclass}.p",
    )


_ROWS = (
    _P2DX,
    _like(_P2DX, "p2de", 0.969, 0.268),
    replace(_like(_P2DX, "p2df", 0.485, 0.268), turn_rad_per_mm=0.006),
    replace(_like(_P2DX, "p2ce", 0.826, 0.268), turn_rad_per_mm=0.0057),
    _like(_P2DX, "p2d8", 0.485, 1.0),
    _like(_P2DX, "p2d8+", 0.485, 1.0),
    _like(_P2DX, "p3dx", 0.485, 1.0),
    _like(_P2DX, "p3dx-sh", 1.0, 1.0),
    _P2AT,
    _like(_P2AT, "p2at8", 1.32, 1.0),
    _like(_P2AT, "p2at8+", 0.465, 1.0),
    _like(_P2AT, "p3at", 0.465, 1.0),
    _like(_P2AT, "p3at-sh", 1.0, 1.0),
    replace(_like(_P2AT, "p2it", 1.136, 0.268), turn_rad_per_mm=0.0032),
    _P2PB,
    replace(_like(_P2PB, "p2pp", 0.485, 0.268), turn_rad_per_mm=0.006, table_sensors=True),
    _AMIGO,
    replace(_like(_AMIGO, "amigo-sh", 1.0, 1.0), speed_unit_mm_s=1.0),
    _PION1X,
    _like(_PION1X, "pion1m", 0.05066, 0.1734),
    _like(_PION1X, "psos1x", 0.05066, 0.1734),
    _like(_PION1X, "psos1m", 0.05066, 0.1734),
    replace(_like(_PION1X, "pionat", 0.07, 0.1734), max_speed_mm_s=500, radius_mm=330),
    _POWERBOT,
)

ROBOTS: Mapping[str, RobotParameters] = MappingProxyType({row.subclass: row for row in _ROWS})
"""The robots by subclass."""

_OLDER = "allenh1/p2os robot_params.cpp; qemu-gazebo-sim/p2os-arduino"

_OLDER_POSES = (
    (sonar_poses.DX, sonar_poses.DX_OLDER),
    (sonar_poses.AT, sonar_poses.AT_OLDER),
    (sonar_poses.PEOPLEBOT, sonar_poses.PEOPLEBOT_OLDER),
    (sonar_poses.AMIGO, sonar_poses.AMIGO_OLDER),
)

ROBOT_VARIANTS: Mapping[str, RobotParameters] = MappingProxyType(
    {
        **{
            f"{row.subclass}/older": replace(row, sonars=older, source=_OLDER)
            for newer, older in _OLDER_POSES
            for row in _ROWS
            if row.sonars is newer and row.subclass != "amigo-sh"
        },
        "amigo-sh/player": replace(
            ROBOTS["amigo-sh"], sonars=sonar_poses.AMIGO_PLAYER, source="Player robot_params.cc"
        ),
        "amigo-sh/older": replace(
            ROBOTS["amigo-sh"], sonars=sonar_poses.AMIGO_OLDER, speed_unit_mm_s=1.3746, source=_OLDER
        ),
        "p2dx/front-array": replace(
            _P2DX, sonars=sonar_poses.DX[:8], source="AriaCoda params/p2dx.p, front array only, as usually fitted"
        ),
        "p2dx/bumpers": replace(
            _P2DX, front_bumpers=5, rear_bumpers=5, source="AriaCoda params/p2dx.p, with the optional bumper rings"
        ),
    }
)
"""Rows that other sources have for the same robots, and common outfits, as "subclass/variant"."""


def find_robot(name: str) -> RobotParameters | None:
    """The robot of a subclass, in any case as all clients match it, or of a "subclass/variant"; None if unknown."""
    key = name.lower()
    return ROBOTS.get(key) or ROBOT_VARIANTS.get(key)


def robot_parameters(name: str) -> RobotParameters:
    """As `find_robot`, for a name that must be known.

    Raises:
        LocalProtocolError: it is not; the message has the names there are.
    """
    found = find_robot(name)
    if found is None:
        raise LocalProtocolError(f"no robot {name!r}; there are {', '.join((*ROBOTS, *ROBOT_VARIANTS))}")
    return found
