"""Statuses of the simulator: whole, cut, damaged, or behind what is none."""

from __future__ import annotations

import math
from dataclasses import replace

from hilbench.check import Violation
from hilbench.suites._vehicle import (
    COMMAND,
    COMMAND_MISS_S,
    MISSES,
    MODE_WITHIN_S,
    STATUS,
    STATUS_HZ,
    STATUS_MISS_S,
    Frame,
    Vehicle,
    on_board,
)
from hilbench.suites.vehicle_board._moves import F1, IMPOSSIBLE_M_S, WHICH, quiet
from protocols.autoware import SteeringReport, VelocityReport
from protocols.carla import STATUS_BYTES, VECTORS, Mode, StatusFrame, decode_status, encode_status

F6 = decode_status(VECTORS["F6"].data)

BESIDE = StatusFrame(lon_speed_m_s=6.0, lat_speed_m_s=0.3, heading_rate_rad_s=-0.15, steering_rad=0.25)
"""What a damaged status says where it is sound: nothing that another one says."""

MOST = {"lon_speed_m_s": 150.0, "lat_speed_m_s": 150.0, "heading_rate_rad_s": 20.0, "steering_rad": 2.0}
"""What a status can be true with."""

INSIDE, OUTSIDE = 0.99, 1.01
"""Shares of a limit that are just within it and just beyond."""


@on_board("VB24", lasts_s=1.5)
def test_delimiters_within_a_float_are_data(vehicle: Vehicle) -> None:
    vehicle.autoware()
    mark = vehicle.stack.mark()
    vehicle.simulator.status = F6
    vehicle.require_reported(F6, mark)


def _go_on(vehicle: Vehicle, speed_m_s: float) -> int:
    """Let statuses come again, with another speed; return a mark in the reports from then on."""
    vehicle.other_status(speed_m_s)
    vehicle.simulator.statuses.start(STATUS_HZ)
    return vehicle.stack.mark()


@on_board("VB25", lasts_s=63.0)
def test_one_stray_byte_is_for_ever(vehicle: Vehicle) -> None:
    quiet(vehicle)
    mark = vehicle.mark()
    vehicle.simulator.write(b"\0")
    stack_mark = _go_on(vehicle, 3.0)
    vehicle.wait_for(Mode.EMERGENCY, 1.3, mark)
    vehicle.run(60.0)
    assert 3.0 not in vehicle.speeds(stack_mark), "a status is accepted after a stray byte"
    vehicle.require_modes(vehicle.frames()[-20:], Mode.EMERGENCY)


_WHOLE = encode_status(STATUS)

_STRAY = (
    *(bytes(count) for count in range(1, 31)),
    *(_WHOLE[:count] for count in range(1, STATUS_BYTES)),
    *(_WHOLE[count:] for count in range(1, STATUS_BYTES)),
    b"##",
    b"#A#",
    b"#" * STATUS_BYTES,
    b"#" * 30,
)
"""Zeros, beginnings and ends of a status, and what looks like beginnings."""


@on_board("VB25H", lasts_s=12.0)
def test_stray_bytes_cost_no_status(vehicle: Vehicle) -> None:
    quiet(vehicle)
    mark = vehicle.mark()
    for number, stray in enumerate(_STRAY):
        vehicle.simulator.write(stray)
        vehicle.run(0.01)
        stack_mark = vehicle.stack.mark()
        status = vehicle.other_status(1.0 + number % 30)
        vehicle.say(status)
        vehicle.require_reported(status, stack_mark, 1 / STATUS_HZ + 0.03)
    vehicle.require_modes(vehicle.frames(mark), Mode.AUTOWARE)


@on_board("VB47", lasts_s=3.0)
def test_half_a_status_is_given_up(vehicle: Vehicle) -> None:
    for count in (1, 10, 21):
        mark = quiet(vehicle)
        data = encode_status(vehicle.other_status(float(count)))
        vehicle.simulator.write(data[:count])
        vehicle.run(0.15)
        vehicle.simulator.write(data[count:])
        vehicle.run(0.1)
        speeds = vehicle.speeds(mark)
        assert float(count) not in speeds, f"a status in pieces of {count} and {STATUS_BYTES - count} is accepted"
        stack_mark = _go_on(vehicle, 4.0)
        vehicle.require_reported(vehicle.simulator.status, stack_mark)


@on_board("VB26", lasts_s=1.5)
def test_a_frame_may_come_in_pieces(vehicle: Vehicle) -> None:
    mark = quiet(vehicle)
    data = encode_status(vehicle.other_status(3.0))
    vehicle.simulator.write(data[:10])
    vehicle.run(0.05)
    vehicle.simulator.write(data[10:])
    vehicle.require_reported(vehicle.simulator.status, mark)


