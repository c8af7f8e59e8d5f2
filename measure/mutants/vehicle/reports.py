"""Boards that tell the driving stack something wrong."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

from measure.mutants.vehicle.changes import Tells
from measure.mutants.vehicle.mutant import VehicleMutant
from protocols.autoware import ControlModeReport, SteeringReport, Time, VelocityReport
from protocols.carla import DeadlineMissed, Mode, StatusReported, Waited
from targets.robots.vehicle_interface import VehicleInterface


class ExchangesFields(Tells):
    def instead(self, message):
        if isinstance(message, VelocityReport):
            message = replace(message, lateral_velocity=message.heading_rate, heading_rate=message.lateral_velocity)
        return [message]


class _HidesSteering(Tells):
    def instead(self, message):
        return [] if isinstance(message, SteeringReport) else [message]


class _TellsTheOneBefore(Tells):
    _before = None

    def instead(self, message):
        if not isinstance(message, VelocityReport):
            return [message]
        before, self._before = self._before, message
        return [before or message]


class _TellsStatusesTwice(Tells):
    def instead(self, message):
        return [message] * (2 if isinstance(message, VelocityReport | SteeringReport) else 1)


class _TellsManual(Tells):
    def instead(self, message):
        return [replace(message, mode=4) if isinstance(message, ControlModeReport) else message]


class _StampsNothing(Tells):
    def instead(self, message):
        return [replace(message, stamp=Time()) if hasattr(message, "stamp") else message]


class _TellsModesLate(Tells):
    """Reports the mode of three reports before."""

    def __init__(self, *arguments, **options):
        self._modes = deque([Mode.AUTOWARE] * 3, maxlen=3)
        super().__init__(*arguments, **options)

    def instead(self, message):
        if not isinstance(message, ControlModeReport):
            return [message]
        late = self._modes[0]
        self._modes.append(message.mode)
        return [replace(message, mode=late)]


class _StampsTooSoon(Tells):
    """Has a time of its own before it is told one."""

    def instead(self, message):
        early = hasattr(message, "stamp") and message.stamp == Time()
        return [replace(message, stamp=Time(1, 0)) if early else message]


class _TellsTheOneBeforeInAutoware(_TellsTheOneBefore):
    def instead(self, message):
        late = super().instead(message)
        return late if self.simulator.mode is Mode.AUTOWARE else [message]


class _StaleInManual(VehicleInterface):
    """In MANUAL reports the old status at a missed one."""

    _last = None

    def _reports(self, event):
        if isinstance(event, StatusReported):
            self._last = event
        missed = isinstance(event, DeadlineMissed) and event.what is Waited.STATUS
        if missed and self.simulator.mode is Mode.MANUAL and self._last is not None:
            event = self._last
        return super()._reports(event)


FAULTS = (
    VehicleMutant(
        id="fields-exchanged",
        what="lateral speed and heading rate are exchanged",
        about=("VB24", "VB26"),
        kind=ExchangesFields,
    ),
    VehicleMutant(
        id="no-steering-report", what="the steering is not reported", about=("VB24", "VB26"), kind=_HidesSteering
    ),
    VehicleMutant(
        id="one-status-behind",
        what="the status before is reported",
        about=("VB19",),
        kind=_TellsTheOneBefore,
    ),
    VehicleMutant(id="statuses-twice", what="each status is reported twice", about=("VB53",), kind=_TellsStatusesTwice),
    VehicleMutant(id="tells-manual", what="the mode reported is always 4", about=("VB48",), kind=_TellsManual),
    VehicleMutant(
        id="seldom-told", what="the mode is reported every 0.45 s", about=("VB48",), board={"mode_report_s": 0.45}
    ),
    VehicleMutant(id="no-stamps", what="each stamp is 0", about=("VB49",), kind=_StampsNothing),
    VehicleMutant(id="mode-told-late", what="the mode is reported 0.2 s late", about=("VB48",), kind=_TellsModesLate),
    VehicleMutant(
        id="own-clock", what="stamps begin at 1 s, before a clock is told", about=("VB52",), kind=_StampsTooSoon
    ),
    VehicleMutant(
        id="one-behind-in-autoware",
        what="in AUTOWARE the status before is reported",
        about=("VB53",),
        kind=_TellsTheOneBeforeInAutoware,
    ),
    VehicleMutant(
        id="stale-in-manual", what="in MANUAL an old status is reported", about=("VB32H",), kind=_StaleInManual
    ),
)
