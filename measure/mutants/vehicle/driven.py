"""Faulty boards that only a drive shows."""

from __future__ import annotations

from dataclasses import replace

from measure.mutants.vehicle.changes import Sends, modes_with
from measure.mutants.vehicle.mutant import VehicleMutant
from measure.mutants.vehicle.reports import ExchangesFields
from protocols.autoware import AckermannControlCommand, ControlModeRequest
from protocols.carla import Mode, ModeTrigger, decode_command, encode_command
from targets.robots.vehicle_interface import VehicleInterface


class _BrakesFirst(Sends):
    """AUTOWARE begins with a stop."""

    _before = Mode.AUTOWARE

    def changed(self, data):
        frame, before = decode_command(data), self._before
        self._before = frame.mode
        begins = frame.mode == Mode.AUTOWARE != before
        return encode_command(replace(frame, speed=0.0, acceleration=0.0, jerk=0.0)) if begins else data


class _ReturnsByItself(VehicleInterface):
    """Takes a command after a second without any for a request for AUTOWARE."""

    _command_ns = None

    def _obey(self, message, now_ns):
        sent = super()._obey(message, now_ns)
        if isinstance(message, AckermannControlCommand):
            before_ns, self._command_ns = self._command_ns, now_ns
            if before_ns is not None and now_ns - before_ns > 1_000_000_000:
                sent += super()._obey(ControlModeRequest(sequence=255, mode=Mode.AUTOWARE), now_ns)
        return sent


DRIVEN = (
    VehicleMutant(
        id="fields-exchanged",
        what="lateral speed and heading rate are exchanged",
        about=("VD02",),
        kind=ExchangesFields,
    ),
    VehicleMutant(id="brakes-first", what="AUTOWARE begins with a stop", about=("VD05",), kind=_BrakesFirst),
    VehicleMutant(
        id="returns-by-itself",
        what="the first command after a second without any leads to AUTOWARE",
        about=("VD07",),
        kind=_ReturnsByItself,
    ),
    VehicleMutant(
        id="straight-to-autoware",
        what="EMERGENCY ends in AUTOWARE",
        about=("VD09",),
        modes=modes_with(Mode.EMERGENCY, ModeTrigger.STATUS_RETURNS, Mode.AUTOWARE),
    ),
)
"""Boards that drives have to find, each by the clause that it is about; `vehicle-drive` runs on these alone."""
