"""UBX: frames, polls, settings, answers, resets (GPS.G6-SW-10018, "UBX Protocol"). Vectors are what u-center sends."""

from __future__ import annotations

import functools
import operator
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.parts.neo6m.ubx import Dropped, Inlet, Line, UbxMessage, fletcher, frame
from tests.each import each

ACK, NAK = 1, 0
FRAMES = [
    (0x05, 0x01, "06 01", "B5 62 05 01 02 00 06 01 0F 38"),
    (0x05, 0x00, "06 01", "B5 62 05 00 02 00 06 01 0E 33"),
    (0x06, 0x08, "C8 00 01 00 01 00", "B5 62 06 08 06 00 C8 00 01 00 01 00 DE 6A"),
    (0x06, 0x08, "E8 03 01 00 01 00", "B5 62 06 08 06 00 E8 03 01 00 01 00 01 39"),
    (0x06, 0x01, "F0 01 00 00 00 00 00 01", "B5 62 06 01 08 00 F0 01 00 00 00 00 00 01 01 2B"),
    (0x06, 0x01, "01 02 01", "B5 62 06 01 03 00 01 02 01 0E 47"),
    (0x06, 0x04, "FF FF 02 00", "B5 62 06 04 04 00 FF FF 02 00 0E 61"),
    (0x0A, 0x04, "", "B5 62 0A 04 00 00 0E 34"),
    (0x01, 0x02, "", "B5 62 01 02 00 00 03 0A"),
]
PORT_9600 = "01 00 00 00 D0 08 00 00 80 25 00 00 07 00 03 00 00 00 00 00"
PORT_115200 = "B5 62 06 00 14 00 01 00 00 00 D0 08 00 00 00 C2 01 00 07 00 03 00 00 00 00 00 C0 7E"
NAV5_AIRBORNE = (
    "B5 62 06 24 24 00 FF FF 06 03 00 00 00 00 10 27 00 00 05 00 FA 00 FA 00 64 00 2C 01 00 00 00 00 "
    "00 00 00 00 00 00 00 00 00 00 16 DC"
)
NAV5_DEFAULT = "FF FF 00 03 00 00 00 00 10 27 00 00 05 00 FA 00 FA 00 64 00 2C 01 00 3C" + " 00" * 12
SAVE = "B5 62 06 09 0D 00 00 00 00 00 FF FF 00 00 00 00 00 00 17 31 BF"


def _hex(text: str) -> bytes:
    return bytes.fromhex(text)


def _answer(gps, group, number, payload, cut) -> int:
    """What is acknowledged: 1 or 0."""
    (a, kind, about) = cut(gps.command(group, number, payload))[-1]
    assert (a, about) == (0x05, bytes((group, number)))
    return kind


# --- frames


@each(("group", "number", "payload", "whole"), FRAMES)
def test_vectors(group, number, payload, whole) -> None:
    message = UbxMessage(group=group, number=number, payload=_hex(payload))
    assert frame(message) == _hex(whole)
    assert list(Inlet().receive(_hex(whole))) == [message]


def test_the_checksum_is_that_of_rfc_1145() -> None:
    assert fletcher(b"\x05\x01\x02\x00\x06\x01") == b"\x0f\x38"


PIECES = st.one_of(
    st.binary(max_size=12),
    st.builds(
        lambda group, number, payload: frame(UbxMessage(group=group, number=number, payload=payload)),
        st.integers(0, 255),
        st.integers(0, 255),
        st.binary(max_size=40),
    ),
    st.sampled_from([b"$PUBX,40,GLL,0,0,0,0,0,0*5C\r\n", b"$EIGPQ,RMC*3A\r\n", b"\xb5", b"\xb5\x62", b"$", b"\n"]),
)


@given(st.lists(PIECES, max_size=8), st.integers(1, 7))
def test_it_makes_no_difference_how_bytes_come(pieces, size) -> None:
    data = b"".join(pieces)
    whole = list(Inlet().receive(data))
    cut = Inlet()
    found = [one for at in range(0, len(data), size) for one in cut.receive(data[at : at + size])]
    assert [one for one in found if not isinstance(one, Dropped)] == [
        one for one in whole if not isinstance(one, Dropped)
    ]


