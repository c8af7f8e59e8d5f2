"""All faulty boards."""

from __future__ import annotations

from measure.mutants.vehicle import commands, joystick, lamps, modes, reports, requests, stand_in, start, statuses
from measure.mutants.vehicle.mutant import VehicleMutant
from measure.mutants.vehicle.published import CURES, PUBLISHED

_FILES = (start, requests, joystick, commands, modes, statuses, reports, lamps, stand_in)

BY_HAND: tuple[VehicleMutant, ...] = tuple(mutant for file in _FILES for mutant in file.FAULTS)
"""What no published firmware gets wrong, thing by thing."""


def all_mutants() -> tuple[VehicleMutant, ...]:
    """Every faulty board."""
    return (*PUBLISHED, *CURES, *BY_HAND)
