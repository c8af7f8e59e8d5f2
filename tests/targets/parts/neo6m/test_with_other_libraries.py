"""What a receiver says and understands, by libraries that were not written for it: pynmeagps and pyubx2."""

from __future__ import annotations

import io

import pynmeagps
import pytest
import pyubx2
from hypothesis import given
from hypothesis import strategies as st

from targets.parts.neo6m import nmea, ubx
from targets.parts.neo6m.nav_messages import NAV, NAV_MESSAGES

PORT = {"portID": 1, "charLen": 3, "parity": 4, "inUBX": 1, "inNMEA": 1, "outUBX": 1, "outNMEA": 1}
BOTH = pyubx2.UBX_PROTOCOL | pyubx2.NMEA_PROTOCOL


def read(data):
    """Return all messages of both protocols; a byte that belongs to none is an error, and so is a wrong checksum."""
    reader = pyubx2.UBXReader(io.BytesIO(data), protfilter=BOTH, quitonerror=pyubx2.ERR_RAISE, validate=pyubx2.VALCKSUM)
    found = list(reader)
    assert b"".join(raw for raw, _ in found) == data
    return [message for _, message in found]


def setting(name, **fields):
    return pyubx2.UBXMessage("CFG", name, pyubx2.SET, **fields)


def moving(ns):
    return {"x": 3 * ns / 1e9, "y": -4 * ns / 1e9, "z": 0.0, "vx": 3.0, "vy": -4.0, "vz": 0.0}


@pytest.fixture
def said(make_gps):
    """Return a receiver that moves, and all it knows to say of one moment, by name; settings are the library's, too."""
    gps = make_gps(moving, x_axis_bearing_deg=90)
    gps.run_to(3.5)
    gps.say(setting("CFG-PRT", **PORT, baudRate=115200).serialize())
    numbers = [*((0xF0, number) for number, _ in nmea.SENTENCES.values()), *((0xF1, n) for n in nmea.PUBX_SENTENCES)]
    for group, number in (*numbers, *((NAV, number) for number in NAV_MESSAGES)):
        gps.take()
        gps.say(setting("CFG-MSG", msgClass=group, msgID=number, rateUART1=1).serialize())
        (answer,) = read(gps.take())
        assert (answer.identity, answer.clsID, answer.msgID) == ("ACK-ACK", 0x06, 0x01)
    gps.run_to(5.0 + 0.9)
    return {message.identity: message for message in read(gps.take())}


def test_everything_is_read_by_the_libraries(said):
    assert {name[2:] for name in said if name.startswith("GP")} == nmea.SENTENCES.keys()
    assert {name for name in said if name.startswith("PUBX")} == {f"PUBX0{number}" for number in nmea.PUBX_SENTENCES}
    assert len([name for name in said if name.startswith("NAV-")]) == len(NAV_MESSAGES)


def test_both_protocols_say_the_same_place(said):
    north_m, east_m = -4 * 5.0, 3 * 5.0
    latitude_deg = pytest.approx(-34.6175 + north_m / 111_000, abs=5e-7)
    longitude_deg = pytest.approx(-58.3683 + east_m / 91_660, abs=5e-7)
    for name in ("GPRMC", "GPGGA", "GPGLL", "PUBX00", "NAV-POSLLH"):
        assert (said[name].lat, said[name].lon) == (latitude_deg, longitude_deg), name
    assert (said["GPGGA"].alt, said["GPGGA"].sep, said["PUBX00"].altRef) == (20, 16, 36)
    assert (said["NAV-POSLLH"].hMSL, said["NAV-POSLLH"].height) == (20_000, 36_000)
    ecef_cm = [100 * part for part in pynmeagps.llh2ecef(said["NAV-POSLLH"].lat, said["NAV-POSLLH"].lon, 36.0)]
    for name in ("NAV-POSECEF", "NAV-SOL"):
        assert [said[name].ecefX, said[name].ecefY, said[name].ecefZ] == pytest.approx(ecef_cm, abs=2), name


def test_both_protocols_say_the_same_velocity(said):
    velocity = said["NAV-VELNED"]
    assert (velocity.velN, velocity.velE, velocity.velD, velocity.gSpeed) == (-400, 300, 0, 500)
    assert velocity.heading == pytest.approx(143.1301, abs=1e-4)
    assert said["GPRMC"].cog == said["GPVTG"].cogt == said["PUBX00"].COG == 143.13
    assert said["GPVTG"].sogk == said["PUBX00"].SOG == 18.0
    assert said["GPRMC"].spd == said["GPVTG"].sogn == pytest.approx(5 * 3600 / 1852, abs=5e-4)


def test_both_protocols_say_the_same_time(said):
    date, clock = "2021-09-10", "12:00:05"
    assert (str(said["GPRMC"].date), str(said["PUBX04"].date)) == (date, date)
    assert {str(said[name].time) for name in ("GPRMC", "GPGGA", "GPGLL", "GPZDA", "PUBX00", "PUBX04")} == {clock}
    utc = said["NAV-TIMEUTC"]
    assert (utc.year, utc.month, utc.day, utc.hour, utc.min, utc.sec) == (2021, 9, 10, 12, 0, 5)
    assert str(pyubx2.itow2utc(said["NAV-POSLLH"].iTOW)) == clock
    assert (said["NAV-TIMEGPS"].week, said["NAV-TIMEGPS"].leapS) == (2174, 18)


def test_both_protocols_say_the_same_satellites(said):
    seen = said["NAV-SVINFO"]
    of_ubx = [getattr(seen, f"svid_{number:02}") for number in range(1, seen.numCh + 1)]
    of_nmea = [getattr(said["GPGSA"], f"svid_{number:02}") for number in range(1, seen.numCh + 1)]
    assert of_ubx == of_nmea
    assert len(of_ubx) == said["GPGGA"].numSV == said["NAV-SOL"].numSV == said["PUBX03"].numSv
    dilution = said["NAV-DOP"]
    assert (dilution.pDOP, dilution.hDOP, dilution.vDOP) == (said["GPGSA"].PDOP, said["GPGSA"].HDOP, said["GPGSA"].VDOP)


def test_a_poll_of_the_library_is_answered(gps):
    gps.say(pyubx2.UBXMessage("CFG", "CFG-RATE", pyubx2.POLL).serialize())
    rate, acknowledged = read(gps.take())
    assert (rate.identity, rate.measRate, rate.navRate, rate.timeRef) == ("CFG-RATE", 1000, 1, 1)
    assert acknowledged.identity == "ACK-ACK"
    gps.say(setting("CFG-RATE", measRate=100, navRate=1, timeRef=1).serialize())
    assert [answer.identity for answer in read(gps.take())] == ["ACK-NAK"]


@given(st.integers(0, 255), st.integers(0, 255), st.binary(max_size=60))
def test_frames_are_those_of_the_library(group, number, payload):
    whole = ubx.frame(ubx.UbxMessage(group=group, number=number, payload=payload))
    assert whole[-2:] == pyubx2.calc_checksum(whole[2:-2])
    assert pyubx2.isvalid_checksum(whole)


@given(st.lists(st.text("ABCxyz0189.-", max_size=9), min_size=1, max_size=12))
def test_sums_of_sentences_are_those_of_the_library(fields):
    line = nmea.sentence("GPXXX", *fields)
    body, _, check = line[1:-2].decode("ascii").partition("*")
    assert check == pynmeagps.calc_checksum(body)
