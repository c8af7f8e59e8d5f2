"""What it says in NMEA: forms, values, order (GPS.G6-SW-10018, "NMEA Protocol"; outputs of modules with 7.03)."""

from __future__ import annotations

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.parts.neo6m import nmea
from targets.parts.neo6m.geodesy import Geodetic
from targets.parts.neo6m.gps_time import Utc
from targets.parts.neo6m.sky import NONE, Dops, Satellite
from targets.parts.neo6m.solution import Fix, Motion, Solution
from tests.each import each

NOTHING = [
    b"$GPRMC,,V,,,,,,,,,,N*53\r\n",
    b"$GPVTG,,,,,,,,,N*30\r\n",
    b"$GPGGA,,,,,,0,00,99.99,,,,,,*48\r\n",
    b"$GPGSA,A,1,,,,,,,,,,,,,99.99,99.99,99.99*30\r\n",
    b"$GPGSV,1,1,00*79\r\n",
    b"$GPGLL,,,,,,V,N*64\r\n",
]
BOOT = [
    b"$GPTXT,01,01,02,u-blox ag - www.u-blox.com*50\r\n",
    b"$GPTXT,01,01,02,HW  UBX-G60xx  00040007 FF7FFFFFp*53\r\n",
    b"$GPTXT,01,01,02,ROM CORE 7.03 (45969) Mar 17 2011 16:18:34*59\r\n",
    b"$GPTXT,01,01,02,ANTSUPERV=AC SD PDoS SR*20\r\n",
    b"$GPTXT,01,01,02,ANTSTATUS=DONTKNOW*33\r\n",
]
M = 1852 * 60 * 180 / math.pi


def _solution(**changes) -> Solution:
    """That of the examples in the protocol specification, near Zurich."""
    place = Geodetic(
        latitude_deg=47 + changes.pop("minutes_n", 17.11437) / 60,
        longitude_deg=8 + changes.pop("minutes_e", 33.91522) / 60,
        height_m=547.6,
    )
    speed, course = 0.004 * 1852 / 3600, math.radians(77.52)
    motion = Motion(
        place=place,
        ecef_m=(0, 0, 0),
        enu_m_s=(speed * math.sin(course), speed * math.cos(course), 0),
        ecef_m_s=(0, 0, 0),
        course_deg=77.52,
        course_frozen=False,
    )
    used = [Satellite(number=n, elevation_deg=1, azimuth_deg=1, cn0_dbhz=40) for n in (23, 29, 7, 8, 9, 18, 26, 28)]
    hour, minute, second = changes.pop("at", (8, 35, 59))
    values = {
        "gps_ns": 0,
        "utc": Utc(year=2002, month=12, day=9, hour=hour, minute=minute, second=second, nano=0),
        "time_known": True,
        "fix": Fix.FIX_3D,
        "motion": motion,
        "tracked": tuple(used),
        "placed": True,
        "used": len(used),
        "dops": Dops(east=1.18, north=0.0, vertical=1.54, time=1.0),
        "metres_per_dop": 2.0,
        "speed_m_s": 0.1,
        "geoid_m": 48.0,
        "leap_seconds": 13,
        "first_fix_ms": 27000,
        "uptime_ms": 60000,
    }
    return Solution(**(values | changes))


# --- vectors


def test_the_examples_of_the_specification() -> None:
    assert nmea.rmc(_solution()) == b"$GPRMC,083559.00,A,4717.11437,N,00833.91522,E,0.004,77.52,091202,,,A*57\r\n"
    assert nmea.vtg(_solution()) == b"$GPVTG,77.52,T,,M,0.004,N,0.007,K,A*09\r\n"
    there = _solution(minutes_n=17.11364, minutes_e=33.91565, at=(9, 23, 21))
    assert nmea.gll(there) == b"$GPGLL,4717.11364,N,00833.91565,E,092321.00,A,A*60\r\n"
    assert nmea.gsa(_solution()) == b"$GPGSA,A,3,23,29,07,08,09,18,26,28,,,,,1.94,1.18,1.54*0D\r\n"


