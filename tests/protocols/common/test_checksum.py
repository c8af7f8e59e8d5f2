"""A checksum as data: what it is over, where it stands."""

from __future__ import annotations

from protocols.common.checksum import Checksum

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