@given(st.lists(st.builds(lambda p: UbxMessage(group=6, number=1, payload=p), st.binary(max_size=30)), max_size=6))
def test_clean_messages_all_arrive(sent) -> None:
    assert list(Inlet().receive(b"".join(map(frame, sent)))) == sent


@given(st.binary(min_size=1000, max_size=1500))
def test_little_is_kept(data) -> None:
    inlet = Inlet()
    list(inlet.receive(data))
    assert len(inlet._held) <= 1024 + 8


def test_what_is_broken_is_dropped_and_the_next_is_found() -> None:
    good = _hex(FRAMES[0][3])
    broken = good[:-1] + b"\x00"
    assert list(Inlet().receive(broken + good))[-1] == UbxMessage(group=5, number=1, payload=b"\x06\x01")
    assert isinstance(next(Inlet().receive(broken)), Dropped)
    assert isinstance(next(Inlet().receive(b"\xb5\x62\x06\x01\xff\xff")), Dropped)
    assert list(Inlet().receive(b"$GPGGA,1$X*58\n")) == [Dropped("a sentence without an end"), Line(b"$X*58")]


# --- polls


def test_polls_of_navigation(gps) -> None:
    payload = gps.poll(0x01, 0x02)
    tow, lon, lat, height, sea = struct.unpack("<Iiiii", payload[:20])
    assert tow == (5 * 86400 + 12 * 3600 + 18 + 3) * 1000
    assert (lon, lat) == (-583683000, -346175000)
    assert (height, sea) == (36000, 20000)
    assert len(payload) == 28


@pytest.mark.parametrize(
    ("number", "size"),
    [
        (0x01, 20),
        (0x02, 28),
        (0x03, 16),
        (0x04, 18),
        (0x06, 52),
        (0x11, 20),
        (0x12, 36),
        (0x20, 16),
        (0x21, 20),
        (0x22, 20),
        (0x30, 8 + 12 * 10),
    ],
)
def test_sizes_of_the_specification(gps, make_gps, number, size) -> None:
    assert len(gps.poll(0x01, number)) == size
    lost = make_gps(start="cold")
    lost.run_to(2)
    assert len(lost.poll(0x01, number)) == (8 if number == 0x30 else size)


def test_status_and_solution_agree(gps) -> None:
    tow, *fix, first, uptime = struct.unpack("<IBBBBII", gps.poll(0x01, 0x03))
    assert fix == [3, 0x0D, 0, 0]
    assert 500 < first <= 3000
    assert uptime == 3000
    sol = struct.unpack("<IihBB3iI3iIHBBI", gps.poll(0x01, 0x06))
    assert sol[:5] == (tow, 0, 2174, 3, 0x0D)
    assert sol[15] == 10
    x, y, z = (part / 100 for part in sol[5:8])
    assert (x**2 + y**2 + z**2) ** 0.5 == pytest.approx(6_371_300, abs=10_000)


def test_velocity_and_dilution(make_gps) -> None:
    gps = make_gps(lambda ns: {"x": 0.0, "y": 0.0, "z": 0.0, "vx": 3.0, "vy": -4.0, "vz": 1.0})
    gps.run_to(3.5)
    velocity = struct.unpack("<I3iIIiII", gps.poll(0x01, 0x12))
    assert velocity[1:6] == (-400, 300, -100, 510, 500)
    assert velocity[6] == pytest.approx(143.1301e5, abs=2)
    _, geometric, position, time, vertical, horizontal, north, east = struct.unpack("<I7H", gps.poll(0x01, 0x04))
    assert position**2 == pytest.approx(vertical**2 + horizontal**2, rel=0.02)
    assert horizontal**2 == pytest.approx(north**2 + east**2, rel=0.02)
    assert geometric**2 == pytest.approx(position**2 + time**2, rel=0.02)


def test_time(gps) -> None:
    utc = struct.unpack("<IIiHBBBBBB", gps.poll(0x01, 0x21))
    assert utc[3:] == (2021, 9, 10, 12, 0, 3, 7)
    _, left_ns, week, leap, valid, _ = struct.unpack("<IihbBI", gps.poll(0x01, 0x20))
    assert (left_ns, week, leap, valid) == (0, 2174, 18, 7)


