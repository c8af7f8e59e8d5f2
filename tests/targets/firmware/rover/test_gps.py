"""NMEA sentences, as the u-blox 6 receiver description has them, and what the reports make of them."""

from __future__ import annotations

import struct

import pynmeagps
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocols.pkt import FrameReader
from tests.each import each
from tests.share import examples

PLACE = "3437.05000,S,05822.09800,W"  # 34.6175 S, 58.3683 W


def sentence(body):
    return f"${body}*{pynmeagps.calc_checksum(body)}\r\n"


def gga(place=PLACE, quality=1, talker="GP"):
    return sentence(f"{talker}GGA,092725.00,{place},{quality},08,1.01,499.6,M,48.0,M,,")


def rmc(place=PLACE, status="A", talker="GP"):
    return sentence(f"{talker}RMC,083559.00,{status},{place},0.004,77.52,091202,,,A")


def position(rover, *, image="rover"):
    """Byte 1 and the two floats of the next 0x84."""
    rover.fetch()
    rover.run(1.0)
    frames = FrameReader().receive(rover.fetch(), 0)
    payload = next(frame.payload for frame in frames if frame.payload[0] == 0x84)
    return payload[1], *struct.unpack_from("<ff", payload, 4)


@each("text", [gga(), rmc(), gga(talker="GN"), rmc(talker="GN"), gga(quality=2)])
def test_a_position(rover, text):
    assert position(rover().hear(text)) == (1, pytest.approx(-34.6175, abs=4e-6), pytest.approx(-58.3683, abs=4e-6))


def test_north_and_east_are_positive(rover):
    heard = rover().hear(gga("4717.11437,N,00833.91522,E"))
    assert position(heard) == (1, pytest.approx(47.285240, abs=4e-6), pytest.approx(8.565254, abs=4e-6))


def test_longitude_first(rover):
    heard = rover("rover-gps-order").hear(gga())
    assert position(heard)[1:] == (pytest.approx(-58.3683, abs=4e-6), pytest.approx(-34.6175, abs=4e-6))


@each("image", ["rover-g2", "rover-no-gps"])
def test_no_position_ever(rover, image):
    assert position(rover(image).hear(gga()))[1:] == (0.0, 0.0)


@each(
    "text",
    [
        gga(quality=0),
        rmc(status="V"),
        gga(",,,", quality=0),
        gga().replace("3437", "3438"),  # the checksum does not fit any more
        gga().replace("*", "x"),
        gga()[:-3] + "\r\n",
        "$" + gga()[1:].replace("GGA", "GSA"),
        gga(place="34x7.05,S,05822.09,W"),
        gga(place=",S,,W"),
        "GPGGA no sentence at all\r\n",
        "$" + "x" * 300 + "\r\n",
        sentence("GPGGA,,,"),
        sentence("GPRMC"),
        sentence(""),
        "$*00\r\n" * 3,
        sentence("GPGGA" + "," * 40),
    ],
)
def test_what_is_no_position(rover, text):
    assert position(rover().hear(text)) == (0, 0.0, 0.0)


def test_a_fix_that_is_lost_leaves_its_last_position(rover):
    heard = rover().hear(gga())
    heard.run(1.0).hear(gga(",,,", quality=0))
    assert position(heard) == (0, pytest.approx(-34.6175, abs=4e-6), pytest.approx(-58.3683, abs=4e-6))


def test_a_sentence_behind_a_broken_one(rover):
    assert position(rover().hear(gga()[:20] + gga()))[0] == 1


def test_a_receiver_that_is_silent_is_said(rover):
    status = [rover().run(seconds).fetch() for seconds in (2.9, 3.3)]
    last = [FrameReader().receive(data, 0) for data in status]
    flags = [[frame.payload[5] & 2 for frame in frames if frame.payload[0] == 0x80][-1] for frames in last]
    assert flags == [0, 2]


def test_a_receiver_without_a_fix_has_not_failed(rover):
    chip = rover()
    for _ in range(6):
        chip.run(1.0).hear(rmc(",,,", status="V"))
    frames = FrameReader().receive(chip.fetch(), 0)
    assert not any(frame.payload[5] & 2 for frame in frames if frame.payload[0] == 0x80)


@settings(max_examples=examples(20))
@given(
    latitude=st.floats(-89.99, 89.99),
    longitude=st.floats(-179.99, 179.99),
)
def test_any_place(rover_factory, latitude, longitude):
    def field(angle, width):
        degrees, minutes = divmod(round(abs(angle) * 60e5), 60 * 10**5)
        return f"{degrees:0{width}d}{minutes / 1e5:08.5f}"

    place = f"{field(latitude, 2)},{'NS'[latitude < 0]},{field(longitude, 3)},{'EW'[longitude < 0]}"
    heard = rover_factory(sensors=False).hear(gga(place))
    assert position(heard)[1:] == (pytest.approx(latitude, abs=1e-5), pytest.approx(longitude, abs=2e-5))


@settings(max_examples=examples(30))
@given(
    st.lists(st.sampled_from(["$", "*", ",", "GPGGA", "GPRMC", "\r\n", "7F", "x" * 60, "3437.05,S", "\0"]), max_size=30)
)
def test_any_noise_is_survived(rover_factory, noise):
    heard = rover_factory(sensors=False).hear("".join(noise))
    assert position(heard.hear("\r\n" + gga()))[0] == 1
