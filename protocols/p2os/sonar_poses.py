"""Where the sonar discs sit: x forward and y left of the centre of rotation in mm, heading in degrees."""

from __future__ import annotations

import math
from dataclasses import dataclass

__all__ = [
    "AMIGO",
    "AMIGO_OLDER",
    "AMIGO_PLAYER",
    "AT",
    "AT_OLDER",
    "DX",
    "DX_OLDER",
    "PEOPLEBOT",
    "PEOPLEBOT_OLDER",
    "PIONEER_1",
    "POWERBOT",
    "SonarPose",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class SonarPose:
    """One disc: where it sits and where it looks, + counter-clockwise."""

    x_mm: float
    y_mm: float
    th_deg: float

    @property
    def th_rad(self) -> float:
        """The direction it looks in, in radians."""
        return math.radians(self.th_deg)


_Row = tuple[int, int, int]


def _poses(*rows: _Row) -> tuple[SonarPose, ...]:
    return tuple(SonarPose(x_mm=x, y_mm=y, th_deg=th) for x, y, th in rows)


def _mirrored(*half: _Row) -> tuple[_Row, ...]:
    """One side of an array, and the other side in reverse order; a disc on the axis stands once."""
    return half + tuple((x, -y, -th) for x, y, th in reversed(half) if y)


_DX_FRONT = _mirrored((69, 136, 90), (114, 119, 50), (148, 78, 30), (166, 27, 10))
_DX_REAR = _mirrored((-157, -136, -90), (-203, -119, -130), (-237, -78, -150), (-255, -27, -170))
_UPPER = _mirrored((-20, 136, 90), (24, 119, 50), (58, 78, 30), (77, 27, 10))

DX = _poses(*_DX_FRONT, *_DX_REAR)
"""Pioneer 2 and 3 with two wheels (AriaCoda params/p2dx.p; Player robot_params.cc). A 2-DX mostly has 0-7 only."""

DX_OLDER = _poses(
    *_mirrored((115, 130, 90), (155, 115, 50), (190, 80, 30), (210, 25, 10)),
    *_mirrored((-115, -130, -90), (-155, -115, -130), (-190, -80, -150), (-210, -25, -170)),
)
"""The same robots by the older table (allenh1/p2os robot_params.cpp; p2os-arduino)."""

AT = _poses(
    *_mirrored((147, 136, 90), (193, 119, 50), (227, 79, 30), (245, 27, 10)),
    *_mirrored((-144, -136, -90), (-189, -119, -130), (-223, -79, -150), (-241, -27, -170)),
)
"""Pioneer 2 and 3 with four wheels (AriaCoda params/p2at.p; Player robot_params.cc)."""

AT_OLDER = _poses(
    *_mirrored((145, 130, 90), (185, 115, 50), (220, 80, 30), (240, 25, 10)),
    *_mirrored((-145, -130, -90), (-185, -115, -130), (-220, -80, -150), (-240, -25, -170)),
)
"""The same by allenh1/p2os robot_params.cpp."""

PEOPLEBOT = _poses(*_DX_FRONT, *_UPPER, *_DX_REAR)
"""PeopleBot and Performance PeopleBot: a second front array above the first (AriaCoda params/p2pb.p)."""

PEOPLEBOT_OLDER = (
    DX_OLDER[:8] + _poses(*_mirrored((50, 130, 90), (90, 115, 50), (125, 80, 30), (145, 25, 10))) + DX_OLDER[8:]
)
"""The same by allenh1/p2os robot_params.cpp."""

AMIGO = _poses(*_mirrored((76, 100, 90), (125, 75, 41), (150, 30, 15)), *_mirrored((-140, -58, -145)))
"""AmigoBot (AriaCoda params/amigo.p)."""

AMIGO_OLDER = _poses(*_mirrored((73, 105, 90), (130, 78, 41), (154, 30, 15)), *_mirrored((-146, -60, -145)))
"""AmigoBot by allenh1/p2os robot_params.cpp."""

AMIGO_PLAYER = _poses(
    *((70, 100, 90), (125, 75, 41), (144, 30, 15), (144, -30, -15), (120, -75, -41), (70, -100, -90)),
    *_mirrored((-146, -58, -145)),
)
"""AmigoBot-sh by Player robot_params.cc, uneven as it stands there."""

PIONEER_1 = _poses(*_mirrored((100, 100, 90), (120, 80, 30), (130, 40, 15), (130, 0, 0)))
"""Pioneer 1 family (AriaCoda params/pion1x.p)."""

_POWERBOT_FRONT = _mirrored(
    *((152, 278, 90), (200, 267, 65), (241, 238, 45), (274, 200, 35)), *((300, 153, 25), (320, 96, 15), (332, 33, 5))
)
_POWERBOT_REAR = _mirrored(
    *((-298, -278, -90), (-347, -267, -115), (-388, -238, -135), (-420, -200, -145)),
    *((-447, -153, -155), (-467, -96, -165), (-478, -33, -175)),
)


def _powerbot_array(rows: tuple[_Row, ...]) -> tuple[SonarPose | None, ...]:
    """Fourteen discs on sixteen numbers: the eighth and the last have none."""
    poses = _poses(*rows)
    return (*poses[:7], None, *poses[7:], None)


POWERBOT = _powerbot_array(_POWERBOT_FRONT) + _powerbot_array(_POWERBOT_REAR)
"""PowerBot (AriaCoda params/powerbot.p): 28 discs on the numbers 0-30; 7, 15, 23 and 31 have none."""
