"""A faulty vehicle interface: what it is made of, and what it is run against."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from protocols.carla import STEP_TABLE, ModeTable, Step, Table, Transition, Trigger
from targets.robots.vehicle_interface import VehicleInterface, VehicleSettings, behaviour_of

SLOW = ("VB03", "VB25", "VB31", "VB31H", "VB42", "VB42H")
"""What takes 20 s of bench time and more is run on faults that it is about, and on the emulated board only where
nothing else finds the defect."""


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleMutant:
    """A board with one fault.

    Attributes:
        id: stable name.
        what: what it does wrong.
        profile: of the cases that have to find it.
        about: the clauses that it is run against; empty for all but the `SLOW` ones.
        board: what is wrong with its options.
        body: the same with its quirks beside the lines.
        steps: changed edges of its control task.
        modes: its table of modes, if that is another one.
        kind: the class that it is made of.
    """

    id: str
    what: str
    profile: str = "hardened"
    about: tuple[str, ...] = ()
    board: Mapping[str, Any] = field(default_factory=dict)
    body: Mapping[str, Any] = field(default_factory=dict)
    steps: Mapping[tuple[Step, Trigger], Transition] = field(default_factory=dict)
    modes: ModeTable | None = None
    kind: type[VehicleInterface] = VehicleInterface

    def make(self, settings: VehicleSettings) -> VehicleInterface:
        """Makes the board, in the profile that a case asks for."""
        behaviour = behaviour_of(settings)
        changed = replace(
            behaviour, board=replace(behaviour.board, **self.board), body=replace(behaviour.body, **self.body)
        )
        steps: Table = {**STEP_TABLE, **self.steps}
        return self.kind(settings, behaviour=changed, steps=steps, modes=self.modes)
