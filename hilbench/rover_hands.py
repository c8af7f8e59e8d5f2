"""What a check does to a rover, and sees of it, beside its line: the same words whatever stands there."""

from __future__ import annotations

from typing import Protocol

from protocols.pkt import Position
from targets.robots.rover import RoverRobot

__all__ = ["HANDS", "ModelHands", "RoverHands"]

HANDS = frozenset({"led", "wheels", "duty", "imu", "gps", "boot"})
"""The capabilities of a bench that has all of them, as the clauses name them."""


class RoverHands(Protocol):
    """Somebody who stands beside the rover."""

    def led_is_lit(self) -> bool:
        """Look at the test LED."""

    def force_wheels(self, rpm: float | None) -> None:
        """Turn all wheels at this speed, hold them for 0, let them go for None."""

    def duties(self) -> tuple[float, float]:
        """Return what reaches the motors of the left and the right pair: -1 to 1 of what the driver can put out."""

    def place(self, position: Position | None) -> None:
        """Have the GPS receiver know that it is there; None for no fix."""


class ModelHands:
    """At a behavioural rover.

    Args:
        robot: the rover.
    """

    def __init__(self, robot: RoverRobot) -> None:
        self._robot = robot

    def led_is_lit(self) -> bool:
        """See `RoverHands`."""
        return self._robot.lit

    def force_wheels(self, rpm: float | None) -> None:
        """See `RoverHands`."""
        self._robot.plant.force(rpm)

    def duties(self) -> tuple[float, float]:
        """See `RoverHands`."""
        return self._robot.duties

    def place(self, position: Position | None) -> None:
        """See `RoverHands`."""
        self._robot.position = position
