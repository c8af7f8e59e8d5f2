"""Lithium-ion cells in series: an open-circuit voltage that falls with the charge, behind a resistance.

It gives both, so that what draws a current in pulses can reckon with the sag during the pulse; its voltage at the
terminals is that under the mean current of the physics step before (`Quantity.late`). Currents into the battery charge
it as if it took them without loss. What is not modelled: `Battery.ABSENT`.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass

from targets.parts.part import Direction, Part, Ports, Quantity
from targets.parts.settings import check_settings, setting

__all__ = ["Battery", "BatteryOff", "BatterySettings", "cell_volts"]

_NS_PER_HOUR = 3.6e12

_CELL_VOLTS = (
    (0.0, 3.00),
    (0.05, 3.35),
    (0.10, 3.48),
    (0.20, 3.60),
    (0.40, 3.70),
    (0.60, 3.84),
    (0.80, 4.01),
    (1.0, 4.20),
)
"""Charge and open-circuit voltage of a cell; assumed, the common course of cells that are full at 4.2 V."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BatterySettings:
    """What the cells are like, and how full.

    Raises:
        ValueError: a value makes no battery.
    """

    cells: int = setting(2, "cells", "PKT! rover, rover_firmware/doc/index.md: two 18650 in series", least=1)
    charge: float = setting(1.0, "of 1", "choice: full, 4.2 V a cell", least=0.0, greatest=1.0)
    capacity_ah: float = setting(2.6, "A·h", "assumed: a common 18650", least=0.01)
    resistance_ohm: float = setting(
        0.12, "ohm", "assumed: 40 mohm a cell, and the springs and wires of a holder", least=0.0
    )
    cutoff_v: float = setting(
        5.0,
        "V",
        "assumed: protection boards open at 2.5 V a cell; here until power comes back on. 0 for none",
        least=0.0,
    )

    def __post_init__(self) -> None:
        check_settings(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class BatteryOff:
    """The battery was drawn below the voltage at which its protection opens, and gives nothing from now on."""

    volts: float


def cell_volts(charge: float) -> float:
    """Return the open-circuit voltage of a cell, V, at a charge of 0..1."""
    index = min(bisect_right(_CELL_VOLTS, charge, key=lambda point: point[0]), len(_CELL_VOLTS) - 1)
    (low, low_v), (high, high_v) = _CELL_VOLTS[index - 1], _CELL_VOLTS[index]
    return low_v + (high_v - low_v) * (charge - low) / (high - low)


class Battery(Part):
    """See the head of this file.

    Attributes:
        charge: what is left, 0..1.
    """

    QUANTITIES = (
        Quantity(name="emf", direction=Direction.OUT, unit="V", needed=False, text="its voltage without a load"),
        Quantity(name="resistance", direction=Direction.OUT, unit="ohm", needed=False, text="behind which that is"),
        Quantity(name="volts", direction=Direction.OUT, unit="V", needed=False, text="at its terminals, one step late"),
        Quantity(
            name="current", direction=Direction.IN, unit="A", needed=False, late=True, text="what is drawn from it"
        ),
    )
    ABSENT = (
        "temperature",
        "ageing",
        "self-discharge",
        "slow recovery of the voltage after a load",
        "cells that differ",
    )
    Settings = BatterySettings

    def __init__(self, settings: BatterySettings, ports: Ports, *, seed: int) -> None:  # noqa: ARG002
        self._settings = settings
        self._tell = ports.tell
        self.charge = settings.charge
        self._current_a = 0.0
        self._off = False

    def power_on(self, now_ns: int) -> None:  # noqa: ARG002
        """Begin as full as the settings say."""
        self.charge, self._current_a, self._off = self._settings.charge, 0.0, False

    def feed(self, values: Mapping[str, float]) -> None:
        """Take the current that was drawn."""
        self._current_a = values.get("current", 0.0)

    def before_step(self, from_ns: int, to_ns: int) -> Mapping[str, float]:
        """Return the voltage for the step, and take from the charge what is drawn in it."""
        settings = self._settings
        open_v = settings.cells * cell_volts(self.charge)
        volts = max(0.0, open_v - self._current_a * settings.resistance_ohm)
        if not self._off and volts < settings.cutoff_v:
            self._off = True
            self._tell(BatteryOff(volts=volts))
        if self._off:
            return {"emf": 0.0, "resistance": settings.resistance_ohm, "volts": 0.0}
        drawn_ah = self._current_a * (to_ns - from_ns) / _NS_PER_HOUR
        self.charge = min(1.0, max(0.0, self.charge - drawn_ah / settings.capacity_ah))
        return {"emf": open_v, "resistance": settings.resistance_ohm, "volts": volts}
