"""What the joystick's two readings mean.

Sources: microAutoware src/HIL taksControl.c (calibration, use), utils.c `fGetJoyPostition`; the report of
toffanetto/im420x, corpo.tex equation 1, has the same law. The report's schematic has X on PF11 and Y on PF12; in the
code it is the other way round, and that is how it works.
"""

from __future__ import annotations

from dataclasses import dataclass

from protocols.carla.errors import LocalProtocolError
from protocols.carla.messages import ManualCommand

__all__ = ["FULL_SCALE", "X_AXIS", "Y_AXIS", "Axis", "manual_command"]

FULL_SCALE = 0xFFFF
"""The largest reading: 16 bits."""
_DEAD_BAND = 500


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """The calibration of one axis, in steps of the converter.

    Attributes:
        least: at one end.
        zero: at rest.
        greatest: at the other end.
        dead_band: so far from rest on either side it is still rest.
    """

    least: int
    zero: int
    greatest: int = FULL_SCALE
    dead_band: int = _DEAD_BAND

    def __post_init__(self) -> None:
        """Checks the order of the figures; LocalProtocolError says which are wrong."""
        if not self.least < self.zero - self.dead_band <= self.zero + self.dead_band < self.greatest:
            raise LocalProtocolError(f"{self} is no calibration: least < zero - dead band, zero + dead band < greatest")

    def position(self, reading: int) -> float:
        """Where the stick is, -1 to 1; readings beyond the calibration give more than that."""
        off = reading - self.zero
        if abs(off) <= self.dead_band:
            return 0.0
        if off > 0:
            return (off - self.dead_band) / (self.greatest - self.zero - self.dead_band)
        return (off + self.dead_band) / (self.zero - self.least - self.dead_band)


X_AXIS = Axis(least=1057, zero=33970)
"""PF12, ADC1_INP6, first in the scan."""
Y_AXIS = Axis(least=1062, zero=33580)
"""PF11, ADC1_INP2, second in the scan."""


def manual_command(x: int, y: int, *, clamp: bool, x_axis: Axis = X_AXIS, y_axis: Axis = Y_AXIS) -> ManualCommand:
    """What the stick commands: the least x is steer 1, the upper half of y throttle, the lower one brake.

    Args:
        x: the reading of X, 0..65535.
        y: the reading of Y.
        clamp: keeps positions within -1..1; the original does not, and reads 0 as a brake of 1.033.
        x_axis: the calibration of X.
        y_axis: the calibration of Y.

    At rest steer is -0.0, as the original's `-fJoyXAxis`.
    """
    across, along = x_axis.position(x), y_axis.position(y)
    if clamp:
        across, along = (max(-1.0, min(1.0, value)) for value in (across, along))
    return ManualCommand(steer=-across, throttle=along if along > 0 else 0.0, brake=-along if along < 0 else 0.0)
