"""The inertial sensor: at rest, in turns, on a ramp, and mounted otherwise."""

from __future__ import annotations

import math
from collections.abc import Sequence

from hilbench.check import Violation, at_least, near
from hilbench.clock import NS_PER_MS
from hilbench.suites._rover_motion import Ride, on_bench
from hilbench.suites.rover_motion._judged import next_imu, ride
from protocols.pkt import ImuReport, acceleration_m_s2, attitude_wxyz
from protocols.pkt.units import STANDARD_GRAVITY_M_S2
from worlds.scenes.builtin import RAMP_FOOT_M, RAMP_SLOPE_RAD
from worlds.vehicles.rover_4wd import DEFAULTS

__all__ = ["ride"]

G = STANDARD_GRAVITY_M_S2
ZERO_G_XY, ZERO_G_Z, SENSITIVITY = 0.06, 0.08, 0.03
"""Tolerances of the accelerometer in g and of both scales (PS-MPU-9250A-01, sections 3.1 and 3.2)."""

NOISE_G = 0.01
"""Five times 300 ug/rtHz in a band of 45 Hz (the same, section 3.2)."""

REST_DEG_S = 0.5
"""The gyroscope has been calibrated at rest; its noise is 0.06 deg/s in a band of 41 Hz. A choice."""

RATE_DEG_S = 3.0
"""Noise, and what the rate changes by until the sensor's filter of 41 Hz has followed. A choice."""

READ_BEFORE_NS = 10 * NS_PER_MS
"""The sensor is read one turn of the loop before it is reported."""

ROOM_C = 25.0
FIELD_MGAUSS, FIELD_OFF_MGAUSS = 227.0, 40.0
"""WMM2020 at the scene's origin, and what is left after a calibration (assumed)."""

FIELD_NORTH_MGAUSS, FIELD_UP_MGAUSS = 172.7, 147.5
"""Of the same: what is level, towards magnetic north, and what points up."""

LEANING_G = ZERO_G_Z + SENSITIVITY + NOISE_G
"""Tolerance of the acceleration of a sensor that was mounted otherwise."""

VALID = 3
"""Inertial sensor and magnetometer were read."""

LEVEL_DEG, HEADING_DEG = 6.0, 12.0
"""Of a sensor whose zero is off by 60 mg and whose field is off by 2 uT; the estimate runs at 10 Hz. Choices."""


@on_bench("R14", lasts_s=1.3)
def test_inertial_sensor_at_rest(ride: Ride) -> None:
    ride.go(0.8)
    _, report = next_imu(ride)
    require_valid(report)
    *level, up = acceleration_m_s2(report, ride.dialect)
    for axis, value in zip("xy", level, strict=True):
        near(value, 0.0, (ZERO_G_XY + NOISE_G) * G, unit="m/s^2", what=f"acceleration along {axis} at rest")
    near(up, G, (ZERO_G_Z + SENSITIVITY + NOISE_G) * G, unit="m/s^2", what="acceleration along z at rest")
    for axis, value in zip("xyz", report.rate_deg_s, strict=True):
        near(value, 0.0, REST_DEG_S, unit="deg/s", what=f"rate about {axis} at rest")
    near(report.temperature_c, ROOM_C, 1.0, unit="C", what="temperature")
    field_mgauss = math.hypot(*report.field_mgauss)
    near(field_mgauss, FIELD_MGAUSS, FIELD_OFF_MGAUSS, unit="mG", what="strength of the magnetic field")


def require_valid(report: ImuReport) -> None:
    """Require both validity bits of a 0x82."""
    if report.validity != VALID:
        raise Violation(f"the validity byte of 0x82 is {report.validity}, required {VALID}")


@on_bench("R15", lasts_s=2.2, scene="hard-floor")
def test_gyroscope(ride: Ride) -> None:
    ride.go(0.8)
    ride.drive(-1.0, 1.0, 0.5)
    at_ns, report = next_imu(ride)
    true_deg_s = ride.at(at_ns - READ_BEFORE_NS).turn_deg_s
    at_least(true_deg_s, 60.0, unit="deg/s", what="rate of turn")
    tolerance = SENSITIVITY * true_deg_s + RATE_DEG_S
    for axis, value, true in zip("xyz", report.rate_deg_s, (0.0, 0.0, true_deg_s), strict=True):
        near(value, true, tolerance, unit="deg/s", what=f"rate about {axis} in a turn to the left")


