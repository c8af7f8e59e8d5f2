"""NMEA 0183 version 2.3 sentences as a u-blox 6 writes them (GPS.G6-SW-10018, "NMEA Protocol", firmware 7.03)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from targets.parts.neo6m.solution import Fix, Solution

__all__ = ["SENTENCES", "parse_sentence", "sentence", "text"]

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
    motion = now.motion
    known = now.fix and motion.ground_m_s >= now.course_from_m_s
    return f"{round(motion.course_deg, 2) % 360:.2f}" if known else ""


def _speed(now: Solution, per_m_s: float) -> str:
    return f"{now.motion.ground_m_s * per_m_s:.3f}" if now.fix else ""


def _status(now: Solution) -> str:
    return "A" if now.fix else "V"


def _mode(now: Solution) -> str:
    return "A" if now.fix else "N"


def rmc(now: Solution) -> bytes:
    """Recommended minimum."""
    utc = now.utc
    date = f"{utc.day:02}{utc.month:02}{utc.year % 100:02}" if now.time_known else ""
    speed = _speed(now, _KNOTS)
    return sentence("GPRMC", _time(now), _status(now), *_position(now), speed, _course(now), date, "", "", _mode(now))


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


SENTENCES: Mapping[str, tuple[int, Callable[[Solution], bytes]]] = MappingProxyType(
    {
        "RMC": (0x04, rmc),
        "VTG": (0x05, vtg),
        "GGA": (0x00, gga),
        "GSA": (0x02, gsa),
        "GSV": (0x03, gsv),
        "GLL": (0x01, gll),
        "ZDA": (0x08, zda),
    }
)
"""By name: message number in class 0xF0, and the writer; in the order in which firmware 7.03 sends them."""
