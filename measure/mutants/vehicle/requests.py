"""Boards that are wrong about who may change the mode: requests of the driving stack, presses of the joystick."""

from __future__ import annotations

from dataclasses import replace

from measure.mutants.vehicle.changes import Tells, modes_with, modes_without
from measure.mutants.vehicle.mutant import VehicleMutant
from protocols.autoware import ControlModeRequest, ControlModeResponse
from protocols.carla import Mode, ModeAnswered, ModeChanged, ModeTrigger
from targets.robots.vehicle_interface import VehicleInterface


class _GrantsAll(VehicleInterface):
    def _reports(self, event):
        if isinstance(event, ModeAnswered):
            event = replace(event, success=True)
        return super()._reports(event)


class _GrantsMore(VehicleInterface):
    """Takes every mode but 2 for MANUAL."""

    def _obey(self, message, now_ns):
        if isinstance(message, ControlModeRequest) and message.mode not in (1, 2, 4):
            message = replace(message, mode=4)
        return super()._obey(message, now_ns)


class _SevenBits(VehicleInterface):
    """Does not look at the highest bit of a mode."""

    def _obey(self, message, now_ns):
        if isinstance(message, ControlModeRequest):
            message = replace(message, mode=message.mode & 0x7F)
        return super()._obey(message, now_ns)


class _AnswersTwice(Tells):
    def instead(self, message):
        return [message] * (2 if isinstance(message, ControlModeResponse) else 1)


class _ActsOnPress(VehicleInterface):
    """Acts as the switch closes, not as it opens."""

    def hold(self, now_ns):
        return super().press(now_ns)

    def press(self, now_ns):
        return self.advance(now_ns)


class _OnePressEver(VehicleInterface):
    def press(self, now_ns):
        if self.simulator.counters.presses:
            return []
        return super().press(now_ns)


class _RemembersRefused(VehicleInterface):
    """Obeys a request for AUTOWARE that it refused, as soon as the emergency is over."""

    _refused = False

    def _from_simulator(self, events, now_ns):
        events = list(events)
        for event in events:
            if isinstance(event, ModeAnswered) and event.mode == Mode.AUTOWARE and not event.success:
                self._refused = True
            elif isinstance(event, ModeChanged) and event.old is Mode.EMERGENCY and self._refused:
                self.simulator._machine.stack.remember(Mode.AUTOWARE)
        return super()._from_simulator(events, now_ns)


class _WantsShortPresses(VehicleInterface):
    """A switch that was closed for more than half a second does nothing."""

    _closed_ns = 0

    def hold(self, now_ns):
        self._closed_ns = now_ns
        return super().hold(now_ns)

    def press(self, now_ns):
        closed_ns, self._closed_ns = self._closed_ns, 0
        if closed_ns and now_ns - closed_ns > 500_000_000:
            return self.advance(now_ns)
        return super().press(now_ns)


FAULTS = (
    VehicleMutant(
        id="no-debounce",
        what="each edge of the switch is a press",
        about=(
            "VB13",
            "VB14",
        ),
        board={"debounce_s": 0.001},
    ),
    VehicleMutant(id="grants-more", what="all modes but 2 are taken for MANUAL", about=("VB12",), kind=_GrantsMore),
    VehicleMutant(
        id="modes-of-seven-bits",
        what="the highest bit of a mode that is asked for is ignored",
        about=("VB61",),
        kind=_SevenBits,
    ),
    VehicleMutant(id="answers-twice", what="each request is answered twice", about=("VB12",), kind=_AnswersTwice),
    VehicleMutant(
        id="wants-short-presses",
        what="a press of more than 0.5 s does nothing",
        about=("VB51",),
        kind=_WantsShortPresses,
    ),
    VehicleMutant(id="acts-on-press", what="the switch acts as it closes", about=("VB51",), kind=_ActsOnPress),
    VehicleMutant(
        id="late-debounce", what="presses 1.01 s apart are one", about=("VB13", "VB14"), board={"debounce_s": 1.02}
    ),
    VehicleMutant(
        id="short-debounce",
        what="presses 0.99 s apart are two, and 0.98 s are blind",
        about=("VB13", "VB14"),
        board={"debounce_s": 0.98},
    ),
    VehicleMutant(
        id="one-press-ever", what="the second press does nothing, nor any after it", about=("VB13",), kind=_OnePressEver
    ),
    VehicleMutant(
        id="press-ends-emergency",
        what="a press ends EMERGENCY",
        about=("VB10",),
        modes=modes_with(Mode.EMERGENCY, ModeTrigger.PRESS, Mode.MANUAL),
    ),
    VehicleMutant(
        id="deaf-switch",
        what="a press in MANUAL does nothing",
        about=(
            "VB09",
            "VB31H",
        ),
        modes=modes_without(Mode.MANUAL, ModeTrigger.PRESS),
    ),
    VehicleMutant(
        id="deaf-to-requests",
        what="a request for AUTOWARE in MANUAL is granted and not obeyed",
        about=(
            "VB23H",
            "VB42H",
        ),
        modes=modes_without(Mode.MANUAL, ModeTrigger.REQUEST_AUTOWARE),
    ),
    VehicleMutant(
        id="grants-all",
        what="each request is said to be granted",
        about=(
            "VB11H",
            "VB12",
        ),
        kind=_GrantsAll,
    ),
    VehicleMutant(
        id="remembers-refused",
        what="a request that was refused in EMERGENCY is obeyed behind it",
        about=("VB11H",),
        kind=_RemembersRefused,
    ),
)
