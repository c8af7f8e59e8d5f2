"""What the rover says of its sensors."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from itertools import pairwise

from hilbench.check import Inconclusive, Violation, near, within
from hilbench.clock import NS_PER_S
from hilbench.suites._rover import Rover, at_power_up, on_rover
from hilbench.systems.rover.hands import RoverBench
from protocols.pkt import GeneralReport, GpsReport, ImuReport, MotionReport, Position, StatusFlag

FIX_WITHIN_S = 60.0
"""How long a GPS receiver may take (u-blox NEO-6 data sheet: 27 s from a cold start)."""

POSITION_DEG = 0.001
"""110 m along a meridian: enough to tell latitude from longitude, and much more than a receiver's error. A choice."""


@on_rover("P39", lasts_s=3.5)
def test_stale_byte_of_the_position(rover: Rover) -> None:
    for before, byte in _bytes_of_position(rover):
        assert byte == before, f"byte 1 of 0x84 is {byte:02X}, that of the report before it {before:02X}"


@on_rover("P39D", lasts_s=3.5)
def test_byte_of_the_position(rover: Rover) -> None:
    pairs = _bytes_of_position(rover)
    if all(byte == before for before, byte in pairs):
        if pairs[0][1] in (0, 1):
            raise Inconclusive("the byte equals that of the previous report, and may be its own")
        raise Violation(f"byte 1 of 0x84 is {pairs[0][1]:02X}, always that of the report before", rover.peer.evidence())


def _bytes_of_position(rover: Rover) -> Sequence[tuple[int, int]]:
    """Return byte 1 of some 0x84, each with that of the report before it."""
    mark = rover.mark()
    rover.peer.run(3.2)
    received = rover.peer.received[mark:]
    at = 5  # behind sync word and length: the id; byte 1 follows
    pairs = [
        (before.raw[at + 1], got.raw[at + 1]) for before, got in pairwise(received) if isinstance(got.packet, GpsReport)
    ]
    if not pairs:
        raise Violation("no 0x84 came in 3.2 s", rover.peer.evidence(mark))
    return pairs


@on_rover("P40", lasts_s=5.0)
def test_no_position(rover: Rover) -> None:
    """The receiver has its fix after a second or two."""
    rover.peer.run(3.0)
    report = rover.next(GpsReport, 1.2)
    found = (report.first_deg, report.second_deg)
    assert found == (0.0, 0.0), f"0x84 has {found[0]} and {found[1]}"


@on_rover("P40D", lasts_s=4.0)
def test_position(rover: Rover) -> None:
    """The first 0x84 with numbers in it counts: a receiver needs a while for its fix."""
    rover.peer.bench.run_until(lambda: any(r.first_deg for _, r in rover.peer.since(0, GpsReport)), FIX_WITHIN_S)
    report, true = rover.next(GpsReport, 2.0), rover.hands.position()
    if true is None:
        require_there(rover, report)
        return
    near(report.first_deg, true.latitude_deg, POSITION_DEG, unit="deg", what="bytes 4 to 7 of 0x84, the latitude")
    near(report.second_deg, true.longitude_deg, POSITION_DEG, unit="deg", what="bytes 8 to 11 of 0x84, the longitude")


def require_there(rover: Rover, report: GpsReport) -> None:
    """Require of whoever stands beside the rover that he finds it where a 0x84 has it."""
    shown = Position(latitude_deg=report.first_deg, longitude_deg=report.second_deg)
    if not (shown.latitude_deg or shown.longitude_deg):
        raise Inconclusive("0x84 has no position")
    if not rover.hands.stands_at(shown):
        text = f"0x84 has {shown.latitude_deg:g} and {shown.longitude_deg:g}, where the rover is not"
        raise Violation(text, rover.peer.evidence())


def _measured(rover: Rover) -> ImuReport:
    """Return a 0x82 with what the sensor has measured: whatever its unit, at rest there is an acceleration."""
    rover.next(ImuReport, 1.2)
    report = rover.next(ImuReport, 1.2)
    if not any(report.acceleration):
        raise Inconclusive("0x82 has zeros for what the sensor measures")
    return report


def _magnitude(report: ImuReport) -> float:
    return math.hypot(*report.acceleration)


@on_rover("P41", lasts_s=2.0)
def test_acceleration_as_shipped(rover: Rover) -> None:
    near(_magnitude(_measured(rover)), 1.0, 0.1, unit="g", what="acceleration at rest")


