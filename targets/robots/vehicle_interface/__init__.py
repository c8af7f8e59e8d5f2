"""A behavioural model of the vehicle-interface board: simulator on one line, driving stack on the other, a joystick.

Bytes and bench time in, bytes out. What the board promises or gets wrong is data: a profile, and defects put into it.
"""

from __future__ import annotations

from targets.robots.vehicle_interface.behaviour import BEHAVIOURS, Behaviour, BodyQuirks
from targets.robots.vehicle_interface.board import SIMULATOR_LINE, STACK_LINE, VehicleInterface, behaviour_of
from targets.robots.vehicle_interface.defects import DEFECTS, Defect
from targets.robots.vehicle_interface.events import LightsSwitched
from targets.robots.vehicle_interface.settings import PROFILE_NAMES, VehicleSettings

__all__ = [
    "BEHAVIOURS",
    "DEFECTS",
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
