"""Frames are found in any stream, cut in any way, within bounds."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols.p2os import Dropped, DropReason, Frame, FrameReader, LocalProtocolError, checksum, encode_frame
from protocols.p2os.framing import MAX_COUNT_TOLERANT, NOISE_RUN
from tests.each import each

SYNC0 = bytes.fromhex("FAFB03000000")
PULSES = [encode_frame(bytes((number,))) for number in range(4)]


def frames(found):
    return [item.raw for item in found if isinstance(item, Frame)]


def drops(found):
    return [(item.reason, item.data) for item in found if isinstance(item, Dropped)]


def all_bytes(found):
    return b"".join(item.raw if isinstance(item, Frame) else item.data for item in found)


def read(data, **options):
    return FrameReader(**options).receive(data, 0)


bodies = st.binary(min_size=1, max_size=60)
biting = st.lists(st.sampled_from(b"\xfa\xfb\x00\x03\x04\x06\xc8\xc9\xff"), max_size=60).map(bytes)
pieces = st.one_of(
    bodies.map(encode_frame),
    biting,
    biting.filter(bool).map(encode_frame),
    st.binary(max_size=20),
    st.binary(min_size=300, max_size=700),
    bodies.map(encode_frame).flatmap(
        lambda frame: st.integers(0, len(frame) - 1).map(
            lambda at: frame[:at] + bytes((frame[at] ^ 0x10,)) + frame[at + 1 :]
        )
    ),
    bodies.map(encode_frame).flatmap(lambda frame: st.integers(0, len(frame)).map(lambda end: frame[:end])),
)
streams = st.lists(pieces, max_size=12).map(b"".join)


@st.composite
def streams_and_cuts(draw):
    stream = draw(streams)
    cuts = sorted(draw(st.lists(st.integers(0, len(stream)), max_size=20)))
    return stream, [stream[a:b] for a, b in zip([0, *cuts], [*cuts, len(stream)], strict=True)]


@given(streams_and_cuts())
def test_any_cut_of_any_stream_gives_the_same(case):
    stream, parts = case
    whole, cut, single = (FrameReader(timeout_ns=10) for _ in range(3))
    expected = whole.receive(stream, 0)
    assert [item for part in parts for item in cut.receive(part, 0)] == expected
    assert [item for byte in stream for item in single.receive(bytes((byte,)), 0)] == expected
    ends = [reader.expire(10) for reader in (whole, cut, single)]
    assert ends[0] == ends[1] == ends[2]
    assert all_bytes(expected + ends[0]) == stream
    assert all(reader.held == 0 for reader in (whole, cut, single))


@given(streams, st.sampled_from((200, 207, 255)))
def test_what_is_held_is_bounded(stream, max_count):
    reader = FrameReader(max_count=max_count)
    for byte in stream:
        reader.receive(bytes((byte,)), 0)
        assert reader.held <= max(max_count + 2, NOISE_RUN)


@given(st.lists(st.one_of(bodies.map(encode_frame), st.binary(max_size=300).map(lambda b: b.replace(b"\xfa", b"")))))
def test_every_good_frame_between_noise_without_fa_is_found(parts):
    expected = [part for part in parts if part.startswith(b"\xfa\xfb")]
    assert frames(read(b"".join(parts))) == expected


@given(st.binary(min_size=1, max_size=198))
def test_checksum_is_the_sum_byte_by_byte(body):
    total = 0
    for at in range(0, len(body) - 1, 2):
        total = (total + (body[at] << 8) + body[at + 1]) & 0xFFFF
    if len(body) % 2:
        total ^= body[-1]
    assert checksum(body) == total
    assert frames(read(encode_frame(body))) == [encode_frame(body)]


@given(st.binary(min_size=255, max_size=700))
def test_checksum_of_what_is_longer_than_a_frame(body):
    even = len(body) & ~1
    words = (int.from_bytes(body[at : at + 2], "big") for at in range(0, even, 2))
    assert checksum(body) == sum(words) % 0x10000 ^ (body[-1] if len(body) % 2 else 0)


def test_stray_header_byte_before_a_header():
    assert frames(read(b"\xfa" + SYNC0)) == [SYNC0]
    assert drops(read(b"\xfa" + SYNC0)) == [(DropReason.NOISE, b"\xfa")]


def test_radio_modem_preamble_is_noise():
    assert read(b"WMS2\r" + SYNC0) == [Dropped(reason=DropReason.NOISE, data=b"WMS2\r"), Frame(raw=SYNC0)]


@each("count", [0, 1, 2, 201, 207, 251, 255])
def test_count_out_of_range_is_no_frame(count):
    found = read(bytes((0xFA, 0xFB, count)) + SYNC0)
    assert frames(found) == [SYNC0]
    assert drops(found) == [(DropReason.BAD_COUNT, bytes((0xFA, 0xFB, count)))]


def test_overlong_frame_and_what_stands_in_it():
    inside = b"\x01" * 100 + SYNC0 + b"\x01" * 144
    found = read(b"\xfa\xfb\xfa" + inside + SYNC0)
    assert frames(found) == [SYNC0, SYNC0]


def test_count_that_begins_the_next_header():
    assert frames(read(b"\xfa\xfb" + SYNC0)) == [SYNC0]


@each("max_count", [200, MAX_COUNT_TOLERANT, 255])
def test_limit_of_the_count(max_count):
    longest = encode_frame(bytes(max_count - 2), max_count=255)
    assert frames(read(longest, max_count=max_count)) == [longest]
    if max_count < 255:
        longer = encode_frame(bytes(max_count - 1), max_count=255)
        assert frames(read(longer + SYNC0, max_count=max_count)) == [SYNC0]


def test_good_frames_inside_and_behind_a_bad_one_are_found():
    bad = bytearray(encode_frame(bytes(3) + SYNC0 + bytes(4)))
    bad[-1] ^= 1
    assert frames(read(bytes(bad) + SYNC0)) == [SYNC0, SYNC0]


def test_header_split_at_the_end_of_a_bad_frame():
    bad = bytes.fromhex("FAFB0411220000")[:-1] + b"\xfa"
    assert frames(read(bad + SYNC0[1:])) == [SYNC0]


def test_any_flipped_bit_behind_the_count_is_noticed():
    for at, bit in itertools.product(range(3, 9), range(8)):
        raw = bytearray(bytes.fromhex("FAFB060B3BC800D33B"))
        raw[at] ^= 1 << bit
        assert frames(read(bytes(raw))) == [], (at, bit)


def test_unfinished_frame_is_given_up_after_the_last_byte():
    reader = FrameReader(timeout_ns=100)
    reader.receive(b"\xfa\xfb\x40\x01", 0)
    reader.receive(b"\x02", 50)
    assert reader.next_deadline_ns() == 150
    assert reader.expire(149) == []
    assert reader.expire(150) == [Dropped(reason=DropReason.TIMED_OUT, data=b"\xfa\xfb\x40\x01\x02")]
    assert reader.next_deadline_ns() is None


def test_giving_up_finds_the_good_frame_inside():
    reader = FrameReader(timeout_ns=100)
    reader.receive(b"\xfa\xfb\x40\x01" + SYNC0 + b"\x07", 0)
    found = reader.expire(100)
    assert frames(found) == [SYNC0]
    assert drops(found) == [(DropReason.TIMED_OUT, b"\xfa\xfb\x40\x01"), (DropReason.NOISE, b"\x07")]


def test_late_bytes_do_not_complete_what_was_given_up():
    reader = FrameReader(timeout_ns=100)
    reader.receive(SYNC0[:4], 0)
    assert frames(reader.receive(SYNC0[4:], 100)) == []
    assert frames(reader.receive(SYNC0, 101)) == [SYNC0]


def test_without_a_timeout_nothing_is_given_up():
    reader = FrameReader()
    reader.receive(SYNC0[:4], 0)
    assert reader.next_deadline_ns() is None
    assert frames(reader.receive(SYNC0[4:], 10**15)) == [SYNC0]


def test_reset_gives_up_what_is_held():
    reader = FrameReader()
    reader.receive(SYNC0[:4], 0)
    assert drops(reader.reset()) == [(DropReason.TIMED_OUT, SYNC0[:4])]
    assert reader.reset() == []


def test_long_noise_comes_in_runs():
    assert [len(item.data) for item in read(bytes(1000) + SYNC0)[:-1]] == [256, 256, 256, 232]


@each("body", [b"", bytes(199)])
def test_body_that_fits_no_frame(body):
    with pytest.raises(LocalProtocolError, match=f"{len(body)} bytes"):
        encode_frame(body)


@each("max_count", [2, 256])
def test_limit_that_is_no_count(max_count):
    with pytest.raises(LocalProtocolError, match=str(max_count)):
        FrameReader(max_count=max_count)
