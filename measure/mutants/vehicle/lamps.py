"""Boards whose lamps are wrong."""

from __future__ import annotations

from dataclasses import replace

from measure.mutants.vehicle.changes import without
from measure.mutants.vehicle.mutant import VehicleMutant
from protocols.autoware import HazardLights, HazardLightsCommand
from protocols.carla import Action, Step, Trigger
from targets.robots.vehicle_interface import VehicleInterface


class _NoRed(VehicleInterface):
    """Shows EMERGENCY by the green light."""

    def _from_simulator(self, events, now_ns):
        sent = super()._from_simulator(events, now_ns)
        self.light = "green" if self.light == "red" else self.light
        return sent


class _HazardForEver(VehicleInterface):
    def _obey(self, message, now_ns):
        ends = isinstance(message, HazardLightsCommand) and message.command == HazardLights.DISABLE
        return [] if ends else super()._obey(message, now_ns)


class _HazardEndsByNothing(VehicleInterface):
    def _obey(self, message, now_ns):
        if isinstance(message, HazardLightsCommand) and message.command == HazardLights.NO_COMMAND:
            message = replace(message, command=HazardLights.DISABLE)
        return super()._obey(message, now_ns)


FAULTS = (
    VehicleMutant(id="no-red", what="EMERGENCY lights the green lamp", about=("VB54",), kind=_NoRed),
    VehicleMutant(id="hasty-lamps", what="lamps blink at 8 Hz", about=("VB43",), body={"blink_hz": 8.0}),
    VehicleMutant(id="slow-lamps", what="lamps blink at 0.7 Hz", about=("VB43",), body={"blink_hz": 0.7}),
    VehicleMutant(
        id="dark-manual",
        what="MANUAL lights no lamp",
        about=("VB08",),
        steps=without(Step.LOOP_TOP, Trigger.MANUAL, Action.SHOW_MODE)
        | without(Step.AUTOWARE_END, Trigger.MANUAL, Action.SHOW_MODE),
    ),
    VehicleMutant(id="hazard-for-ever", what="hazard lights cannot be put out", about=("VB43",), kind=_HazardForEver),
    VehicleMutant(
        id="hazard-ends-by-nothing",
        what="NO_COMMAND puts hazard lights out",
        about=("VB43",),
        kind=_HazardEndsByNothing,
    ),
)
