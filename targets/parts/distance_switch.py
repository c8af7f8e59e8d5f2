"""A distance sensor with one output wire: high while something is nearer than a threshold.

The sensor of the simulation (bachelor-thesis, listing of the distance sensor plug-in) is one ray and strict: high if
range < threshold. On the real robot the adapter decides from a sonar and includes the threshold
(pioneer_2DX-Interface code-esp32_d1, bluepill_comm.cpp): high if range <= 1.0 m. The output is written at changes only
(stm32-qemu vl.c), and is low before the first reading.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from targets.parts.part import Direction, Part, Ports, Quantity, Terminal
from targets.parts.settings import check_settings, setting

__all__ = ["DistanceSwitch", "DistanceSwitchSettings", "DistanceSwitched"]

_THRESHOLDS_M = {"simulation": 0.5, "robot": 1.0}
_MS = 1_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class DistanceSwitchSettings:
    """How the sensor decides, and how often.

    Raises:
        ValueError: a value makes no sensor.
    """

    profile: Literal["simulation", "robot"] = setting(
        "simulation", "", "bachelor-thesis (strict); pioneer_2DX-Interface bluepill_comm.cpp (includes the threshold)"
    )
    threshold_m: float | None = setting(
        None, "m", "none: 0.5 simulation, assumed (not published); 1.0 robot, bluepill_comm.cpp", least=0.0
    )
    hysteresis_m: float = setting(0.0, "m", "choice: a switch that is on goes off this much farther out", least=0.0)
    period_ms: float = setting(
        0.0, "ms", "choice: 0 for every physics step; the rate of the original's laser is not published", least=0.0
    )

    def __post_init__(self) -> None:
        check_settings(self)

    @property
    def effective_threshold_m(self) -> float:
        """The threshold: as set, or that of the profile."""
        return _THRESHOLDS_M[self.profile] if self.threshold_m is None else self.threshold_m


@dataclass(frozen=True, slots=True, kw_only=True)
class DistanceSwitched:
    """The output has changed at `at_ns`; `range_m` is what was measured, None for nothing in reach."""

    on: bool
    range_m: float | None
    at_ns: int


class DistanceSwitch(Part):
    """See the head of this file. Readings fall on multiples of the period after power-on, or on every physics step."""

    TERMINALS = (Terminal(name="out", direction=Direction.OUT, needed=True, text="high: obstacle"),)
    QUANTITIES = (Quantity(name="range", direction=Direction.IN, unit="m", text="distance, inf without an echo"),)
    Settings = DistanceSwitchSettings

    def __init__(self, settings: DistanceSwitchSettings, ports: Ports, *, seed: int) -> None:  # noqa: ARG002
        self._settings = settings
        self._output = ports.output("out")
        self._tell = ports.tell
        self._period_ns = round(settings.period_ms * _MS)
        self._due_ns = 0
        self._on = False

    def power_on(self, now_ns: int) -> None:
        """Begin with a low output; the first reading is taken at once."""
        self._due_ns = now_ns
        self._on = False
        self._output.set(False, now_ns)

    def after_step(self, from_ns: int, to_ns: int, before: Mapping[str, float], after: Mapping[str, float]) -> None:
        """Take the readings that are due in this step; between two physics steps the range is that of the former."""
        if "range" not in after:
            return
        if not self._period_ns:
            self._read(after["range"], to_ns)
            return
        while self._due_ns <= to_ns:
            at_end = self._due_ns == to_ns
            self._read((after if at_end else before)["range"], max(self._due_ns, from_ns))
            self._due_ns += self._period_ns

    def _read(self, range_m: float, at_ns: int) -> None:
        on = self._decide(range_m)
        if on is not self._on:
            self._on = on
            self._output.set(on, at_ns)
            seen = range_m if math.isfinite(range_m) else None
            self._tell(DistanceSwitched(on=on, range_m=seen, at_ns=at_ns))

    def _decide(self, range_m: float) -> bool:
        limit_m = self._settings.effective_threshold_m + (self._settings.hysteresis_m if self._on else 0.0)
        return range_m < limit_m if self._settings.profile == "simulation" else range_m <= limit_m
