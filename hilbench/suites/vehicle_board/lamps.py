"""Lamps: the light of each mode, turn indicators and hazard lights."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from hilbench.check import Violation, within
from hilbench.suites._vehicle import Vehicle, on_board
from protocols.autoware import (
    HazardLights,
    HazardLightsCommand,
    HazardLightsReport,
    TurnIndicators,
    TurnIndicatorsCommand,
    TurnIndicatorsReport,
)

WATCH_S = 2.5
"""How long lamps are watched that have to blink: they go on twice at least."""
LOOK_S = 0.02


@on_board("VB54", lasts_s=4.0)
def test_each_mode_has_its_light(vehicle: Vehicle) -> None:
    vehicle.autoware()
    _require_light(vehicle, "amber")
    vehicle.manual()
    _require_light(vehicle, "green")
    vehicle.emergency()
    vehicle.run(0.2)
    _require_light(vehicle, "red")


def _require_light(vehicle: Vehicle, wanted: str) -> None:
    """Require that one light is lit and no other."""
    lit = vehicle.light
    assert lit == wanted, f"lit is {lit}, required {wanted}"


@on_board("VB43", lasts_s=18.0)
def test_turn_indicators_and_hazard_lights(vehicle: Vehicle) -> None:
    vehicle.autoware()
    off = TurnIndicators.DISABLE
    _require_lamps(vehicle, TurnIndicatorsCommand(command=TurnIndicators.ENABLE_LEFT), (True, False))
    _require_lamps(vehicle, TurnIndicatorsCommand(command=TurnIndicators.NO_COMMAND), (True, False))
    _require_told(vehicle, TurnIndicators.ENABLE_LEFT, HazardLights.DISABLE)
    _require_lamps(vehicle, TurnIndicatorsCommand(command=TurnIndicators.ENABLE_RIGHT), (False, True))
    _require_lamps(vehicle, TurnIndicatorsCommand(command=off), (False, False))
    _require_lamps(vehicle, HazardLightsCommand(command=HazardLights.ENABLE), (True, True))
    _require_lamps(vehicle, HazardLightsCommand(command=HazardLights.NO_COMMAND), (True, True))
    _require_told(vehicle, off, HazardLights.ENABLE)
    _require_lamps(vehicle, HazardLightsCommand(command=HazardLights.DISABLE), (False, False))
    _require_told(vehicle, off, HazardLights.DISABLE)


def _require_lamps(
    vehicle: Vehicle, command: TurnIndicatorsCommand | HazardLightsCommand, blinks: tuple[bool, bool]
) -> None:
    """Require that a command makes some lamps blink, 60 to 120 times a minute, and the others dark."""
    vehicle.stack.send(command)
    vehicle.run(0.1)
    found = vehicle.hands.blinking()
    if found is not None:
        names = {(True, False): "left", (False, True): "right", (True, True): "both", (False, False): "none"}
        assert found == blinks, f"of the lamps blink after {command}: {names[found]}, required {names[blinks]}"
        return
    seen, begun_ns = [], vehicle.bench.now_ns
    for _ in range(round(WATCH_S / LOOK_S) if True in blinks else round(1.0 / LOOK_S)):
        vehicle.run(LOOK_S)
        seen.append(vehicle.hands.lamps())
    for name, side, wanted in zip(("left", "right"), zip(*seen, strict=True), blinks, strict=True):
        if wanted:
            _require_blinking(vehicle, name, side, begun_ns)
        elif True in side:
            raise Violation(f"the {name} lamp is lit after {command}")


def _require_blinking(vehicle: Vehicle, name: str, side: Sequence[bool], begun_ns: int) -> None:
    """Require that a lamp goes on 60 to 120 times a minute."""
    lit = [number for number, (before, now) in enumerate(pairwise(side)) if now and not before]
    if len(lit) < 2:
        raise Violation(f"the {name} lamp goes on {len(lit)} times in {WATCH_S:g} s")
    doubt_s = LOOK_S + vehicle.uncertainty_s(begun_ns)
    for before, now in pairwise(lit):
        what = f"the {name} lamp goes on again after"
        within((now - before) * LOOK_S, 0.5, 1.0, unit="s", what=what, uncertainty=doubt_s)


def _require_told(vehicle: Vehicle, turn: int, hazard: int) -> None:
    """Require what is reported to the driving stack of the lamps."""
    mark = vehicle.stack.mark()
    vehicle.run(0.2)
    turns = {report.report for report in vehicle.reports(mark, TurnIndicatorsReport)}
    hazards = {report.report for report in vehicle.reports(mark, HazardLightsReport)}
    if (turns, hazards) != ({turn}, {hazard}):
        raise Violation(
            f"reported are {turns} and {hazards}, required {turn} and {hazard}", vehicle.stack.evidence(mark)
        )
