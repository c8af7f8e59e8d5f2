"""What the driving stack is told of the modes and of the vehicle."""

from __future__ import annotations

from hilbench.check import Violation, at_least, at_most
from hilbench.suites._vehicle import STATUS_MISS_S, Vehicle, on_board
from hilbench.suites.vehicle_board._moves import quiet
from protocols.autoware import ControlMode, ControlModeReport, SteeringReport, Time, VelocityReport
from protocols.carla import Mode

MODE_REPORT_S = 0.1
"""How often the mode is reported. A choice: the original's task has no pace of its own."""


def _told_in_emergency(vehicle: Vehicle) -> set[int]:
    vehicle.emergency()
    mark = vehicle.stack.mark()
    vehicle.run(0.5)
    return {*vehicle.modes_told(mark)}


@on_board("VB36", lasts_s=3.0)
def test_emergency_is_kept_from_the_stack(vehicle: Vehicle) -> None:
    told = _told_in_emergency(vehicle)
    assert told == {Mode.AUTOWARE}, f"the modes told in EMERGENCY are {sorted(told)}"


@on_board("VB36H", lasts_s=3.0)
def test_emergency_is_reported(vehicle: Vehicle) -> None:
    told = _told_in_emergency(vehicle)
    assert told == {ControlMode.NOT_READY}, f"the modes told in EMERGENCY are {sorted(told)}"


@on_board("VB37", lasts_s=3.0)
def test_emergency_is_reported_as_manual(vehicle: Vehicle) -> None:
    told = _told_in_emergency(vehicle)
    assert told == {Mode.MANUAL}, f"the modes told in EMERGENCY are {sorted(told)}"


@on_board("VB48", lasts_s=6.5)
def test_the_mode_is_reported(vehicle: Vehicle) -> None:
    vehicle.autoware()
    _require_mode_told(vehicle, ControlMode.AUTONOMOUS)
    vehicle.manual()
    _require_mode_told(vehicle, ControlMode.MANUAL)


def _require_mode_told(vehicle: Vehicle, mode: ControlMode) -> None:
    """Require that a mode and no other is reported, at the usual rate."""
    mark, begun_ns = vehicle.stack.mark(), vehicle.bench.now_ns
    vehicle.run(2.0)
    told = vehicle.modes_told(mark)
    if {*told} != {mode}:
        raise Violation(f"the modes told are {sorted({*told})}, required {mode.value}", vehicle.stack.evidence(mark))
    what, rate_hz = f"reports of mode {mode.value} in 2 s", 1 / MODE_REPORT_S
    vehicle.require_count(len(told), round(2.0 * rate_hz), 2, what=what, since_ns=begun_ns, rate_hz=rate_hz)


@on_board("VB49", lasts_s=2.5)
def test_reports_are_stamped(vehicle: Vehicle) -> None:
    vehicle.autoware()
    for time_ns in (12_345_678_901, 13_000_000_000):
        vehicle.stack.set_clock(time_ns)
        vehicle.run(0.2)
        mark = vehicle.stack.mark()
        vehicle.run(0.3)
        stamps = {
            "mode": [report.stamp for report in vehicle.reports(mark, ControlModeReport)],
            "velocity": [report.stamp for report in vehicle.reports(mark, VelocityReport)],
            "steering": [report.stamp for report in vehicle.reports(mark, SteeringReport)],
        }
        for what, found in stamps.items():
            if {*found} != {Time.from_ns(time_ns)}:
                text = f"the reports of {what} are stamped {found[:3]}, required {Time.from_ns(time_ns)}"
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


@on_board("VB32H", lasts_s=2.0)
def test_no_status_no_report(vehicle: Vehicle) -> None:
    at_most(len(_reports_without_statuses(vehicle)), 0, unit="reports", what="without a status")
