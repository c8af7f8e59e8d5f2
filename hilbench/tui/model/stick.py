"""Two axes that are moved by keys: a terminal tells of presses and repeats, never of a key that is let go."""

from __future__ import annotations

__all__ = ["Stick"]

HOLD_S = 0.7
"""How long a press holds, as the bench's own dead man (`hilbench.driving.driver.DEAD_MAN_NS`)."""


class Stick:
    """The stick.

    A press on one axis keeps the other one where it is, if that has not run out: forward, then left held, is a curve.
    """

    def __init__(self) -> None:
        self._axes = [0.0, 0.0]
        self._until_s = [0.0, 0.0]

    def press(self, axis: int, share: float, now_s: float) -> tuple[float, float]:
        """Move axis 0 (forward) or 1 (counter-clockwise) to a share; return both."""
        other = 1 - axis
        if now_s >= self._until_s[other]:
            self._axes[other] = 0.0
        else:
            self._until_s[other] = now_s + HOLD_S
        self._axes[axis] = share
        self._until_s[axis] = now_s + HOLD_S
        return self.at(now_s)

    def release(self) -> None:
        """Let go."""
        self._axes = [0.0, 0.0]

    def at(self, now_s: float) -> tuple[float, float]:
        """Return both axes at a time."""
        forward, turn = (
            value if now_s < until_s else 0.0 for value, until_s in zip(self._axes, self._until_s, strict=True)
        )
        return forward, turn
