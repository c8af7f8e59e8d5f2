"""Boards that wait wrongly for the driving stack, or for the watchdog."""

from __future__ import annotations

from dataclasses import replace

from measure.mutants.vehicle.mutant import VehicleMutant
from protocols.autoware import AgentFound, AgentPing, encode_frame, encode_message
from protocols.carla import Mode
from targets.robots.vehicle_interface import STACK_LINE, VehicleInterface


class _WatchedInAutoware(VehicleInterface):
    """Has a watchdog that sleeps in MANUAL."""

    def hang(self, now_ns):
        if self.simulator.mode is Mode.MANUAL:
            self.behaviour = replace(self.behaviour, body=replace(self.behaviour.body, watchdog_s=None))
        return super().hang(now_ns)


class _HearsNobodyAfterTwoSeconds(VehicleInterface):
    """Takes a driving stack that is there within 2 s of the start, or after 20 s, and none between."""

    _heard = False
    _listens_s = 2.0

    def receive(self, line, data, now_ns):
        since_s = (now_ns - self._epoch_ns) / 1e9
        if line == STACK_LINE and not self._heard and self._listens_s < since_s < 20.0:
            return self.advance(now_ns)
        self._heard = self._heard or line == STACK_LINE
        return super().receive(line, data, now_ns)


class _HearsNobodyAfterSeventeenSeconds(_HearsNobodyAfterTwoSeconds):
    _listens_s = 17.0


_PING = encode_frame(encode_message(AgentPing()))


class _AsksHalfAsOften(VehicleInterface):
    """Leaves out every second ping."""

    _pings = 0

    def _from_stack(self, events, now_ns):
        return [(line, data) for line, data in super()._from_stack(events, now_ns) if data != _PING or self._is_odd()]

    def _is_odd(self):
        self._pings += 1
        return self._pings % 2 == 1


class _HearsCommandsAlone(VehicleInterface):
    """Commands and requests are all by which it knows that the driving stack is there."""

    def receive(self, line, data, now_ns):
        if line != STACK_LINE:
            return super().receive(line, data, now_ns)
        sent = self.advance(now_ns)
        found = [event for event in self.stack.receive(data, now_ns) if not isinstance(event, AgentFound)]
        return sent + self._from_stack(found, now_ns)


FAULTS = (
    VehicleMutant(id="ping-2s", what="an agent is asked for every 2 s", about=("VB03",), kind=_AsksHalfAsOften),
    VehicleMutant(
        id="agent-by-commands",
        what="only commands and requests tell that the agent is there",
        about=("VB42H",),
        kind=_HearsCommandsAlone,
    ),
    VehicleMutant(
        id="agent-half-second",
        what="a driving stack that is silent for 0.5 s is lost",
        about=("VB42H",),
        board={"agent_silence_s": 0.5},
    ),
    VehicleMutant(
        id="agent-2s",
        what="an agent that comes from 2 to 20 s after the first ping is not heard",
        about=("VB58",),
        kind=_HearsNobodyAfterTwoSeconds,
    ),
    VehicleMutant(
        id="agent-17s",
        what="an agent that comes from 17 to 20 s after the first ping is not heard",
        about=("VB58",),
        kind=_HearsNobodyAfterSeventeenSeconds,
    ),
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
