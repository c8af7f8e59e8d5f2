"""What the journal has of pins: the level of each, how many edges it had, whether it is fast.

A pin at rest is recorded once. Who reads only a later part of the journal would not know it, so that is recorded again.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

__all__ = ["RecordedPins"]


@dataclass(slots=True)
class _Pin:
    """A pin, as recorded last.

    Attributes:
        level: high, low, or None while nobody drives it.
        edges: how many there were.
        fast: whether its edges are recorded as period and duty; see `hilbench.mcu.pin_log`.
    """

    level: bool | None = None
    edges: int = 0
    fast: bool = False


class RecordedPins:
    """See the module."""

    def __init__(self) -> None:
        self._pins: dict[str, _Pin] = {}

    def take(self, event: Mapping[str, Any]) -> None:
        """Take an event; those that are not of pins say nothing here."""
        kind = event["kind"]
        if kind not in {"pin", "pwm"}:
            return
        pin = self._pins.setdefault(event["source"], _Pin())
        pin.level = event.get("level")
        pin.edges += 1 if kind == "pin" else event["edges"]
        pin.fast = kind == "pwm" and event["edges"] > 0 and "period_ns" in event

    def standing(self) -> Mapping[str, object]:
        """Return the level of each pin, how many edges it had, and whether it is fast."""
        return {source: [pin.level, pin.edges, pin.fast] for source, pin in self._pins.items()}
