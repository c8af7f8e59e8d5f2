"""Turn indicators and hazard lights."""

from __future__ import annotations

from hilbench.check import Violation
from hilbench.suites._vehicle import Vehicle, on_board
from protocols.autoware import (
    HazardLights,
    HazardLightsCommand,
    HazardLightsReport,
    TurnIndicators,
    TurnIndicatorsCommand,
    TurnIndicatorsReport,
)


@on_board("VB43", lasts_s=6.0)
def test_turn_indicators_and_hazard_lights(vehicle: Vehicle) -> None:
    vehicle.autoware()
    off = TurnIndicators.DISABLE
    _require_lamps(vehicle, TurnIndicatorsCommand(command=TurnIndicators.ENABLE_LEFT), (True, False))
    _require_lamps(vehicle, TurnIndicatorsCommand(command=TurnIndicators.NO_COMMAND), (True, False))
    _require_told(vehicle, TurnIndicators.ENABLE_LEFT, HazardLights.DISABLE)
    _require_lamps(vehicle, TurnIndicatorsCommand(command=TurnIndicators.ENABLE_RIGHT), (False, True))
    _require_lamps(vehicle, TurnIndicatorsCommand(command=off), (False, False))
    _require_lamps(vehicle, HazardLightsCommand(command=HazardLights.ENABLE), (True, True))
    _require_told(vehicle, off, HazardLights.ENABLE)


def _require_lamps(
    vehicle: Vehicle, command: TurnIndicatorsCommand | HazardLightsCommand, blinks: tuple[bool, bool]
) -> None:
    """Require that a command makes some lamps blink, once a second at least, and the others dark."""
    vehicle.stack.send(command)
    vehicle.run(0.1)
    seen = []
    for _ in range(22):
        vehicle.run(0.05)
        seen.append(vehicle.hands.lamps())
    for name, side, wanted in zip(("left", "right"), zip(*seen, strict=True), blinks, strict=True):
        found = True in side and False in side if wanted else True in side
        if found is not wanted:
            does = "does not blink" if wanted else "is lit"
            raise Violation(f"the {name} lamp {does} behind {command}")


def _require_told(vehicle: Vehicle, turn: int, hazard: int) -> None:
    """Require what the driving stack is told of the lamps."""
    mark = vehicle.stack.mark()
    vehicle.run(0.2)
    turns = {report.report for report in vehicle.reports(mark, TurnIndicatorsReport)}
    hazards = {report.report for report in vehicle.reports(mark, HazardLightsReport)}
    if (turns, hazards) != ({turn}, {hazard}):
        raise Violation(f"told are {turns} and {hazards}, required {turn} and {hazard}", vehicle.stack.evidence(mark))