def test_time_and_date() -> None:
    assert nmea.zda(_solution()) == nmea.sentence("GPZDA", "083559.00", "09", "12", "2002", "00", "00")
    assert nmea.zda(_solution(time_known=False)) == nmea.sentence("GPZDA", "", "", "", "", "00", "00")


def test_the_datum_and_the_errors() -> None:
    assert nmea.dtm(_solution()) == b"$GPDTM,W84,,0.0,N,0.0,E,0.0,W84*6F\r\n"
    assert nmea.gst(_solution()) == nmea.sentence("GPGST", "083559.00", "2.0", "", "", "", "0.0", "2.4", "3.1")
    assert nmea.gbs(_solution()) == nmea.sentence("GPGBS", "083559.00", "0.0", "2.4", "3.1", "", "", "", "")
    assert nmea.gst(_solution(fix=Fix.NONE)) == nmea.sentence("GPGST", "083559.00", *[""] * 7)
    assert nmea.gbs(_solution(fix=Fix.NONE)) == nmea.sentence("GPGBS", "083559.00", *[""] * 7)


def test_sentences_of_u_blox() -> None:
    position = "4717.11437,N,00833.91522,E"
    expected = f"PUBX,00,083559.00,{position},547.600,G3,2.4,3.1,0.007,77.52,0.000,,1.18,1.54,1.00,8,0,0"
    assert nmea.pubx_00(_solution(motion=_solution().motion)) == nmea.sentence(*expected.split(","))
    lost = nmea.pubx_00(_solution(fix=Fix.NONE, used=0, dops=NONE, time_known=False)).decode().split(",")
    assert (len(lost), lost[8], lost[2:7]) == (21, "NF", [""] * 5)
    satellites = nmea.pubx_03(_solution(tracked=_solution().tracked[:2], used=1)).decode()
    assert satellites.startswith("$PUBX,03,02,23,U,001,01,40,060,29,-,001,01,40,060*")
    # 2002-12-09 08:35:59 UTC, a Monday, in week 1196, with 13 leap seconds
    gps_ns = (1196 * 7 * 86400 + 86400 + 8 * 3600 + 35 * 60 + 59 + 13) * 10**9
    expected = "PUBX,04,083559.00,091202,117359.00,1196,13,0,0.000,21,"
    assert nmea.pubx_04(_solution(gps_ns=gps_ns)) == nmea.sentence(*expected.split(","))
    assert nmea.pubx_04(_solution(time_known=False)).startswith(b"$PUBX,04,,,,,13D,0,0.000,21,*")


def test_the_example_of_gsv() -> None:
    seen = [(23, 38, 230, 44), (29, 71, 156, 47), (7, 29, 116, 41), (8, 9, 81, 36), (10, 7, 189, 0), (5, 5, 220, 0)]
    seen += [(9, 34, 274, 42), (18, 25, 309, 44), (26, 82, 187, 47), (28, 43, 56, 46)]
    shown = [Satellite(number=n, elevation_deg=e, azimuth_deg=a, cn0_dbhz=c) for n, e, a, c in seen]
    lines = nmea.gsv(_solution(tracked=tuple(shown))).splitlines(keepends=True)
    assert lines[0] == b"$GPGSV,3,1,10,23,38,230,44,29,71,156,47,07,29,116,41,08,09,081,36*7F\r\n"
    assert lines[2] == b"$GPGSV,3,3,10,26,82,187,47,28,43,056,46*77\r\n"


def test_gga_has_the_height_above_the_sea() -> None:
    there = _solution(minutes_n=17.11399, minutes_e=33.91590, at=(9, 27, 25))
    expected = "GPGGA,092725.00,4717.11399,N,00833.91590,E,1,08,1.18,499.6,M,48.0,M,,"
    assert nmea.gga(there) == nmea.sentence(*expected.split(","))


def test_everything_is_empty_before_anything_is_known(make_gps) -> None:
    gps = make_gps(start="cold")
    gps.run(1.2)
    assert gps.take().splitlines(keepends=True) == BOOT + NOTHING


@each(
    ("degrees", "expected"),
    [(-34.6175, "3437.05000"), (0.0, "0000.00000"), (59.999999999, "6000.00000"), (-0.000001, "0000.00006")],
)
def test_minutes_never_reach_sixty(degrees, expected) -> None:
    assert nmea._angle(degrees, 2, "NS") == (expected, "S" if degrees < 0 else "N")


