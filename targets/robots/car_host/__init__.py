"""The simulator's side of the vehicle-interface board's line: the original's bridge and what stands behind it.

Bytes, bench time and the car's state in; bytes and what the car is commanded out. What it promises or gets wrong is
data: a profile, and defects put into it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from targets.robots.car_host.behaviour import BEHAVIOURS, DEFECTS, Behaviour, Defect, behaviour_of
    from targets.robots.car_host.events import CarCommanded
    from targets.robots.car_host.host import CarHost, CarState, CarWish
    from targets.robots.car_host.settings import PROFILE_NAMES, CarHostSettings
else:
    from targets.robots.deferred import deferred

    __getattr__ = deferred(
        __name__,
        {
            "BEHAVIOURS": "behaviour",
            "Behaviour": "behaviour",
            "CarCommanded": "events",
            "CarHost": "host",
            "CarHostSettings": "settings",
            "CarState": "host",
            "CarWish": "host",
            "DEFECTS": "behaviour",
            "Defect": "behaviour",
            "PROFILE_NAMES": "settings",
            "behaviour_of": "behaviour",
        },
    )

__all__ = [
    "BEHAVIOURS",
    "DEFECTS",
    "PROFILE_NAMES",
    "Behaviour",
    "CarCommanded",
    "CarHost",
    "CarHostSettings",
    "CarState",
    "CarWish",
    "Defect",
    "behaviour_of",
]
