"""Boards that wait wrongly for the driving stack, or for the watchdog."""

from __future__ import annotations

from dataclasses import replace

from protocols.carla import Mode
from targets.robots.vehicle_interface import VehicleInterface
from tests.mutants.vehicle.mutant import VehicleMutant


class _WatchedInAutoware(VehicleInterface):
    """Has a watchdog that sleeps in MANUAL."""

    def hang(self, now_ns):
        if self.simulator.mode is Mode.MANUAL:
            self.behaviour = replace(self.behaviour, body=replace(self.behaviour.body, watchdog_s=None))
        return super().hang(now_ns)


FAULTS = (
    VehicleMutant(
        id="agent-10s", what="an agent is waited for for 10 s", about=("VB03",), board={"agent_wait_s": 10.0}
    ),
    VehicleMutant(id="lazy-watchdog", what="the watchdog waits for 5 s", about=("VB56H",), body={"watchdog_s": 5.0}),
    VehicleMutant(
        id="watched-in-autoware",
        what="the watchdog sleeps in MANUAL",
        about=("VB56H",),
        kind=_WatchedInAutoware,
    ),
)
