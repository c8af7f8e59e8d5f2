"""Vehicles as data, by name."""

from __future__ import annotations

import importlib
from types import MappingProxyType

from worlds.errors import UnknownNameError
from worlds.vehicles.model import Parameter, Vehicle

__all__ = ["Parameter", "Vehicle", "find_vehicle", "vehicle_names"]

_MODULES = MappingProxyType(
    {
        "pioneer-2dx": "worlds.vehicles.pioneer_2dx",
        "rover-4wd": "worlds.vehicles.rover_4wd",
        "car": "worlds.vehicles.car",
    }
)


def vehicle_names() -> tuple[str, ...]:
    """Return the names of the built-in vehicles."""
    return tuple(_MODULES)


def find_vehicle(name: str) -> Vehicle:
    """Return a built-in vehicle with its standard parameters.

    Raises:
        UnknownNameError: no such vehicle.
    """
    if name not in _MODULES:
        raise UnknownNameError("vehicle", name, _MODULES)
    vehicle: Vehicle = importlib.import_module(_MODULES[name]).vehicle()
    return vehicle
