"""NMEA 0183 version 2.3 sentences as a u-blox 6 writes them (GPS.G6-SW-10018, "NMEA Protocol", firmware 7.03)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from targets.parts.neo6m.gps_time import week_of
from targets.parts.neo6m.solution import Fix, Solution

__all__ = ["PUBX_SENTENCES", "SENTENCES", "parse_sentence", "sentence", "text"]

_KNOTS, _KM_H = 3600 / 1852, 3.6
_PER_GSV = 4
_CHANNELS = 12


def sentence(*fields: str) -> bytes:
    """Put fields together: ``$``, commas, ``*``, the exclusive or of all characters in between, CR LF."""
    body = ",".join(fields)
    check = 0
    for byte in body.encode("ascii"):
        check ^= byte
    return f"${body}*{check:02X}\r\n".encode("ascii")


def parse_sentence(line: bytes) -> list[str] | None:
    """Return the fields of a sentence without its end of line; None if its form or checksum is wrong."""
    body, star, check = line[1:].partition(b"*")
    if line[:1] != b"$" or not star or not body.isascii():
        return None
    fields = body.decode("ascii").split(",")
    return fields if sentence(*fields)[:-2].upper() == b"$" + body.upper() + b"*" + check.strip().upper() else None


def text(kind: int, words: str) -> bytes:
    """A GPTXT; the kind is 0 error, 1 warning, 2 notice, 7 user."""
    return sentence("GPTXT", "01", "01", f"{kind:02}", words)


def _time(now: Solution) -> str:
    utc = now.utc
    return f"{utc.hour:02}{utc.minute:02}{utc.second:02}.{utc.nano // 10_000_000:02}" if now.time_known else ""


def _date(now: Solution) -> str:
    return f"{now.utc.day:02}{now.utc.month:02}{now.utc.year % 100:02}" if now.time_known else ""


def _angle(degrees: float, width: int, ends: str) -> tuple[str, str]:
    """Degrees and minutes with five decimals, and the letter of the half of the globe."""
    hundred_thousandths = round(abs(degrees) * 60 * 100_000)
    whole, minutes = divmod(hundred_thousandths, 60 * 100_000)
    return f"{whole:0{width}}{minutes // 100_000:02}.{minutes % 100_000:05}", ends[degrees < 0]


def _position(now: Solution) -> tuple[str, str, str, str]:
    if not now.fix:
        return "", "", "", ""
    place = now.motion.place
    return *_angle(place.latitude_deg, 2, "NS"), *_angle(place.longitude_deg, 3, "EW")


def _course(now: Solution) -> str:
    """A frozen course is not told."""
    motion = now.motion
    return f"{round(motion.course_deg, 2) % 360:.2f}" if now.fix and not motion.course_frozen else ""


def _speed(now: Solution, per_m_s: float) -> str:
    return f"{now.motion.ground_m_s * per_m_s:.3f}" if now.fix else ""


def _status(now: Solution) -> str:
    return "A" if now.fix else "V"


def _mode(now: Solution) -> str:
    return "A" if now.fix else "N"


def rmc(now: Solution) -> bytes:
    """Recommended minimum."""
    speed = _speed(now, _KNOTS)
    return sentence(
        "GPRMC", _time(now), _status(now), *_position(now), speed, _course(now), _date(now), "", "", _mode(now)
    )


def vtg(now: Solution) -> bytes:
    """Course and speed over ground; the letters of the units are left out without a fix."""
    if not now.fix:
        return sentence("GPVTG", *[""] * 8, "N")
    return sentence("GPVTG", _course(now), "T", "", "M", _speed(now, _KNOTS), "N", _speed(now, _KM_H), "K", _mode(now))


def gga(now: Solution) -> bytes:
    """Fix data."""
    head = ("GPGGA", _time(now), *_position(now), "1" if now.fix else "0", f"{min(now.used, _CHANNELS):02}")
    horizontal = f"{now.dops.horizontal:.2f}" if now.fix else "99.99"
    if not now.fix:
        return sentence(*head, horizontal, "", "", "", "", "", "")
    above_sea_m = now.motion.place.height_m - now.geoid_m
    return sentence(*head, horizontal, f"{above_sea_m:.1f}", "M", f"{now.geoid_m:.1f}", "M", "", "")


def gsa(now: Solution) -> bytes:
    """Satellites in use and their geometry."""
    used = [f"{one.number:02}" for one in now.tracked[: min(now.used, _CHANNELS)]]
    dops = (now.dops.position, now.dops.horizontal, now.dops.vertical) if now.fix else (99.99,) * 3
    kind = {Fix.NONE: "1", Fix.FIX_2D: "2", Fix.FIX_3D: "3"}[now.fix]
    return sentence("GPGSA", "A", kind, *used, *[""] * (_CHANNELS - len(used)), *(f"{dop:.2f}" for dop in dops))


def gsv(now: Solution) -> bytes:
    """Satellites in view, four a sentence."""
    seen = now.tracked
    pages = max(1, -(-len(seen) // _PER_GSV))
    found = b""
    for page in range(pages):
        fields = ["GPGSV", str(pages), str(page + 1), f"{len(seen):02}"]
        for one in seen[page * _PER_GSV : (page + 1) * _PER_GSV]:
            where = (f"{one.elevation_deg:02}", f"{one.azimuth_deg:03}") if now.placed else ("", "")
            fields += [f"{one.number:02}", *where, f"{one.cn0_dbhz:02}"]
        found += sentence(*fields)
    return found


def gll(now: Solution) -> bytes:
    """Latitude and longitude."""
    return sentence("GPGLL", *_position(now), _time(now), _status(now), _mode(now))


def zda(now: Solution) -> bytes:
    """Time and date."""
    if not now.time_known:
        return sentence("GPZDA", "", "", "", "", "00", "00")
    utc = now.utc
    return sentence("GPZDA", _time(now), f"{utc.day:02}", f"{utc.month:02}", f"{utc.year:04}", "00", "00")


def gst(now: Solution) -> bytes:
    """Standard deviations of the position; the ellipse of the error is left out."""
    if not now.fix:
        return sentence("GPGST", _time(now), *[""] * 7)
    dops = (now.dops.north, now.dops.east, now.dops.vertical)
    errors = (f"{now.metres_per_dop * dop:.1f}" for dop in dops)
    return sentence("GPGST", _time(now), f"{now.metres_per_dop:.1f}", "", "", "", *errors)


def gbs(now: Solution) -> bytes:
    """Expected errors; no satellite is suspected."""
    dops = (now.dops.north, now.dops.east, now.dops.vertical)
    errors = [f"{now.metres_per_dop * dop:.1f}" for dop in dops] if now.fix else [""] * 3
    return sentence("GPGBS", _time(now), *errors, "", "", "", "")


def dtm(now: Solution) -> bytes:  # noqa: ARG001
    """The datum is WGS 84 always."""
    return sentence("GPDTM", "W84", "", "0.0", "N", "0.0", "E", "0.0", "W84")


def pubx_00(now: Solution) -> bytes:
    """Position of u-blox: height above the ellipsoid, kind of fix, accuracies, km/h, speed downwards."""
    status = {Fix.NONE: "NF", Fix.FIX_2D: "G2", Fix.FIX_3D: "G3"}[now.fix]
    dops = (now.dops.horizontal, now.dops.vertical, now.dops.time)
    tail = [f"{min(dop, 99.99):.2f}" for dop in dops] + [str(now.used), "0", "0"]
    if not now.fix:
        return sentence("PUBX", "00", _time(now), *[""] * 4, "0.000", status, *[""] * 6, *tail)
    height, down = f"{now.motion.place.height_m:.3f}", f"{-now.motion.enu_m_s[2]:.3f}"
    accuracies = (f"{now.horizontal_m:.1f}", f"{now.vertical_m:.1f}")
    moving = (_speed(now, _KM_H), _course(now), down, "")
    return sentence("PUBX", "00", _time(now), *_position(now), height, status, *accuracies, *moving, *tail)


def pubx_03(now: Solution) -> bytes:
    """Satellites: number, U used or - not, azimuth, elevation, strength, seconds of lock (64 at most)."""
    fields: list[str] = []
    for index, one in enumerate(now.tracked):
        where = (f"{one.azimuth_deg:03}", f"{one.elevation_deg:02}") if now.placed else ("", "")
        used = "U" if index < now.used else "-"
        lock = min(64, now.uptime_ms // 1000)
        fields += [f"{one.number:02}", used, *where, f"{one.cn0_dbhz:02}", f"{lock:03}"]
    return sentence("PUBX", "03", f"{len(now.tracked):02}", *fields)


def pubx_04(now: Solution) -> bytes:
    """Time: of day, date, of week, week, leap seconds (D: not from a satellite), and an ideal clock."""
    if not now.time_known:
        return sentence("PUBX", "04", *["", "", "", ""], f"{now.leap_seconds}D", "0", "0.000", "21", "")
    utc_ns = now.gps_ns - now.leap_seconds * 1_000_000_000
    seconds, left_ns = divmod(utc_ns % (7 * 86_400 * 1_000_000_000), 1_000_000_000)
    of_week = f"{seconds}.{left_ns // 10_000_000:02}"
    known = "" if now.fix else "D"
    week = str(week_of(utc_ns))
    return sentence(
        "PUBX", "04", _time(now), _date(now), of_week, week, f"{now.leap_seconds}{known}", "0", "0.000", "21", ""
    )


SENTENCES: Mapping[str, tuple[int, Callable[[Solution], bytes]]] = MappingProxyType(
    {
        "RMC": (0x04, rmc),
        "VTG": (0x05, vtg),
        "GGA": (0x00, gga),
        "GSA": (0x02, gsa),
        "GSV": (0x03, gsv),
        "GLL": (0x01, gll),
        "GST": (0x07, gst),
        "ZDA": (0x08, zda),
        "GBS": (0x09, gbs),
        "DTM": (0x0A, dtm),
    }
)
"""By name: message number in class 0xF0, and the writer; in the order in which firmware 7.03 sends those that are on at
start, the others behind them (choice)."""

PUBX_SENTENCES: Mapping[int, Callable[[Solution], bytes]] = MappingProxyType({0: pubx_00, 3: pubx_03, 4: pubx_04})
"""By message number in class 0xF1."""