@given(st.floats(-180, 180))
def test_angles_can_be_read_back(degrees) -> None:
    text, letter = nmea._angle(degrees, 3, "EW")
    assert len(text) == 11
    back = (int(text[:3]) + float(text[3:]) / 60) * (1 if letter == "E" else -1)
    assert back == pytest.approx(degrees, abs=0.51e-5 / 60)


@given(
    st.lists(
        st.text(st.characters(min_codepoint=32, max_codepoint=126, exclude_characters="*$,"), max_size=9), min_size=1
    )
)
def test_sentences_can_be_read_back(fields) -> None:
    assert nmea.parse_sentence(nmea.sentence(*fields).rstrip()) == fields


@each("line", [b"", b"$", b"$GPGGA", b"$GPGGA*", b"$GPGGA*00", b"$GPGGA*zz", b"GPGGA*56", b"$\xff*FF"])
def test_what_is_no_sentence(line) -> None:
    assert nmea.parse_sentence(line) is None


def test_checksums_in_small_letters_are_taken() -> None:
    assert nmea.parse_sentence(b"$PUBX,40,GLL,0,0,0,0,0,0*5c") is not None


# --- from the bench


def test_a_set_comes_every_second_in_the_order_of_the_firmware(gps) -> None:
    gps.run(2)
    names = [fields[0][2:] for fields in gps.lines()]
    assert names == ["RMC", "VTG", "GGA", "GSA", "GSV", "GSV", "GSV", "GLL"] * 2


def test_time_is_that_of_the_bench(make_gps) -> None:
    gps = make_gps(utc="2023-12-31T23:59:57")
    gps.run_to(4.5)
    lines = [fields for fields in gps.lines() if fields[0] == "GPRMC"]
    assert [fields[1] for fields in lines] == ["235958.00", "235959.00", "000000.00", "000001.00"]
    assert [fields[9] for fields in lines] == ["311223", "311223", "010124", "010124"]


def test_a_solution_goes_out_a_latency_after_its_moment(make_gps) -> None:
    gps = make_gps(utc="2021-09-10T12:00:00.3", latency_ms=60)
    gps.run_to(4)
    times_ns = [ns for ns, _ in gps.bench.sent[1:]]
    assert times_ns == [700_000_000 + 60_000_000 + tick * 1_000_000_000 for tick in range(4)]


def test_the_origin_is_where_the_settings_say(gps) -> None:
    gps.run(1)
    gga = gps.last("GPGGA")
    assert gga[2:6] == ["3437.05000", "S", "05822.09800", "W"]
    assert gga[9:13] == ["20.0", "M", "16.0", "M"]


@pytest.mark.parametrize(
    ("bearing", "vx", "vy", "course"), [(90, 1, 0, 90), (90, 0, 1, 0), (0, 1, 0, 0), (0, 0, 1, 270)]
)
def test_a_known_path_to_the_resolution_of_the_format(make_gps, bearing, vx, vy, course) -> None:
    """1 m/s along an axis of the world: course and speed, and the place to half a unit of the last digit."""

    def moving(ns):
        return {"x": vx * ns / 1e9, "y": vy * ns / 1e9, "z": 0.0, "vx": vx, "vy": vy, "vz": 0.0}

    gps = make_gps(moving, x_axis_bearing_deg=bearing)
    gps.run_to(100.5)
    lines = gps.lines()
    vtg = [fields for fields in lines if fields[0] == "GPVTG"][-1]
    assert float(vtg[1]) == pytest.approx(course % 360, abs=0.005) or float(vtg[1]) == 360.0
    assert (vtg[5], vtg[7]) == ("1.944", "3.600")
    north_m = 100 * math.cos(math.radians(course))
    east_m = 100 * math.sin(math.radians(course))
    sine = math.sin(math.radians(34.6175))
    e2 = 0.00669437999014
    meridian = 6378137 * (1 - e2) / (1 - e2 * sine**2) ** 1.5 + 36
    ring = (6378137 / math.sqrt(1 - e2 * sine**2) + 36) * math.sqrt(1 - sine**2)
    gga = [fields for fields in lines if fields[0] == "GPGGA"][-1]
    south = 34 * 60 + 37.05 - math.degrees(north_m / meridian) * 60
    west = 58 * 60 + 22.098 - math.degrees(east_m / ring) * 60
    assert int(gga[2][:2]) * 60 + float(gga[2][2:]) == pytest.approx(south, abs=0.8e-5)
    assert int(gga[4][:3]) * 60 + float(gga[4][3:]) == pytest.approx(west, abs=0.8e-5)


