"""What the joystick asks for in manual mode: counts of two potentiometers to steering, throttle and brake.

Source: LMA-FEM-UNICAMP/microAutoware, Core/Src/utils.c and taskControle.c of the original; the calibration is that of
the author's own joystick.
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["HIGHEST_COUNT", "X_AXIS", "Y_AXIS", "Axis", "Stick"]

HIGHEST_COUNT = 65_535
"""Of a converter of 16 bits."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """One axis, in counts of the converter.

    Attributes:
        least: at one stop.
        zero: let go.
        most: at the other stop.
        dead_band: so far from `zero` nothing is asked for yet.
        clamped: counts beyond a stop ask for no more than the stop does; the original goes on (-1.033 at count 0).
    """

    least: int
    zero: int
    most: int
    dead_band: int = 500
    clamped: bool = True

    def share(self, count: int) -> float:
        """How far it is pushed: -1 at `least` to 1 at `most`, 0 within the dead band."""
        away = count - self.zero
        if abs(away) <= self.dead_band:
            return 0.0
        if away > 0:
            share = (away - self.dead_band) / (self.most - self.zero - self.dead_band)
        else:
            share = (away + self.dead_band) / (self.zero - self.least - self.dead_band)
        return min(1.0, max(-1.0, share)) if self.clamped else share


X_AXIS = Axis(least=1057, zero=33_970, most=65_535)
"""Channel 6, PF12: to the right is more."""

Y_AXIS = Axis(least=1062, zero=33_580, most=65_535)
"""Channel 2, PF11: forward is more."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Stick:
    """What both axes ask for.

    Attributes:
        steer: -1 to 1, positive to the left: the axis turned round, so that its zero is -0.0.
        throttle: 0 to 1.
        brake: 0 to 1.
    """

    steer: float
    throttle: float
    brake: float

    @classmethod
    def of(cls, x_count: int, y_count: int, *, x_axis: Axis = X_AXIS, y_axis: Axis = Y_AXIS) -> Stick:
        """What two counts ask for."""
        push = y_axis.share(y_count)
        return cls(steer=-x_axis.share(x_count), throttle=max(push, 0.0), brake=max(-push, 0.0))