_SHORT = b"#A" + bytes.fromhex("00004040") + b"$" + bytes(15)
"""A field A of 3.0 and the end, in a block of 22 bytes."""


@on_board("VB27", lasts_s=1.5)
def test_missing_fields_keep_their_old_values(vehicle: Vehicle) -> None:
    mark = quiet(vehicle)
    vehicle.simulator.write(_SHORT)
    vehicle.require_reported(replace(STATUS, lon_speed_m_s=3.0), mark)


@on_board("VB27H", lasts_s=2.5)
def test_a_frame_that_lacks_a_field_is_none(vehicle: Vehicle) -> None:
    twice = encode_status(replace(STATUS, lon_speed_m_s=3.0)).replace(b"B", b"A", 1)
    for stimulus in (_SHORT, twice):
        mark = quiet(vehicle)
        vehicle.simulator.write(stimulus)
        vehicle.run(0.05)
        stack_mark = _go_on(vehicle, 4.0)
        vehicle.require_reported(vehicle.simulator.status, stack_mark)
        assert 3.0 not in vehicle.speeds(mark), f"{stimulus.hex(' ')} is accepted"


@on_board("VB28", lasts_s=2.5)
def test_hashes_are_no_status(vehicle: Vehicle) -> None:
    stack_mark = quiet(vehicle)
    mark, quiet_ns = vehicle.mark(), vehicle.bench.now_ns
    vehicle.run(5 * STATUS_MISS_S)
    vehicle.simulator.write(b"#" * 22)
    first = vehicle.wait_for(Mode.EMERGENCY, 1.3, mark)
    moving = [got for got in vehicle.frames(mark) if got.start_ns < first.start_ns]
    what, rate_hz = "frames of mode 1 without a status", 1 / STATUS_MISS_S
    vehicle.require_count(len(moving), MISSES, 1.5, what=what, since_ns=quiet_ns, rate_hz=rate_hz)
    others = [speed for speed in vehicle.speeds(stack_mark) if abs(speed - STATUS.lon_speed_m_s) > 1e-5]
    assert not others, f"a speed of {others[0]:g} m/s is reported, which was never sent"


def _damaged(vehicle: Vehicle, damaged: StatusFrame) -> tuple[list[VelocityReport], list[SteeringReport]]:
    """Say a status that cannot be, and then sound ones; return the reports."""
    mark = quiet(vehicle)
    vehicle.say(damaged, 0.06)
    stack_mark = _go_on(vehicle, 4.0)
    vehicle.require_reported(vehicle.simulator.status, stack_mark)
    return vehicle.reports(mark, VelocityReport), vehicle.reports(mark, SteeringReport)


@on_board("VB29", lasts_s=1.5)
def test_a_nan_is_handed_on(vehicle: Vehicle) -> None:
    velocities, _ = _damaged(vehicle, replace(STATUS, heading_rate_rad_s=math.nan))
    assert any(math.isnan(report.heading_rate) for report in velocities), "the NaN is not reported"


@on_board("VB29H", lasts_s=10.0)
def test_a_nan_is_no_figure(vehicle: Vehicle) -> None:
    for name in MOST:
        for value in (math.nan, math.inf):
            _require_dropped(vehicle, replace(BESIDE, **{name: value}))


def _require_dropped(vehicle: Vehicle, damaged: StatusFrame) -> None:
    """Say a status that cannot be between sound ones; require that no report has a figure of it."""
    velocities, steerings = _damaged(vehicle, damaged)
    sound = [decode_status(encode_status(status)) for status in (STATUS, vehicle.simulator.status)]
    figures = {(one.lon_speed_m_s, one.lat_speed_m_s, one.heading_rate_rad_s) for one in sound}
    reported = {(one.longitudinal_velocity, one.lateral_velocity, one.heading_rate) for one in velocities}
    angles = {one.steering_tire_angle for one in steerings} - {one.steering_rad for one in sound}
    if reported - figures or angles:
        raise Violation(f"reported after {damaged}: {sorted(reported - figures)}, steering {sorted(angles)}")


@on_board("VB35", lasts_s=1.5)
def test_damaged_figures_are_believed(vehicle: Vehicle) -> None:
    velocities, _ = _damaged(vehicle, replace(STATUS, lon_speed_m_s=IMPOSSIBLE_M_S))
    assert any(report.longitudinal_velocity > 1e29 for report in velocities), "1e30 m/s is not reported"