def test_nothing_is_valid_before_a_cold_fix(make_gps) -> None:
    gps = make_gps(start="cold")
    gps.run_to(2)
    assert gps.poll(0x01, 0x03)[4:6] == b"\0\0"
    assert gps.poll(0x01, 0x21)[-1] == 0
    assert gps.poll(0x01, 0x02)[-8:] == b"\xff" * 8


def test_version(gps) -> None:
    assert gps.poll(0x0A, 0x04) == b"7.03 (45969)".ljust(30, b"\0") + b"00040007".ljust(10, b"\0")


def test_a_query_in_nmea_and_in_ubx(gps, cut_sentences) -> None:
    gps.say(b"$EIGPQ,RMC*3A\r\n")
    assert [fields[0] for fields in gps.lines()] == ["GPRMC"]
    assert [fields[0] for fields in cut_sentences(gps.command(0xF0, 0x00))] == ["GPGGA"]


# --- settings


def test_messages_are_switched_on_and_off(gps, cut_messages) -> None:
    gps.say(FRAMES[4][3])
    assert gps.take() == _hex("B5 62 05 01 02 00 06 01 0F 38")
    gps.run(1)
    assert [fields[0] for fields in gps.lines()].count("GPGLL") == 0
    for number in (0, 2, 3, 4, 5):
        gps.command(0x06, 0x01, bytes((0xF0, number, 0)))
    gps.say(FRAMES[5][3])
    gps.take()
    gps.run(2)
    assert [found[:2] for found in cut_messages(gps.take())] == [(0x01, 0x02)] * 2
    assert gps.notes() == []


def test_a_rate_is_once_in_so_many_solutions(gps) -> None:
    gps.command(0x06, 0x01, bytes((0xF0, 0x00, 3)))
    gps.take()
    gps.run(6)
    names = [fields[0] for fields in gps.lines()]
    assert (names.count("GPGGA"), names.count("GPRMC")) == (2, 6)
    assert gps.poll(0x06, 0x01, b"\xf0\x00") == b"\xf0\x00\x00\x03\x00\x00\x00\x00"


def test_five_solutions_a_second_and_no_more(gps, cut_messages) -> None:
    for number in (1, 2, 3, 4, 5):
        gps.command(0x06, 0x01, bytes((0xF0, number, 0)))
    gps.say(FRAMES[2][3])
    gps.take()
    gps.run(2)
    times = [fields[1][-5:] for fields in gps.lines()]
    assert len(times) == 10
    assert [time[-2:] for time in times] == ["60", "80", "00", "20", "40"] * 2
    assert gps.poll(0x06, 0x08) == _hex("C8 00 01 00 01 00")
    assert _answer(gps, 0x06, 0x08, _hex("64 00 01 00 01 00"), cut_messages) == NAK
    assert gps.poll(0x06, 0x08) == _hex("C8 00 01 00 01 00")


def test_a_line_that_is_too_slow_loses_messages(make_gps) -> None:
    """Everything at 5 Hz is over 2000 bytes a second, and 9600 bit/s carry 960."""
    gps = make_gps()
    gps.run_to(3.5)
    gps.say(FRAMES[2][3])
    gps.take()
    gps.run(20)
    assert 900 < len(gps.take()) / 20 < 1020
    assert any("dropped" in note for note in gps.notes())


def test_the_port(gps) -> None:
    assert gps.poll(0x06, 0x00) == _hex(PORT_9600)
    assert gps.poll(0x06, 0x00, b"\x01") == _hex(PORT_9600)
    gps.say(PORT_115200)
    assert gps.poll(0x06, 0x00)[8:12] == (115200).to_bytes(4, "little")


