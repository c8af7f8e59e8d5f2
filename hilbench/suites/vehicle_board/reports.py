"""What is reported to the driving stack of the modes and of the vehicle."""

from __future__ import annotations

import math

from hilbench.check import Untimely, Violation, at_least, at_most
from hilbench.clock import NS_PER_S
from hilbench.suites._vehicle import MODE_WITHIN_S, STATUS_HZ, STATUS_MISS_S, Vehicle, on_board
from hilbench.suites.vehicle_board._moves import REPORT_WITHIN_S, between_lines_s, quiet, require_newest, say_a_hundred
from protocols.autoware import ControlMode, ControlModeReport, SteeringReport, Time, VelocityReport
from protocols.carla import Mode

MODE_REPORT_S = 0.1
"""How often the mode is reported. A choice: the original's task has no pace of its own."""

NEXT_COMMAND_S = 0.040
"""Within this a command comes, at 30 Hz, and a status that waited for it is taken."""


def _reported_in_emergency(vehicle: Vehicle) -> set[int]:
    vehicle.emergency()
    mark = vehicle.stack.mark()
    vehicle.run(0.5)
    return {*vehicle.modes_reported(mark)}


@on_board("VB36", lasts_s=3.0)
def test_emergency_is_kept_from_the_stack(vehicle: Vehicle) -> None:
    reported = _reported_in_emergency(vehicle)
    assert reported == {Mode.AUTOWARE}, f"the modes reported in EMERGENCY are {sorted(reported)}"


@on_board("VB36H", lasts_s=3.0)
def test_emergency_is_reported(vehicle: Vehicle) -> None:
    reported = _reported_in_emergency(vehicle)
    assert reported == {ControlMode.NOT_READY}, f"the modes reported in EMERGENCY are {sorted(reported)}"


@on_board("VB37", lasts_s=3.0)
def test_emergency_is_reported_as_manual(vehicle: Vehicle) -> None:
    reported = _reported_in_emergency(vehicle)
    assert reported == {Mode.MANUAL}, f"the modes reported in EMERGENCY are {sorted(reported)}"


@on_board("VB48", lasts_s=6.5)
def test_the_mode_is_reported(vehicle: Vehicle) -> None:
    vehicle.autoware()
    _require_mode_told(vehicle, ControlMode.AUTONOMOUS)
    _require_mode_told_soon(vehicle, ControlMode.MANUAL)
    _require_mode_told(vehicle, ControlMode.MANUAL)


def _require_mode_told(vehicle: Vehicle, mode: ControlMode) -> None:
    """Require that a mode and no other is reported, at the usual rate."""
    mark, begun_ns = vehicle.stack.mark(), vehicle.bench.now_ns
    vehicle.run(2.0)
    reported = vehicle.modes_reported(mark)
    if {*reported} != {mode}:
        raise Violation(
            f"the modes reported are {sorted({*reported})}, required {mode.value}", vehicle.stack.evidence(mark)
        )
    what, rate_hz = f"reports of mode {mode.value} in 2 s", 1 / MODE_REPORT_S
    vehicle.require_count(len(reported), round(2.0 * rate_hz), 2, what=what, since_ns=begun_ns, rate_hz=rate_hz)


def _require_mode_told_soon(vehicle: Vehicle, mode: ControlMode) -> None:
    """Ask for a mode; require that it is reported within one period of its first frame, and no other from then on."""
    mark, stack_mark = vehicle.mark(), vehicle.stack.mark()
    vehicle.stack.request(mode)
    first = vehicle.wait_for(Mode(mode), MODE_WITHIN_S, mark)
    vehicle.run(0.3)
    reports = vehicle.stack.since(stack_mark, ControlModeReport)
    right = [got for got, report in reports if report.mode == mode]
    if not right:
        raise Violation(f"mode {mode.value} is not reported", vehicle.stack.evidence(stack_mark))
    late_s = max(0, right[0].start_ns - first.start_ns) / NS_PER_S
    limit_s, doubt_s = MODE_REPORT_S + REPORT_WITHIN_S, between_lines_s(vehicle, first.start_ns)
    what = f"behind the first frame of mode {mode.value} it was reported after"
    at_most(late_s, limit_s, unit="s", what=what, uncertainty=doubt_s)
    after = {report.mode for got, report in reports if got.start_ns >= right[0].start_ns}
    assert after == {mode}, f"the modes reported after that are {sorted(after)}"


