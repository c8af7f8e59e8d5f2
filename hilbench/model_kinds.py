"""The behavioural models that a bench file can name: what each is set to, its lines, and what is checked of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from targets.robots.car_host import CarHostSettings
from targets.robots.pioneer import RobotSettings
from targets.robots.pioneer.hostbaud import RATES as PIONEER_RATES
from targets.robots.rover import RoverSettings
from targets.robots.vehicle_interface import LINE_BAUD, SIMULATOR_LINE, STACK_LINE, VehicleSettings

__all__ = ["MODEL_KINDS", "ModelKind", "board_protocol"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelKind:
    """One kind of model.

    Attributes:
        settings: the class of its settings.
        protocol: what is spoken on its lines, as the capability of that name.
        suites: what is checked on a bench with it, unless its file says otherwise.
        baud: of its lines, if the bench file says none, in bit/s.
        rates: that its lines can have, in bit/s; empty for any.
        lines: the ends of links that it has, as ``NAME.LINE``.
        bench: the built-in bench with it alone, which a run of its suites means; empty for the default one.
        target: what it is called as a TARGET; empty if it cannot be one.
        beside: it may stand beside another model.
    """

    settings: type[Any]
    protocol: str
    suites: tuple[str, ...]
    baud: int = 9600
    rates: tuple[int, ...] = ()
    lines: tuple[str, ...] = ("host",)
    bench: str = ""
    target: str = ""
    beside: bool = False


VEHICLE_SUITES = ("vehicle-board", "vehicle-host")

MODEL_KINDS: Mapping[str, ModelKind] = MappingProxyType(
    {
        "pioneer-2dx": ModelKind(
            settings=RobotSettings,
            protocol="P2OS",
            suites=("p2os-client", "p2os-server", "pioneer-motion"),
            rates=tuple(PIONEER_RATES),
            target="pioneer",
        ),
        "rover": ModelKind(
            settings=RoverSettings,
            protocol="PKT!",
            suites=("pkt-board", "pkt-host"),
            rates=tuple(PIONEER_RATES),
            bench="rover-model",
            target="rover-model",
        ),
        "vehicle-interface": ModelKind(
            settings=VehicleSettings,
            protocol="CARLA",
            suites=VEHICLE_SUITES,
            baud=LINE_BAUD,
            lines=(SIMULATOR_LINE, STACK_LINE),
            bench="vehicle-model",
            target="vehicle-model",
        ),
        "car-host": ModelKind(
            settings=CarHostSettings,
            protocol="CARLA",
            suites=("vehicle-host",),
            baud=LINE_BAUD,
            lines=("board",),
            beside=True,
        ),
    }
)
"""By the name that a bench file has for them."""


def board_protocol(suites: Iterable[str]) -> str:
    """Return which protocol a board speaks, by the shipped suites that are run on it; empty for none that is known.

    Whoever opens a port in the place of a board sends what belongs to that protocol, and nothing else.
    """
    named = {*suites}
    return next((kind.protocol for kind in MODEL_KINDS.values() if named & {*kind.suites}), "")
