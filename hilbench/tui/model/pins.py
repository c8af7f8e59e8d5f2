"""What the pins of boards do: levels, edges as a small trace, period and duty; voltages."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

__all__ = ["PinModel", "PinsModel"]

Event = Mapping[str, Any]
_KEPT_EDGES = 256
_KEPT_VOLTS = 64
"""Of two seconds, which the trace shows, there are twenty (choice)."""


@dataclass(slots=True)
class PinModel:
    """A pin.

    Attributes:
        board: whose it is.
        pin: the port pin.
        light: the light at it; empty if there is none.
        level: high, low, or None while nobody drives it.
        edges: bench times of its latest edges, each with the level after it.
        edge_count: how many there were.
        known: bench time at which its level was recorded again, and the level, where edges before that were
            not recorded; None where all were.
        pwm: period and time high in ns, of a fast pin; None of a slow one.
        volts: bench times at which a part put another voltage on it, each with the voltage; none of a digital pin.
        full_v: the supply of the chip, which is the full scale of its voltages.
    """

    board: str
    pin: str
    light: str = ""
    level: bool | None = None
    edges: deque[tuple[int, bool | None]] = field(default_factory=lambda: deque(maxlen=_KEPT_EDGES))
    edge_count: int = 0
    known: tuple[int, bool | None] | None = None
    pwm: tuple[int, int] | None = None
    volts: deque[tuple[int, float]] = field(default_factory=lambda: deque(maxlen=_KEPT_VOLTS))
    full_v: float = 0.0

    def volts_at(self, ns: int) -> float | None:
        """Return the voltage that was recorded last up to a bench time; None before."""
        return next((volts for at_ns, volts in reversed(self.volts) if at_ns <= ns), None)

    def wave(self, now_ns: int) -> tuple[int, int] | None:
        """Return the period and the time high, in ns, of a pin that goes to and fro; None of one that has come to rest.

        That of a slow pin is taken from its latest three edges; it is at rest when they are four periods old.
        """
        if self.pwm is not None:
            return self.pwm if self.pwm[0] else None
        if len(self.edges) < 3 or None in {level for _, level in self.edges}:
            return None
        (first_ns, level), (second_ns, _), (third_ns, _) = list(self.edges)[-3:]
        period_ns = third_ns - first_ns
        if not period_ns or now_ns - third_ns > 4 * period_ns:
            return None
        return period_ns, second_ns - first_ns if level else third_ns - second_ns


class PinsModel:
    """The pins that have done something.

    Args:
        live: what the header of the journal says of the bench.
    """

    def __init__(self, live: Event) -> None:
        self.pins: dict[str, PinModel] = {}
        for board, about in live.get("boards", {}).items():
            for pin, light in about.get("leds", {}).items():
                self.pins[f"{board}.{pin}"] = PinModel(board=board, pin=pin, light=light)

    def take(self, event: Event) -> None:
        """Take an edge, what a fast pin does, or voltages."""
        if event["kind"] == "volts":
            self._take_volts(event)
            return
        pin = self._pin(event["source"])
        pin.level = event.get("level")
        if event["kind"] == "pin":
            pin.pwm = None
            pin.edges.append((event["ns"], pin.level))
            pin.edge_count += 1
        else:
            pin.edge_count += event.get("edges", 0)
            fast = event.get("edges", 0) > 0 and "period_ns" in event
            pin.pwm = (event["period_ns"], event["high_ns"]) if fast else None

    def take_standing(self, source: str, ns: int, level: bool | None, edges: int, *, fast: bool) -> None:
        """Take how a pin is at a bench time; what is known of its edges counts no more if some were not recorded."""
        pin = self._pin(source)
        if (level, edges, fast) == (pin.level, pin.edge_count, pin.pwm is not None):
            return
        pin.level, pin.edge_count, pin.known = level, edges, (ns, level)
        pin.edges.clear()
        if not fast:
            pin.pwm = None

    def _take_volts(self, event: Event) -> None:
        """Take the voltages that parts put on pins; raises ValueError for what is none."""
        for source, (volts, full_v) in event["pins"].items():
            if not (math.isfinite(volts) and 0 < full_v < math.inf):
                raise ValueError(f"{volts} V of {full_v} V is no voltage")
            pin = self._pin(source)
            pin.full_v = float(full_v)
            pin.volts.append((event["ns"], float(volts)))

    def _pin(self, source: str) -> PinModel:
        board, _, name = source.partition(".")
        return self.pins.setdefault(source, PinModel(board=board, pin=name))
