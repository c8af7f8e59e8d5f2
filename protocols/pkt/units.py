"""What the numbers of the reports mean, where code and manual disagree; and counters that wrap.

Sources: manual, 0x82 and 0x84; G2 at 6058e92, application.cpp `read_imu` and `send_gps_report`,
sensors/mpu9250_imu/mpu9250.cpp, sensors/mpu9250_imu/madwick.cpp.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass

from protocols.pkt.reports import EulerImuReport, Four, GeneralReport, GpsReport, ImuReport, Triple

__all__ = [
    "STANDARD_GRAVITY_M_S2",
    "AccelerationUnit",
    "Dialect",
    "PacketTotals",
    "Position",
    "PositionOrder",
    "QuaternionOrder",
    "acceleration_m_s2",
    "acceleration_raw",
    "attitude_wxyz",
    "gps_report",
    "position",
    "quaternion_raw",
    "unwrap",
]

STANDARD_GRAVITY_M_S2 = 9.80665
"""One g, by definition."""


class AccelerationUnit(enum.Enum):
    """The unit of the acceleration in 0x82."""

    G = "g (G2: mpu9250.cpp, 2 g over 32768 steps)"
    M_S2 = "m/s^2 (manual, 0x82)"


class QuaternionOrder(enum.Enum):
    """The order of the quaternion in 0x82."""

    WXYZ = "scalar first (G2: madwick.cpp, q1 to q4 as they are)"
    XYZW = "scalar last (manual, 0x82)"


class PositionOrder(enum.Enum):
    """The order of the position in 0x84."""

    LONGITUDE_FIRST = "longitude, latitude (G2: application.cpp `send_gps_report`)"
    LATITUDE_FIRST = "latitude, longitude (manual, 0x84)"


@dataclass(frozen=True, slots=True, kw_only=True)
class Dialect:
    """How the raw fields of the reports are understood where the sources disagree; the defaults are the code's."""

    acceleration: AccelerationUnit = AccelerationUnit.G
    quaternion: QuaternionOrder = QuaternionOrder.WXYZ
    position: PositionOrder = PositionOrder.LONGITUDE_FIRST


@dataclass(frozen=True, slots=True, kw_only=True)
class Position:
    """Where the rover is, in degrees; north and east are positive."""

    latitude_deg: float
    longitude_deg: float


_CODE = Dialect()


def acceleration_m_s2(report: ImuReport | EulerImuReport, dialect: Dialect = _CODE) -> Triple:
    """The acceleration along X, Y and Z, in m/s^2."""
    scale = STANDARD_GRAVITY_M_S2 if dialect.acceleration is AccelerationUnit.G else 1.0
    x, y, z = report.acceleration
    return (x * scale, y * scale, z * scale)


def acceleration_raw(acceleration: Triple, dialect: Dialect = _CODE) -> Triple:
    """The field `acceleration` for this one, given in m/s^2."""
    scale = STANDARD_GRAVITY_M_S2 if dialect.acceleration is AccelerationUnit.G else 1.0
    x, y, z = acceleration
    return (x / scale, y / scale, z / scale)


def attitude_wxyz(report: ImuReport, dialect: Dialect = _CODE) -> Four:
    """The attitude as a quaternion, scalar first."""
    if dialect.quaternion is QuaternionOrder.WXYZ:
        return report.quaternion
    x, y, z, w = report.quaternion
    return (w, x, y, z)


def quaternion_raw(attitude: Four, dialect: Dialect = _CODE) -> Four:
    """The field `quaternion` for this attitude, given scalar first."""
    if dialect.quaternion is QuaternionOrder.WXYZ:
        return attitude
    w, x, y, z = attitude
    return (x, y, z, w)


def position(report: GpsReport, dialect: Dialect = _CODE) -> Position:
    """Where the report says the rover is."""
    if dialect.position is PositionOrder.LONGITUDE_FIRST:
        return Position(latitude_deg=report.second_deg, longitude_deg=report.first_deg)
    return Position(latitude_deg=report.first_deg, longitude_deg=report.second_deg)


def gps_report(where: Position, dialect: Dialect = _CODE, *, validity: int = 0) -> GpsReport:
    """The report that says the rover is there."""
    first, second = where.latitude_deg, where.longitude_deg
    if dialect.position is PositionOrder.LONGITUDE_FIRST:
        first, second = second, first
    return GpsReport(validity=validity, first_deg=first, second_deg=second)


def unwrap(total: int, raw: int, modulus: int = 256) -> int:
    """The total that a counter modulo `modulus` stands for: the smallest not below the total known before.

    It is right as long as the counter is read more often than it wraps, and was not set back.
    """
    return total + (raw - total) % modulus


@dataclass(frozen=True, slots=True, kw_only=True)
class PacketTotals:
    """The rover's two counters, without their wrapping, since the first general report.

    Attributes:
        accepted: at least as large as what the last report says.
        rejected: as above.
    """

    accepted: int
    rejected: int

    @classmethod
    def of(cls, report: GeneralReport, before: PacketTotals | None = None) -> PacketTotals:
        """The totals after this report."""
        if before is None:
            return cls(accepted=report.accepted, rejected=report.rejected)
        return cls(accepted=unwrap(before.accepted, report.accepted), rejected=unwrap(before.rejected, report.rejected))
