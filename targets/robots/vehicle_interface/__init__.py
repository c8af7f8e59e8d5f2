"""A behavioural model of the vehicle-interface board: simulator on one line, driving stack on the other, a joystick.

Bytes and bench time in, bytes out. What the board promises or gets wrong is data: a profile, and defects put into it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from targets.robots.vehicle_interface.behaviour import BEHAVIOURS, Behaviour, BodyQuirks
    from targets.robots.vehicle_interface.board import VehicleInterface, behaviour_of
    from targets.robots.vehicle_interface.defects import DEFECTS, Defect
    from targets.robots.vehicle_interface.events import LightsSwitched
    from targets.robots.vehicle_interface.settings import (
        LINE_BAUD,
        PROFILE_NAMES,
        SIMULATOR_LINE,
        STACK_LINE,
        VehicleSettings,
    )
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
            "LINE_BAUD": "settings",
            "LightsSwitched": "events",
            "PROFILE_NAMES": "settings",
            "SIMULATOR_LINE": "settings",
            "STACK_LINE": "settings",
            "VehicleInterface": "board",
            "VehicleSettings": "settings",
            "behaviour_of": "board",
        },
    )

__all__ = [
    "BEHAVIOURS",
    "DEFECTS",
    "LINE_BAUD",
    "PROFILE_NAMES",
    "SIMULATOR_LINE",
    "STACK_LINE",
    "Behaviour",
    "BodyQuirks",
    "Defect",
    "LightsSwitched",
    "VehicleInterface",
    "VehicleSettings",
    "behaviour_of",
]
