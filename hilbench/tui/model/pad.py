"""A game pad as Linux's joystick interface tells of it, and what its sticks, triggers and buttons mean.

Events are ``struct js_event`` of linux/joystick.h: time in ms (u32), value (s16), type (u8), number (u8), in the byte
order of the machine (Linux, Documentation/input/joydev/joystick-api.rst). The kernel numbers axes and buttons of a pad
by their codes, so that on those that its drivers know as game pads (Documentation/input/gamepad.rst; xpad,
hid-playstation) the left stick is 0 and 1, the right one 3 and 4, the triggers 2 and 5, the cross 6 and 7.

What they mean follows the pad of a real robot, a PS5 controller (docs/dashboard.md, "Game pads", has the source): the
triggers are the speed, their difference; the right stick turns; up connects, down disconnects. The left stick does
both, which is a choice, and so are the dead man, the upper left button, and the dead zone.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, field

__all__ = ["DEAD_MAN", "DEAD_ZONE", "EVENT", "PadState"]

EVENT = struct.Struct("=IhBB")
DEAD_ZONE = 0.1
"""How far a stick may be off its middle and still be at rest."""
DEAD_MAN = 4
"""The button that is held while the pad drives: L1, or LB."""

_BUTTON, _AXIS, _INITIAL = 0x01, 0x02, 0x80
_FULL = 32767
_LEFT_X, _LEFT_Y, _LEFT_TRIGGER, _RIGHT_X, _RIGHT_TRIGGER, _CROSS_Y = 0, 1, 2, 3, 5, 7
_AT_REST = -0.95
_CROSS = 0.5


@dataclass(slots=True)
class PadState:
    """Where everything on a pad is.

    Attributes:
        held: whether the dead man's button is down.
        asked: ``connect`` and ``disconnect``, as the cross was pressed since it was looked at last.
    """

    held: bool = False
    asked: list[str] = field(default_factory=list)
    _axes: dict[int, float] = field(default_factory=dict)
    _triggers: set[int] = field(default_factory=set)
    _data: bytes = b""

    def feed(self, data: bytes) -> None:
        """Take bytes of the device; events may be cut anywhere."""
        data = self._data + data
        whole = len(data) - len(data) % EVENT.size
        self._data = data[whole:]
        for _, value, kind, number in EVENT.iter_unpack(data[:whole]):
            if kind & ~_INITIAL == _BUTTON and number == DEAD_MAN:
                self.held = bool(value)
            elif kind & ~_INITIAL == _AXIS:
                self._move(number, max(-1.0, value / _FULL), initial=bool(kind & _INITIAL))

    @property
    def shares(self) -> tuple[float, float]:
        """How far forward and to the left it is pushed, -1 to 1 each."""
        triggers = self._pulled(_RIGHT_TRIGGER) - self._pulled(_LEFT_TRIGGER)
        forward = _farther(-self._beyond(_LEFT_Y), triggers)
        return forward, _farther(-self._beyond(_LEFT_X), -self._beyond(_RIGHT_X))

    def _move(self, number: int, share: float, *, initial: bool) -> None:
        before = self._axes.get(number, 0.0)
        self._axes[number] = share
        if number in {_LEFT_TRIGGER, _RIGHT_TRIGGER} and share < _AT_REST:
            self._triggers.add(number)  # only one that was seen at rest is known to be a trigger
        if number == _CROSS_Y and not initial and abs(share) > _CROSS >= abs(before):
            self.asked.append("connect" if share < 0 else "disconnect")

    def _beyond(self, number: int) -> float:
        """Return how far a stick is pushed beyond its dead zone, so that it begins there with nothing."""
        share = self._axes.get(number, 0.0)
        pushed = max(0.0, abs(share) - DEAD_ZONE) / (1 - DEAD_ZONE)
        return pushed if share > 0 else -pushed

    def _pulled(self, number: int) -> float:
        return (self._axes[number] + 1) / 2 if number in self._triggers else 0.0


def _farther(one: float, other: float) -> float:
    return one if abs(one) >= abs(other) else other
