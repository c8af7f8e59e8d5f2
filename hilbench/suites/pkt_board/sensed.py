"""What the rover makes of what its sensors are given to sense: each figure of it, and that of now."""

from __future__ import annotations

from collections.abc import Sequence

from hilbench.check import Violation, near
from hilbench.suites._rover import Rover, on_rover
from protocols.pkt import GpsReport, ImuReport, Position
from targets.robots.rover import Sensed

FLOAT32 = 1e-6
"""Of a figure, as a share: more than 32 bits round it by. A choice."""

BOTH_READ = 3
"""Bits 0 and 1 of the validity: the MPU9250 and its magnetometer were read."""

SENSED = (
    Sensed(
        acceleration_m_s2=(1.5, -2.5, 9.5),
        rate_deg_s=(10.0, -20.0, 30.0),
        field_mgauss=(120.0, -60.0, 310.0),
        temperature_c=31.5,
        attitude_wxyz=(0.8, 0.2, -0.4, 0.4),
    ),
    Sensed(
        acceleration_m_s2=(-3.5, 4.5, -8.0),
        rate_deg_s=(-15.0, 25.0, -5.0),
        field_mgauss=(-210.0, 90.0, -33.0),
        temperature_c=-7.25,
        attitude_wxyz=(0.4, -0.4, 0.2, 0.8),
    ),
    Sensed(
        acceleration_m_s2=(6.0, 7.0, 3.0),
        rate_deg_s=(40.0, 50.0, -60.0),
        field_mgauss=(75.0, 180.0, 240.0),
        temperature_c=18.0,
        attitude_wxyz=(0.2, 0.8, 0.4, -0.4),
    ),
)
"""No two figures that are alike, none of 0, and each with either sign."""

PLACES = (
    Position(latitude_deg=-34.6037, longitude_deg=-58.3816),
    Position(latitude_deg=48.1374, longitude_deg=11.5755),
    Position(latitude_deg=-33.8688, longitude_deg=151.2093),
)

NEXT_WITHIN_S = 1.2
"""0x82 and 0x84 come once a second (P30)."""


@on_rover("P86", lasts_s=4.5)
def test_figures_of_the_inertial_sensor(rover: Rover) -> None:
    rover.next(ImuReport, NEXT_WITHIN_S)  # the next one is made of what is sensed from now on
    for sensed in SENSED:
        rover.hands.sense(sensed)
        _require_sensed(rover.next(ImuReport, NEXT_WITHIN_S), sensed)


def _require_sensed(report: ImuReport, sensed: Sensed) -> None:
    assert report.validity == BOTH_READ, f"byte 1 of 0x82 is {report.validity}, required {BOTH_READ}"
    w, *xyz = sensed.attitude_wxyz
    sign = 1.0 if report.quaternion[3] * w > 0 else -1.0
    for what, unit, shown, true in (
        ("acceleration", "m/s^2", report.acceleration, sensed.acceleration_m_s2),
        ("rate", "deg/s", report.rate_deg_s, sensed.rate_deg_s),
        ("field", "mG", report.field_mgauss, sensed.field_mgauss),
        ("temperature", "C", (report.temperature_c,), (sensed.temperature_c,)),
        ("quaternion", "", report.quaternion, [sign * part for part in (*xyz, w)]),
    ):
        _require_near(what, unit, shown, true)


def _require_near(what: str, unit: str, shown: Sequence[float], true: Sequence[float]) -> None:
    for number, (one, wanted) in enumerate(zip(shown, true, strict=True), start=1):
        near(one, wanted, FLOAT32 * max(1.0, abs(wanted)), unit=unit, what=f"{what}, figure {number}, in 0x82")


@on_rover("P87", lasts_s=5.5)
def test_positions_are_those_of_now(rover: Rover) -> None:
    rover.next(GpsReport, NEXT_WITHIN_S)
    for place in (*PLACES, None):
        rover.hands.place(place)
        report = rover.next(GpsReport, NEXT_WITHIN_S)
        if bool(report.validity) != (place is not None):
            text = f"byte 1 of 0x84 is {report.validity} with{'' if place else 'out'} a fix"
            raise Violation(text, rover.peer.evidence())
        if place is not None:
            shown = (report.first_deg, report.second_deg)
            for what, one, wanted in zip(
                ("latitude", "longitude"), shown, (place.latitude_deg, place.longitude_deg), strict=True
            ):
                near(one, wanted, FLOAT32 * abs(wanted), unit="deg", what=f"{what} in 0x84")
