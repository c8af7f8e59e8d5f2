"""Time as a GPS receiver has it: nanoseconds since the GPS epoch (1980-01-06 00:00:00), weeks, and the calendar of UTC.

The calendar is the proleptic Gregorian one, by the arithmetic of days that begins a year in March.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

__all__ = ["Utc", "gps_of_utc", "time_of_week_ms", "utc_of_gps", "week_of"]

_S = 1_000_000_000
_DAY_NS = 86_400 * _S
_WEEK_NS = 7 * _DAY_NS
_FORM = re.compile(r"(\d{4})-(\d\d)-(\d\d)T(\d\d):(\d\d):(\d\d)(?:\.(\d{1,9}))?")


@dataclass(frozen=True, slots=True, kw_only=True)
class Utc:
    """A moment in UTC; `nano` is what is left over after the second, 0..999999999."""

    year: int
    month: int
    day: int
    hour: int
    minute: int
    second: int
    nano: int


def gps_of_utc(text: str, leap_seconds: int) -> int:
    """Return nanoseconds since the GPS epoch for ``2021-09-10T12:00:00``, with a fraction if need be.

    Raises:
        ValueError: that is no moment after the GPS epoch.
    """
    found = _FORM.fullmatch(text)
    if found is None:
        raise ValueError("must look like 2021-09-10T12:00:00")
    year, month, day, hour, minute, second = map(int, found.groups()[:6])
    days = _days(year, month, day) - _GPS_EPOCH_DAYS
    if _date_of(days) != (year, month, day) or hour > 23 or minute > 59 or second > 59 or days < 0:
        raise ValueError("is no moment since 1980-01-06")
    nano = int((found.group(7) or "").ljust(9, "0"))
    return days * _DAY_NS + (hour * 3600 + minute * 60 + second + leap_seconds) * _S + nano


def utc_of_gps(gps_ns: int, leap_seconds: int) -> Utc:
    """Return the moment in UTC."""
    days, left_ns = divmod(gps_ns - leap_seconds * _S, _DAY_NS)
    year, month, day = _date_of(days)
    seconds, nano = divmod(left_ns, _S)
    minutes, second = divmod(seconds, 60)
    hour, minute = divmod(minutes, 60)
    return Utc(year=year, month=month, day=day, hour=hour, minute=minute, second=second, nano=nano)


def week_of(gps_ns: int) -> int:
    """Weeks since the GPS epoch, all of them: 2174 in September 2021."""
    return gps_ns // _WEEK_NS


def time_of_week_ms(gps_ns: int) -> int:
    """Milliseconds since the week began, rounded."""
    return (gps_ns % _WEEK_NS + 500_000) // 1_000_000


def _days(year: int, month: int, day: int) -> int:
    """Days since 0000-03-01."""
    years, months = (year, month - 3) if month > 2 else (year - 1, month + 9)
    return 365 * years + years // 4 - years // 100 + years // 400 + (153 * months + 2) // 5 + day - 1


_GPS_EPOCH_DAYS = _days(1980, 1, 6)


def _date_of(days_since_epoch: int) -> tuple[int, int, int]:
    days = days_since_epoch + _GPS_EPOCH_DAYS
    era, of_era = divmod(days, 146_097)
    years = (of_era - of_era // 1_460 + of_era // 36_524 - of_era // 146_096) // 365
    of_year = of_era - (365 * years + years // 4 - years // 100)
    months = (5 * of_year + 2) // 153
    day = of_year - (153 * months + 2) // 5 + 1
    month = months + 3 if months < 10 else months - 9
    return 400 * era + years + (month <= 2), month, day