@on_rover("P41D", lasts_s=2.0)
def test_acceleration(rover: Rover) -> None:
    before = None if rover.can("imu") else rover.motion()
    magnitude = _magnitude(_measured(rover))
    if before is not None and rover.motion().ticks != before.ticks:
        raise Inconclusive("the wheels turn, by their counts in 0x83")
    near(magnitude, 9.8, 1.0, unit="m/s^2", what="acceleration at rest")


@on_rover("P42", lasts_s=2.0)
def test_quaternion_as_shipped(rover: Rover) -> None:
    _require_scalar(rover, 0)


@on_rover("P42D", lasts_s=2.0)
def test_quaternion(rover: Rover) -> None:
    _require_scalar(rover, 3)


SCALAR = 0.98
"""How near to 1 the scalar is at least where the others are near to 0: 23 degrees off. A choice."""


def _require_scalar(rover: Rover, index: int) -> None:
    rover.hands.face_north()
    quaternion = _measured(rover).quaternion
    if not any(quaternion):
        raise Inconclusive("0x82 has zeros for the attitude")
    if any(map(math.isnan, quaternion)):
        raise Violation("the quaternion is no number", rover.peer.evidence())
    within(abs(quaternion[index]), SCALAR, 1.001, unit="", what=f"size of component {index + 1}, the scalar")


def _motions_from_power_up(there: RoverBench, duration_s: float) -> Sequence[MotionReport]:
    peer = there.peer
    peer.run(duration_s)
    reports = [report for _, report in peer.since(0, MotionReport)]
    if not reports:
        raise Violation(f"no 0x83 within {duration_s:g} s of power-up", peer.evidence())
    return reports


@at_power_up("P43", lasts_s=3.0)
def test_wheels_at_power_up_as_shipped(there: RoverBench) -> None:
    first = _motions_from_power_up(there, 3.0)[0]
    assert first.rpm == (1.0, 1.0, 1.0, 1.0), f"the first 0x83 shows {first.rpm} rpm"


@at_power_up("P43D", lasts_s=3.0)
def test_wheels_at_power_up(there: RoverBench) -> None:
    for report in _motions_from_power_up(there, 3.0):
        assert report.rpm == (0.0, 0.0, 0.0, 0.0), f"a 0x83 shows {report.rpm} rpm"
        assert report.ticks == (0, 0, 0, 0), f"a 0x83 shows counts of {report.ticks}"


SLOTS, STEADY_S = 20, 1.2
"""Slots of a tachometer's disc (the manual's chapter on them), and until a wheel keeps its speed: a choice."""

REPORT_WITHIN_S = 0.6
"""0x83 comes four times a second (P30)."""

COUNTS, COUNTS_SHARE = 3.0, 0.15
"""Tolerance: where in a slot one begins and ends, and what a speed changes by between two reports. Choices."""


@on_rover("P83", lasts_s=6.0)
def test_counts_follow_speeds(rover: Rover) -> None:
    """Each pair of wheels at another speed, so that what is exchanged shows."""
    begun = rover.mark()
    rover.next(MotionReport, REPORT_WITHIN_S)  # the last one at rest
    rover.drive(0.26, 0.35)
    rover.keep_alive(STEADY_S)
    mark = rover.mark()
    rover.keep_alive(2.0)
    driven = rover.peer.since(mark, MotionReport)
    rover.drive(0.0, 0.0)
    rover.keep_alive(2.5)
    if len(driven) < 2:
        raise Violation("no two 0x83 came in 2 s", rover.peer.evidence(mark))
    (first_got, first), (last_got, last) = driven[0], driven[-1]
    span_s = (last_got.start_ns - first_got.start_ns) / NS_PER_S
    doubt = rover.peer.uncertainty_s(first_got.start_ns) / span_s
    for wheel in range(4):
        speeds_rpm = [report.rpm[wheel] for _, report in driven]
        if not all(0 <= rpm <= FASTEST_RPM for rpm in speeds_rpm):
            shown = ", ".join(f"{rpm:g}" for rpm in speeds_rpm)
            raise Violation(f"wheel {wheel + 1}, driven ahead, has speeds of {shown} rpm", rover.peer.evidence(mark))
        if last.ticks[wheel] == first.ticks[wheel] and not any(speeds_rpm):
            raise Inconclusive(f"wheel {wheel + 1} stands, by its speed and by its count in 0x83")
        wanted = statistics.fmean(speeds_rpm) / 60 * SLOTS * span_s
        near(
            last.ticks[wheel] - first.ticks[wheel],
            wanted,
            COUNTS + COUNTS_SHARE * wanted,
            unit="counts",
            what=f"counts of wheel {wheel + 1} in {span_s:.2f} s",
            uncertainty=doubt * wanted,
        )
    _require_in_step([report for _, report in rover.peer.since(begun, MotionReport)], rover)
    *before, last = [report for _, report in rover.peer.since(mark, MotionReport)][-REPORTS_AT_REST:]
    if all(report.ticks == last.ticks for report in before) and any(last.rpm):
        raise Violation(f"0x83 shows {last.rpm} rpm of wheels that count nothing", rover.peer.evidence())


