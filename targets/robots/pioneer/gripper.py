"""The gripper accessory: paddles and lift that travel between two limits in a fixed time.

Modelled in part: nothing is ever grasped, no beam is ever broken. Travel times are assumed. Commands and state bits
follow the Pioneer 2 / PeopleBot Operations Manual (GRIPPER, GRIPPERpac) and reedhedges/AriaCoda src/ArGripper.cpp.
"""

from __future__ import annotations

from dataclasses import dataclass

GRIP_TRAVEL_S = 2.0
LIFT_TRAVEL_S = 4.0

GRIP_LIMIT, LIFT_LIMIT = 0x01, 0x02
BEAMS_AND_PADDLES_CLEAR = 0x3C
"""Outer beam, inner beam, left and right paddle: 0 means obstructed or touched."""
LIFT_MOVING, GRIP_MOVING = 0x40, 0x80

_OPEN, _CLOSE, _STOP, _UP, _DOWN, _LIFT_STOP, _STORE, _DEPLOY, _HALT = 1, 2, 3, 4, 5, 6, 7, 8, 15
_GRIP_TARGETS = {_OPEN: 1.0, _CLOSE: 0.0, _STORE: 0.0, _DEPLOY: 1.0}
_LIFT_TARGETS = {_UP: 1.0, _DOWN: 0.0, _STORE: 1.0, _DEPLOY: 0.0}


@dataclass(slots=True, kw_only=True)
class _Actuator:
    """Position 0..1 travelling to a target; `moved_ns` is when the position was last brought up to date."""

    travel_s: float
    position: float
    target: float
    moved_ns: int = 0

    def bring_to(self, now_ns: int) -> None:
        reach = (now_ns - self.moved_ns) * 1e-9 / self.travel_s
        self.position += max(-reach, min(reach, self.target - self.position))
        self.moved_ns = now_ns

    def go(self, target: float | None, now_ns: int) -> None:
        self.bring_to(now_ns)
        self.target = self.position if target is None else target

    @property
    def moving(self) -> bool:
        return self.position != self.target

    @property
    def at_limit(self) -> bool:
        return self.position in (0.0, 1.0)


class Gripper:
    """Paddles (0 closed, 1 open) and lift (0 down, 1 up); starts open and down."""

    def __init__(self) -> None:
        self._grip = _Actuator(travel_s=GRIP_TRAVEL_S, position=1.0, target=1.0)
        self._lift = _Actuator(travel_s=LIFT_TRAVEL_S, position=0.0, target=0.0)

    def command(self, code: int, now_ns: int) -> bool:
        """GRIPPER: obey `code`; False when the model does not know it (16 press, 17 carry and the rest)."""
        if code in (_STOP, _HALT):
            self._grip.go(None, now_ns)
        if code in (_LIFT_STOP, _HALT):
            self._lift.go(None, now_ns)
        if code in _GRIP_TARGETS:
            self._grip.go(_GRIP_TARGETS[code], now_ns)
        if code in _LIFT_TARGETS:
            self._lift.go(_LIFT_TARGETS[code], now_ns)
        return code in _GRIP_TARGETS or code in _LIFT_TARGETS or code in (_STOP, _LIFT_STOP, _HALT)

    def state(self, now_ns: int) -> int:
        """State byte of the SIP and of GRIPPERpac."""
        self._grip.bring_to(now_ns)
        self._lift.bring_to(now_ns)
        bits = BEAMS_AND_PADDLES_CLEAR
        bits |= GRIP_LIMIT if self._grip.at_limit else 0
        bits |= LIFT_LIMIT if self._lift.at_limit else 0
        bits |= LIFT_MOVING if self._lift.moving else 0
        return bits | (GRIP_MOVING if self._grip.moving else 0)
