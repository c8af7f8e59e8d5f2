"""The joystick: what MANUAL makes of its readings."""

from __future__ import annotations

from hilbench.check import Violation
from hilbench.suites._vehicle import MODE_WITHIN_S, Frame, Vehicle, on_board
from hilbench.suites.vehicle_board._moves import MANUAL_S, WHICH
from protocols.carla import X_AXIS, Y_AXIS, Axis, CommandFrame, Mode

ROUND_SHARE = 0.4
"""How far off either end a joystick may be that a hand holds in a corner: in a round gate it goes 0.71 of the way in
both directions, and by a hand 5 % of it less. A choice."""

MOVED_S = 0.005
"""How long behind a frame the joystick is moved: the converter and its filter have the rest of 60 ms. A choice."""


def _joystick(vehicle: Vehicle, x_count: int, y_count: int) -> Frame:
    """In MANUAL, move the joystick; return the last of the frames that follow."""
    vehicle.manual()
    vehicle.hands.set_joystick(x_count, y_count)
    vehicle.run(0.2)
    mark = vehicle.mark()
    vehicle.run(0.4)
    frames = [got for got in vehicle.frames(mark) if got.packet is not None and got.packet.mode == Mode.MANUAL]
    assert frames, "no frame of mode 4 came"
    return frames[-1]


def _manual(steer: float, throttle: float, brake: float) -> CommandFrame:
    return CommandFrame(steering=steer, speed=throttle, acceleration=brake, mode=Mode.MANUAL)


@on_board("VB15", lasts_s=1.5)
def test_the_joystick_at_rest(vehicle: Vehicle) -> None:
    got = _joystick(vehicle, 33_970, 33_580)
    vehicle.require_frame(got, _manual(0.0, 0.0, 0.0), "the joystick at rest")
    if got.raw[2:6] != bytes.fromhex("00000080"):
        raise Violation(f"S is {got.raw[2:6].hex(' ')}, required 00 00 00 80", vehicle.shown([got]))


@on_board("VB16", lasts_s=2.5)
def test_the_dead_band_has_its_edges(vehicle: Vehicle) -> None:
    for counts in ((34_470, 34_080), (33_470, 33_080)):
        vehicle.require_frame(_joystick(vehicle, *counts), _manual(0.0, 0.0, 0.0), f"the joystick at {counts}")


@on_board("VB17", lasts_s=1.5)
def test_the_joystick_at_its_upper_ends(vehicle: Vehicle) -> None:
    _require_ends(vehicle, _joystick(vehicle, 65_535, 65_535), _manual(-1.0, 1.0, 0.0))


@on_board("VB18", lasts_s=1.5)
def test_the_joystick_at_its_lower_ends(vehicle: Vehicle) -> None:
    _require_ends(vehicle, _joystick(vehicle, 1057, 1062), _manual(1.0, 0.0, 1.0))


def _require_ends(vehicle: Vehicle, got: Frame, wanted: CommandFrame) -> None:
    off = ROUND_SHARE if vehicle.hands.off_share else 0.0
    vehicle.require_frame(got, wanted, "the joystick at its ends", off)


@on_board("VB46", lasts_s=7.0)
def test_the_joystick_between_its_ends(vehicle: Vehicle) -> None:
    for part in (0.25, 0.5, 0.75):
        for sign in (1, -1):
            counts = (_reading(X_AXIS, sign * part), _reading(Y_AXIS, sign * part))
            _require_stick(vehicle, *counts)
    for sign in (1, -1):
        beyond = sign * (X_AXIS.dead_band + 1)
        _require_stick(vehicle, X_AXIS.zero + beyond, Y_AXIS.zero + beyond)


def _reading(axis: Axis, position: float) -> int:
    """Return the reading next to a position, -1 to 1."""
    end, sign = (axis.greatest, 1) if position > 0 else (axis.least, -1)
    edge = axis.zero + sign * axis.dead_band
    return round(edge + abs(position) * (end - edge))


def _share(axis: Axis, reading: int) -> float:
    """Return how far beyond the dead band a reading is, 1 at its end: the checker's own sum, not the board's."""
    beyond = abs(reading - axis.zero) - axis.dead_band
    sign, end = (1, axis.greatest) if reading > axis.zero else (-1, axis.least)
    return sign * beyond / (abs(end - axis.zero) - axis.dead_band)


def _require_stick(vehicle: Vehicle, x_count: int, y_count: int) -> None:
    """Require what the calibration makes of two readings."""
    got = _joystick(vehicle, x_count, y_count)
    across, along = _share(X_AXIS, x_count), _share(Y_AXIS, y_count)
    vehicle.require_frame(got, _manual(-across, max(0.0, along), max(0.0, -along)), f"at {x_count} and {y_count}")


@on_board("VB64", lasts_s=2.5)
def test_the_next_frame_says_where_the_joystick_is(vehicle: Vehicle) -> None:
    vehicle.manual()
    for counts, wanted in (
        ((X_AXIS.greatest, Y_AXIS.greatest), _manual(-1.0, 1.0, 0.0)),
        ((X_AXIS.least, Y_AXIS.least), _manual(1.0, 0.0, 1.0)),
        ((X_AXIS.zero, Y_AXIS.zero), _manual(0.0, 0.0, 0.0)),
    ):
        mark = vehicle.mark()
        vehicle.bench.run_until(lambda mark=mark: vehicle.mark() > mark, 0.3)  # type: ignore[misc]
        moved_ns = vehicle.bench.now_ns
        vehicle.run(MOVED_S)
        vehicle.hands.set_joystick(*counts)
        mark = vehicle.mark()
        vehicle.wait_for(Mode.MANUAL, MODE_WITHIN_S, mark)
        vehicle.simulator.require_punctual(moved_ns, MANUAL_S - MOVED_S, WHICH)
        vehicle.require_frame(vehicle.frames(mark)[0], wanted, f"the frame behind a move to {counts}")


@on_board("VB34", lasts_s=1.5)
def test_beyond_the_calibration_is_beyond_one(vehicle: Vehicle) -> None:
    got = _joystick(vehicle, 0, 0)
    vehicle.require_frame(got, _manual(33_470 / 32_413, 0.0, 33_080 / 32_018), "the joystick beyond its ends")


@on_board("VB34H", lasts_s=1.5)
def test_the_joystick_ends_at_one(vehicle: Vehicle) -> None:
    vehicle.require_frame(_joystick(vehicle, 0, 0), _manual(1.0, 0.0, 1.0), "the joystick beyond its ends")