@on_board("VB53", lasts_s=6.5)
def test_the_newest_status_is_reported(vehicle: Vehicle) -> None:
    vehicle.autoware()
    stack_mark, begun_ns = vehicle.stack.mark(), vehicle.bench.now_ns
    newest = say_a_hundred(vehicle)
    vehicle.run(NEXT_COMMAND_S)
    require_newest(vehicle, stack_mark, newest)
    reports = [
        (got.start_ns, report.longitudinal_velocity) for got, report in vehicle.stack.since(stack_mark, VelocityReport)
    ]
    what = "reports of 100 statuses"
    vehicle.require_count(len(reports), len(newest), 2, what=what, since_ns=begun_ns, rate_hz=STATUS_HZ)
    uncertainty_s = between_lines_s(vehicle, begun_ns)
    for when_ns, speed in newest:
        behind_s = [(start_ns - when_ns) / NS_PER_S for start_ns, told_m_s in reports if told_m_s == speed]
        after_s = min((found_s for found_s in behind_s if found_s > 0), default=math.inf)
        if math.isinf(after_s):
            spare_s = 1 / STATUS_HZ - NEXT_COMMAND_S
            raise Untimely(
                f"a status of {speed:g} m/s is not reported", vehicle.stack.evidence(stack_mark), spare_s=spare_s
            )
        what = f"a status of {speed:g} m/s was reported after"
        at_most(after_s, NEXT_COMMAND_S, unit="s", what=what, uncertainty=uncertainty_s)


@on_board("VB52", lasts_s=1.0)
def test_without_a_clock_stamps_are_zero(vehicle: Vehicle) -> None:
    vehicle.autoware()
    vehicle.run(0.2)
    _require_stamps(vehicle, 0, Time())


@on_board("VB49", lasts_s=2.5)
def test_reports_are_stamped(vehicle: Vehicle) -> None:
    vehicle.autoware()
    for time_ns in (12_345_678_901, 13_000_000_000):
        vehicle.stack.set_clock(time_ns)
        vehicle.run(0.2)
        mark = vehicle.stack.mark()
        vehicle.run(0.3)
        _require_stamps(vehicle, mark, Time.from_ns(time_ns))


def _require_stamps(vehicle: Vehicle, mark: int, stamp: Time) -> None:
    """Require that there are reports of mode, velocity and steering since a mark, and that all have a stamp."""
    stamps = {
        "mode": [report.stamp for report in vehicle.reports(mark, ControlModeReport)],
        "velocity": [report.stamp for report in vehicle.reports(mark, VelocityReport)],
        "steering": [report.stamp for report in vehicle.reports(mark, SteeringReport)],
    }
    for what, found in stamps.items():
        if {*found} != {stamp}:
            text = f"the reports of {what} are stamped {found[:3]}, required {stamp}"
            raise Violation(text, vehicle.stack.evidence(mark))


def _reports_without_statuses(vehicle: Vehicle) -> list[VelocityReport]:
    """Let statuses stop; return what is reported from 0.1 s after it on, until just before the emergency."""
    quiet(vehicle)
    vehicle.run(STATUS_MISS_S)
    mark = vehicle.stack.mark()
    vehicle.run(0.75)
    return vehicle.reports(mark, VelocityReport)


@on_board("VB32", lasts_s=2.0)
def test_an_old_status_is_reported_as_new(vehicle: Vehicle) -> None:
    at_least(len(_reports_without_statuses(vehicle)), 6, unit="reports", what="of a status that was long ago")


@on_board("VB32H", lasts_s=4.0)
def test_no_status_no_report(vehicle: Vehicle) -> None:
    at_most(len(_reports_without_statuses(vehicle)), 0, unit="reports", what="without a status")
    vehicle.manual()
    vehicle.simulator.statuses.stop()
    vehicle.run(3 * STATUS_MISS_S)
    mark = vehicle.stack.mark()
    vehicle.run(1.0)
    at_most(len(vehicle.reports(mark, VelocityReport)), 0, unit="reports", what="without a status in MANUAL")
