"""BUMPSTALL: stop at once when a bumper is hit.

Off at power-on and after every session. The contact that counts is a *new* one: a robot that stands against a wall
with a segment pressed can be driven away by the next motion command, and the next hit stops it again (choice; the
Pioneer 2 Operations Manual only says that the robot stops immediately and notifies a stall). Later robots stop only
when moving toward the bumper (Pioneer 3 Operations Manual); that is a setting.
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

    def reset(self) -> None:
        """Back to the power-on mode (end of a session)."""
        self.mode = 0
        self.latched = False

    def update(self, masks: tuple[int, int], speed_mm_s: float, *, motors_on: bool) -> bool:
        """Take the (front, rear) contact masks, bit 0 = segment 1; return whether a new contact must stop the robot.

        Args:
            masks: Contacts of this moment.
            speed_mm_s: Speed of the robot, + forward.
            motors_on: Without power there is nothing to stop and no stall to notify.
        """
        if not self._fitted:
            return False
        front, rear = masks[0] & self._widths[0], masks[1] & self._widths[1]
        hit = (FRONT if front & ~self.front else 0) | (REAR if rear & ~self.rear else 0)
        self.front, self.rear = front, rear
        if self._only_toward:
            hit &= FRONT if speed_mm_s > 0 else REAR if speed_mm_s < 0 else 0
        stops = motors_on and bool(hit & self.mode)
        self.latched = self.latched or stops
        return stops

    def release(self) -> None:
        """A new motion command was obeyed: the stall bits go out."""
        self.latched = False

    def segments(self) -> tuple[int, int]:
        """(front, rear) segment bits for the SIP; every bit set where no bumper is fitted, as captured from a P2-DX."""
        if not self._fitted:
            return 0x7F, 0x7F
        return self.front, self.rear
