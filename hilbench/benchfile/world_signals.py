"""What a vehicle in its world takes from parts and gives to them: quantities by the names that a bench file uses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from targets.parts import Direction

__all__ = ["WorldSignal", "WorldSignals"]


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldSignal:
    """One quantity.

    Attributes:
        name: without the ``world.`` before it.
        direction: as a part sees it: IN if the world gives it, OUT if a part gives it to the world.
        unit: SI; ``1`` for none.
        text: what it is.
        by_rays: it is found by casting rays, which not every physics can.
    """

    name: str
    direction: Direction
    unit: str
    text: str
    by_rays: bool = False


class WorldSignals(Protocol):
    """Reads and drives the signals of one vehicle."""

    def read(self) -> dict[str, float]:
        """Return every signal that is wanted, as it is now; to be asked after every step."""

    def drive(self, name: str, value: float) -> None:
        """Give the world a signal for the steps to come."""
