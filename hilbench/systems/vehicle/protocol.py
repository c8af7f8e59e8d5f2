"""The two protocols of a vehicle-interface board, as hilbench knows them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from hilbench.plugins.protocol import API, ProtocolPlugin, Quantity, Recorded
from protocols.autoware import decoding as stack_line
from protocols.autoware.stand_in import longest_frame
from protocols.carla import COMMAND_LAYOUT, VECTORS
from protocols.carla import decoding as simulator_line
from protocols.carla.clause import Clause
from targets.robots.vehicle_interface import LINE_BAUD

__all__ = ["AUTOWARE", "CARLA"]

_BOTH_ENDS = (
    "The board hands the driving stack's commands on to the car, or the joystick's: its mode says whose. We are at its "
    "two lines, the simulator with a car at one, the driving stack at the other. Ten deadlines missed in a row end it."
)


def _clauses() -> Sequence[Clause]:
    from protocols.carla.clauses import CLAUSES

    return CLAUSES


def _of_simulator(live: Mapping[str, Any]) -> Mapping[str, Quantity]:
    del live
    return {name: Quantity(name, "%", 100.0) for name in ("steer", "throttle", "brake")}


def _of_stack(live: Mapping[str, Any]) -> Mapping[str, Quantity]:
    del live
    units = {
        "steering_tire_angle": "rad", "steering_tire_rotation_rate": "rad/s", "speed": "m/s", "acceleration": "m/s²",
        "jerk": "m/s³", "longitudinal_velocity": "m/s", "lateral_velocity": "m/s", "heading_rate": "rad/s",
    }  # fmt: skip
    return {name: Quantity(name.replace("_", " "), unit) for name, unit in units.items()} | {
        "stamp": Quantity("stamp", "s"),
        "clock": Quantity("clock", "s"),
    }


CARLA = ProtocolPlugin(
    api=API,
    name="carla",
    title="CARLA",
    summary="the UART frames between a vehicle-interface board and a simulator",
    help=_BOTH_ENDS,
    decoder=simulator_line.decoder,
    encode=simulator_line.encode,
    quantities=_of_simulator,
    regions=simulator_line.regions,
    fixed={"EMERGENCY": VECTORS["F3"].data},
    longest_frame=COMMAND_LAYOUT.length + len(COMMAND_LAYOUT.padding),
    clauses=_clauses,
    baud=LINE_BAUD,
    recorded=Recorded(
        capabilities=frozenset({"board", "simulator"}), suites=("recorded-carla", "vehicle-board", "vehicle-host")
    ),
)

AUTOWARE = ProtocolPlugin(
    api=API,
    name="autoware",
    title="AUTOWARE",
    summary="the stand-in for the link between a vehicle-interface board and its driving stack",
    help=_BOTH_ENDS,
    decoder=stack_line.decoder,
    encode=stack_line.encode,
    quantities=_of_stack,
    answers={"ControlModeRequest": ("ControlModeResponse",), "AgentPing": ("AgentOnline",)},
    regions=stack_line.regions,
    longest_frame=longest_frame(),
    baud=LINE_BAUD,
)