def test_a_new_rate_counts_when_the_answer_is_out(gps) -> None:
    gps.run_to(3.8)  # all sentences are out
    said_ns = gps.now_ns
    gps.say(PORT_115200)
    gps.run(0.1)
    assert gps.bench.rates == [(0, 9600), (said_ns + 10 * 10 * 10**9 // 9600, 115200)]
    gps.command(0x06, 0x04, b"\x00\x00\x01\x00")
    assert gps.bench.rates[-1] == (gps.now_ns, 9600)


@pytest.mark.parametrize(("port", "mode", "baud"), [(0, 0x84, 0), (2, 0x8D0, 9600), (3, 0, 0), (4, 0, 0)])
def test_the_other_ports_are_there_to_be_asked(gps, port, mode, baud) -> None:
    found = struct.unpack("<BBHIIHHHH", gps.poll(0x06, 0x00, bytes((port,))))
    assert (found[0], found[3], found[4]) == (port, mode, baud)


def test_before_the_first_solution_there_is_nothing_to_tell(make_gps, make_ubx) -> None:
    gps = make_gps()
    gps.run_to(0.5)
    gps.take()
    gps.say(make_ubx(0x01, 0x02) + make_ubx(0xF0, 0x00) + b"$EIGPQ,RMC*3A\r\n$PUBX,00*33\r\n")
    assert gps.take() == b""


def test_sentences_are_not_heard_with_nmea_off(gps) -> None:
    gps.command(0x06, 0x00, _hex(PORT_9600)[:12] + b"\x01\x00\x03\x00" + bytes(4))
    gps.say(b"$EIGPQ,RMC*3A\r\n")
    assert gps.take() == b""


def test_protocols_can_be_switched_off(gps, make_ubx) -> None:
    gps.command(0x06, 0x00, _hex(PORT_9600)[:14] + b"\x01\x00" + bytes(4))
    gps.take()
    gps.run(2)
    assert gps.take() == b""
    gps.command(0x06, 0x00, _hex(PORT_9600)[:12] + b"\x02\x00\x03\x00" + bytes(4))
    gps.take()
    gps.say(make_ubx(0x0A, 0x04))
    assert gps.take() == b""


def test_navigation_settings(gps, cut_messages) -> None:
    assert gps.poll(0x06, 0x24) == _hex(NAV5_DEFAULT)
    gps.say(NAV5_AIRBORNE)
    assert gps.take() == _hex("B5 62 05 01 02 00 06 24 32 5B")
    assert gps.poll(0x06, 0x24)[2] == 6
    only_mask_0 = b"\x01\x00" + b"\x04" + b"\x01" + bytes(32)
    assert _answer(gps, 0x06, 0x24, only_mask_0, cut_messages) == ACK
    assert gps.poll(0x06, 0x24)[2:4] == b"\x04\x03"
    assert _answer(gps, 0x06, 0x24, b"\x04\x00\x00\x07" + bytes(32), cut_messages) == NAK


@pytest.mark.parametrize(("mode", "sky", "fix"), [(1, 1, 2), (3, 1, 3), (3, 0.3, 2), (2, 0.3, 0), (2, 1, 3)])
def test_fix_modes(gps, mode, sky, fix) -> None:
    gps.command(0x06, 0x24, b"\x04\x00\x00" + bytes((mode,)) + bytes(32))
    gps.bench.part.set({"sky": sky}, gps.now_ns)
    gps.run(2)
    assert gps.poll(0x01, 0x03)[4] == fix


def test_low_satellites_can_be_masked(gps) -> None:
    gps.command(0x06, 0x24, b"\x02\x00" + bytes(10) + b"\x1e" + bytes(23))
    gps.run(1)
    assert gps.last("GPGGA")[7] == "06"


@pytest.mark.parametrize(
    ("number", "payload"),
    [
        (0x31, ""),
        (0x99, "01"),
        (0x00, "00" * 19),
        (0x00, "09"),
        (0x00, "01" + "00" * 19),
        (0x01, "F0"),
        (0x01, "F0 20 01"),
        (0x01, "77 00 01"),
        (0x04, "00 00 07 00"),
        (0x04, "00"),
        (0x08, "00"),
        (0x09, "00"),
        (0x24, "00"),
    ],
)
def test_what_makes_no_sense_is_not_acknowledged(gps, cut_messages, number, payload) -> None:
    before = gps.bench.part._configurator.state
    assert _answer(gps, 0x06, number, _hex(payload), cut_messages) == NAK
    assert gps.bench.part._configurator.state == before


def test_what_is_saved_survives_a_reset_and_other_things_do_not(gps) -> None:
    gps.command(0x06, 0x01, bytes((0xF0, 0x01, 0)))
    gps.say(SAVE)
    gps.command(0x06, 0x01, bytes((0xF0, 0x03, 0)))
    gps.command(0x06, 0x04, b"\x00\x00\x01\x00")
    gps.take()
    gps.run(2)
    names = [fields[0] for fields in gps.lines()]
    assert "GPGLL" not in names
    assert "GPGSV" in names


def test_clearing_and_loading_restores_the_default(gps) -> None:
    gps.command(0x06, 0x01, bytes((0xF0, 0x01, 0)))
    gps.say(SAVE)
    gps.command(0x06, 0x09, struct.pack("<III", 0xFFFF, 0, 0xFFFF))
    assert gps.poll(0x06, 0x01, b"\xf0\x01")[3] == 1


def test_sentences_of_u_blox_set_rates_and_port(gps) -> None:
    gps.say(b"$PUBX,40,GLL,0,0,0,0,0,0*5C\r\n")
    gps.say(b"$PUBX,41,1,0007,0003,19200,0*25\r\n")
    gps.run(1)
    assert "GPGLL" not in [fields[0] for fields in gps.lines()]
    assert gps.poll(0x06, 0x00)[8:12] == (19200).to_bytes(4, "little")


def test_an_unknown_sentence_is_answered_and_a_broken_one_noted(gps) -> None:
    gps.say(b"$GPXYZ,1*51\r\n$GPXYZ,1*00\r\n")
    assert gps.take() == b"$GPTXT,01,01,01,NMEA unknown msg*58\r\n"
    assert any("checksum" in note for note in gps.notes())


@pytest.mark.parametrize(
    ("group", "number", "payload", "word"),
    [
        (0x01, 0x60, b"", "not answered"),
        (0x0B, 0x01, b"\0", "not answered"),
        (0x06, 0x60, b"", "0x60 is not modelled"),
        (0x06, 0x31, b"", "0x31: what the receiver begins with"),
        (0x06, 0x16, bytes(8), "0x16 is kept"),
        (0x06, 0x24, b"\x40\0" + bytes(20) + b"\x05" + bytes(13), "static_hold_cm_s"),
        (0x06, 0x00, b"\x03" + bytes(19), "lead nowhere"),
        (0x06, 0x01, b"\xf0\x06\x01", "0x06 is not modelled"),
        (0x06, 0x08, b"\xe8\x03\x02\x00\x01\x00", "always 1"),
        (0x06, 0x00, _hex(PORT_9600)[:4] + b"\xc0\x00" + _hex(PORT_9600)[6:], "8 bits without parity"),
    ],
)
def test_what_is_absent_is_noted(gps, group, number, payload, word) -> None:
    gps.command(group, number, payload)
    assert any(word in note for note in gps.notes())


def test_sentences_that_are_absent_are_noted(gps) -> None:
    gps.say(b"$PUBX,05*36\r\n$EIGPQ,GRS*20\r\n$PUBX,41,1*2B\r\n")
    assert [sum(word in note for note in gps.notes()) for word in ("PUBX,05", "GRS", "PUBX,41")] == [1, 1, 1]


def test_positions_of_u_blox_by_query_and_by_rate(gps) -> None:
    gps.say(b"$PUBX,00*33\r\n$PUBX,04*37\r\n")
    assert [fields[:2] for fields in gps.lines()] == [["PUBX", "00"], ["PUBX", "04"]]
    assert gps.command(0xF1, 0x03).startswith(b"$PUBX,03,10,")
    gps.command(0x06, 0x01, b"\xf1\x00\x02")
    gps.take()
    gps.run(4)
    assert [fields[0] for fields in gps.lines()].count("PUBX") == 2


NUMBERS = {"GGA": 0, "GLL": 1, "GSA": 2, "GSV": 3, "RMC": 4, "VTG": 5, "GST": 7, "ZDA": 8, "GBS": 9, "DTM": 10}


@pytest.mark.parametrize(("name", "number"), NUMBERS.items())
def test_numbers_of_sentences(gps, cut_sentences, name, number) -> None:
    """GPS.G6-SW-10018, "NMEA Messages Overview"; by poll, by CFG-MSG and by PUBX,40."""
    assert cut_sentences(gps.command(0xF0, number))[0][0] == f"GP{name}"
    gps.command(0x06, 0x01, bytes((0xF0, number, 5)))
    assert gps.poll(0x06, 0x01, bytes((0xF0, number)))[3] == 5
    body = f"PUBX,40,{name},0,7,0,0,0,0"
    check = functools.reduce(operator.xor, body.encode())
    gps.say(f"${body}*{check:02X}\r\n".encode())
    assert gps.poll(0x06, 0x01, bytes((0xF0, number)))[3] == 7


@pytest.mark.parametrize(("mask", "kept"), [(0x01, "port"), (0x02, "messages"), (0x08, "navigation")])
def test_sections_are_saved_one_by_one(gps, mask, kept) -> None:
    gps.command(0x06, 0x00, _hex(PORT_9600)[:12] + b"\x03\x00\x03\x00" + bytes(4))
    gps.command(0x06, 0x01, b"\xf0\x01\x00")
    gps.command(0x06, 0x08, _hex("F4 01 01 00 01 00"))
    gps.command(0x06, 0x24, b"\x01\x00\x04" + bytes(33))
    gps.command(0x06, 0x09, struct.pack("<III", 0, mask, 0))
    gps.command(0x06, 0x04, b"\x00\x00\x01\x00")
    gps.run(0.5)
    found = {
        "port": gps.poll(0x06, 0x00)[12] == 3,
        "messages": gps.poll(0x06, 0x01, b"\xf0\x01")[3] == 0,
        "navigation": gps.poll(0x06, 0x08)[:2] == b"\xf4\x01" and gps.poll(0x06, 0x24)[2] == 4,
    }
    assert found == {name: name == kept for name in found}


def test_satellites_one_by_one(gps, make_gps) -> None:
    """Used, orbit known by ephemeris; before a fix neither."""
    found = gps.poll(0x01, 0x30)
    assert found[4] == 10
    channel, number, flags, _, strength, elevation, azimuth, _ = struct.unpack("<BBBBBbhi", found[8:20])
    assert (channel, number, flags, elevation, azimuth) == (0, 17, 0x0D, 78, 40)
    assert 40 < strength <= 48
    searching = make_gps(start="cold", spread_percent=0)
    searching.run_to(14)
    flags = searching.poll(0x01, 0x30)[10::12]
    assert len(flags) > 3
    assert set(flags) == {0}


def test_settings_without_effect_are_kept_and_acknowledged(gps, cut_messages) -> None:
    """As flight controllers do it: they wait for ACK of CFG-SBAS before they go on."""
    sbas = b"\x01\x03\x03\x00\xd1\xa2\x06\x00"
    assert _answer(gps, 0x06, 0x16, b"", cut_messages) == NAK
    assert _answer(gps, 0x06, 0x16, sbas, cut_messages) == ACK
    assert gps.poll(0x06, 0x16) == sbas
    assert _answer(gps, 0x06, 0x16, sbas[1:], cut_messages) == NAK


@given(st.lists(PIECES, max_size=10))
def test_no_bytes_raise_anything(pieces) -> None:
    from targets.parts.neo6m import Neo6m, Neo6mSettings
    from targets.parts.testing import PartBench

    bench = PartBench(Neo6m, Neo6mSettings(start="hot"))
    bench.run(2)
    for piece in pieces:
        bench.receive(piece)
        bench.run(0.3)


CFG_BYTES = st.tuples(st.sampled_from([0, 1, 4, 8, 9, 0x24]), st.binary(max_size=40))


@given(st.lists(CFG_BYTES, max_size=8))
def test_no_setting_raises_anything(settings) -> None:
    from targets.parts.neo6m import Neo6m, Neo6mSettings
    from targets.parts.testing import PartBench

    bench = PartBench(Neo6m, Neo6mSettings(start="hot"))
    bench.run(2)
    for number, payload in settings:
        bench.receive(frame(UbxMessage(group=6, number=number, payload=payload)))
        bench.run(0.5)
