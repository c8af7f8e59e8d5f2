"""Frames worked out by hand: what must stand on the line for what is said."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from protocols.carla.frames import CommandFrame, Mode, StatusFrame

__all__ = ["VECTORS", "Vector"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Vector:
    """A frame and its bytes.

    Attributes:
        text: what it is.
        frame: what it says; its floats may differ from those in the bytes by what 32 bits cannot hold.
        data: as on the line.
    """

    text: str
    frame: StatusFrame | CommandFrame
    data: bytes


_HELD_DELIMITERS = 0.6416646838188171
_HELD_CR = 0.5509803891181946

VECTORS: Mapping[str, Vector] = MappingProxyType(
    {
        "F1": Vector(
            text="a command of the driving stack, 0.5 rad and 0.1 rad/s times 1.2",
            frame=CommandFrame(
                steering=0.6, steering_rate=0.12, speed=5.0, acceleration=1.0, jerk=0.2, mode=Mode.AUTOWARE
            ),
            data=bytes.fromhex("23539A99193F578FC2F53D560000A040410000803F4ACDCC4C3E4D012400"),
        ),
        "F2": Vector(
            text="the joystick: steer half to the left, three quarters throttle",
            frame=CommandFrame(steering=-0.5, speed=0.75, mode=Mode.MANUAL),
            data=bytes.fromhex("2353000000BF5700000000560000403F41000000004A000000004D042400"),
        ),
        "F3": Vector(
            text="emergency",
            frame=CommandFrame(mode=Mode.EMERGENCY),
            data=bytes.fromhex("23530000000057000000005600000000410000" + "00004A000000004D002400"),
        ),
        "F4": Vector(
            text="a car that stands",
            frame=StatusFrame(),
            data=bytes.fromhex("23410000000042000000004300000000440000000024"),
        ),
        "F5": Vector(
            text="a car in a curve",
            frame=StatusFrame(lon_speed_m_s=8.3333, lat_speed_m_s=-0.05, heading_rate_rad_s=0.1, steering_rad=-0.2),
            data=bytes.fromhex("2341325505" + "4142CDCC4CBD43CDCCCC3D44CDCC4CBE24"),
        ),
        "F6": Vector(
            text="#, D and $ within a float",
            frame=StatusFrame(lon_speed_m_s=_HELD_DELIMITERS),
            data=bytes.fromhex("23412344243F42000000004300000000440000000024"),
        ),
        "F7": Vector(
            text="carriage returns within a float",
            frame=StatusFrame(lon_speed_m_s=_HELD_CR),
            data=bytes.fromhex("23410D0D0D3F42000000004300000000440000000024"),
        ),
    }
)
"""By name."""
