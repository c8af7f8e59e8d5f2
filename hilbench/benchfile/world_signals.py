"""What a vehicle in its world takes from parts and gives to them: quantities by the names that a bench file uses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from targets.parts import Direction

__all__ = ["WorldSignal", "WorldSignals"]

_BY_RAYS = ("ray", "sonar")


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldSignal:
    """One quantity.

    Attributes:
        name: without the ``world.`` before it.
        direction: as a part sees it: IN if the world gives it, OUT if a part gives it to the world.
        unit: SI; ``1`` for none.
        text: what it is.
    """

    name: str
    direction: Direction
    unit: str
    text: str

    @property
    def by_rays(self) -> bool:
        """It is found by casting rays, which not every physics can."""
        return self.name.partition("_")[0] in _BY_RAYS


class WorldSignals(Protocol):
    """Reads and drives the signals of one vehicle."""

    def read(self) -> dict[str, float]:
        """Return every signal that is wanted, as it is now; to be asked after every step."""

    def drive(self, name: str, value: float) -> None:
        """Give the world a signal for the steps to come."""
