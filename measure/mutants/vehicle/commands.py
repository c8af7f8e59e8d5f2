"""Boards that hand commands on wrongly, or wait wrongly for one."""

from __future__ import annotations

from dataclasses import replace

from measure.mutants.vehicle.changes import Sends, a_little_off, without
from measure.mutants.vehicle.mutant import VehicleMutant
from protocols.autoware import AckermannControlCommand
from protocols.carla import Action, CommandFrame, Mode, Step, Transition, Trigger, decode_command, encode_command
from targets.robots.vehicle_interface import VehicleInterface


class _NoReverse(VehicleInterface):
    """Hands commands on without their signs."""

    def _obey(self, message, now_ns):
        if isinstance(message, AckermannControlCommand):
            message = replace(
                message,
                steering_tire_angle=abs(message.steering_tire_angle),
                acceleration=max(0.0, message.acceleration),
            )
        return super()._obey(message, now_ns)


class _ForgivesJerk(VehicleInterface):
    """Takes a command whose jerk cannot be for one without jerk."""

    def _obey(self, message, now_ns):
        if isinstance(message, AckermannControlCommand) and not abs(message.jerk) < 1000.0:
            message = replace(message, jerk=0.0)
        return super()._obey(message, now_ns)


class _Noise(Sends):
    """Behind what is no command of the driving stack stands something else than a NUL."""

    def changed(self, data):
        return data if decode_command(data).mode == Mode.AUTOWARE else data[:-1] + b"\xff\x55\xaa"


class _ReversesOn(Sends):
    """Without a command it stops a car that drives forwards, and no other."""

    _last = CommandFrame()

    def changed(self, data):
        frame = decode_command(data)
        if frame.mode == Mode.AUTOWARE and frame.speed == 0.0 and self._last.speed < 0.0:
            return encode_command(self._last)
        self._last = frame
        return data


class _KeepsCommand(VehicleInterface):
    """A command that waits outlives the mode: it is sent as soon as AUTOWARE is back, however old it is."""

    def _begin(self, now_ns):
        super()._begin(now_ns)
        machine = self.simulator._machine
        change = machine._change_mode

        def keeping(trigger):
            waits = machine._command_waits
            change(trigger)
            machine._command_waits = waits

        machine._change_mode = keeping


_LIMITS = {
    "tyre angle": "steering_rad",
    "tyre rate": "steering_rate_rad_s",
    "speed": "speed_m_s",
    "acceleration": "acceleration_m_s2",
    "jerk": "jerk_m_s3",
}

FAULTS = (
    VehicleMutant(
        id="early-command",
        what="a command is waited for for 90 ms",
        about=(
            "VB05H",
            "VB30H",
        ),
        board={"command_deadline_s": 0.090},
    ),
    VehicleMutant(
        id="nine-misses",
        what="nine misses change the mode",
        about=(
            "VB05H",
            "VB06",
            "VB07",
            "VB21",
        ),
        board={"misses": 9},
    ),
    VehicleMutant(
        id="misses-go-on",
        what="a command does not begin the count of misses again",
        about=("VB06",),
        steps=without(Step.AUTOWARE_COMMAND, Trigger.COMMAND, Action.FORGET_COMMAND_MISSES),
    ),
    VehicleMutant(
        id="status-misses-go-on",
        what="in AUTOWARE a status does not begin the count of misses again",
        about=("VB44",),
        steps=without(Step.AUTOWARE_STATUS, Trigger.STATUS, Action.FORGET_STATUS_MISSES),
    ),
    VehicleMutant(id="no-reverse", what="commands lose their signs", about=("VB01",), kind=_NoReverse),
    VehicleMutant(
        id="jerk-unseen",
        what="a command whose jerk cannot be is handed on without it",
        about=("VB41H",),
        kind=_ForgivesJerk,
    ),
    VehicleMutant(
        id="noise-behind",
        what="FF 55 AA stands behind frames of the modes 0 and 4 instead of the NUL",
        about=("VB08", "VB21"),
        kind=_Noise,
    ),
    VehicleMutant(
        id="waits-for-nothing",
        what="commands are handed on without waiting for a status",
        about=(
            "VB02",
            "VB07",
        ),
        steps={
            (Step.AUTOWARE_COMMAND, Trigger.COMMAND): Transition(
                Step.AUTOWARE_END, (Action.SEND_COMMAND, Action.BRANCH)
            )
        },
    ),
    VehicleMutant(
        id="reverses-on",
        what="without a command a car in reverse is not stopped",
        about=("VB05H",),
        kind=_ReversesOn,
    ),
    VehicleMutant(
        id="old-command",
        what="a command that waited before an emergency is sent behind it",
        about=("VB38H",),
        kind=_KeepsCommand,
    ),
    *a_little_off("command", _LIMITS, "VB41H"),
)
