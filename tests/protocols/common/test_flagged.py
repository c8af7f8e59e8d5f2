"""Frames in any stream of bytes: found, cut, damaged, for somebody else."""

from __future__ import annotations

from functools import partial

import crcmod.predefined
import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols.common.flagged import (
    NOISE_RUN,
    Dropped,
    DropReason,
    FlaggedOptions,
    Frame,
    FrameReader,
    crc16,
    encode_frame,
    longest_frame,
)
from tests.each import each

ANY = FlaggedOptions()
SMALL = FlaggedOptions(max_payload=20)
GOOD = encode_frame(b"\x81\x00\x00\x00", ANY)


def test_the_crc_is_that_of_another_hand():
    other = crcmod.predefined.mkPredefinedCrcFun("crc-16")
    assert crc16(b"") == 0
    assert crc16(b"123456789") == 0xBB3D
    assert all(crc16(bytes((byte,))) == other(bytes((byte,))) for byte in range(256))


@given(st.binary(max_size=80))
def test_the_crc_of_anything_is_that_of_another_hand(data):
    assert crc16(data) == crcmod.predefined.mkPredefinedCrcFun("crc-16")(data)


def kinds(found):
    return [item.reason if isinstance(item, Dropped) else item.payload for item in found]


@each(
    ("stream", "expected"),
    [
        (GOOD * 3, [b"\x81\0\0\0"] * 3),
        (b"noise" + GOOD, [DropReason.NOISE, b"\x81\0\0\0"]),
        (GOOD[:-1] + GOOD, [DropReason.CUT_SHORT, b"\x81\0\0\0"]),
        (GOOD[:-1] + b"\x7d" + GOOD, [DropReason.CUT_SHORT, b"\x81\0\0\0"]),
        (b"\x7e" + GOOD, [DropReason.NOISE, b"\x81\0\0\0"]),
        (GOOD[:-1] + b"?" + GOOD, [DropReason.BAD_CRC, b"\x81\0\0\0"]),
        (b"\x7e\0\x05" + GOOD, [DropReason.NOT_FOR_US, b"\x81\0\0\0"]),
        (b"\x7e\0\0\x15\0rest" + GOOD, [DropReason.BAD_LENGTH, DropReason.NOISE, b"\x81\0\0\0"]),
        (b"?" * NOISE_RUN + b"?" + GOOD, [DropReason.NOISE, DropReason.NOISE, b"\x81\0\0\0"]),
    ],
)
def test_what_is_found_and_why_the_rest_is_not(stream, expected):
    assert kinds(FrameReader(SMALL).receive(stream)) == expected


def test_a_reader_that_is_reset_gives_up_what_it_holds():
    reader = FrameReader(ANY)
    assert reader.receive(GOOD[:5]) == []
    assert reader.reset() == [Dropped(reason=DropReason.CUT_SHORT, data=GOOD[:5])]
    assert kinds(reader.receive(GOOD[5:] + GOOD)) == [DropReason.NOISE, b"\x81\0\0\0"]


def test_an_escape_is_undone_whatever_follows_it():
    frame = bytes.fromhex("7E 7D 20 00 01 00 01 C1 C0")
    assert FrameReader(ANY).receive(frame) == [Frame(raw=frame, source=0, payload=b"\x01")]


def test_an_empty_payload_is_a_sound_frame():
    frame = bytes.fromhex("7E 00 00 00 00 00 00")
    assert encode_frame(b"", ANY) == frame
    assert FrameReader(ANY).receive(frame) == [Frame(raw=frame, source=0, payload=b"")]


def test_a_payload_beyond_the_limit_is_refused():
    with pytest.raises(ValueError, match="21 bytes"):
        encode_frame(bytes(21), SMALL)
    longest = encode_frame(b"\x7e" * 20, SMALL)
    assert kinds(FrameReader(SMALL).receive(longest)) == [b"\x7e" * 20]
    assert len(longest) <= longest_frame(SMALL)


@each("wrong", [{"local_address": 256}, {"remote_address": -1}, {"max_payload": 0}, {"max_payload": 65536}])
def test_options_that_cannot_be(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        FlaggedOptions(**wrong)


@given(st.binary(max_size=300), st.integers(0, 255), st.integers(0, 255))
def test_any_payload_survives(payload, source, destination):
    sent = encode_frame(payload, FlaggedOptions(local_address=source, remote_address=destination))
    assert sent.count(b"\x7e") == 1
    reader = FrameReader(FlaggedOptions(local_address=destination))
    assert reader.receive(sent) == [Frame(raw=sent, source=source, payload=payload)]


PIECES = st.one_of(
    st.binary(max_size=30).map(partial(encode_frame, options=ANY)),
    st.binary(max_size=12),
    st.sampled_from([b"\x7e", b"\x7d", b"\x7e\0\0", b"\x7e\0\0\x02", bytes(NOISE_RUN)]),
)


@given(st.lists(PIECES, max_size=12).map(b"".join), st.lists(st.integers(1, 40), min_size=1), st.booleans())
def test_any_cut_of_any_stream_gives_the_same_and_loses_no_byte(stream, sizes, small):
    options = SMALL if small else ANY
    whole, cut = FrameReader(options), FrameReader(options)
    found, at = [], 0
    while at < len(stream):
        size = sizes[at % len(sizes)]
        found += cut.receive(stream[at : at + size])
        at += size
        assert cut.held < longest_frame(options) + NOISE_RUN
    assert found == whole.receive(stream)
    found += cut.reset()
    assert b"".join(item.raw if isinstance(item, Frame) else item.data for item in found) == stream
