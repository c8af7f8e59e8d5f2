"""Boards that read the joystick wrongly."""

from __future__ import annotations

from dataclasses import replace

from measure.mutants.vehicle.changes import Sends
from measure.mutants.vehicle.mutant import VehicleMutant
from protocols.carla import FULL_SCALE, X_AXIS, Y_AXIS, Axis, CommandFrame, Mode, decode_command, encode_command


class _CubicAxis(Axis):
    """Softer in the middle."""

    def position(self, reading):
        return super().position(reading) ** 3


def _cubic(axis):
    return _CubicAxis(least=axis.least, zero=axis.zero, greatest=axis.greatest, dead_band=axis.dead_band)


def _at_half(axis):
    """Twice as far to either end."""
    return replace(axis, least=2 * axis.least - axis.zero, greatest=2 * axis.greatest - axis.zero)


class _OneFrameBehind(Sends):
    """Says where the joystick was at the frame before."""

    _before = b""

    def changed(self, data):
        if decode_command(data).mode != Mode.MANUAL:
            return data
        before, self._before = self._before, data
        return before or data


class _KeepsTheRate(Sends):
    """In MANUAL the rate of the last command stands where nothing is said."""

    _last = CommandFrame()

    def changed(self, data):
        frame = decode_command(data)
        if frame.mode == Mode.MANUAL:
            return encode_command(replace(frame, steering_rate=self._last.steering_rate))
        self._last = frame
        return data


FAULTS = (
    VehicleMutant(
        id="joystick-behind",
        what="each frame of MANUAL says where the joystick was at the one before",
        about=("VB64",),
        kind=_OneFrameBehind,
    ),
    VehicleMutant(
        id="rate-in-manual",
        what="the rate of the last command stays in frames of MANUAL",
        about=("VB17", "VB19", "VB20"),
        kind=_KeepsTheRate,
    ),
    VehicleMutant(
        id="narrow-dead-band",
        what="a dead band of 400",
        about=("VB16",),
        board={"x_axis": replace(X_AXIS, dead_band=400), "y_axis": replace(Y_AXIS, dead_band=400)},
    ),
    VehicleMutant(
        id="zero-off",
        what="the joystick's middle is taken to be 1000 lower",
        about=(
            "VB15",
            "VB16",
        ),
        board={"x_axis": replace(X_AXIS, zero=32_970), "y_axis": replace(Y_AXIS, zero=32_580)},
    ),
    VehicleMutant(
        id="upper-end-off",
        what="the joystick's upper ends are taken to be higher",
        about=("VB17",),
        board={"x_axis": replace(X_AXIS, greatest=FULL_SCALE + 2000), "y_axis": replace(Y_AXIS, greatest=70_000)},
    ),
    VehicleMutant(
        id="lower-end-off",
        what="the joystick's lower ends are taken to be lower",
        about=(
            "VB18",
            "VB34H",
        ),
        board={"x_axis": replace(X_AXIS, least=0), "y_axis": replace(Y_AXIS, least=0)},
    ),
    VehicleMutant(
        id="joystick-at-half",
        what="the joystick's ends are half of what they should be",
        about=("VB17", "VB18"),
        board={"x_axis": _at_half(X_AXIS), "y_axis": _at_half(Y_AXIS)},
    ),
    VehicleMutant(
        id="soft-joystick",
        what="the joystick's positions are cubed",
        about=("VB46",),
        board={"x_axis": _cubic(X_AXIS), "y_axis": _cubic(Y_AXIS)},
    ),
)
