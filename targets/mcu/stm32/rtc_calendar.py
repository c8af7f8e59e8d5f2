"""The calendar of the RTC: seconds since the year 00 began, as fields in BCD; and when an alarm matches next.

Years are 00 to 99; every fourth, from 00 on, is a leap year (RM0410 section 32.3.4). The day of the week counts by
itself, from 1 to 7, whatever the date is.
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["DAY", "Alarm", "date_of", "date_register", "seconds_of", "time_of", "time_register"]

DAY = 86_400
_CYCLE_DAYS = 4 * 365 + 1
_ALL_DAYS = 25 * _CYCLE_DAYS
_LENGTHS = (31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31)
_PM = 1 << 22


def _bcd(value: int) -> int:
    return value // 10 << 4 | value % 10


def _binary(bcd: int) -> int:
    return 10 * (bcd >> 4) + (bcd & 0xF)


def _lengths(year: int) -> list[int]:
    return [length + (month == 1 and year % 4 == 0) for month, length in enumerate(_LENGTHS)]


def date_of(days: int) -> tuple[int, int, int]:
    """Return year, month from 1 and day from 1 of a number of days since 1 January 00; after 99 comes 00."""
    cycle, rest = divmod(days % _ALL_DAYS, _CYCLE_DAYS)
    year = 0 if rest < 366 else (rest - 1) // 365
    rest -= 365 * year + (year > 0)
    month, lengths = 1, _lengths(year)
    while rest >= lengths[month - 1]:
        rest -= lengths[month - 1]
        month += 1
    return 4 * cycle + year, month, rest + 1


def _days_of(year: int, month: int, day: int) -> int:
    cycle, year_in_cycle = divmod(year, 4)
    days = _CYCLE_DAYS * cycle + 365 * year_in_cycle + (year_in_cycle > 0)
    return days + sum(_lengths(year)[: month - 1]) + day - 1


def time_of(value: int, *, half_days: bool) -> int:
    """Return seconds of the day for RTC_TR; with hours of half a day, PM adds twelve."""
    hours = _binary(value >> 16 & 0x3F)
    if half_days:
        hours = hours % 12 + (12 if value & _PM else 0)
    return 3600 * hours + 60 * _binary(value >> 8 & 0x7F) + _binary(value & 0x7F)


def time_register(seconds: int, *, half_days: bool) -> int:
    """Return RTC_TR for a number of seconds."""
    minutes, second = divmod(seconds % DAY, 60)
    hours, minute = divmod(minutes, 60)
    half = 0
    if half_days:
        half = _PM if hours >= 12 else 0
        hours = hours % 12 or 12
    return half | _bcd(hours) << 16 | _bcd(minute) << 8 | _bcd(second)


def seconds_of(date: int, time: int, *, half_days: bool) -> tuple[int, int]:
    """Return seconds since the year 00 began for RTC_DR and RTC_TR, and the weekday, 0 to 6, of the first day of 00.

    Fields that are no date count on: 31 February is 2 or 3 March (choice).
    """
    month = max(1, min(12, _binary(date >> 8 & 0x1F)))
    days = _days_of(_binary(date >> 16 & 0xFF), month, max(1, _binary(date & 0x3F)))
    weekday = (date >> 13 & 7) - 1
    return days * DAY + time_of(time, half_days=half_days), (weekday - days) % 7


def date_register(seconds: int, first_weekday: int) -> int:
    """Return RTC_DR for a number of seconds."""
    days = seconds // DAY
    year, month, day = date_of(days)
    return _bcd(year) << 16 | (first_weekday + days) % 7 + 1 << 13 | _bcd(month) << 8 | _bcd(day)


@dataclass(frozen=True, slots=True)
class Alarm:
    """What an alarm waits for.

    Attributes:
        value: RTC_ALRMxR.
        sub_seconds: RTC_ALRMxSSR.
        half_days: hours are 1 to 12 and PM.
        first_weekday: see `seconds_of`.
    """

    value: int
    sub_seconds: int
    half_days: bool
    first_weekday: int

    def after(self, seconds: int, count: int, reload: int) -> tuple[int, int] | None:
        """Return the next moment that matches, later than this one, as seconds and sub-second count; None: never.

        Args:
            seconds: since the year 00 began.
            count: of the sub-second counter, which goes down.
            reload: what it begins a second with.
        """
        bits = self.sub_seconds >> 24 & 0xF
        if not bits:
            found = self._second_from(seconds + 1)
            return None if found is None else (found, reload)
        if self._second_from(seconds) == seconds and (later := self._count_below(count - 1, bits)) is not None:
            return seconds, later
        first, found = self._count_below(reload, bits), self._second_from(seconds + 1)
        return None if first is None or found is None else (found, first)

    def _count_below(self, count: int, bits: int) -> int | None:
        """Return the highest sub-second count up to `count` whose lower bits match."""
        found = count - (count - self.sub_seconds) % (1 << bits)
        return found if count >= 0 and found >= 0 else None

    def _second_from(self, seconds: int) -> int | None:
        """Return the first second from this one on that matches, within eight years."""
        day, rest = divmod(seconds, DAY)
        for later in range(day, day + 8 * 366):
            if self._is_day(later) and (found := self._time_from(rest if later == day else 0)) is not None:
                return later * DAY + found
        return None

    def _is_day(self, day: int) -> bool:
        value = self.value
        if value >> 31:
            return True
        if value >> 30 & 1:
            return (self.first_weekday + day) % 7 + 1 == value >> 24 & 0xF
        return date_of(day)[2] == _binary(value >> 24 & 0x3F)

    def _time_from(self, second: int) -> int | None:
        """Return the first second of the day from this one on that matches."""
        wanted = time_of(self.value, half_days=self.half_days)
        hours = range(24) if self.value >> 23 & 1 else (wanted // 3600,)
        minutes = range(60) if self.value >> 15 & 1 else (wanted // 60 % 60,)
        seconds = range(60) if self.value >> 7 & 1 else (wanted % 60,)
        for hour in hours:
            if 3600 * hour + 3599 < second:
                continue
            for minute in minutes:
                start = 3600 * hour + 60 * minute
                if start + 59 < second:
                    continue
                found = next((start + one for one in seconds if start + one >= second), None)
                if found is not None:
                    return found
        return None