REPORTS_AT_REST = 6
"""Over 1.25 s: a wheel without a slot for a second stands (manual, chapter on the tachometers)."""

FASTEST_RPM = 1000.0
"""A tachometer takes what is faster for a wrong pulse (manual, chapter on the tachometers)."""


TURNING_COUNTS = 4
"""From one 0x83 to the next, of a wheel that has turned long enough for a median of three. A choice."""


def _require_in_step(reports: Sequence[MotionReport], rover: Rover) -> None:
    """Require that a wheel counts nothing between reports in which it stands, and stands in none amid its counting."""
    for before, now, after in zip(reports, reports[1:], reports[2:], strict=False):
        for wheel in range(4):
            risen, later = now.ticks[wheel] - before.ticks[wheel], after.ticks[wheel] - now.ticks[wheel]
            if not before.rpm[wheel] and not now.rpm[wheel] and abs(risen) > COUNTS:
                text = f"wheel {wheel + 1} stands in two 0x83, and counts {risen} between them"
                raise Violation(text, rover.peer.evidence())
            if min(risen, later) >= TURNING_COUNTS and not now.rpm[wheel]:
                text = f"wheel {wheel + 1} stands in a 0x83, and counts {risen} before it and {later} behind it"
                raise Violation(text, rover.peer.evidence())


LENGTH = 1e-3
"""How far the length of a quaternion of 32-bit floats may be off. A choice."""

RANGES = {
    "acceleration": (2 * 9.80665, "m/s^2"),
    "rate_deg_s": (250.0, "deg/s"),
    "field_mgauss": (49_120.0, "mG"),
}
"""Full scales as the firmware sets them: 2 g, 250 deg/s, 4912 uT (manual, chapter on the inertial sensor)."""

MPU_READ = 1
"""Bit of the validity in 0x82."""

NEXT_GENERAL_S = 0.6
"""0x80 comes three times a second (P30)."""

TEMPERATURE_C = -40.0, 85.0
"""In which the sensor works (PS-MPU-9250A-01, section 3.4.2)."""


@on_rover("P84", lasts_s=2.0)
def test_figures_of_the_inertial_sensor_are_possible(rover: Rover) -> None:
    report = _measured(rover)
    status = rover.next(GeneralReport, NEXT_GENERAL_S).status
    if report.validity & MPU_READ and (status or 0) & StatusFlag.AHRS_FAIL:
        text = f"STATUS is {status:02X}: the inertial sensor has failed; byte 1 of 0x82, {report.validity}: it was read"
        raise Violation(text, rover.peer.evidence())
    for field, (most, unit) in RANGES.items():
        for axis, value in zip("xyz", getattr(report, field), strict=True):
            within(value, -most, most, unit=unit, what=f"{field} along {axis} in 0x82")
    within(report.temperature_c, *TEMPERATURE_C, unit="C", what="temperature in 0x82")
    _require_no_trace(rover, report.temperature_c, "temperature in 0x82")
    if not any(report.quaternion):
        raise Inconclusive("0x82 has zeros for the attitude")
    near(math.hypot(*report.quaternion), 1.0, LENGTH, unit="", what="length of the quaternion in 0x82")


TRACE = 1e-9
"""Far less than a step of any sensor here: what is less and not 0 is a number whose bytes are in a wrong order."""


def _require_no_trace(rover: Rover, value: float, what: str) -> None:
    if 0 < abs(value) < TRACE:
        raise Violation(f"{what} is {value:g}", rover.peer.evidence())


@on_rover("P93", lasts_s=1.5)
def test_a_place_of_the_earth(rover: Rover) -> None:
    report = rover.next(GpsReport, NEXT_GPS_S)
    for what, value, most in (("first", report.first_deg, 90.0), ("second", report.second_deg, 180.0)):
        within(value, -most, most, unit="deg", what=f"{what} figure of 0x84")
        _require_no_trace(rover, value, f"{what} figure of 0x84")


NEXT_GPS_S = 1.2
"""0x84 comes once a second (P30)."""