def test_solutions_are_of_their_moment_and_not_of_a_step(make_gps) -> None:
    """At 3.6 km/h within a step of 0.3 s: the place at the full second."""
    gps = make_gps(lambda ns: {"x": ns / 1e9, "y": 0, "z": 0, "vx": 1, "vy": 0, "vz": 0}, step_ns=300_000_000)
    gps.run_to(3.5)
    west = gps.last("GPGGA")[4]
    east_m = (22.098 - float(west[3:])) / 60 * math.pi / 180 * 6378137 * math.cos(math.radians(34.6175))
    assert east_m == pytest.approx(3.0, abs=0.03)


def test_a_course_is_frozen_and_not_told_while_it_stands(make_gps) -> None:
    """East at first; then the last course stays in UBX, and NMEA has none."""
    gps = make_gps(lambda ns: {"x": 0, "y": 0, "z": 0, "vx": 1.0 if ns < 4 * 10**9 else 0.0, "vy": 0, "vz": 0})
    gps.run_to(6.5)
    assert struct.unpack("<I3iIIiII", gps.poll(0x01, 0x12))[6] == 90 * 10**5
    lines = {fields[0]: fields for fields in gps.lines()}
    assert lines["GPVTG"] == ["GPVTG", "", "T", "", "M", "0.000", "N", "0.000", "K", "A"]
    assert lines["GPRMC"][8] == ""


# --- errors


def test_errors_have_the_size_of_the_data_sheet(make_gps) -> None:
    """Half of the positions are within 2.5 m; neighbours are much alike."""
    gps = make_gps(exact=False, correlation_s=0.5, noise_m=0)
    gps.run_to(400)
    found = []
    for fields in gps.lines():
        if fields[0] == "GPGGA" and fields[6] == "1":
            north = -(float(fields[2][2:]) - 37.05) / 60 * math.pi / 180 * 6356752
            east = -(float(fields[4][3:]) - 22.098) / 60 * math.pi / 180 * 6378137 * math.cos(math.radians(34.6175))
            found.append(math.hypot(north, east))
    assert len(found) > 390
    assert sum(error < 2.5 for error in found) / len(found) == pytest.approx(0.5, abs=0.08)


def test_errors_wander_slowly(make_gps) -> None:
    gps = make_gps(exact=False)
    gps.run_to(60)
    norths = [float(f[2][2:]) * 1852 for f in gps.lines() if f[0] == "GPGGA" and f[6] == "1"]
    steps = [abs(b - a) for a, b in zip(norths[1:], norths, strict=False)]
    assert max(steps) < 2.5
    assert sum(steps) / len(steps) < 0.5


def test_speed_errors(make_gps) -> None:
    """Half of them within 0.1 m/s."""
    gps = make_gps(exact=False)
    gps.run_to(400)
    speeds = [float(fields[7]) * 1852 / 3600 for fields in gps.lines() if fields[0] == "GPRMC" and fields[2] == "A"]
    assert sum(speed < 0.1 for speed in speeds) / len(speeds) == pytest.approx(0.5, abs=0.08)


@each("step_ns", [4_000_000, 33_000_000])
def test_what_is_said_does_not_depend_on_the_steps(make_gps, step_ns) -> None:
    def said(step):
        moving = {"x": 5.0, "y": 7.0, "z": 0.0, "vx": 0.0, "vy": 0.0, "vz": 0.0}
        gps = make_gps(lambda _ns: moving, exact=False, step_ns=step)
        gps.run_to(6)
        return gps.bench.sent

    assert said(step_ns) == said(10_000_000)


def test_dilution_without_a_fix_is_the_greatest() -> None:
    assert nmea.gsa(_solution(fix=Fix.NONE, used=0, dops=NONE)) == NOTHING[3]
