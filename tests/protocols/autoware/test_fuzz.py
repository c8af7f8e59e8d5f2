"""Whatever the bytes: no exception, bounded memory, every byte reported once, the same events however they are cut."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols.autoware import (
    MESSAGES,
    NOISE_RUN,
    Connection,
    Frame,
    FrameReader,
    Role,
    encode_frame,
    encode_message,
    longest_frame,
)

SECOND = 1_000_000_000
MAX_HELD = max(NOISE_RUN, longest_frame())
FRAMES = [encode_frame(encode_message(kind())) for kind in MESSAGES]
PIECES = [*FRAMES, b"\x7e", b"\x7d", b"\x7e\x00\x00\x41\x00", encode_frame(b"\x03"), encode_frame(b"\x7f\x7e")]

every_role = pytest.mark.parametrize("role", Role, ids=str)


@st.composite
def streams(draw):
    """Good frames, damaged frames and noise."""
    parts = draw(st.lists(st.one_of(st.sampled_from(PIECES), st.binary(max_size=12)), max_size=20))
    stream = bytearray(b"".join(parts))
    for at in draw(st.lists(st.integers(0, max(0, len(stream) - 1)), max_size=4)):
        if at < len(stream):
            stream[at] ^= 1 << draw(st.integers(0, 7))
    return bytes(stream)


@given(streams())
def test_every_byte_is_reported_once(stream):
    reader = FrameReader()
    found = [*reader.receive(stream), *reader.reset()]
    assert b"".join(item.raw if isinstance(item, Frame) else item.data for item in found) == stream


@every_role
def test_any_cut_of_any_stream_gives_the_same_events(role):
    @given(st.lists(st.tuples(streams(), st.integers(0, 2 * SECOND)), max_size=5))
    def check(bursts):
        whole, single = Connection(role), Connection(role)
        now_ns = 0
        for stream, gap_ns in bursts:
            now_ns += gap_ns
            expected = whole.receive(stream, now_ns)
            events = single.advance(now_ns)
            for byte in stream:
                events += single.receive(bytes((byte,)), now_ns)
                assert single.held <= MAX_HELD
            assert repr(events) == repr(expected)  # by text: NaN is not equal to itself
            assert single.state is whole.state
            assert single.next_deadline_ns() == whole.next_deadline_ns()
        assert single.counters == whole.counters

    check()


@every_role
def test_forty_thousand_bytes(role):
    """Half noise, half frames with a bit turned now and then, in pieces of any size."""
    chance = random.Random(role.name)
    connection = Connection(role)
    stream = bytearray()
    while len(stream) < 40_000:
        stream += chance.choice(FRAMES) if chance.random() < 0.7 else chance.randbytes(chance.randrange(20))
        if chance.random() < 0.1:
            stream[-1 - chance.randrange(5)] ^= 1 << chance.randrange(8)
    at, now_ns = 0, 0
    while at < len(stream):
        size = chance.choice((1, 7, 36, 300))
        now_ns += chance.randrange(SECOND // 20)
        connection.receive(bytes(stream[at : at + size]), now_ns)
        at += size
        assert connection.held <= MAX_HELD
    assert connection.counters.bytes_in == len(stream)
    assert connection.counters.frames_in > 800
