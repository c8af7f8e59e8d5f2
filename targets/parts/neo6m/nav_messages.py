"""The navigation messages of UBX (GPS.G6-SW-10018, section "NAV (0x01)"): what a solution looks like in each."""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from types import MappingProxyType

from targets.parts.neo6m.gps_time import time_of_week_ms, week_of
from targets.parts.neo6m.solution import Fix, Solution

__all__ = ["NAV", "NAV_MESSAGES"]

NAV = 0x01

_UNKNOWN_MM = 0xFFFFFFFF
_TIME_ACCURACY_NS = 30
"""NEO-6 data sheet table 2: accuracy of the time pulse, rms."""
_COURSE_ACCURACY_DEG = 0.5
"""NEO-6 data sheet table 2."""


def _tow(now: Solution) -> int:
    return time_of_week_ms(now.gps_ns) if now.time_known else 0


def _flags(now: Solution) -> int:
    """Fix valid, week valid, time of week valid; differential corrections never."""
    return (now.fix != Fix.NONE) | now.time_known << 2 | now.time_known << 3


def _mm(metres: float) -> int:
    return max(-(2**31), min(2**31 - 1, round(metres * 1000)))


def _accuracy(metres: float, now: Solution, unit: float) -> int:
    return min(_UNKNOWN_MM, round(metres / unit)) if now.fix else _UNKNOWN_MM


def _both_m(now: Solution) -> float:
    return float((now.horizontal_m**2 + now.vertical_m**2) ** 0.5)


def _cm(vector: tuple[float, float, float]) -> tuple[int, ...]:
    return tuple(_mm(part / 10) for part in vector)


def _dop(value: float) -> int:
    return min(9999, round(value * 100))


def posllh(now: Solution) -> bytes:
    """Latitude, longitude, heights, accuracies."""
    place = now.motion.place
    return struct.pack(
        "<IiiiiII",
        _tow(now),
        *((round(place.longitude_deg * 1e7), round(place.latitude_deg * 1e7)) if now.fix else (0, 0)),
        *((_mm(place.height_m), _mm(place.height_m - now.geoid_m)) if now.fix else (0, 0)),
        _accuracy(now.horizontal_m, now, 0.001),
        _accuracy(now.vertical_m, now, 0.001),
    )


def posecef(now: Solution) -> bytes:
    """Position in ECEF."""
    where = _cm(now.motion.ecef_m) if now.fix else (0, 0, 0)
    return struct.pack("<IiiiI", _tow(now), *where, _accuracy(_both_m(now), now, 0.01))


def velecef(now: Solution) -> bytes:
    """Velocity in ECEF."""
    speed = _cm(now.motion.ecef_m_s) if now.fix else (0, 0, 0)
    return struct.pack("<IiiiI", _tow(now), *speed, _accuracy(now.speed_m_s, now, 0.01))


def status(now: Solution) -> bytes:
    """Kind of fix, times of the first fix and since the start."""
    return struct.pack("<IBBBBII", _tow(now), now.fix, _flags(now), 0, 0, now.first_fix_ms, now.uptime_ms)


def dop(now: Solution) -> bytes:
    """Dilution of precision."""
    dops = now.dops
    values = (dops.geometric, dops.position, dops.time, dops.vertical, dops.horizontal, dops.north, dops.east)
    return struct.pack("<I7H", _tow(now), *(_dop(value) if now.fix else 9999 for value in values))


def sol(now: Solution) -> bytes:
    """Everything in ECEF."""
    none = (0, 0, 0)
    return struct.pack(
        "<IihBB3iI3iIHBBI",
        _tow(now),
        _left_ns(now),
        week_of(now.gps_ns) if now.time_known else 0,
        now.fix,
        _flags(now),
        *(_cm(now.motion.ecef_m) if now.fix else none),
        _accuracy(_both_m(now), now, 0.01),
        *(_cm(now.motion.ecef_m_s) if now.fix else none),
        _accuracy(now.speed_m_s, now, 0.01),
        _dop(now.dops.position) if now.fix else 9999,
        0,
        now.used,
        0,
    )


def velned(now: Solution) -> bytes:
    """Velocity to the north, to the east, down; speeds and course."""
    if not now.fix:
        return struct.pack("<I3iIIiII", _tow(now), *(0,) * 6, _UNKNOWN_MM, round(180e5))
    east, north, up = now.motion.enu_m_s
    speed = (east**2 + north**2 + up**2) ** 0.5
    return struct.pack(
        "<I3iIIiII",
        _tow(now),
        *_cm((north, east, -up)),
        round(speed * 100),
        round(now.motion.ground_m_s * 100),
        round(now.motion.course_deg * 1e5),
        _accuracy(now.speed_m_s, now, 0.01),
        round(_COURSE_ACCURACY_DEG * 1e5),
    )


def timegps(now: Solution) -> bytes:
    """GPS time: the leap seconds are known together with it (choice)."""
    known = now.time_known
    week = week_of(now.gps_ns) if known else 0
    accuracy = _TIME_ACCURACY_NS if now.fix else _UNKNOWN_MM
    return struct.pack("<IihbBI", _tow(now), _left_ns(now), week, now.leap_seconds, 7 if known else 0, accuracy)


def timeutc(now: Solution) -> bytes:
    """UTC."""
    utc, known = now.utc, now.time_known
    accuracy = _TIME_ACCURACY_NS if now.fix else _UNKNOWN_MM
    date = (utc.year, utc.month, utc.day, utc.hour, utc.minute, utc.second) if known else (1980, 1, 6, 0, 0, 0)
    return struct.pack("<IIiH6B", _tow(now), accuracy, utc.nano if known else 0, *date, 7 if known else 0)


def clock(now: Solution) -> bytes:
    """Bias and drift of the receiver's clock: none, it is ideal (choice)."""
    return struct.pack("<IiiII", _tow(now), 0, 0, _TIME_ACCURACY_NS if now.fix else _UNKNOWN_MM, 0)


def svinfo(now: Solution) -> bytes:
    """Satellites, one a channel."""
    found = struct.pack("<IBBH", _tow(now), len(now.tracked), 4, 0)
    for channel, one in enumerate(now.tracked):
        flags = (channel < now.used) | (0x04 | 0x08 if now.placed else 0)
        where = (one.elevation_deg, one.azimuth_deg) if now.placed else (-91, 0)
        found += struct.pack("<BBBBBbhi", channel, one.number, flags, 7, one.cn0_dbhz, *where, 0)
    return found


def _left_ns(now: Solution) -> int:
    """What the whole milliseconds of the time of week leave over."""
    left = now.gps_ns % 1_000_000
    return (left - 1_000_000 if left >= 500_000 else left) if now.time_known else 0


NAV_MESSAGES: Mapping[int, Callable[[Solution], bytes]] = MappingProxyType(
    {
        0x01: posecef,
        0x02: posllh,
        0x03: status,
        0x04: dop,
        0x06: sol,
        0x11: velecef,
        0x12: velned,
        0x20: timegps,
        0x21: timeutc,
        0x22: clock,
        0x30: svinfo,
    }
)
"""By number in class 0x01; each returns a payload."""
