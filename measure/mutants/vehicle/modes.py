"""Boards that are wrong in MANUAL and EMERGENCY, and on the way there and back."""

from __future__ import annotations

from dataclasses import replace

from measure.mutants.vehicle.changes import Sends, modes_with, modes_without, without
from measure.mutants.vehicle.mutant import VehicleMutant
from protocols.carla import (
    VECTORS,
    Action,
    CommandFrame,
    Mode,
    ModeChanged,
    ModeTrigger,
    Step,
    Trigger,
    decode_command,
    encode_command,
)
from targets.robots.vehicle_interface import VehicleInterface


class _KeepsThrottle(Sends):
    """In EMERGENCY the mode alone changes: what it had last said in MANUAL goes on."""

    _last = CommandFrame()

    def changed(self, data):
        frame = decode_command(data)
        if frame.mode == Mode.EMERGENCY:
            return encode_command(replace(self._last, mode=Mode.EMERGENCY))
        if frame.mode == Mode.MANUAL:
            self._last = frame
        return data


class _OneMoreStop(Sends):
    """Sends F3 once more, before the first frame of MANUAL."""

    _before = Mode.AUTOWARE

    def changed(self, data):
        before, self._before = self._before, decode_command(data).mode
        stopped = before == Mode.EMERGENCY and self._before == Mode.MANUAL
        return VECTORS["F3"].data + data if stopped else data


class _ImpatientBehindEmergency(VehicleInterface):
    """Behind an emergency goes on with a count of eight missed statuses."""

    def _from_simulator(self, events, now_ns):
        events = list(events)
        if any(isinstance(event, ModeChanged) and event.old is Mode.EMERGENCY for event in events):
            self.simulator._machine._status_misses = 8
        return super()._from_simulator(events, now_ns)


class _StopsOnce(Sends):
    """Says F3 once, and nothing more until the emergency is over."""

    _stopped = False

    def changed(self, data):
        before, self._stopped = self._stopped, decode_command(data).mode == Mode.EMERGENCY
        return b"" if before and self._stopped else data


class _StartsOff(Sends):
    """The first frame of MANUAL behind an emergency has full throttle."""

    _before = Mode.AUTOWARE

    def changed(self, data):
        before, self._before = self._before, decode_command(data).mode
        begins = before == Mode.EMERGENCY and self._before == Mode.MANUAL
        return encode_command(replace(decode_command(data), speed=1.0)) if begins else data


FAULTS = (
    VehicleMutant(
        id="long-pause",
        what="MANUAL rests for 120 ms",
        about=(
            "VB19",
            "VB20",
            "VB21",
        ),
        board={"manual_pause_s": 0.120},
    ),
    VehicleMutant(
        id="late-status",
        what="a status is waited for for 120 ms",
        about=(
            "VB07",
            "VB21",
        ),
        board={"status_deadline_s": 0.120},
    ),
    VehicleMutant(
        id="manual-misses-go-on",
        what="in MANUAL a status does not begin the count of misses again",
        about=("VB45",),
        steps=without(Step.MANUAL_STATUS, Trigger.STATUS, Action.FORGET_STATUS_MISSES),
    ),
    VehicleMutant(
        id="throttle-in-emergency",
        what="EMERGENCY has the values of the joystick",
        about=("VB21",),
        kind=_KeepsThrottle,
    ),
    VehicleMutant(
        id="stops-once",
        what="F3 comes once in an emergency",
        about=(
            "VB07",
            "VB21",
        ),
        kind=_StopsOnce,
    ),
    VehicleMutant(
        id="no-emergency-in-manual",
        what="MANUAL never becomes EMERGENCY",
        about=("VB21",),
        modes=modes_without(Mode.MANUAL, ModeTrigger.STATUS_LOST),
    ),
    VehicleMutant(
        id="starts-off",
        what="the first frame of MANUAL behind an emergency has full throttle",
        about=("VB08",),
        kind=_StartsOff,
    ),
    VehicleMutant(
        id="one-more-stop",
        what="a status in EMERGENCY is followed by F3 once more",
        about=("VB08",),
        kind=_OneMoreStop,
    ),
    VehicleMutant(
        id="quiet-manual",
        what="in MANUAL no status is reported",
        about=("VB19",),
        steps=without(Step.MANUAL_STATUS, Trigger.STATUS, Action.REPORT_STATUS),
    ),
    VehicleMutant(
        id="straight-to-autoware",
        what="EMERGENCY ends in AUTOWARE",
        about=(
            "VB08",
            "VB09",
            "VB10",
        ),
        modes=modes_with(Mode.EMERGENCY, ModeTrigger.STATUS_RETURNS, Mode.AUTOWARE),
    ),
    VehicleMutant(
        id="impatient-behind-emergency",
        what="behind an emergency two missed statuses are another",
        about=("VB45",),
        kind=_ImpatientBehindEmergency,
    ),
)