def angles_deg(ride: Ride, report: ImuReport) -> tuple[float, float, float]:
    """Return roll, pitch and yaw that the attitude of a 0x82 stands for."""
    w, x, y, z = attitude_wxyz(report, ride.dialect)
    near(math.hypot(w, x, y, z), 1.0, 1e-3, unit="", what="length of the quaternion")
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return math.degrees(roll), math.degrees(pitch), math.degrees(yaw)


@on_bench("R16", lasts_s=2.1, scene="ramp")
def test_attitude_on_a_ramp(ride: Ride) -> None:
    """Nose up is a negative pitch: x forward, y left, z up."""
    half = DEFAULTS.wheelbase_m / 2
    ride.place(RAMP_FOOT_M + 1.0, 0.0, 0.0, (1.0 + half) * math.tan(RAMP_SLOPE_RAD) + 0.002)
    ride.go(0.8)
    for _ in range(2):
        _, report = next_imu(ride)
    roll, pitch, _ = angles_deg(ride, report)
    near(pitch, -math.degrees(RAMP_SLOPE_RAD), LEVEL_DEG, unit="deg", what="pitch on the ramp")
    near(roll, 0.0, LEVEL_DEG, unit="deg", what="roll on the ramp")
    wanted = (G * math.sin(RAMP_SLOPE_RAD), 0.0, G * math.cos(RAMP_SLOPE_RAD))
    for axis, value, true in zip("xyz", acceleration_m_s2(report, ride.dialect), wanted, strict=True):
        near(value, true, ZERO_G_Z * G + NOISE_G * G, unit="m/s^2", what=f"acceleration along {axis} on the ramp")


@on_bench("R17", lasts_s=4.2, scene="hard-floor")
def test_heading_after_a_turn(ride: Ride) -> None:
    """The scene's x axis looks to magnetic north, and so does the rover at first."""
    ride.go(0.8)
    ride.drive(-0.8, 0.8, 1.5)
    ride.drive(0.0, 0.0, 0.6)
    for _ in range(2):
        at_ns, report = next_imu(ride)
    true_deg = ride.at(at_ns).yaw_deg
    at_least(true_deg, 60.0, unit="deg", what="turn to the left")
    *_, yaw = angles_deg(ride, report)
    require_field(report, true_deg)
    off_deg = math.remainder(yaw - true_deg, 360)
    near(off_deg, 0.0, HEADING_DEG, unit="deg", what=f"heading beside the true {true_deg:.0f} degrees")


def require_field(report: ImuReport, yaw_deg: float) -> None:
    """Require the field that a level rover sees which looks so far to the left of magnetic north."""
    yaw_rad = math.radians(yaw_deg)
    ahead, left = FIELD_NORTH_MGAUSS * math.cos(yaw_rad), -FIELD_NORTH_MGAUSS * math.sin(yaw_rad)
    for axis, value, true in zip("xyz", report.field_mgauss, (ahead, left, FIELD_UP_MGAUSS), strict=True):
        near(value, true, FIELD_OFF_MGAUSS, unit="mG", what=f"field along {axis} at {yaw_deg:.0f} degrees")


def require_axes_of_a_turn(ride: Ride, up: Sequence[float]) -> None:
    """Turn to the left, and require gravity and the turn along the axis of the sensor that points upward."""
    ride.go(0.8)
    _, report = next_imu(ride)
    for axis, value, share in zip("xyz", acceleration_m_s2(report, ride.dialect), up, strict=True):
        near(value, share * G, LEANING_G * G, unit="m/s^2", what=f"acceleration along {axis} of a sensor that leans")
    ride.drive(-1.0, 1.0, 0.5)
    at_ns, report = next_imu(ride)
    true_deg_s = ride.at(at_ns - READ_BEFORE_NS).turn_deg_s
    at_least(true_deg_s, 60.0, unit="deg/s", what="rate of turn")
    for axis, value, share in zip("xyz", report.rate_deg_s, up, strict=True):
        tolerance = SENSITIVITY * true_deg_s + RATE_DEG_S
        near(value, share * true_deg_s, tolerance, unit="deg/s", what=f"rate about {axis} of a sensor that leans")


@on_bench("R27", lasts_s=2.2, scene="hard-floor", settings={"imu": {"mount_roll_deg": 90.0}})
def test_sensor_on_its_side(ride: Ride) -> None:
    require_axes_of_a_turn(ride, (0.0, 1.0, 0.0))


@on_bench("R27", lasts_s=2.2, scene="hard-floor", settings={"imu": {"mount_pitch_deg": 90.0}})
def test_sensor_on_its_nose(ride: Ride) -> None:
    require_axes_of_a_turn(ride, (-1.0, 0.0, 0.0))
