"""The signals of every vehicle, and who reads and drives them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from hilbench.wiring.car_signals import CAR_SIGNALS, CarSignals
from hilbench.wiring.pioneer_signals import PIONEER_SIGNALS, PioneerSignals
from hilbench.wiring.rover_signals import ROVER_SIGNALS, RoverSignals
from hilbench.wiring.world_signals import WorldSignal, WorldSignals
from worlds.vehicles.car import CarBody
from worlds.vehicles.pioneer_2dx import Pioneer2dxBody
from worlds.vehicles.rover_4wd import Rover4wdBody

__all__ = ["SIGNALS", "VehicleBody", "open_signals"]

VehicleBody = Pioneer2dxBody | Rover4wdBody | CarBody

SIGNALS: Mapping[str, Mapping[str, WorldSignal]] = {
    "pioneer-2dx": PIONEER_SIGNALS,
    "rover-4wd": ROVER_SIGNALS,
    "car": CAR_SIGNALS,
}
"""Signals by name, by vehicle."""


def open_signals(body: VehicleBody, wanted: Sequence[str]) -> WorldSignals:
    """Return who reads these signals of a vehicle at each step, and drives the others."""
    if isinstance(body, CarBody):
        return CarSignals(body, wanted)
    return RoverSignals(body, wanted) if isinstance(body, Rover4wdBody) else PioneerSignals(body, wanted)