@on_board("VB35H", lasts_s=12.0)
def test_what_cannot_be_is_dropped(vehicle: Vehicle) -> None:
    for name, most in MOST.items():
        for value in (OUTSIDE * most, -OUTSIDE * most):
            _require_dropped(vehicle, replace(BESIDE, **{name: value}))
    for sign in (1, -1):
        fastest = StatusFrame(**{name: sign * INSIDE * most for name, most in MOST.items()})
        mark = quiet(vehicle)
        vehicle.say(fastest)
        vehicle.require_reported(fastest, mark, 1 / STATUS_HZ + 0.03)


def _after_line_error(vehicle: Vehicle) -> int:
    """Make a framing error between two statuses; return a mark in the reports of what follows."""
    quiet(vehicle)
    return _line_error(vehicle, 3.0)


def _line_error(vehicle: Vehicle, speed_m_s: float) -> int:
    """Make a framing error, and let statuses come with another speed; return a mark in the reports from then on."""
    vehicle.simulator.port.send_break(200_000)
    vehicle.run(0.01)
    return _go_on(vehicle, speed_m_s)


@on_board("VB39", lasts_s=5.0)
def test_a_line_error_ends_reception(vehicle: Vehicle) -> None:
    stack_mark = _after_line_error(vehicle)
    vehicle.wait_for(Mode.EMERGENCY, 1.5, vehicle.mark())
    vehicle.run(2.0)
    assert 3.0 not in vehicle.speeds(stack_mark), "a status is accepted after a line error"
    vehicle.require_modes(vehicle.frames()[-10:], Mode.EMERGENCY)


@on_board("VB39H", lasts_s=3.5)
def test_a_line_error_costs_a_status(vehicle: Vehicle) -> None:
    stack_mark = _after_line_error(vehicle)
    vehicle.require_reported(vehicle.simulator.status, stack_mark, 1 / STATUS_HZ + 0.03)
    vehicle.manual()
    vehicle.simulator.statuses.stop()
    vehicle.run(0.02)
    stack_mark = _line_error(vehicle, 5.0)
    vehicle.require_reported(vehicle.simulator.status, stack_mark)
    vehicle.emergency()
    mark = vehicle.mark()
    _line_error(vehicle, 6.0)
    vehicle.wait_for(Mode.MANUAL, MODE_WITHIN_S, mark)


OLD_M_S = 7.0

OLD_S = 0.105
"""Between the 100 ms for which a status is waited for, and the next missed command."""


def _command_behind_a_status(vehicle: Vehicle, after_s: float) -> tuple[Frame, Frame, int]:
    """Just behind a missed command, say a status, and some time later command.

    Returns:
        The frames of the missed command and of the other, and a mark in the reports since the latter.

    Raises:
        Violation: no frame comes of one of them.
    """
    vehicle.autoware()
    vehicle.feed(status_hz=None, command_hz=None)
    vehicle.run(3 * COMMAND_MISS_S)
    mark = vehicle.mark()
    vehicle.bench.run_until(lambda: vehicle.mark() > mark, 2 * COMMAND_MISS_S)
    said_ns = vehicle.bench.now_ns
    vehicle.say(vehicle.other_status(OLD_M_S))
    vehicle.run(after_s)
    behind, stack_mark = vehicle.mark(), vehicle.stack.mark()
    vehicle.stack.send(COMMAND)
    vehicle.run(0.02)
    vehicle.simulator.require_punctual(said_ns, COMMAND_MISS_S - OLD_S, WHICH)
    frames = [*vehicle.frames(mark)[:1], *vehicle.frames(behind)[:1]]
    if len(frames) < 2:
        raise Violation("no frame of a missed command and of a command came", vehicle.shown(vehicle.frames()[-6:]))
    missed, command = frames
    vehicle.require_frame(command, F1, "the frame of the command")
    return missed, command, stack_mark


@on_board("VB57", lasts_s=2.0, noisy=True)
def test_an_old_status_is_an_answer(vehicle: Vehicle) -> None:
    _, _, stack_mark = _command_behind_a_status(vehicle, 0.5)
    vehicle.run(0.03)
    assert OLD_M_S in vehicle.speeds(stack_mark), "the status is not reported within 50 ms"


@on_board("VB57H", lasts_s=1.5)
def test_an_old_status_is_no_answer(vehicle: Vehicle) -> None:
    missed, command, stack_mark = _command_behind_a_status(vehicle, OLD_S)
    vehicle.require_gap(missed, command, STATUS_MISS_S, COMMAND_MISS_S, "the frame of the command came after")
    vehicle.run(0.03)
    assert OLD_M_S not in vehicle.speeds(stack_mark), f"a status that waited for {OLD_S:g} s is reported"
    vehicle.say(vehicle.other_status(4.0))
    vehicle.require_reported(vehicle.simulator.status, stack_mark, 0.03)
