"""What the sensor tells of itself: what it is asked for and does not do, once each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

__all__ = ["Notes", "SensorNote"]


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorNote:
    """Something is not modelled, or is a mistake that the data sheet warns of."""

    text: str


class Notes:
    """Tells each thing once.

    Args:
        tell: takes the events.
    """

    def __init__(self, tell: Callable[[object], None]) -> None:
        self._tell = tell
        self._noted: set[str] = set()

    def note(self, text: str) -> None:
        """Tell something, unless it has been told."""
        if text not in self._noted:
            self._noted.add(text)
            self._tell(SensorNote(text=text))
