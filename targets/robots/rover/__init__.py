"""A behavioural model of the CEAI rover: its control board as the host sees it, and a plain plant behind it.

Bytes and bench time in, bytes out. What the board promises or gets wrong is data: a profile, and defects put into it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from targets.robots.rover.behaviour import BEHAVIOURS, Behaviour, BodyQuirks
    from targets.robots.rover.defects import DEFECTS, Defect
    from targets.robots.rover.events import LedSwitched, MotorsCommanded, RoverEvent
    from targets.robots.rover.plant import STEADY_RPM, Plant, steady_rpm
    from targets.robots.rover.robot import RoverRobot, behaviour_of
    from targets.robots.rover.sensed import Rocking, Sensed
    from targets.robots.rover.settings import PROFILE_NAMES, RoverSettings
else:
    from targets.robots.deferred import deferred

    __getattr__ = deferred(
        __name__,
        {
            "BEHAVIOURS": "behaviour",
            "Behaviour": "behaviour",
            "BodyQuirks": "behaviour",
            "DEFECTS": "defects",
            "Defect": "defects",
            "LedSwitched": "events",
            "MotorsCommanded": "events",
            "PROFILE_NAMES": "settings",
            "Plant": "plant",
            "Rocking": "sensed",
            "RoverEvent": "events",
            "RoverRobot": "robot",
            "RoverSettings": "settings",
            "STEADY_RPM": "plant",
            "Sensed": "sensed",
            "behaviour_of": "robot",
            "steady_rpm": "plant",
        },
    )

__all__ = [
    "BEHAVIOURS",
    "DEFECTS",
    "PROFILE_NAMES",
    "STEADY_RPM",
    "Behaviour",
    "BodyQuirks",
    "Defect",
    "LedSwitched",
    "MotorsCommanded",
    "Plant",
    "Rocking",
    "RoverEvent",
    "RoverRobot",
    "RoverSettings",
    "Sensed",
    "behaviour_of",
    "steady_rpm",
]
