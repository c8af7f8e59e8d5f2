"""BUMPSTALL: stop at once when a bumper is hit.

Off at power-on and after every session. Two things stop the robot: a new contact, whichever way it moves, and motion
toward an end that is pressed, however long it has been (choice; the Pioneer 2 Operations Manual only says that the
robot stops immediately and notifies a stall). So a robot that stands at a wall can be driven away, or turned, but a
client that sends its speed again and again does not push. Later robots stop only when moving toward the bumper, at a
new contact too (Pioneer 3 Operations Manual); that is a setting.
"""

from __future__ import annotations

from targets.robots.pioneer.settings import RobotSettings

FRONT, REAR = 1, 2
"""Bits of the BUMPSTALL argument; 3 is either end (Pioneer 2 / PeopleBot Operations Manual)."""


class BumpGuard:
    """Watches both bumpers and says when a contact has to stop the robot."""

    def __init__(self, settings: RobotSettings) -> None:
        self._only_toward = settings.bump_stall_only_toward
        self._fitted = settings.bumpers_fitted
        self._widths = (1 << settings.front_bumper_segments) - 1, (1 << settings.rear_bumper_segments) - 1
        self.mode = 0
        self.front = self.rear = 0
        self.latched = False
        self._ordered = False

    def reset(self) -> None:
        """Back to the power-on mode (end of a session)."""
        self.mode = 0
        self.latched = self._ordered = False

    def update(self, masks: tuple[int, int], speed_mm_s: float, direction: float, *, motors_on: bool) -> bool:
        """Take the (front, rear) contact masks, bit 0 = segment 1; return whether they must stop the robot.

        Args:
            masks: Contacts of this moment.
            speed_mm_s: Speed of the robot, + forward.
            direction: Where the loops drive it, or are about to: + forward, - backward, 0 nowhere or on the spot.
            motors_on: Without power there is nothing to stop and no stall to notify.
        """
        if not self._fitted:
            return False
        front, rear = masks[0] & self._widths[0], masks[1] & self._widths[1]
        hit = (FRONT if front & ~self.front else 0) | (REAR if rear & ~self.rear else 0)
        self.front, self.rear = front, rear
        if self._only_toward:
            hit &= _end_ahead(speed_mm_s)
        pressed = (FRONT if front else 0) | (REAR if rear else 0)
        stops = motors_on and bool((hit | pressed & _end_ahead(direction)) & self.mode)
        self.latched = stops or (self.latched and not self._ordered)
        self._ordered = False
        return stops

    def release(self) -> None:
        """A new motion command was obeyed: the stall bits go out at the next `update`, unless that stops it."""
        self._ordered = True

    def segments(self) -> tuple[int, int]:
        """(front, rear) segment bits for the SIP; every bit set where no bumper is fitted, as captured from a P2-DX."""
        if not self._fitted:
            return 0x7F, 0x7F
        return self.front, self.rear


def _end_ahead(direction: float) -> int:
    return FRONT if direction > 0 else REAR if direction < 0 else 0
