"""How much of the state tables of both links of a vehicle-interface board a run went through."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

from hilbench.bench.observing import coverage_of
from hilbench.judging.observations import Coverage
from hilbench.systems.vehicle.car_simulator import CarSimulator
from protocols import autoware
from protocols.carla import LINK_TABLE, MODE_TABLE, STEP_TABLE, Transition
from targets.robots.vehicle_interface import VehicleInterface

__all__ = ["VehicleObserver"]

_MODES, _STEPS, _STACK, _HOST = "modes of the board", "control task", "stand-in link", "simulator's side"

_TABLES: Mapping[str, Mapping[tuple[Any, Any], Any]] = {
    _MODES: {at: Transition(edge.next_mode) for at, edge in MODE_TABLE.items()},  # type: ignore[arg-type]
    _STEPS: STEP_TABLE,
    _STACK: autoware.BOARD_TABLE,
    _HOST: LINK_TABLE,
}


class VehicleObserver:
    """Adds up what the connections of a run went through."""

    def __init__(self) -> None:
        self._visits: dict[str, Counter[tuple[Any, Any]]] = {}

    def take_board(self, board: VehicleInterface) -> None:
        """Look at a board whose case is over."""
        self._add(_MODES, board.simulator.mode_visits)
        self._add(_STEPS, board.simulator.visits)
        self._add(_STACK, board.stack.visits)

    def take_host(self, simulator: CarSimulator) -> None:
        """Look at a simulator's side whose case is over."""
        self._add(_HOST, simulator.host.connection.visits)

    def coverage(self) -> tuple[Coverage, ...]:
        """Return the coverage of each table that was gone through."""
        return tuple(
            coverage_of(name, table, self._visits[name]) for name, table in _TABLES.items() if name in self._visits
        )

    def _add(self, name: str, visits: Mapping[tuple[Any, Any], int]) -> None:
        self._visits.setdefault(name, Counter()).update(visits)
