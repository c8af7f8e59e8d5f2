"""Faulty simulator's sides, each with one fault that a bridge could have, and the clauses that have to find it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import ClassVar

from protocols.carla import (
    COMMAND_LAYOUT,
    AckermannCommand,
    CommandLimits,
    Dropped,
    ManualCommand,
    Mode,
    StreamReader,
)
from protocols.carla.checking import simulator_fault
from targets.robots.car_host import BEHAVIOURS, CarHost, CarHostSettings


class _KeepsSteering(CarHost):
    """Says a status for each velocity report, with whatever steering came last."""

    _said = False

    def report(self, *what, now_ns):
        sent = b""
        for one in what:
            sent += super().report(one, now_ns=now_ns)
            if one == "velocity" and self._said:
                sent += super().report("steering", now_ns=now_ns)
            self._said = self._said or one == "steering"
        return sent


class _VelocityFirst(CarHost):
    """Forgets a steering report that comes before the velocity."""

    _velocity = False

    def report(self, *what, now_ns):
        sent = b""
        for one in what:
            sent += super().report(one, now_ns=now_ns) if one == "velocity" or self._velocity else b""
            self._velocity = one == "velocity"
        return sent


class _KeepsSliding(CarHost):
    """Takes the newer speed, and the first of lateral speed and yaw rate."""

    _first = None

    def sense(self, state):
        first = self._first = self._first or state
        super().sense(replace(state, lat_speed_m_s=first.lat_speed_m_s, yaw_rate_rad_s=first.yaw_rate_rad_s))


class _NeverBack(CarHost):
    """A car that rolls back is said to stand."""

    def sense(self, state):
        super().sense(replace(state, lon_speed_m_s=max(0.0, state.lon_speed_m_s)))


class _AlwaysRight(CarHost):
    """Takes CARLA's steer for an angle to the right, whatever its sign."""

    def sense(self, state):
        super().sense(state if state.steer is None else replace(state, steer=abs(state.steer)))


class _Signless(CarHost):
    """Hands acceleration and jerk on as magnitudes."""

    def _tell(self, command, **about):
        if isinstance(command, AckermannCommand):
            acceleration_m_s2, jerk_m_s3 = abs(command.acceleration_m_s2), abs(command.jerk_m_s3)
            command = replace(command, acceleration_m_s2=acceleration_m_s2, jerk_m_s3=jerk_m_s3)
        super()._tell(command, **about)


class _BrakeSwitch(CarHost):
    """Takes the brake for a switch."""

    def _tell(self, command, **about):
        if isinstance(command, ManualCommand):
            command = replace(command, brake=float(command.brake == 1.0))
        super()._tell(command, **about)


class _StopsOnce(CarHost):
    """Stops the car at the first silence alone."""

    _silences = 0

    def _command(self, command, mode, now_ns):
        self._silences += mode is None
        if mode is not None or self._silences < 2:
            super()._command(command, mode, now_ns)


class _LeavesTheJoystickAlone(CarHost):
    """Stops no car that a human drives."""

    def _command(self, command, mode, now_ns):
        if mode is not None or not isinstance(self.wish, ManualCommand):
            super()._command(command, mode, now_ns)


class _EmergencyIsRest(CarHost):
    """Takes a frame of mode 0 for a stop, whatever it says."""

    def _command(self, command, mode, now_ns):
        super()._command(AckermannCommand() if mode == Mode.EMERGENCY else command, mode, now_ns)


class _TakesMode2(CarHost):
    """Takes mode 2 for 4."""

    _before = b""

    def receive(self, data, now_ns):
        before, self._before = self._before, data
        return super().receive(b"\x04" if (before, data) == (b"M", b"\x02") else data, now_ns)


class _Reads(CarHost):
    """Reads frames otherwise than it should."""

    kind: type[StreamReader] = StreamReader

    def __init__(self, settings: CarHostSettings, *, power_on_ns: int) -> None:
        super().__init__(settings, power_on_ns=power_on_ns)
        self.connection._machine.reader = self.kind(COMMAND_LAYOUT, self.fault, timeout_ns=100_000_000)

    def fault(self, frame):
        return simulator_fault(self.behaviour.line, frame)


class _TrustsTheJoystick(_Reads):
    """Does not look at what the joystick says."""

    def fault(self, frame):
        return None if frame.mode == Mode.MANUAL else super().fault(frame)


class _LooksAtWhatItUses(_Reads):
    """Does not look at what a frame of the joystick says where nothing is said."""

    def fault(self, frame):
        used = replace(frame, steering_rate=0.0, jerk=0.0) if frame.mode == Mode.MANUAL else frame
        return super().fault(used)


class _OneByteReader(StreamReader):
    def _give_up(self, reason):
        last, time_ns = bytes(self._held[-1:]), self._times[-1]
        self._found.append(Dropped(reason=reason, data=bytes(self._held)))
        self._held.clear()
        self._times = []
        if last == b"#":
            self._take(last[0], time_ns)


class _LooksAtOneByte(_Reads):
    """Of what fails it looks at the last byte alone for another beginning."""

    kind = _OneByteReader


class _Optional(CarHost):
    """Has other options than it should."""

    line: ClassVar[Mapping[str, object]]

    def __init__(self, settings: CarHostSettings, *, power_on_ns: int) -> None:
        right = BEHAVIOURS["hardened"]
        wrong = replace(right, line=replace(right.line, **self.line))
        super().__init__(settings, power_on_ns=power_on_ns, behaviour=wrong)


class _Patient(_Optional):
    """Never gives up half a frame."""

    line: ClassVar = {"frame_timeout_s": None}


def _off(name: str, factor: float) -> type[CarHost]:
    """Make a simulator's side one of whose limits is that many times as far out."""
    limits = CommandLimits()
    line = {"limits": replace(limits, **{name: getattr(limits, name) * factor})}
    return type(f"_Off_{name}_{factor}", (_Optional,), {"line": line})


_OFF_LIMITS = tuple(_off(one.name, factor) for one in fields(CommandLimits) for factor in (1.05, 0.95))

FAULTY_HOSTS: tuple[tuple[type[CarHost], tuple[str, ...]], ...] = (
    (_KeepsSteering, ("VS14",)),
    (_VelocityFirst, ("VS14",)),
    (_KeepsSliding, ("VS15",)),
    (_NeverBack, ("VS14",)),
    (_AlwaysRight, ("VS16",)),
    (_Signless, ("VS01",)),
    (_BrakeSwitch, ("VS02",)),
    (_StopsOnce, ("VS26H",)),
    (_LeavesTheJoystickAlone, ("VS26H",)),
    (_TakesMode2, ("VS04",)),
    (_EmergencyIsRest, ("VS29",)),
    (_LooksAtWhatItUses, ("VS27H",)),
    (_TrustsTheJoystick, ("VS27H",)),
    (_LooksAtOneByte, ("VS07H",)),
    (_Patient, ("VS06H",)),
    *((kind, ("VS27H",)) for kind in _OFF_LIMITS),
)
"""Each is found by the clauses behind it; a simulator's side of the profile `hardened` otherwise."""
