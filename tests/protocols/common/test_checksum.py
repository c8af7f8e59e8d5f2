"""A checksum as data: what it is over, where it stands."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from protocols.common.checksum import Checksum
from protocols.common.decoding import NoOptions
from protocols.p2os.decoding import checksum as p2os_checksum
from protocols.pkt.decoding import DecodeOptions
from protocols.pkt.decoding import checksum as pkt_checksum
from tests.each import each

SUM = Checksum(value=lambda data, begin: begin + sum(data), begin=1, first=1, stop=-2, at=-2, size=1, order="big")
WORD = Checksum(value=lambda data, begin: begin - sum(data), begin=0, first=0, stop=-2, at=-2, size=2, order="little")


def test_a_frame_gets_the_checksum_that_it_should_have():
    assert SUM.mended(b"<\x02\x03?>") == b"<\x02\x03\x06>"
    assert WORD.mended(b"\x01\x02??") == b"\x01\x02\xfd\xff"
    assert WORD.in_frame(b"\x01\x02??") == b"??"


def test_it_may_be_more_than_has_room():
    assert SUM.of(b"<" + b"\xff" * 4 + b"?>") == bytes([(1 + 4 * 255) % 256])


def test_what_is_too_short_stays_as_it_is():
    assert SUM.mended(b"") == b""
    assert SUM.in_frame(b"") == b""
    assert WORD.mended(b"?") == b"?"


P2OS, PKT = p2os_checksum(NoOptions()), pkt_checksum(DecodeOptions())
VEL_200 = bytes.fromhex("FAFB060B3BC800D33B")
LED_ON = bytes.fromhex("504B54210101F1D10A")


@each(
    ("rule", "raw", "mistake"),
    [
        (P2OS, "FAFB060B3BC8003BD3", "the bytes of its checksum are swapped"),
        (P2OS, "FAFB060B3BC8002CC4", "its checksum is inverted"),
        (P2OS, "FAFB060B3BC8002CC5", "its checksum is negated"),
        (P2OS, "FAFB060B3BC80541D6", "its checksum is over its bytes 3 to 7 instead of 4 to 7"),
        (PKT, "504B54210101D1F10A", "the bytes of its checksum are swapped"),
        (PKT, "504B5421010110210A", "its checksum begins with 0 instead of FFFF hex"),
        (PKT, "504B542101011021", "its checksum begins with 0 instead of FFFF hex"),
        (PKT, "504B5421010112340A", ""),
        (PKT, "504B54210101F1D10A", ""),
        (PKT, "50", ""),
        (P2OS, "FAFB06013B0101023B", ""),
        (SUM, "3C0203F93E", ""),
    ],
)
def test_what_is_often_done_wrong_has_a_name(rule, raw, mistake):
    assert rule.mistake(bytes.fromhex(raw)) == mistake


@given(st.binary(max_size=20))
def test_whatever_was_refused_can_be_looked_at(raw):
    assert P2OS.mistake(P2OS.mended(raw)) == PKT.mistake(PKT.mended(raw)) == ""
    assert isinstance(P2OS.mistake(raw) + PKT.mistake(raw), str)
