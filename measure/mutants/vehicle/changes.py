"""What faulty boards have in common: who changes what a board says, and tables with an edge of another kind."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from measure.mutants.vehicle.mutant import VehicleMutant
from protocols.carla import (
    MODE_TABLE,
    STEP_TABLE,
    Action,
    Mode,
    ModeTable,
    ModeTransition,
    ModeTrigger,
    Step,
    Transition,
    Trigger,
)
from targets.robots.vehicle_interface import BEHAVIOURS, SIMULATOR_LINE, VehicleInterface


class Tells(VehicleInterface):
    """Changes what it tells the driving stack."""

    def _reports(self, event):
        return [other for message in super()._reports(event) for other in self.instead(message)]

    def instead(self, message):
        return [message]


class Sends(VehicleInterface):
    """Changes what it puts on the simulator's line."""

    def _from_simulator(self, events, now_ns):
        sent = super()._from_simulator(events, now_ns)
        return [(line, self.changed(data) if line == SIMULATOR_LINE else data) for line, data in sent]

    def changed(self, data):
        return data


def limited(**limits: float) -> dict[str, Any]:
    return {"status_limits": replace(BEHAVIOURS["hardened"].board.status_limits, **limits)}  # type: ignore[type-var]


def a_little_off(of: str, limits: Mapping[str, str], clause: str) -> Iterator[VehicleMutant]:
    """Boards with one limit that is a twentieth too wide or too narrow.

    Args:
        of: what is limited, ``"status"`` or ``"command"``.
        limits: the names of its limits, by what they are of.
        clause: what has to find them.
    """
    option = f"{of}_limits"
    right = getattr(BEHAVIOURS["hardened"].board, option)
    for name, limit in limits.items():
        for word, factor in (("wide", 1.05), ("narrow", 0.95)):
            figure = getattr(right, limit) * factor
            yield VehicleMutant(
                id=f"{word}-{of}-{name.replace(' ', '-')}",
                what=f"the {name} of a {of} is too large from {figure:g} on",
                about=(clause,),
                board={option: replace(right, **{limit: figure})},
            )


def without(step: Step, trigger: Trigger, action: Action) -> dict[tuple[Step, Trigger], Transition]:
    edge = STEP_TABLE[step, trigger]
    return {(step, trigger): replace(edge, actions=tuple(one for one in edge.actions if one is not action))}


def modes_with(mode: Mode, trigger: ModeTrigger, next_mode: Mode) -> ModeTable:
    return {**MODE_TABLE, (mode, trigger): ModeTransition(next_mode)}


def modes_without(mode: Mode, trigger: ModeTrigger) -> ModeTable:
    return {at: edge for at, edge in MODE_TABLE.items() if at != (mode, trigger)}
